from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from rendered_bodies import MODEL, at_frame, evidence_of, standing_pose, subject
from topview.body.model import BodyModel
from topview.body.parts import (
    JOINTS,
    LEFT_UPPER_ARM,
    LEFT_UPPER_LEG,
    PARTS,
    RIGHT_UPPER_ARM,
    UPPER_TORSO,
)
from topview.geometry.quadrics import closed_cylinder_depths
from topview.geometry.rotations import transform, unit
from topview.kernels.arms import BODYS, OPEN, OTHERS, compare_arms
from topview.people.users import HandCandidate, User
from topview.records import Camera, JointState
from topview.track import Tracker, TrackerSettings
from topview.track.areas import UserAreas
from topview.track.evidence import Evidence
from topview.track.methods.btvr import BTVR_AS_PRINTED, BtvrSettings, BtvrTracker
from topview.track.methods.btvr.arm_angles import arm_angles, beyond_ranges_rad
from topview.track.methods.btvr.arms import ArmFilter, ArmSettings
from topview.track.methods.btvr.ellipses import fit_ellipses
from topview.track.methods.btvr.torso import TorsoFilter, views_around
from topview.track.methods.btvr.torso_shape import NARROW
from topview.track.methods.btvr.tracker import PROPORTIONS
from topview.track.methods.btvr.yaw import (
    SHOULDER_SECTION,
    TRUNK_SECTION,
    YAWS_RAD,
    YawFilter,
)
from topview.track.methods.btvr.yaw_cues import FEET_FORWARD, HEAD_FORWARD, Before, YawCues
from topview.track.stances import facing
from topview_lab.sim import SimulatedRecording, scene_by_name

LEGS = [j for j, joint in enumerate(JOINTS) if joint.part >= LEFT_UPPER_LEG]
ABOVE = [j for j in range(len(JOINTS)) if j not in LEGS]
UPPER = BodyModel.of(MODEL.stature_m, PROPORTIONS)
CAMERA = Camera(fx=100, fy=100, cx=49.5, cy=49.5, width=100, height=100)

Array = NDArray[np.float64]

directions = st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda v: np.linalg.norm(v) > 0.2)


def tracked(evidence, frames: int = 4, seed: int = 0, threads: int = 1):
    tracker = BtvrTracker(subject(seed, threads), BtvrSettings())
    poses = [tracker.update(at_frame(evidence, k)) for k in range(frames)]
    return poses[-1].Ts_camera_part


def half_ellipse(rng, turn_rad, centre, semi_axes):
    """[N, 2] points on the side of an ellipse that faces -z."""
    angle = rng.uniform(np.pi, 2 * np.pi, 400)
    ellipse = np.stack([semi_axes[0] * np.cos(angle), semi_axes[1] * np.sin(angle)], axis=1)
    c, s = np.cos(turn_rad), np.sin(turn_rad)
    return ellipse @ np.array([[c, -s], [s, c]]) + centre


@settings(max_examples=25)
@given(st.floats(-0.6, 0.6), st.integers(0, 9))
def test_the_ellipse_of_the_right_turn_fits_best(turn, seed):
    semi_axes, centre = np.array([0.18, 0.10]), (0.01, -0.015)
    points = half_ellipse(np.random.default_rng(seed), turn, centre, semi_axes)
    turns = np.array([turn - 0.2, turn, turn + 0.2])
    costs, centres = fit_ellipses(
        points, semi_axes, turns, np.zeros((3, 2)), centre_sigma_m=1.0, iterations=10
    )
    assert np.argmin(costs) == 1
    assert costs[1] < 0.01
    np.testing.assert_allclose(centres[1], centre, atol=0.002)


def test_an_ellipse_that_is_held_firmly_stays():
    semi_axes = np.array([0.18, 0.10])
    points = half_ellipse(np.random.default_rng(0), 0.3, (0.05, 0.05), semi_axes)
    _, centres = fit_ellipses(points, semi_axes, np.zeros(1), np.zeros((1, 2)), centre_sigma_m=1e-5)
    np.testing.assert_allclose(centres, 0.0, atol=1e-3)


