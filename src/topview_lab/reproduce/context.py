"""How the report is made: where, how large, on what data."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Final

from topview_lab.reproduce.runs import Counterpart
from topview_lab.seeds import report_seed
from topview_lab.sim.appearance import Appearance

QUICK_FRAMES: Final = 15
"""How long most recordings are in the quick form."""
QUICK_DUMMY_FRAMES: Final = 30
"""The same of those beside the dummy, who hides nothing by 60 % in half as many."""


@dataclass(frozen=True, slots=True)
class Context:
    """How an experiment is run.

    Attributes:
        out: the report's folder.
        quick: smaller, for a first look.
        seed: shifts the seeds of all scenes; the tracker's stays.
        mhad: folder of Berkeley MHAD, or None for its simulated counterparts.
        bridge: folder of another system's skeletons of the rivals' recordings, or None.
    """

    out: Path
    quick: bool = False
    seed: int = 0
    mhad: Path | None = None
    bridge: Path | None = None

    def size(self, full: int, quick: int) -> int:
        """How many of something."""
        return quick if self.quick else full

    def picture(self, name: str) -> Path:
        return self.out / "pictures" / name

    def counterpart(
        self,
        scene: str,
        number: int,
        frames: int,
        start_s: float = 0.0,
        body: str = "",
        appearance: Appearance | None = None,
    ) -> Counterpart:
        """A simulated recording; its number tells it from others of the same scene."""
        seed = report_seed(self.seed, number)
        return Counterpart(self.out / "recordings", scene, seed, frames, start_s, body, appearance)

    def own_sequences(self) -> list[Counterpart]:
        """Of Sec. 6.1.2: two of one user alone, two with a second one who plays the dummy and
        occludes the first, by 30 % and then by 60 %; more than 2000 frames."""
        if self.quick:
            return [self.counterpart("single_user", 0, QUICK_DUMMY_FRAMES), *self.dummy_sequences()]
        return [
            self.counterpart("single_user", 0, 510),
            self.counterpart("single_user", 1, 510, start_s=25.0),
            *self.dummy_sequences(),
        ]

    def dummy_sequences(self) -> list[Counterpart]:
        """Those with the dummy, who comes at about 5 s and hides more from about 12 s on."""
        if self.quick:
            starts_s = (5.7, 12.3)
            return [
                self.counterpart("dummy_occluder", 0, QUICK_DUMMY_FRAMES, start_s=start)
                for start in starts_s
            ]
        return [self.counterpart("dummy_occluder", number, 510) for number in range(2)]
