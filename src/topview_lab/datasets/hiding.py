"""Somebody is hidden for some time and comes back, rendered while it is tracked."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from topview.records import Camera, InputError
from topview_lab.datasets.base import select_simulated
from topview_lab.datasets.simulated import RecordingWithTruth
from topview_lab.sim import Scene
from topview_lab.sim.scenes import KINECT_V1_HALF
from topview_lab.sim.scenes.hiding import HIDERS, hiding_scene


@dataclass(frozen=True, slots=True)
class SimulatedHiding:
    """A scene of `topview_lab.sim.scenes.hiding`.

    Attributes:
        behind: what hides.
        hidden_s: for how long.
        seed: of people, room and noise.
        camera: whose images are rendered.
    """

    behind: str
    hidden_s: float
    seed: int = 1
    camera: Camera = KINECT_V1_HALF

    @property
    def name(self) -> str:
        return f"{self.behind}_{self.hidden_s:g}s_{self.seed}"

    def open(self) -> RecordingWithTruth:
        return RecordingWithTruth(self.make())

    def make(self) -> Scene:
        """Raises InputError where a name or a number is wrong."""
        return hiding_scene(self.behind, self.hidden_s, self.seed, self.camera)


def make_hidings(
    behind: Sequence[str] = (),
    seconds: Sequence[float] = (2, 5, 10),
    seeds: Sequence[int] = (1,),
    camera: Camera = KINECT_V1_HALF,
    pattern: str = "*",
) -> list[SimulatedHiding]:
    """Everything that hides (if nothing is named) for each time with every seed.

    Raises:
        InputError: a name or a number is wrong, or no name matches.
    """
    if not seconds:
        raise InputError("no seconds given; give at least one number, such as 2,5,10")
    made = [
        SimulatedHiding(one, hidden_s, seed, camera)
        for one in behind or HIDERS
        for hidden_s in seconds
        for seed in seeds
    ]
    return select_simulated(made, seeds, pattern, "returns")