@given(st.floats(0.1, 1.5), st.integers(20, 200))
def test_views_cover_a_cap_evenly(reach_rad, count):
    middle = unit(np.array([0.3, 0.8, -0.2]))
    views = views_around(middle, count, reach_rad)
    np.testing.assert_allclose(np.linalg.norm(views, axis=1), 1.0, atol=1e-9)
    assert np.arccos((views @ middle).min()) <= reach_rad + 1e-6
    mean_cosine = 0.5 * (1.0 + np.cos(reach_rad))
    assert (views @ middle).mean() == pytest.approx(mean_cosine, abs=1e-6)
    np.testing.assert_allclose(unit(views.mean(0)), middle, atol=0.1)


def torso_shell(rng, turn_rad, behind_m):
    """[N, 3] what the camera, on the side of +z, sees of shoulders and trunk below a neck joint."""
    pieces = []
    for piece in (SHOULDER_SECTION, TRUNK_SECTION):
        semi_axes = MODEL.stature_m * np.array(piece.semi_axes)
        middle = -behind_m * np.array([np.sin(turn_rad), np.cos(turn_rad)])
        angle = rng.uniform(0.0, 2 * np.pi, 800)
        own = np.stack([semi_axes[0] * np.cos(angle), semi_axes[1] * np.sin(angle)], axis=1)
        c, s = np.cos(turn_rad), np.sin(turn_rad)
        across = own @ np.array([[c, -s], [s, c]])
        across = across[across[:, 1] > 0.0] + middle
        along = MODEL.stature_m * rng.uniform(piece.top, piece.bottom, len(across))
        pieces.append(np.stack([across[:, 0], along, across[:, 1]], axis=1))
    return np.concatenate(pieces)


@pytest.mark.parametrize("turn", [-1.0, 0.0, 0.7])
def test_the_belief_finds_a_turn_and_keeps_it_unseen(turn):
    yaw_filter, behind_m = YawFilter(), 0.045 * MODEL.stature_m
    points = torso_shell(np.random.default_rng(1), turn, behind_m)
    found = [yaw_filter.update(points, MODEL.stature_m, 0.045) for _ in range(30)][-1]
    assert found == pytest.approx(turn, abs=0.06)
    nothing = np.empty((0, 3))
    kept = [yaw_filter.update(nothing, MODEL.stature_m, 0.045) for _ in range(10)][-1]
    assert kept == pytest.approx(found, abs=0.1)


@pytest.mark.parametrize("rate_rad", [-0.1, 0.1])
def test_who_turns_round_is_followed_all_the_way_and_turns_on_unseen(rate_rad):
    yaw_filter, rng, found = YawFilter(), np.random.default_rng(1), 0.0
    behind_m = 0.045 * MODEL.stature_m
    for turn in rate_rad * np.arange(64):
        points = torso_shell(rng, turn, behind_m)
        found = yaw_filter.update(points, MODEL.stature_m, 0.045)
        assert abs((found - turn + np.pi) % (2 * np.pi) - np.pi) < 0.4
    nothing = np.empty((0, 3))
    later = [yaw_filter.update(nothing, MODEL.stature_m, 0.045) for _ in range(5)][-1]
    assert (later - found) * np.sign(rate_rad) > 0.2


def mean_before(law: Before, turn: float) -> float:
    """Of who is turned so from facing the camera, in shares of the stature."""
    return law.mean - law.towards_camera * np.cos(turn)


@pytest.mark.parametrize("turn", [-2.5, -1.2, 0.0, 0.4, 1.8, np.pi])
def test_the_feet_tell_the_front_from_the_back(turn):
    seen, floor = head_alone(), np.array([0.0, -1.0, 0.0, 1.0])
    front = np.array([np.sin(turn), 0.0, np.cos(turn)])
    rng, height_m = np.random.default_rng(1), MODEL.stature_m
    shins, feet = rng.normal(0.0, 0.01, (2, 60, 3)) * height_m
    shins[:, 1] -= 0.12 * height_m
    feet[:, 1] = -0.02 * height_m
    feet += mean_before(FEET_FORWARD, turn) * height_m * front
    points = np.concatenate([shins, feet]) @ facing(0.0, floor[:3]).T
    points = np.stack([points[:, 0], 1.0 + np.concatenate([shins, feet])[:, 1], points[:, 2]], 1)
    told = YawCues(with_feet=True).log_likelihood(
        replace(seen, all_points_camera=points, floor=floor), MODEL.stature_m
    )
    true, opposite = (np.cos(YAWS_RAD - turn - half).argmax() for half in (0.0, np.pi))
    assert told[true] > told[opposite] + 0.02


