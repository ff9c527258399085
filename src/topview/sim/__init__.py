"""The simulator: people, motions, rooms and a depth sensor, rendered its own way."""

from topview.sim.cast import CHILD_LOOK, TWELVE_LOOKS
from topview.sim.recording import SimulatedRecording
from topview.sim.scene import Scene
from topview.sim.scenes import SCENES, scene_by_name
from topview.sim.truth import GroundTruth, simulate_truth
from topview.sim.write import write_scene

__all__ = [
    "CHILD_LOOK",
    "SCENES",
    "TWELVE_LOOKS",
    "GroundTruth",
    "Scene",
    "SimulatedRecording",
    "scene_by_name",
    "simulate_truth",
    "write_scene",
]
