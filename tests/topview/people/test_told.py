"""What the joint network says of the last frame."""

from __future__ import annotations

from dataclasses import replace as replaced

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace
from numpy.typing import NDArray

from dressed_scenes import GROUND_Y, ROOM, person_with, scene_of, track_at
from people_scenes import head_of, render, standing_person
from topview.body.parts import JOINT_NAMES, OUTPUT_JOINT_NAMES
from topview.detect.heads import HEAD_RADIUS_M
from topview.detect.joints.proposals import JointProposals
from topview.people.bodies import own_mask
from topview.people.likelihood import MOST_LOG_ODDS
from topview.people.settings import PeopleSettings
from topview.people.step import Step
from topview.people.told import ELSEWHERE, IN_PLACE, Told
from topview.people.told_head import ELSEWHERE_M, ROUGHLY_M, SURE_M, TOLD_JOINT, ToldHead
from topview.people.track import Track

SCENE = scene_of(render([], ROOM), None, 0)
RIGHT = np.array([1.0, 0.0, 0.0])
PLACE = head_of(0.0, 2.6, GROUND_Y)
ONE = track_at(SCENE, PLACE, 1)
OTHER = track_at(SCENE, PLACE + 1.5 * RIGHT, 2)
BOTH = [ONE, OTHER]


def told_of(id: int, place_camera: NDArray[np.float64], p_person: float = 0.95) -> Told:
    is_sure = p_person > 0.5
    return Told((), {id: ToldHead(p_person, place_camera, 0.03 if is_sure else np.inf)}, True)


def proposals_of(p_person: float, scale_m: float) -> JointProposals:
    """Of one person and two modes, of which the second is the likelier."""
    positions = np.zeros((1, 2, len(JOINT_NAMES), 3))
    positions[0, 1, JOINT_NAMES.index(TOLD_JOINT)] = PLACE
    weights, scales = np.array([[0.2, 0.8]]), np.full(positions.shape, scale_m)
    return JointProposals(positions, scales, weights, np.array([p_person]), JOINT_NAMES)


@pytest.mark.parametrize(
    ("p_person", "sigma_m", "is_sure", "is_rough"),
    [
        (0.9, 0.5 * SURE_M, True, True),
        (0.1, 0.5 * SURE_M, False, False),
        (0.9, 0.5 * (SURE_M + ROUGHLY_M), False, True),
        (0.9, 1.1 * ROUGHLY_M, False, False),
    ],
)
def test_the_head_is_that_of_the_likeliest_mode(
    p_person: float, sigma_m: float, is_sure: bool, is_rough: bool
) -> None:
    told = Told.of((), {1: proposals_of(p_person, sigma_m / 2.0**0.5)}, True)
    head = told.heads[1]
    np.testing.assert_array_equal(head.head_camera, PLACE)
    assert head.is_sure == is_sure
    assert head.is_rough == is_rough
    assert (told.head_of(ONE, BOTH, 0.0) is not None) == is_sure
    assert (told.head_of(ONE, BOTH, 0.0, roughly=True) is not None) == is_rough
    assert head.log_odds == pytest.approx(np.log(p_person / (1.0 - p_person)))
    assert np.isfinite([ToldHead(p, PLACE, 0.03).log_odds for p in (0.0, 1.0)]).all()


def test_what_is_told_of_one_is_nobody_elses() -> None:
    told = told_of(1, PLACE)
    assert told.log_odds_of(ONE, BOTH) == pytest.approx(np.log(19.0))
    assert told.log_odds_of(OTHER, BOTH) is None
    doubtful = replace(OTHER, id=0)
    assert told_of(-doubtful.key, OTHER.place_camera).log_odds_of(doubtful, [ONE, doubtful])


def test_a_head_that_is_seen_elsewhere_speaks_against_a_track() -> None:
    away = PLACE - 1.5 * ELSEWHERE_M * RIGHT
    assert told_of(1, away).log_odds_of(ONE, BOTH) == ELSEWHERE
    assert told_of(1, away, 0.001).log_odds_of(ONE, BOTH) == pytest.approx(np.log(1 / 999))


def near(track: Track) -> Track:
    """Of the other person, beside the track."""
    return replace(OTHER, place_camera=track.place_camera + 0.35 * RIGHT)


def unseen(track: Track) -> Track:
    return replace(track.coasted(SCENE), seen_s=SCENE.time_s - 0.1)


def test_who_is_followed_on_the_body_of_another_is_nobody() -> None:
    other = near(ONE)
    anothers = told_of(1, other.place_camera)
    assert anothers.log_odds_of(ONE, [ONE, other]) == ELSEWHERE
    assert anothers.head_of(ONE, [ONE, other], 0.0) is None
    for others in ([ONE, replace(other, id=0)], [ONE, unseen(other)]):
        assert anothers.head_of(ONE, others, 0.0) is not None
    assert told_of(1, PLACE).head_of(ONE, [ONE, other], 0.0) is not None


@given(st.floats(0.0, 0.35))
def test_two_who_hug_are_two_where_the_network_sees_two_heads(apart_m: float) -> None:
    """However near the head is to that of the other, as long as they are not the same."""
    other = track_at(SCENE, PLACE + 0.3 * RIGHT, 2)
    theirs = ToldHead(0.95, other.place_camera, 0.03)
    own = ToldHead(0.95, other.place_camera - apart_m * RIGHT, 0.03)
    told = Told((), {1: own, 2: theirs}, True)
    is_same = apart_m < min(HEAD_RADIUS_M, abs(0.3 - apart_m))
    assert (told.head_of(ONE, [ONE, other], 0.0) is None) == is_same