@pytest.mark.parametrize("turn", [-2.5, -1.2, 0.0, 0.4, 1.8, np.pi])
def test_the_head_tells_the_front_from_the_back(turn):
    """Its measured centre and the trunk lie towards the camera by different amounts."""
    seen, up = evidence_of(standing_pose()), np.array([0.0, -1.0, 0.0])
    R_upright = facing(0.0, up)
    before = mean_before(HEAD_FORWARD, turn)
    shell = torso_shell(np.random.default_rng(1), turn, before * MODEL.stature_m)
    shell[:, 1] += 0.09 * MODEL.stature_m
    points = seen.head_camera + shell @ R_upright.T
    told = YawCues().log_likelihood(replace(seen, all_points_camera=points), MODEL.stature_m)
    true, opposite = (np.cos(YAWS_RAD - turn - half).argmax() for half in (0.0, np.pi))
    assert told[true] > told[opposite] + 0.05


@pytest.mark.parametrize("turn", [0.0, 2.0, np.pi])
def test_whoever_is_new_may_face_any_way_and_other_evidence_tells_it(turn):
    yaw_filter = YawFilter(any_first_yaw=True)
    yaw_filter.fuse(5.0 * np.cos(YAWS_RAD - turn))
    assert abs((yaw_filter.yaw_rad - turn + np.pi) % (2 * np.pi) - np.pi) < 0.1


def head_alone() -> Evidence:
    """Somebody of whom nothing but the head is seen."""
    return replace(evidence_of(standing_pose()), all_points_camera=np.empty((0, 3)))


def test_a_face_tells_the_front():
    seen = head_alone()
    assert not YawCues().log_likelihood(seen, MODEL.stature_m).any()
    towards = YawCues().log_likelihood(replace(seen, face_share=1.0), MODEL.stature_m)
    away = YawCues().log_likelihood(replace(seen, face_share=0.0), MODEL.stature_m)
    np.testing.assert_allclose(towards, -away)
    assert abs(YAWS_RAD[np.argmax(towards)]) < 0.3


@pytest.mark.parametrize(
    ("speed_m", "turn"), [((0.05, 0.0, 0.0), -np.pi / 2), ((0, 0, 0.05), np.pi)]
)
def test_people_walk_to_their_front(speed_m, turn):
    walking, seen = YawCues(), head_alone()
    told = [
        walking.log_likelihood(
            replace(seen, head_camera=seen.head_camera + k * np.array(speed_m)), MODEL.stature_m
        )
        for k in range(15)
    ]
    assert not told[0].any()
    assert np.cos(YAWS_RAD[np.argmax(told[-1])] - turn) > 0.99


@given(directions, directions)
def test_a_leaning_head_is_no_walk(start, end):
    nodding, seen = YawCues(), head_alone()
    for place in (start, end):
        moved = seen.head_camera + 0.15 * unit(np.array(place))
        told = nodding.log_likelihood(replace(seen, head_camera=moved), MODEL.stature_m)
        assert not told.any()


def test_hands_that_are_the_other_ones_count_less():
    left, right = (ArmFilter(u, side, ArmSettings()) for u, side in
                   ((LEFT_UPPER_ARM, -1.0), (RIGHT_UPPER_ARM, 1.0)))  # fmt: skip
    hand = HandCandidate(np.zeros(3), 0.8, left_share=0.75)
    assert left._confidence(hand) == pytest.approx(0.6)
    assert right._confidence(hand) == pytest.approx(0.2)


@given(directions, directions)
def test_a_mirrored_arm_has_the_same_angles(upper, lower):
    axes = unit(np.array([[upper, lower]]))
    np.testing.assert_allclose(
        arm_angles(axes, 1.0), arm_angles(axes * (-1.0, 1.0, 1.0), -1.0), atol=1e-9
    )


def test_ranges_of_the_arm():
    to_front, down, back_up, up = (0, 0, 1), (0, 1, 0), (-0.3, -0.3, -0.9), (0, -1, 0)
    pairs = [(down, down), (to_front, to_front), (back_up, back_up), (down, up)]
    arms = unit(np.array(pairs, np.float64))
    beyond = beyond_ranges_rad(arm_angles(arms, 1.0))
    np.testing.assert_allclose(beyond[:2], 0.0, atol=1e-9)
    assert beyond[2] > 0.5  # behind the back
    assert beyond[3] == pytest.approx(np.radians(180 - 145))  # folded up


