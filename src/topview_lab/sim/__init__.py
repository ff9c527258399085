"""The simulator: people, motions, rooms and a depth sensor, rendered its own way."""

from topview_lab.sim.cast import CHILD, TWELVE_PEOPLE
from topview_lab.sim.recording import SimulatedRecording
from topview_lab.sim.scene import Scene
from topview_lab.sim.scenes import SCENES, scene_by_name
from topview_lab.sim.truth import GroundTruth, simulate_truth
from topview_lab.sim.write import write_scene

__all__ = [
    "CHILD",
    "SCENES",
    "TWELVE_PEOPLE",
    "GroundTruth",
    "Scene",
    "SimulatedRecording",
    "scene_by_name",
    "simulate_truth",
    "write_scene",
]
