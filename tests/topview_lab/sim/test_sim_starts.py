"""Poses that somebody is in from the first frame on."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray

from topview.records import InputError
from topview_lab.sim import SimulatedRecording
from topview_lab.sim.bodies import SIM_JOINT_NAMES
from topview_lab.sim.scene import Scene
from topview_lab.sim.scenes import KINECT_V1_HALF
from topview_lab.sim.scenes.starts import START_DIRECTIONS, START_FRAMES, START_POSES, start_scene
from topview_lab.sim.skeleton import SEGMENT_INDEX, SEGMENT_LIMITS_RAD, segment_poses

SEED = 1
FURNITURE_AND_EDGE = ("half_behind_furniture", "cut_by_the_edge")
TURNED_OUT = [SEGMENT_INDEX[f"thigh_{side}"] for side in "lr"]


def scene_of(pose: str, direction: str = "front") -> Scene:
    return start_scene(pose, direction, SEED, KINECT_V1_HALF)


def joints_at(scene: Scene, frame: int) -> NDArray[np.float64]:
    """[J, 3] in the room."""
    body, performance = scene.actors[0].body, scene.actors[0].performance
    return body.joints(segment_poses(body.offsets_m, performance.pose(body, scene.time_s(frame))))


def test_there_are_twenty_poses_in_four_directions() -> None:
    assert (len(START_POSES), len(START_DIRECTIONS)) == (20, 4)


@pytest.mark.parametrize("pose", START_POSES)
def test_the_body_lies_on_the_floor_and_is_nearly_still(pose: str) -> None:
    scene = scene_of(pose)
    places = [joints_at(scene, frame) for frame in range(0, START_FRAMES, 5)]
    assert np.min(places) + 10.0 > 0.0  # finite
    heights_m = np.array(places)[..., 2]
    assert (heights_m > 0.0).all()
    assert heights_m.min() < 0.12  # the thickness of what touches it
    moved_m = np.linalg.norm(np.ptp(places, axis=0), axis=-1)
    assert 0.0 < moved_m.max() < 0.08


@pytest.mark.parametrize("pose", START_POSES)
def test_joints_keep_to_their_limits(pose: str) -> None:
    """But for the pelvis, whose turn is that of the whole body, and thighs turned out on the
    floor, which do it beyond what is normal while they hang."""
    scene = scene_of(pose)
    angles = scene.actors[0].performance.pose(scene.actors[0].body, 0.0).angles_rad
    least, greatest = SEGMENT_LIMITS_RAD[..., 0], SEGMENT_LIMITS_RAD[..., 1]
    beyond_rad = np.maximum(least - angles, angles - greatest).max(-1)
    free = [SEGMENT_INDEX["pelvis"], *(TURNED_OUT if pose == "cross_legged" else ())]
    assert np.delete(beyond_rad, free).max() < 0.06  # drifts


def test_every_pose_is_another() -> None:
    """The standing ones that furniture and the edge hide are the same."""
    bodies = {}
    for name, held in START_POSES.items():
        if name not in FURNITURE_AND_EDGE:
            actor = scene_of("lunge").actors[0]
            performance = type(actor.performance).at(  # type: ignore[attr-defined]
                held, (0.0, 3.0), 0.0, actor.performance.style
            )
            Ts = segment_poses(actor.body.offsets_m, performance.pose(actor.body, 0.0))
            bodies[name] = actor.body.joints(Ts)
    for one, other in combinations(bodies, 2):
        apart_m = np.linalg.norm(bodies[one] - bodies[other], axis=-1).max()
        assert apart_m > 0.2, (one, other)


def test_a_direction_turns_the_front_of_somebody_who_stands() -> None:
    shoulders = [SIM_JOINT_NAMES.index(f"shoulder_{side}") for side in "lr"]
    for direction, heading_rad in START_DIRECTIONS.items():
        joints = joints_at(scene_of("arms_up", direction), 0)
        left = joints[shoulders[0]] - joints[shoulders[1]]
        front = np.array([left[1], -left[0]]) / np.hypot(*left[:2])
        assert_allclose(front, [np.cos(heading_rad), np.sin(heading_rad)], atol=0.15)


def test_the_desk_and_the_edge_hide_about_half() -> None:
    desk, edge = (
        SimulatedRecording(scene_of(pose)).simulate(0).truth.joint_hidden
        for pose in FURNITURE_AND_EDGE
    )
    names = np.array(SIM_JOINT_NAMES)
    legs, head = np.char.startswith(names, "knee"), names == "head"
    assert desk.by_furniture[0, legs].min() > 0.9
    assert desk.by_furniture[0, head].max() == 0.0
    assert 0.15 < edge.outside[0].mean() < 0.6


@pytest.mark.parametrize(
    ("pose", "direction", "seed", "complaint"),
    [
        ("flying", "front", 1, "pose is 'flying'; it must be one of lying_on_back, "),
        ("kneeling", "up", 1, "direction is 'up'; it must be one of front, left, right, back"),
        ("kneeling", "front", -1, "seed is -1; it must be 0 or more"),
    ],
)
def test_what_there_is_not_is_one_line(
    pose: str, direction: str, seed: int, complaint: str
) -> None:
    with pytest.raises(InputError, match=complaint):
        start_scene(pose, direction, seed, KINECT_V1_HALF)


def test_a_seed_gives_the_same_start_again() -> None:
    first, again = (joints_at(scene_of("lunge", "left"), 7) for _ in range(2))
    assert np.array_equal(first, again)