def test_the_kernel_compares_as_the_definition_does():
    rng = np.random.default_rng(3)
    v, u = np.indices((100, 100), np.float64)
    rays = np.stack([(u - 49.5) / 100, (v - 49.5) / 100, np.ones_like(u)], -1)
    depth = rng.uniform(1.6, 2.4, (100, 100)) * (rng.random((100, 100)) > 0.1)
    whose = rng.integers(0, 3, (100, 100)).astype(np.uint8)
    worth = rng.random((100, 100)).astype(np.float32)
    lengths, radii = np.array([0.3, 0.28]), np.array([0.05, 0.04])
    shoulders = np.array([[0.1, -0.3, 2.0], [-0.2, 0.0, 2.1]])
    axes = unit(rng.standard_normal((2, 2, 3)))
    f4 = np.float32
    sums = np.empty((2, 3))
    compare_arms(
        shoulders.astype(f4), axes.astype(f4), lengths.astype(f4), radii.astype(f4),
        depth.astype(f4), whose, worth, f4(100), f4(100), f4(49.5), f4(49.5), f4(0.1), f4(0.03),
        f4(0.07), sums,
    )  # fmt: skip
    for shoulder, (upper, lower), counted in zip(shoulders, axes, sums, strict=True):
        rendered = np.full(depth.shape, np.inf)
        elbow = shoulder + upper * lengths[0]
        for start, axis, length, r in (
            (shoulder, upper, lengths[0], radii[0]),
            (elbow, lower, lengths[1], radii[1]),
        ):
            x = unit(np.asarray(np.cross(axis, (0.3, 0.5, 0.7)), np.float64))
            R = np.asarray(np.stack([x, axis, np.cross(x, axis)], axis=1), np.float64)
            T = transform(R, start)
            rendered = np.minimum(rendered, closed_cylinder_depths(rays, T, length, r, r))
        hit = np.isfinite(rendered)
        off = np.abs(depth - rendered)
        is_before = depth < rendered
        cost = np.minimum(off, 0.1)
        cost = np.where((whose == BODYS) & is_before, np.minimum(off, 0.07), cost)
        cost = np.where(whose == OTHERS, np.where(is_before, 0.03, 0.1), cost)
        explained = worth[hit & (whose == OPEN) & (cost < 0.1)].sum()
        expected = (cost[hit].sum(), hit.sum(), explained)
        np.testing.assert_allclose(counted, expected, rtol=0.01, atol=0.15)


def users_at(*places: tuple[float, float]) -> tuple[list[User], np.ndarray]:
    """Users 20 pixels wide and 40 high, by column and distance; who owns each pixel."""
    owner = np.zeros((100, 100), np.int32)
    users = []
    for k, (column, distance_m) in enumerate(places, start=1):
        left = int(column)
        mask = np.zeros_like(owner, bool)
        mask[30:70, left : left + 20] = True
        head = np.array([(left + 10 - 49.5) / 100, (30 - 49.5) / 100, 1.0]) * distance_m
        pixels = np.flatnonzero(mask & (owner == 0)).astype(np.int32)
        users.append(User(k, head, True, 1.7, True, pixels))
        owner.ravel()[pixels] = k
    return users, owner


def test_areas_remember_what_is_hidden():
    areas = UserAreas()
    assert areas.hidden_shares(*users_at((10, 2.0), (60, 3.0)), CAMERA, 0.00) == {1: 0.0, 2: 0.0}
    half = areas.hidden_shares(*users_at((50, 2.0), (60, 3.0)), CAMERA, 0.03)
    assert half[1] == 0.0
    assert half[2] == pytest.approx(0.5, abs=0.15)
    assert areas.hidden_shares(*users_at((60, 2.0), (60, 3.0)), CAMERA, 0.07)[2] > 0.8


def test_an_area_is_learnt_after_a_first_frame_at_time_0():
    areas, fresh = UserAreas(), UserAreas()
    areas.hidden_shares(*users_at((10, 3.0)), CAMERA, 0.0)
    areas.hidden_shares(*users_at((10, 2.0)), CAMERA, 10.0)
    fresh.hidden_shares(*users_at((10, 2.0)), CAMERA, 10.0)
    np.testing.assert_allclose(areas._areas[1].covariance, fresh._areas[1].covariance, rtol=1e-9)


