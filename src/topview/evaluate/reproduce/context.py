"""How the report is made: where, how large, on what data."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from topview.evaluate.reproduce.runs import Counterpart
from topview.sim.looks import Look

SEEDS: Final = 6000
"""The report's scenes have seeds from here on, which nothing was tuned on."""


@dataclass(frozen=True, slots=True)
class Context:
    """How an experiment is run.

    Attributes:
        out: the report's folder.
        quick: smaller, for a first look.
        seed: shifts the seeds of all scenes and of the tracker.
        mhad: folder of Berkeley MHAD, or None for its simulated counterparts.
    """

    out: Path
    quick: bool = False
    seed: int = 0
    mhad: Path | None = None

    def size(self, full: int, quick: int) -> int:
        """How many of something."""
        return quick if self.quick else full

    def picture(self, name: str) -> Path:
        return self.out / "pictures" / name

    def counterpart(
        self, scene: str, number: int, frames: int, body: str = "", look: Look | None = None
    ) -> Counterpart:
        """A simulated recording; its number tells it from others of the same scene."""
        seed = SEEDS + 100 * self.seed + number
        return Counterpart(self.out / "recordings", scene, seed, frames, body, look)

    def own_sequences(self) -> list[Counterpart]:
        """Of Sec. 6.1.2: two of one user alone, two with a second one who plays the dummy and
        occludes the first; more than 2000 frames."""
        frames = self.size(520, 150)
        scenes: Sequence[str] = ("single_user", "dummy_occluder")
        return [
            self.counterpart(scene, number, frames)
            for scene in scenes
            for number in range(self.size(2, 1))
        ]
