"""Feet point where they are proposed, keep their length, and stand at rest where nobody knows."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from rendered_bodies import MODEL, joints_of, standing_pose
from topview.body.ends import ANKLES, FEET_AT_REST, LOWER_LEGS
from topview.body.parts import JOINT_NAMES, PART_NAMES
from topview.detect.joints import JointProposals
from topview.geometry.rotations import rotations_from_angles
from topview.track.feet import Feet
from topview.track.pose import FittedBody

POSE = standing_pose()
BODY = FittedBody(1, MODEL, POSE.transforms(MODEL))
JOINTS = joints_of(POSE)
AT_REST_M = MODEL.stature_m * FEET_AT_REST
TURNED_M = AT_REST_M @ rotations_from_angles(np.radians((25.0, 30.0, 0.0))).T
NAMES = (*JOINT_NAMES, "left_foot", "right_foot")


def proposed(*feet_leg_m: np.ndarray, scale_m: float = 0.02, others_m: float = 0.0):
    """Modes with these feet; each but the last has its other joints so far away."""
    Rs = BODY.Ts_camera_part[LOWER_LEGS, :3, :3]
    modes = [
        np.concatenate([JOINTS, JOINTS[ANKLES] + np.einsum("lab,lb->la", Rs, ways)])
        for ways in feet_leg_m
    ]
    for mode in modes[:-1]:
        mode[: len(JOINTS), 0] += others_m
    M = len(modes)
    scales_m = np.full((1, M, len(NAMES), 3), scale_m)
    return JointProposals(
        np.stack(modes)[None], scales_m, np.full((1, M), 1 / M), np.ones(1), NAMES
    )


def after(proposals: JointProposals | None, frames: int, feet: Feet | None = None, start_s=0.0):
    feet = feet or Feet()
    for f in range(frames - 1):
        feet.update(BODY, proposals, start_s + f / 30)
    return feet.update(BODY, proposals, start_s + (frames - 1) / 30)


def degrees_from(feet_m: np.ndarray, others_m: np.ndarray) -> np.ndarray:
    cosine = (feet_m * others_m).sum(-1) / (AT_REST_M**2).sum(-1)
    return np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0)))


def test_nobody_who_proposes_and_proposals_without_feet_leave_them_at_rest():
    whole = proposed(TURNED_M)
    without = JointProposals(
        whole.positions_camera[:, :, :-2].copy(),
        whole.scales_m[:, :, :-2].copy(),
        whole.weights.copy(),
        whole.p_person.copy(),
        JOINT_NAMES,
    )
    for proposals in (None, without):
        assert_allclose(after(proposals, 5), AT_REST_M, atol=1e-12)


def test_they_turn_to_where_they_are_proposed_and_keep_their_length():
    feet_m = after(proposed(TURNED_M), 15)
    assert (degrees_from(TURNED_M, AT_REST_M) > 30.0).all()
    assert (degrees_from(feet_m, TURNED_M) < 10.0).all()
    assert_allclose(np.linalg.norm(feet_m, axis=-1), np.linalg.norm(AT_REST_M, axis=-1))
    doubtful_m = after(proposed(TURNED_M, scale_m=0.5), 15)
    assert (degrees_from(doubtful_m, AT_REST_M) < 5.0).all()


def test_they_are_quieter_than_what_is_proposed():
    rng = np.random.default_rng(3)
    feet, told, given = Feet(), [], []
    for f in range(90):
        given.append(TURNED_M + rng.normal(0.0, 0.02, (2, 3)))
        told.append(feet.update(BODY, proposed(given[-1]), f / 30))
    assert np.std(told[30:], axis=0).max() < 0.5 * np.std(given[30:], axis=0).min()


def test_the_mode_that_is_nearest_to_the_body_counts():
    away = proposed(AT_REST_M * (1.0, 1.0, -1.0), TURNED_M, others_m=0.3)
    assert_allclose(after(away, 5), after(proposed(TURNED_M), 5))


def test_what_was_seen_is_forgotten():
    feet = Feet()
    after(proposed(TURNED_M), 15, feet)
    assert (degrees_from(after(None, 1, feet, start_s=2.0), AT_REST_M) < 0.1).all()


def test_an_unknown_leg_is_unknown_and_the_other_goes_on():
    Ts = BODY.Ts_camera_part.copy()
    Ts[PART_NAMES.index("left_lower_leg")] = np.nan
    feet = Feet()
    half = np.empty(0)
    for f in range(15):
        half = feet.update(FittedBody(1, MODEL, Ts), proposed(TURNED_M), f / 30)
    assert_allclose(half[1], after(proposed(TURNED_M), 15)[1])
    assert degrees_from(half, AT_REST_M)[0] == pytest.approx(0.0, abs=1e-5)