def seen_upper_body(yaw_rad: float = 0.0) -> tuple[Evidence, Array]:
    """Somebody whose head is before the trunk, as people's are, and the [11, 4, 4] parts."""
    pose = standing_pose(yaw_rad)
    R = pose.Rs[UPPER_TORSO]
    offset = NARROW.neck_behind * R[:, 2] - NARROW.neck_below * R[:, 1]
    head_camera = pose.neck_camera + UPPER.stature_m * offset
    evidence = replace(evidence_of(pose, UPPER), head_camera=head_camera)
    return evidence, pose.transforms(UPPER)


def test_it_finds_torso_and_arms_of_a_body_made_of_cylinders():
    evidence, expected = seen_upper_body()
    Ts = tracked(evidence)
    for axis in (0, 1):
        assert np.degrees(np.arccos(Ts[1, :3, axis] @ expected[1, :3, axis])) < 6.0
    for upper in (LEFT_UPPER_ARM, RIGHT_UPPER_ARM):
        palms = [T[upper + 1, :3, 3] + T[upper + 1, :3, 1] * UPPER.lengths_m[upper + 1]
                 for T in (Ts, expected)]  # fmt: skip
        assert np.linalg.norm(palms[0] - palms[1]) < 0.08


def test_as_printed_the_torso_follows_from_what_is_seen_alone():
    (first, _), (second, expected) = seen_upper_body(0.0), seen_upper_body(0.6)
    Rs = []
    for seen in ((second,) * 4, (first, second, second, second)):
        torso = TorsoFilter(BTVR_AS_PRINTED.torso, threads=1)
        frames = [torso.update(UPPER, at_frame(each, k)) for k, each in enumerate(seen)]
        Rs.append(frames[-1].R_camera_torso)
    np.testing.assert_allclose(Rs[0], Rs[1], atol=1e-12)
    assert np.degrees(np.arccos(Rs[0][:, 1] @ expected[1, :3, 1])) < 8.0
    assert np.degrees(np.arccos(Rs[0][:, 0] @ expected[1, :3, 0])) < 25.0  # arms hang beside it


def test_parts_are_rigid_connected_and_without_legs():
    Ts = tracked(evidence_of(standing_pose()))
    assert np.isnan(Ts[LEFT_UPPER_LEG:]).all()
    Rs = Ts[:LEFT_UPPER_LEG, :3, :3]
    np.testing.assert_allclose(Rs @ np.swapaxes(Rs, 1, 2), [np.eye(3)] * len(Rs), atol=1e-9)
    for part in range(1, LEFT_UPPER_LEG):
        if PARTS[part].is_hinge:
            upper = PARTS[part].parent
            elbow = Ts[upper, :3, 3] + Ts[upper, :3, 1] * UPPER.lengths_m[upper]
            np.testing.assert_allclose(elbow, Ts[part, :3, 3], atol=1e-9)


def test_the_same_seed_gives_the_same_for_any_number_of_threads():
    evidence = evidence_of(standing_pose())
    one = tracked(evidence, frames=2)
    np.testing.assert_array_equal(one, tracked(evidence, frames=2, threads=2))
    assert not np.array_equal(one, tracked(evidence, frames=2, seed=1), equal_nan=True)


def test_nothing_seen_keeps_the_torso():
    tracker = BtvrTracker(subject(), BtvrSettings())
    seen = evidence_of(standing_pose())
    before = tracker.update(seen).Ts_camera_part
    nothing = replace(
        seen,
        user_mask=np.zeros_like(seen.user_mask),
        all_points_camera=np.empty((0, 3)),
        points_camera=np.empty((0, 3)),
        pixels=np.empty(0, np.int32),
        head_is_seen=False,
    )
    after = tracker.update(at_frame(nothing, 1)).Ts_camera_part
    np.testing.assert_allclose(after[1], before[1], atol=5e-3)  # the belief in its turn spreads
    assert np.isfinite(after[:LEFT_UPPER_LEG]).all()


def test_absent_legs_go_through_tracker_and_finder():
    recording = SimulatedRecording(scene_by_name("stand", frames=3))
    tracker = Tracker(TrackerSettings(method="btvr", threads=1))
    nowhere = HandCandidate(np.array([0.0, 0.0, 9.0]), 0.9)
    people = [tracker.update(frame, hands=[nowhere]) for frame in recording]
    (person,) = people[-1]
    assert (person.joint_state[LEGS] == JointState.ABSENT).all()
    assert (person.joint_confidence[LEGS] == 0.0).all()
    assert np.isnan(person.joints_camera[LEGS]).all()
    assert np.isfinite(person.joints_camera[ABOVE]).all()
    assert (person.joint_state[ABOVE] != JointState.ABSENT).all()
