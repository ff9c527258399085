"""Other hypotheses of a body: they go on beside what is told, until one leads over time."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from rendered_bodies import MODEL, standing_pose
from topview.body.parts import LEFT_UPPER_ARM, LEFT_UPPER_LEG, UPPER_TORSO
from topview.geometry.rotations import rotations_from_vectors
from topview.track.methods.topview.hypotheses import (
    DISTINCT_M,
    JUDGED_S,
    MOST_BEHIND,
    MOST_HYPOTHESES,
    Hypotheses,
)
from topview.track.pose import TRUNK_PARTS, Pose

HANDICAP = 0.005
TOLD = standing_pose()


def turned(part: int, rad: float, pose: Pose = TOLD) -> Pose:
    """The pose with a limb, or the trunk alone, swung about the camera's axis."""
    Rs = pose.Rs.copy()
    own = TRUNK_PARTS if part == UPPER_TORSO else [part, part + 1]
    Rs[own] = rotations_from_vectors(np.array([0.0, 0.0, rad])) @ Rs[own]
    return Pose(pose.neck_camera, Rs)


def one_arm() -> tuple[Hypotheses, Pose]:
    """A hypothesis of an arm that is raised, as nearly as cheap."""
    kept, raised = Hypotheses(), turned(LEFT_UPPER_ARM, 1.5)
    kept.keep(TOLD, TOLD, set(), {LEFT_UPPER_ARM: [(raised, 0.0)]}, MODEL, HANDICAP)
    assert len(kept) == 1
    return kept, raised


def leads_after_s(gains: np.ndarray, step_s: float) -> float:
    kept, raised = one_arm()
    for frame, gain in enumerate(gains, start=1):
        if kept.judge([raised], [float(gain)], step_s):
            return frame * step_s
    return np.inf


@pytest.mark.parametrize("step_s", [1 / 10, 1 / 30, 1 / 60])
def test_what_costs_less_on_average_leads_after_the_same_time_at_any_rate(step_s):
    gain = 0.003
    expected_s = JUDGED_S * np.log(1.0 + HANDICAP / gain)
    assert abs(leads_after_s(np.full(1000, gain), step_s) - expected_s) <= step_s


def test_what_costs_less_now_and_then_but_more_on_average_does_not_lead():
    noise = np.random.default_rng(0).normal(-0.002, 0.003, 300)
    assert (noise > 0.0).mean() > 0.2
    assert leads_after_s(noise, 1 / 30) == np.inf


def test_what_costs_more_now_does_not_lead_now():
    kept, raised = one_arm()
    assert kept.judge([raised], [0.1], 1.0) == {LEFT_UPPER_ARM: 0}
    assert kept.judge([raised], [-0.001], 1 / 30) == {}


def test_a_limb_goes_with_the_trunk_and_a_trunk_takes_no_limb_along():
    kept, raised = one_arm()
    bent = turned(UPPER_TORSO, 0.5)
    (pose,) = kept.poses(bent)
    own = [LEFT_UPPER_ARM, LEFT_UPPER_ARM + 1]
    swing = bent.Rs[UPPER_TORSO] @ TOLD.Rs[UPPER_TORSO].T
    assert_allclose(pose.Rs[own], swing @ raised.Rs[own], atol=1e-12)
    others = [part for part in range(len(pose.Rs)) if part not in own]
    assert_array_equal(pose.Rs[others], bent.Rs[others])
    kept.keep(TOLD, bent, {UPPER_TORSO}, {}, MODEL, HANDICAP)
    trunk = kept.poses(raised)[0]
    assert_array_equal(trunk.Rs[TRUNK_PARTS], bent.Rs[TRUNK_PARTS])
    assert_array_equal(trunk.Rs[own], raised.Rs[own])


def test_what_was_told_before_goes_on_and_has_to_lead_anew():
    kept, raised = one_arm()
    assert kept.judge([raised], [0.1], 1.0) == {LEFT_UPPER_ARM: 0}
    kept.keep(raised, TOLD, {LEFT_UPPER_ARM}, {}, MODEL, HANDICAP)
    (before,) = kept.poses(raised)
    assert_allclose(before.Rs, TOLD.Rs, atol=1e-12)
    assert kept.judge([TOLD], [0.001], 1 / 30) == {}


def test_none_is_kept_that_is_like_another_or_far_behind():
    kept = Hypotheses()
    slight = DISTINCT_M / 10.0
    arms = [(turned(LEFT_UPPER_ARM, rad), -0.001) for rad in (slight, 1.5, 1.5 + slight)]
    legs = [(turned(LEFT_UPPER_LEG, 1.0), -2.0 * MOST_BEHIND)]
    kept.keep(TOLD, TOLD, set(), {LEFT_UPPER_ARM: arms, LEFT_UPPER_LEG: legs}, MODEL, HANDICAP)
    assert len(kept) == 1
    assert kept.judge(kept.poses(TOLD), [0.1], 10.0 * JUDGED_S) == {LEFT_UPPER_ARM: 0}
    kept.judge(kept.poses(TOLD), [-2.0 * MOST_BEHIND], 10.0 * JUDGED_S)
    kept.keep(TOLD, TOLD, set(), {}, MODEL, HANDICAP)
    assert len(kept) == 0


def test_so_many_are_kept_the_cheapest_of_those_that_are_new():
    kept = Hypotheses()
    several = [(turned(LEFT_UPPER_ARM, 0.25 * k), -0.001 * k) for k in range(1, 12)]
    kept.keep(TOLD, TOLD, set(), {LEFT_UPPER_ARM: several}, MODEL, HANDICAP)
    assert len(kept) == MOST_HYPOTHESES
    for pose, (cheap, _) in zip(kept.poses(TOLD), several, strict=False):
        assert_allclose(pose.Rs, cheap.Rs, atol=1e-12)
