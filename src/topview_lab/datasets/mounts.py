"""Cameras that hang otherwise than at the height of a chest: scenes rendered while tracked."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import radians
from typing import Final

from topview.records import Camera
from topview_lab.datasets.base import select_simulated
from topview_lab.datasets.simulated import RecordingWithTruth
from topview_lab.datasets.true_heads import true_heads_from
from topview_lab.metrics.heads import TrueHeads
from topview_lab.sim import Scene, scene_by_name, simulate_truth
from topview_lab.sim.scene import Mount
from topview_lab.sim.scenes import KINECT_V1_HALF

MOUNTS: Final[dict[str, Mount]] = {
    "no-floor": Mount(1.5, radians(-10.0)),
    "45-down": Mount(2.6, radians(45.0), position_room=(0.0, 1.0)),
    "2.6-m": Mount(2.6, radians(25.0)),
}
"""By name: looks up, so that no floor is in view; looks down steeply, from where the heads of
people who stand at 2.4 to 3.4 m are in view; hangs below the ceiling."""
MOUNTED_SCENES: Final = ("crossing",)


@dataclass(frozen=True, slots=True)
class MountedScene:
    """A scene of the simulator under a camera that hangs in a way of its own.

    Attributes:
        mount: one of `MOUNTS`.
        scene: its name.
        seed: of people, room, motions and noise.
        frames: how many, as the scene has it if None.
        camera: whose images are rendered.
    """

    mount: str
    scene: str
    seed: int = 1
    frames: int | None = None
    camera: Camera = KINECT_V1_HALF

    @property
    def name(self) -> str:
        return f"{self.mount}_{self.scene}_{self.seed}"

    def open(self) -> RecordingWithTruth:
        return RecordingWithTruth(self.make())

    def true_heads(self) -> TrueHeads:
        """Of all frames, which are rendered once more for it, without noise."""
        return true_heads_from(simulate_truth(self.make()).arrays())

    def make(self) -> Scene:
        """Raises InputError where a name or a number is wrong."""
        made = scene_by_name(self.scene, seed=self.seed, frames=self.frames, camera=self.camera)
        return replace(made, mount=MOUNTS[self.mount])


def make_mounted(
    scenes: Sequence[str] = (),
    seeds: Sequence[int] = (1,),
    frames: int | None = None,
    camera: Camera = KINECT_V1_HALF,
    pattern: str = "*",
) -> list[MountedScene]:
    """Every scene (`MOUNTED_SCENES` if none is named) under every mount with every seed.

    Raises:
        InputError: a name or a number is wrong, or no name matches.
    """
    made = [
        MountedScene(mount, scene, seed, frames, camera)
        for mount in MOUNTS
        for scene in scenes or MOUNTED_SCENES
        for seed in seeds
    ]
    return select_simulated(made, seeds, pattern, "mounts")
