"""Hands that the colour of skin shows, and the arms that they belong to."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rendered_bodies import MODEL, evidence_of, joints_of, standing_pose
from topview.body import JOINT_NAMES
from topview.body.parts import LEFT_FOREARM, LEFT_UPPER_ARM, RIGHT_UPPER_ARM
from topview.filter.particles import generator
from topview.people.users import HandCandidate
from topview.track.evidence import Evidence
from topview.track.methods.topview.hands import hands_of_arms
from topview.track.methods.topview.limbs import LIMBS, LimbSearch, LimbSettings
from topview.track.pose import Pose

POSE = standing_pose()
ENDS = {
    upper: joints_of(POSE)[JOINT_NAMES.index(name)]
    for upper, name in ((LEFT_UPPER_ARM, "left_hand"), (RIGHT_UPPER_ARM, "right_hand"))
}


def on_the_skin(end: np.ndarray) -> np.ndarray:
    return end * (1.0 - MODEL.radii_m[LEFT_FOREARM, 0] / np.linalg.norm(end))


@cache
def evidence_of_pose() -> Evidence:
    return evidence_of(POSE)


def seen(*hands: HandCandidate) -> Evidence:
    return replace(evidence_of_pose(), hands=hands)


@given(order=st.permutations([LEFT_UPPER_ARM, RIGHT_UPPER_ARM]), left_share=st.floats(0.2, 0.8))
def test_each_arm_gets_its_own_hand(order, left_share):
    hands = [HandCandidate(on_the_skin(ENDS[upper]), 0.9, left_share) for upper in order]
    found = hands_of_arms(POSE, POSE, MODEL, seen(*hands))
    assert set(found) == set(ENDS)
    for upper, hand in found.items():
        assert np.linalg.norm(hand.palm_camera - ENDS[upper]) < 0.02
        assert hand.belief == 0.9


def test_a_lone_hand_goes_to_one_arm_only():
    hand = HandCandidate(on_the_skin(ENDS[RIGHT_UPPER_ARM]), 0.9)
    assert set(hands_of_arms(POSE, POSE, MODEL, seen(hand))) == {RIGHT_UPPER_ARM}


@pytest.mark.parametrize("place", [[9.0, 0.0, 2.0], [0.0, 0.0, -1.0], [0.9, -0.7, 2.6]])
def test_what_is_not_on_the_user_is_nobodys_hand(place):
    assert not hands_of_arms(POSE, POSE, MODEL, seen(HandCandidate(np.array(place), 1.0)))
    assert not hands_of_arms(POSE, POSE, MODEL, seen())


def test_a_hand_that_is_seen_draws_its_arm():
    """From a pose whose left arm hangs, with next to no points on the true one."""
    wrong = Pose(POSE.neck_camera, POSE.Rs.copy())
    wrong.Rs[[LEFT_UPPER_ARM, LEFT_FOREARM]] = POSE.Rs[[RIGHT_UPPER_ARM, RIGHT_UPPER_ARM]]
    hand = HandCandidate(on_the_skin(ENDS[LEFT_UPPER_ARM]), 1.0, 0.9)
    settings = LimbSettings(wide=0, palms=0, jittered=0, settled_jittered=0)

    def left_hand(evidence: Evidence) -> np.ndarray:
        rngs = {upper: generator(0, 1, upper, 0) for upper in LIMBS}
        search = LimbSearch(settings, threads=1)
        found, _ = search.search(wrong, wrong, MODEL, evidence, rngs, {})
        return joints_of(found)[JOINT_NAMES.index("left_hand")]

    drawn = np.linalg.norm(left_hand(seen(hand)) - ENDS[LEFT_UPPER_ARM])
    alone = np.linalg.norm(left_hand(seen()) - ENDS[LEFT_UPPER_ARM])
    assert drawn < 0.05 < alone
