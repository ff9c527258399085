"""How far proposed joints can be relied on: wider scales where a window looks unfamiliar."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from topview.detect.joints import JointProposals
from topview.track.familiarity import (
    FAMILIAR_DISAGREEMENT,
    FAMILIAR_DOUBT,
    FAMILIAR_RESIDUAL,
    LEAST_DISAGREEMENT,
    LONGEST_STEP_S,
    DisagreementOverTime,
    Familiarity,
    FamiliarityOverTime,
    widening_beside,
)

residuals = st.floats(0.0, 50.0)
shares = st.floats(0.0, 1.0)


def test_what_is_familiar_is_not_widened():
    assert Familiarity().widening == 1.0
    assert Familiarity(FAMILIAR_RESIDUAL / 2.0, FAMILIAR_DOUBT / 2.0).widening == 1.0


@given(residuals, shares, st.floats(1e-4, 2.0))
def test_scales_are_widened(residual, doubt, scale_m):
    proposals = JointProposals(
        np.ones((1, 1, 1, 3)),
        np.full((1, 1, 1, 3), scale_m),
        np.ones((1, 1)),
        np.ones(1),
        ("head",),
    )
    familiarity = Familiarity(residual, doubt)
    trusted_m = familiarity.trusted_scales_m(proposals)
    np.testing.assert_array_equal(trusted_m, familiarity.widening * proposals.scales_m)


def two_joints(to_cover_m: list[float] | None) -> JointProposals:
    return JointProposals(
        np.ones((1, 1, 2, 3)),
        np.full((1, 1, 2, 3), 0.01),
        np.ones((1, 1)),
        np.ones(1),
        ("head", "neck"),
        None if to_cover_m is None else np.array([[to_cover_m]]),
    )


def test_only_joints_beside_others_are_trusted_less_than_the_person():
    familiarity = Familiarity(residual=1.0)
    alone = familiarity.widened_scales_m(two_joints(None))
    np.testing.assert_array_equal(familiarity.trusted_scales_m(two_joints(None)), alone)
    touching = two_joints([np.inf, 0.05])
    np.testing.assert_array_equal(familiarity.widened_scales_m(touching), alone)
    trusted = familiarity.trusted_scales_m(touching)
    np.testing.assert_array_equal(trusted[..., 0, :], alone[..., 0, :])
    assert (trusted[..., 1, :] > 1.2 * alone[..., 1, :]).all()


@given(st.floats(0.0, 3.0), st.floats(0.0, 3.0))
def test_nearer_to_others_never_makes_joints_surer(here_m, further_m):
    near, far = widening_beside(np.array([here_m, here_m + further_m]))
    assert near >= far >= 1.0


@given(residuals, shares, residuals, shares)
def test_a_worse_fit_and_more_doubt_never_make_joints_surer(residual, doubt, more, less_sure):
    here = Familiarity(residual, doubt).widening
    assert here >= 1.0
    assert Familiarity(residual + more, doubt).widening >= here
    assert Familiarity(residual, min(doubt + less_sure, 1.0)).widening >= here


def test_ten_times_the_doubt_or_the_residual_widens():
    assert Familiarity(doubt=10.0 * FAMILIAR_DOUBT).widening > 1.3
    assert Familiarity(residual=10.0 * FAMILIAR_RESIDUAL).widening > 1.3


@given(shares, st.floats(1 / 120, 1.0))
def test_a_doubt_that_stays_is_the_doubt(p_person, elapsed_s):
    over_time = FamiliarityOverTime()
    told = [over_time.update(0.1, p_person, elapsed_s) for _ in range(5)][-1]
    assert told.doubt == pytest.approx(1.0 - p_person, abs=1e-6)
    assert told.residual == 0.1


def test_one_odd_frame_hardly_counts_and_a_new_look_is_learnt():
    over_time = FamiliarityOverTime()
    sure = [over_time.update(0.1, 0.999, 1 / 30) for _ in range(300)][-1]
    odd = over_time.update(0.1, 0.5, 1 / 30)
    assert sure.doubt < odd.doubt < 2.0 * sure.doubt
    lasting = [over_time.update(0.1, 0.5, 1 / 30) for _ in range(900)][-1]
    assert lasting.doubt == pytest.approx(0.5, rel=0.05)


def a_head_at(place_camera: tuple[float, float, float]) -> JointProposals:
    return JointProposals(
        np.array([[[place_camera]]]),
        np.full((1, 1, 1, 3), 0.01),
        np.ones((1, 1)),
        np.ones(1),
        ("head",),
    )


def disagreement_of(places_camera: list[tuple[float, float, float]], step_s: float = 1 / 30):
    over_time = DisagreementOverTime()
    told = [over_time.update(a_head_at(p), i * step_s) for i, p in enumerate(places_camera)]
    return told[-1]


def test_nothing_is_expected_of_the_third_place_but_by_two():
    assert disagreement_of([(0.0, 0.0, 2.0)] * 2) is None
    assert disagreement_of([(0.0, 0.0, 2.0)] * 3) is not None


@given(st.floats(-0.1, 0.1), st.floats(-0.1, 0.1))
def test_whoever_keeps_their_velocity_agrees(across_m, down_m):
    places = [(across_m * i, down_m * i, 2.0) for i in range(6)]
    assert disagreement_of(places) == pytest.approx(LEAST_DISAGREEMENT, rel=1e-6)


def test_what_jumps_to_a_side_disagrees_on_that_axis_alone():
    places = [(0.05 * (i % 2), 0.0, 2.0) for i in range(9)]
    told = disagreement_of(places)
    assert told is not None
    assert told[0, 0] > 1.0
    assert told[0, 1:] == pytest.approx(LEAST_DISAGREEMENT)


def test_where_frames_are_rare_the_same_jump_says_less():
    places = [(0.05 * (i % 2), 0.0, 2.0) for i in range(9)]
    often, rarely = disagreement_of(places), disagreement_of(places, 0.2)
    assert often is not None
    assert rarely is not None
    assert rarely[0, 0] < 0.5 * often[0, 0]


def test_after_a_pause_nothing_is_expected():
    over_time = DisagreementOverTime()
    for i in range(5):
        over_time.update(a_head_at((0.0, 0.0, 2.0)), i / 30)
    after_s = 5 / 30 + 2.0 * LONGEST_STEP_S
    assert over_time.update(a_head_at((1.0, 0.0, 2.0)), after_s) is None


def test_joints_that_disagree_are_trusted_less_than_stated_and_others_more():
    told = FAMILIAR_DISAGREEMENT * np.array([[0.5, 1.0, 4.0]])
    scales = Familiarity(disagreement=told).trusted_scales_m(a_head_at((0.0, 0.0, 2.0)))[0, 0, 0]
    assert scales[0] < 0.01
    assert scales[1] == pytest.approx(0.01)
    assert scales[2] > 0.012
