"""Somebody who is in another posture in every frame."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from topview_lab.sim.actions.act import SIDES
from topview_lab.sim.bodies import SIM_JOINT_NAMES
from topview_lab.sim.scene import Box
from topview_lab.sim.scenes import KINECT_V1_HALF
from topview_lab.sim.scenes.postures import (
    KEPT_ON_SEATS,
    LEAST_SEAT_M,
    LYING,
    ON_BODY,
    POSTURES,
    STANDING_STRAIGHT,
    Posing,
    drawn_hands,
    drawn_posture,
    held_postures,
    posture_scene,
    seated_scene,
    touching_scene,
)
from topview_lab.sim.skeleton import (
    SEGMENT_INDEX,
    SEGMENT_LIMITS_RAD,
    angles_array,
    segment_poses,
)

SCENE = posture_scene(0, KINECT_V1_HALF)
BODY, PERFORMANCE = SCENE.actors[0].body, SCENE.actors[0].performance


def joints_at(frame: int) -> NDArray[np.float64]:
    """[J, 3] in the room."""
    return BODY.joints(segment_poses(BODY.offsets_m, PERFORMANCE.pose(BODY, SCENE.time_s(frame))))


@pytest.mark.parametrize("name", [*POSTURES, STANDING_STRAIGHT])
def test_joints_keep_to_their_limits(name: str) -> None:
    """But for the pelvis, whose turn is that of the whole body."""
    rng = np.random.default_rng(0)
    for _ in range(20):
        angles = angles_array(drawn_posture(name, rng).angles)
        least, greatest = SEGMENT_LIMITS_RAD[..., 0], SEGMENT_LIMITS_RAD[..., 1]
        beyond_rad = np.maximum(least - angles, angles - greatest).max(-1)
        assert np.delete(beyond_rad, SEGMENT_INDEX["pelvis"]).max() < 1e-9


@pytest.mark.parametrize("name", POSTURES)
def test_sides_are_drawn_apart(name: str) -> None:
    angles = drawn_posture(name, np.random.default_rng(0)).angles
    left, right = (angles[f"upper_arm_{side}"] for side in SIDES)
    assert left != right


def test_every_frame_shows_another_posture_on_the_floor() -> None:
    places = np.array([joints_at(frame) for frame in range(SCENE.frames)])
    moved_m = np.linalg.norm(np.diff(places, axis=0), axis=-1).max(-1)
    assert moved_m.min() > 0.1
    lowest_m = places[..., 2].min(-1)
    assert (lowest_m > 0.0).all()
    assert (lowest_m < 0.18).all()  # hips of who sits: half the trunk is below them
    assert {PERFORMANCE.action_at(SCENE.time_s(f)) for f in range(SCENE.frames)} == set(POSTURES)


def test_who_lies_lies_low() -> None:
    """Hips are nearer to the floor than those of anybody who stands."""
    heights_m: dict[str, list[float]] = {name: [] for name in POSTURES}
    for frame in range(SCENE.frames):
        pose = PERFORMANCE.pose(BODY, SCENE.time_s(frame))
        heights_m[PERFORMANCE.action_at(SCENE.time_s(frame))].append(float(pose.root_room[2]))
    lying_m = np.concatenate([heights_m[name] for name in LYING])
    assert np.median(lying_m) < 0.35
    assert lying_m.max() < min(heights_m["standing"])


def test_the_seed_tells_all() -> None:
    again, other = posture_scene(0, KINECT_V1_HALF), posture_scene(1, KINECT_V1_HALF)
    same = again.actors[0].performance.pose(again.actors[0].body, 0.5)
    np.testing.assert_array_equal(same.angles_rad, PERFORMANCE.pose(BODY, 0.5).angles_rad)
    assert other.mount != SCENE.mount


@pytest.mark.parametrize("seed", range(4))
def test_who_sits_keeps_to_the_seat_and_moves_trunk_and_arms(seed: int) -> None:
    scene = seated_scene(seed, KINECT_V1_HALF)
    (actor,) = scene.actors
    poses = [
        actor.performance.pose(actor.body, scene.time_s(frame)) for frame in range(scene.frames)
    ]
    hips = np.array([pose.root_room for pose in poses])
    assert np.ptp(hips[:, :2], axis=0).max() == 0.0
    assert np.ptp(hips[:, 2]) < 0.05
    angles = np.array([pose.angles_rad for pose in poses])
    is_kept = [name.startswith(KEPT_ON_SEATS) for name in SEGMENT_INDEX]
    assert np.ptp(angles[:, is_kept], axis=0).max() < np.radians(4.0)
    arms = [SEGMENT_INDEX[f"upper_arm_{side}"] for side in SIDES]
    assert np.ptp(angles[:, arms], axis=0).min() > np.radians(10.0)
    tops_m = [
        part.center_room[2] + part.size_m[2] / 2
        for part in scene.furniture
        if isinstance(part, Box) and np.allclose(part.center_room[:2], hips[0, :2])
    ]
    assert len(tops_m) == 1
    assert LEAST_SEAT_M < tops_m[0] < hips[0, 2]


def test_hands_touch_alike_or_each_as_it_likes() -> None:
    rng = np.random.default_rng(0)
    drawn = [drawn_hands(rng) for _ in range(200)]
    alike = [hands for hands in drawn if len(hands) == 2 and hands["l"] == hands["r"].mirrored()]
    assert 0.5 < len(alike) / len(drawn) < 0.7
    assert {len(hands) for hands in drawn} == {0, 1, 2}
    ups = [hand.at[1] for hands in drawn for hand in hands.values()]
    ends = np.array([up for (_, up, _), _ in ON_BODY.values()])
    assert ends.min() <= min(ups) < -0.1
    assert 0.3 < max(ups) <= ends.max()


@pytest.mark.parametrize("seed", range(3))
def test_whose_hands_are_on_the_body_reaches_it(seed: int) -> None:
    scene = touching_scene(seed, KINECT_V1_HALF)
    (actor,) = scene.actors
    assert isinstance(actor.performance, Posing)
    body, names = actor.body, list(SIM_JOINT_NAMES)
    for frame in range(scene.frames):
        pose = actor.performance.pose(body, scene.time_s(frame))
        joints = body.joints(segment_poses(body.offsets_m, pose))
        held = actor.performance.holdings[frame].held
        trunk = joints[[names.index(name) for name in ("head", "neck", "torso", "pelvis")]]
        for side in held.hands:
            away_m = np.linalg.norm(joints[names.index(f"hand_{side}")] - trunk, axis=1).min()
            assert away_m < 0.22 * body.appearance.stature_m, (held.name, held.hands[side])


def test_a_posture_is_held_with_all_that_stands_round() -> None:
    scene = seated_scene(1, KINECT_V1_HALF)
    held = held_postures(scene, 5, 3)
    assert [own.frames for own in held] == [3, 3]
    assert all(own.furniture == scene.furniture for own in held)
    (actor,) = scene.actors
    (own,) = held[1].actors
    np.testing.assert_array_equal(
        own.performance.pose(own.body, 0.0).root_room[:2],
        actor.performance.pose(actor.body, scene.time_s(5)).root_room[:2],
    )
