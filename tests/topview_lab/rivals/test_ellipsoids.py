"""The ellipsoid baseline of the upper body."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rendered_bodies import MODEL, at_frame, evidence_of, standing_pose, subject
from topview.body.parts import JOINTS, LEFT_UPPER_ARM, LEFT_UPPER_LEG, RIGHT_UPPER_ARM
from topview.geometry.rotations import unit
from topview.records import InputError, JointState
from topview.track import Tracker, TrackerSettings
from topview.track.evidence import Evidence
from topview_lab.rivals.ellipsoids import (
    EllipsoidSettings,
    EllipsoidTracker,
    contour_curvature,
    pseudo_distances,
)
from topview_lab.sim import SimulatedRecording, scene_by_name

LEGS = [j for j, joint in enumerate(JOINTS) if joint.part >= LEFT_UPPER_LEG]
ABOVE = [j for j in range(len(JOINTS)) if j not in LEGS]
directions = st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda v: np.linalg.norm(v) > 0.2)
sizes = st.tuples(*[st.floats(0.02, 0.5)] * 3)


def tracked(evidence: Evidence, frames: int = 4) -> np.ndarray:
    tracker = EllipsoidTracker(subject(), EllipsoidSettings())
    poses = [tracker.update(at_frame(evidence, k)) for k in range(frames)]
    return poses[-1].Ts_camera_part


@given(directions, sizes, st.floats(0.2, 3.0))
def test_the_pseudo_distance_is_what_is_left_on_the_way_to_the_surface(way, semi_axes, share):
    axes = np.array(semi_axes)
    surface = unit(np.array(way)) / np.linalg.norm(unit(np.array(way)) / axes)
    left = pseudo_distances(share * surface, axes)
    assert left == pytest.approx((share - 1.0) * np.linalg.norm(surface), abs=1e-9)


@given(directions, st.floats(0.02, 0.5), st.floats(0.2, 3.0))
def test_of_a_sphere_it_is_the_distance(way, radius, distance):
    point = distance * unit(np.array(way))
    assert pseudo_distances(point, np.full(3, radius)) == pytest.approx(distance - radius)


@pytest.mark.parametrize("radius", [20, 45])
def test_a_disc_is_curved_alike_everywhere(radius):
    v, u = np.indices((120, 140))
    disc = (u - 70) ** 2 + (v - 60) ** 2 < radius**2
    place, inward, curvature = contour_curvature(disc, 0.3 * radius)
    np.testing.assert_allclose(curvature, 1.0 / radius, rtol=0.2)
    np.testing.assert_allclose(inward, unit((70, 60) - place), atol=0.1)


def test_corners_are_convex_and_notches_are_not():
    mask = np.zeros((100, 100), bool)
    mask[20:80, 20:80] = True
    mask[20:50, 40:60] = False
    place, _, curvature = contour_curvature(mask, 3.0)

    def at(column: float, row: float) -> float:
        return float(curvature[np.linalg.norm(place - (column, row), axis=1).argmin()])

    assert min(at(20, 20), at(80, 20), at(20, 80)) > 0.05
    assert max(at(40, 50), at(60, 50)) < -0.05
    assert abs(at(50, 80)) < 0.01
    assert len(contour_curvature(np.zeros((9, 9), bool), 3.0)[0]) == 0


@pytest.mark.parametrize("yaw_rad", [0.0, 0.3])
def test_it_finds_a_body_made_of_cylinders(yaw_rad):
    truth = standing_pose(yaw_rad)
    Ts, expected = tracked(evidence_of(truth)), truth.transforms(MODEL)
    assert np.degrees(np.arccos(Ts[1, :3, 1] @ expected[1, :3, 1])) < 8.0
    for upper in (LEFT_UPPER_ARM, RIGHT_UPPER_ARM):
        palms = [T[upper + 1, :3, 3] + T[upper + 1, :3, 1] * MODEL.lengths_m[upper + 1]
                 for T in (Ts, expected)]  # fmt: skip
        assert np.linalg.norm(palms[0] - palms[1]) < 0.1


def test_parts_are_rigid_and_the_same_on_every_run():
    evidence = evidence_of(standing_pose())
    Ts = tracked(evidence, frames=2)
    assert np.isnan(Ts[LEFT_UPPER_LEG:]).all()
    Rs = Ts[:LEFT_UPPER_LEG, :3, :3]
    np.testing.assert_allclose(Rs @ np.swapaxes(Rs, 1, 2), [np.eye(3)] * len(Rs), atol=1e-9)
    np.testing.assert_array_equal(Ts, tracked(evidence, frames=2))


@pytest.mark.parametrize("frames_before", [0, 1])
def test_nothing_seen_leaves_everything_as_it_was(frames_before):
    tracker = EllipsoidTracker(subject(), EllipsoidSettings())
    seen = evidence_of(standing_pose())
    nothing = replace(
        seen,
        user_mask=np.zeros_like(seen.user_mask),
        all_points_camera=np.empty((0, 3)),
        points_camera=np.empty((0, 3)),
        pixels=np.empty(0, np.int32),
        head_is_seen=frames_before == 0,
    )
    shown = [seen] * frames_before + [nothing] * 2
    poses = [tracker.update(at_frame(e, k)).Ts_camera_part for k, e in enumerate(shown)]
    assert np.isfinite(poses[-1][:LEFT_UPPER_LEG]).all()
    np.testing.assert_allclose(poses[-1][1], poses[0][1], atol=1e-9)


def test_absent_legs_go_through_the_tracker():
    recording = SimulatedRecording(scene_by_name("stand", frames=3))
    tracker = Tracker(TrackerSettings(method="ellipsoids", threads=1))
    (person,) = [tracker.update(frame) for frame in recording][-1]
    assert (person.joint_state[LEGS] == JointState.ABSENT).all()
    assert np.isnan(person.joints_camera[LEGS]).all()
    assert np.isfinite(person.joints_camera[ABOVE]).all()


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"noise_m": 0.0}, "noise_m is 0.0; it must be above 0, up to 0.1"),
        ({"most_points": 19}, "most_points is 19; it must be 20 or more"),
    ],
)
def test_settings_out_of_range_are_refused(changed, message):
    with pytest.raises(InputError, match=message):
        EllipsoidSettings(**changed)