def test_the_head_that_the_network_sees_is_a_persons_own() -> None:
    """So no new person has it; where it does not know it claims nothing."""
    seen = PLACE + 0.3 * RIGHT
    assert told_of(1, seen).claims(seen + 0.3 * RIGHT, BOTH)
    assert not told_of(1, seen).claims(PLACE - 0.5 * RIGHT, BOTH)
    assert not told_of(1, seen, 0.2).claims(seen, BOTH)
    assert not told_of(1, seen).claims(seen, [replace(ONE, id=0), OTHER])


def test_a_head_that_was_seen_goes_on_with_its_track() -> None:
    moving = replace(ONE, motion=replace(ONE.motion, velocity=RIGHT))
    head = told_of(1, PLACE).head_of(moving, BOTH, 0.1)
    assert head is not None
    np.testing.assert_allclose(head, PLACE + 0.1 * RIGHT)
    assert told_of(1, PLACE, 0.2).head_of(moving, BOTH, 0.1) is None
    assert Told().head_of(ONE, BOTH, 0.0) is None


def test_no_head_is_where_the_trunk_or_a_leg_of_somebody_is() -> None:
    """But where an arm is, or a joint that is not sure, a head may be."""
    joints = np.full((len(OUTPUT_JOINT_NAMES), 3), np.nan)
    for name, right_m, down_m in (
        ("neck", 0.0, 0.25), ("torso", 0.0, 0.5), ("left_elbow", 0.3, 0.5), ("left_hand", 0.3, 0.8),
    ):  # fmt: skip
        joints[OUTPUT_JOINT_NAMES.index(name)] = PLACE + np.array([right_m, down_m, 0.0])
    on_trunk, beside, on_arm = PLACE + np.array(
        [[0.02, 0.4, -0.07], [0.02, 0.4, -0.12], [0.3, 0.65, 0.0]]
    )
    sure = Told([person_with(joints, IN_PLACE + 0.1)])
    assert sure.is_on_body(on_trunk)
    assert not sure.is_on_body(beside)
    assert not sure.is_on_body(on_arm)
    assert not Told([person_with(joints, IN_PLACE - 0.1)]).is_on_body(on_trunk)
    assert not Told().is_on_body(on_trunk)


def test_what_is_on_another_s_body_speaks_for_the_other() -> None:
    """As a leg does, of which the network is asked as if it were somebody's."""
    told = Told()
    assert told.unless_anothers(9.0, 0.0) == MOST_LOG_ODDS
    assert told.unless_anothers(9.0, 1.0) == told.unless_anothers(0.0, 1.0) == ELSEWHERE
    assert told.unless_anothers(2.0, 0.5) == pytest.approx(0.5 * (2.0 + ELSEWHERE))
    assert told.unless_anothers(2.0 * ELSEWHERE, 0.5) == 2.0 * ELSEWHERE


STANDING, A_FRAME_LATER = (
    scene_of(render(standing_person(0.0, 2.6, GROUND_Y), ROOM), None, index) for index in (0, 1)
)
WHOLE = track_at(STANDING, PLACE)
ITS_JOINTS = np.tile(PLACE, (len(OUTPUT_JOINT_NAMES), 1))
ITS_JOINTS[:, 1] = np.linspace(PLACE[1], GROUND_Y, len(ITS_JOINTS))


@pytest.mark.parametrize(("aside_m", "least", "most"), [(0.0, 0.3, 0.6), (1.5, 0.0, 0.0)])
def test_the_share_on_a_body_is_that_of_points_at_its_bones(
    aside_m: float, least: float, most: float
) -> None:
    """Which are all in one line here."""
    told = Told([person_with(ITS_JOINTS + aside_m * RIGHT, 1.0, OTHER.id)])
    is_own = own_mask(STANDING, WHOLE)
    assert least <= told.share_on_body(STANDING, is_own, [OTHER]) <= most
    assert told.share_on_body(STANDING, is_own, [ONE]) == 0.0  # whose body is not tracked
    assert told.share_on_body(STANDING, np.zeros_like(is_own), [OTHER]) == 0.0


def test_more_is_on_a_body_whose_joints_may_be_off() -> None:
    exact = person_with(ITS_JOINTS + 0.5 * RIGHT, 1.0, OTHER.id)
    is_own = own_mask(STANDING, WHOLE)
    shares = []
    for sigma_m in (0.01, 0.1, 0.4):
        covariances_m2 = np.tile(sigma_m**2 * np.eye(3, dtype=np.float32), (len(ITS_JOINTS), 1, 1))
        unsure = replaced(exact, joint_covariance_m2=covariances_m2)
        shares.append(Told([unsure]).share_on_body(STANDING, is_own, [OTHER]))
    assert shares[0] < 0.05 < shares[1] < 0.95 < shares[2]


@pytest.mark.parametrize(
    ("own", "others", "is_surer"), [(0, 2.0, True), (1, 4.0, True), (1, 2.0, False)]
)
def test_the_network_s_word_on_a_piece_of_a_surer_person_is_that_person_s(
    own: int, others: float, is_surer: bool
) -> None:
    said = replace(WHOLE, id=own, evidence=WHOLE.evidence.with_network(3.0, 1.0, 0.0))
    other = replace(OTHER, evidence=OTHER.evidence.with_network(others, 1.0, 0.0))
    heads = {said.told_as: ToldHead(0.999, PLACE, 0.03)}
    told = Told([person_with(ITS_JOINTS, 1.0, OTHER.id)], heads, True)
    step = Step(A_FRAME_LATER, STANDING, told, PeopleSettings(), before=(said, other))
    after, _ = step.with_evidence([said, other], {1, 2})
    assert (after.evidence.network < said.evidence.network) == is_surer
