"""Scenes of the simulator, rendered while they are tracked: nothing is written to a disk."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from topview.records import Camera, Frame
from topview_lab.datasets.base import select_simulated
from topview_lab.datasets.groundtruth import reference_from
from topview_lab.datasets.true_heads import true_heads_from
from topview_lab.metrics import ReferenceSequence
from topview_lab.metrics.heads import TrueHeads
from topview_lab.sim import SCENES, Scene, SimulatedRecording, scene_by_name, simulate_truth
from topview_lab.sim.scenes import KINECT_V1_HALF
from topview_lab.sim.truth import FrameTruth, GroundTruth, stack_truth


@dataclass(frozen=True, slots=True)
class SimulatedScene:
    """A scene of `topview_lab.sim.SCENES`.

    Attributes:
        scene: its name.
        seed: of bodies, looks, motions and noise.
        people, frames: how many, as the scene has it if None.
        camera: whose images are rendered.
    """

    scene: str
    seed: int = 0
    people: int | None = None
    frames: int | None = None
    camera: Camera = KINECT_V1_HALF

    @property
    def name(self) -> str:
        return f"{self.scene}_{self.seed}"

    def open(self) -> RecordingWithTruth:
        return RecordingWithTruth(self.make())

    def reference(self) -> ReferenceSequence:
        """The truth, for which the whole scene is rendered once more, without noise."""
        return reference_from(simulate_truth(self.make()).arrays(), self.name)

    def true_heads(self) -> TrueHeads:
        """Of all frames, which are rendered once more for it, without noise."""
        return true_heads_from(simulate_truth(self.make()).arrays())

    def make(self) -> Scene:
        """Raises InputError where the name or a number is wrong."""
        return scene_by_name(
            self.scene,
            seed=self.seed,
            people=self.people,
            frames=self.frames,
            camera=self.camera,
        )


@dataclass(frozen=True, slots=True, eq=False)
class MadeScene:
    """A simulated recording of any scene."""

    scene: Scene

    @property
    def name(self) -> str:
        return self.scene.name

    def open(self) -> RecordingWithTruth:
        return RecordingWithTruth(self.scene)

    def true_heads(self) -> TrueHeads:
        """Of all frames, which are rendered once more for it, without noise."""
        return true_heads_from(simulate_truth(self.scene).arrays())


class RecordingWithTruth(SimulatedRecording):
    """A simulated recording that keeps the truth of every frame that is read."""

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self._truths: dict[int, FrameTruth] = {}

    def __iter__(self) -> Iterator[Frame]:
        for index in range(self.frame_count):
            simulated = self.simulate(index)
            self._truths[index] = simulated.truth
            yield self._frame(index, simulated.depth_mm, simulated.color)

    def reference(self) -> ReferenceSequence:
        """The truth of the frames that were read, from the first on."""
        return reference_from(self._truth().arrays(), self.name)

    def true_heads(self) -> TrueHeads:
        """Of the frames that were read, from the first on."""
        return true_heads_from(self._truth().arrays())

    def _truth(self) -> GroundTruth:
        return stack_truth(self.scene, [self._truths[index] for index in sorted(self._truths)])


def make_simulated(
    scenes: Sequence[str] = (),
    seeds: Sequence[int] = (1,),
    people: int | None = None,
    frames: int | None = None,
    camera: Camera = KINECT_V1_HALF,
    pattern: str = "*",
) -> list[SimulatedScene]:
    """Every scene (all of them if none is named) with every seed.

    Args:
        scenes: names.
        seeds: at least one.
        people, frames, camera: as in `SimulatedScene`.
        pattern: globs over the names, which are like `pass_by_1`.

    Raises:
        InputError: a name or a number is wrong, or no name matches.
    """
    made = [
        SimulatedScene(scene, seed, people, frames, camera)
        for scene in scenes or SCENES
        for seed in seeds
    ]
    return select_simulated(made, seeds, pattern, "simulated")
