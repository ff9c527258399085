"""Which hypothesis of a limb is taken is what the whole body says."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from rendered_bodies import MODEL, evidence_of, joints_of, standing_pose, subject
from topview.body import JOINT_NAMES
from topview.body.parts import LEFT_FOREARM, LEFT_UPPER_ARM, RIGHT_UPPER_ARM
from topview.filter.particles import generator
from topview.timing import StageClock
from topview.track.methods.topview.limbs import LIMBS, Choose, LimbSearch, LimbSettings
from topview.track.methods.topview.tracker import FrameContext, TopviewSettings, TopviewTracker
from topview.track.pose import Pose

POSE = standing_pose()
EVIDENCE = evidence_of(POSE)
LEFT_HAND = JOINT_NAMES.index("left_hand")


def with_a_wrong_arm() -> Pose:
    """The left one hangs like the right one."""
    wrong = Pose(POSE.neck_camera, POSE.Rs.copy())
    wrong.Rs[[LEFT_UPPER_ARM, LEFT_FOREARM]] = POSE.Rs[[RIGHT_UPPER_ARM, RIGHT_UPPER_ARM]]
    return wrong


def off_m(pose: Pose) -> float:
    """How far the left hand is off."""
    return float(np.linalg.norm(joints_of(pose)[LEFT_HAND] - joints_of(POSE)[LEFT_HAND]))


def searched(choose: Choose) -> Pose:
    wrong = with_a_wrong_arm()
    rngs = {upper: generator(0, 1, upper, 0) for upper in LIMBS}
    return LimbSearch(LimbSettings(), 1).search(wrong, wrong, MODEL, EVIDENCE, rngs, {}, choose)[0]


def test_without_a_better_body_limbs_stay():
    def stay(_: Sequence[Pose]) -> int:
        return 0

    np.testing.assert_array_equal(searched(stay).Rs, with_a_wrong_arm().Rs)


def test_the_present_pose_comes_first_and_others_are_few():
    asked = []

    def nearest(poses: Sequence[Pose]) -> int:
        asked.append(poses)
        return int(np.argmin([off_m(pose) for pose in poses]))

    assert off_m(searched(nearest)) < 0.1 < off_m(with_a_wrong_arm())
    assert off_m(asked[0][0]) == off_m(with_a_wrong_arm())
    assert all(1 <= len(poses) <= LimbSettings().judged + 1 for poses in asked)


def test_the_body_that_explains_more_is_taken_and_the_present_one_if_none_does():
    tracker = TopviewTracker(subject(), TopviewSettings())
    look = FrameContext(MODEL, EVIDENCE, StageClock(), 0.03)
    assert tracker._best_limb(look, 1.0, [with_a_wrong_arm(), POSE]) == 1
    assert tracker._best_limb(look, 1.0, [POSE, with_a_wrong_arm(), POSE]) == 0
