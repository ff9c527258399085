"""Starts: somebody is in some pose from the first frame of a simulated recording on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from topview.records import Camera
from topview_lab.datasets.base import select_simulated
from topview_lab.datasets.groundtruth import reference_from
from topview_lab.datasets.simulated import RecordingWithTruth
from topview_lab.metrics import ReferenceSequence
from topview_lab.sim import Scene, simulate_truth
from topview_lab.sim.scenes import KINECT_V1_HALF
from topview_lab.sim.scenes.starts import START_DIRECTIONS, START_POSES, start_scene


@dataclass(frozen=True, slots=True)
class SimulatedStart:
    """A scene of `topview_lab.sim.scenes.starts`.

    Attributes:
        pose, direction: their names.
        seed: of body, room and noise.
        camera: whose images are rendered.
    """

    pose: str
    direction: str
    seed: int = 1
    camera: Camera = KINECT_V1_HALF

    @property
    def name(self) -> str:
        return f"{self.pose}_{self.direction}_{self.seed}"

    def open(self) -> RecordingWithTruth:
        return RecordingWithTruth(self.make())

    def reference(self) -> ReferenceSequence:
        """The truth, for which the whole scene is rendered once more, without noise."""
        return reference_from(simulate_truth(self.make()).arrays(), self.name)

    def make(self) -> Scene:
        """Raises InputError where the name or a number is wrong."""
        return start_scene(self.pose, self.direction, self.seed, self.camera)


def make_starts(
    poses: Sequence[str] = (),
    seeds: Sequence[int] = (1,),
    camera: Camera = KINECT_V1_HALF,
    pattern: str = "*",
) -> list[SimulatedStart]:
    """Every pose (all of them if none is named) in every direction with every seed.

    Args:
        poses: names.
        seeds: at least one.
        camera: as in `SimulatedStart`.
        pattern: globs over the names, which are like `squatting_left_1`.

    Raises:
        InputError: a name or a number is wrong, or no name matches.
    """
    made = [
        SimulatedStart(pose, direction, seed, camera)
        for pose in poses or START_POSES
        for direction in START_DIRECTIONS
        for seed in seeds
    ]
    return select_simulated(made, seeds, pattern, "starts")
