"""Who is followed may be something else: furniture, an arm, another's shoulder."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from topview.detect.heads import HeadCandidate
from topview.people.height import sunk_m
from topview.people.identity import KnownUser
from topview.people.present import OWN_HEAD_M, Present, reached
from topview.people.roll import Roll
from topview.people.scene import Scene
from topview.people.validation import is_doubtful, is_half_hidden, is_torn_out

Distance = NDArray[np.float32]

# Ours: one who has been in no doubt for so many looks, one after the other, is somebody.
UNDOUBTED_LOOKS = 4.5
# Ours: whoever has gone so far is somebody for good.
PROVEN_M = 0.3
# Ours: as is one whose head is hidden, but went so far until so lately, if the body moves, too.
COME_M, LATELY_S = 0.15, 0.5
# Ours: a head this much of which is hidden does not go further down, or aside, than this from where
# it is expected, in any frame and besides for each second since the frame before.
COVERED = 0.15
SLIP_M, SLIP_M_PER_S = 0.02, 0.3
ASIDE_M, ASIDE_M_PER_S = 0.04, 0.6
# From the head to the hand of a stretched arm, of tall people (Table 3.1).
REACH_M = 0.9
# Ours: a head that is hidden by and by seems to slide down, by so much before it is missed; of one
# that is less far below the stature that does not tell.
OCCLUDED_DEFICIT_M, SLID_M = 0.12, 0.35
# Ours: nobody comes back taller than he was by more than this.
TALLER_M = 0.12
# Ours: shares of a head's colours that are its own and not the clothes'. Of a hundred simulated
# heads one has less than 0.57, of places on shoulders half have less than 0.23.
UNLIKE, UNTOLD, ALIKE = 0.3, 0.5, 0.55
# Ours: so much of what hangs together with an arm is its body's.
JOINED = 0.3


def likeness(scene: Scene, user: KnownUser, head: HeadCandidate) -> float:
    """How far a head has the colours of a user's, 0..1; `UNTOLD` where that is not known."""
    if user.head_colors is None:
        return UNTOLD
    share = user.head_colors.share_at(scene.cloud, head.center_camera)
    return UNTOLD if share is None else share


def slips(scene: Scene, user: KnownUser, head: HeadCandidate) -> bool:
    """Whether a user's head seems to move as something comes before it: it is the shoulder then
    that still is to be seen, or a half of the head."""
    expected, step_s = user.predicted(scene.time_s), user.step_s(scene.time_s)
    offset = head.center_camera - expected
    up_m = float(offset @ scene.up_camera)
    is_covered = scene.covered_share(expected) > COVERED
    if _is_low(scene, user, head) or (
        up_m < -(SLIP_M + SLIP_M_PER_S * step_s)
        and (is_covered or _is_under_cover(scene, head, -up_m))
    ):
        return likeness(scene, user, head) < ALIKE
    was_seen = not user.was_hidden(scene.time_s)
    aside_m = ASIDE_M + ASIDE_M_PER_S * step_s
    return bool(is_covered and was_seen and np.linalg.norm(offset) > aside_m)


def _is_low(scene: Scene, user: KnownUser, head: HeadCandidate) -> bool:
    """Whether a head is below something that may hide the true one, upright."""
    below_m = sunk_m(scene, head.center_camera, user.height)
    return (
        below_m is not None
        and OCCLUDED_DEFICIT_M < below_m < SLID_M
        and _is_under_cover(scene, head, below_m)
    )


def _is_under_cover(scene: Scene, head: HeadCandidate, up_m: float) -> bool:
    """Whether something hides what is so far above a head."""
    return scene.covered_share(head.center_camera + up_m * scene.up_camera) > COVERED


def is_no_head(scene: Scene, user: KnownUser, head: HeadCandidate) -> bool:
    """Whether what is below the stature has not the colours of the head: a shoulder, or the back of
    one who bends. What is above it may still be the head of one whose shoulder was followed."""
    below_m = sunk_m(scene, head.center_camera, user.height)
    is_low = below_m is not None and below_m > OCCLUDED_DEFICIT_M
    return is_low and likeness(scene, user, head) < UNLIKE


def is_unlike(scene: Scene, user: KnownUser, head: HeadCandidate) -> bool:
    """Whether a head by which one whom something hid seems to come back is not that of then: too
    high, or of other colours."""
    if scene.covered_share(user.head_camera) <= COVERED:
        return False
    below_m = sunk_m(scene, head.center_camera, user.height)
    is_higher = below_m is not None and below_m < -TALLER_M
    return is_higher or likeness(scene, user, head) < UNLIKE


def is_anothers(scene: Scene, user: KnownUser, roll: Roll) -> bool:
    """Whether who is in doubt is the shoulder of one who is surer."""
    return any(
        other.confidence_now > user.confidence_now
        and reached(scene, user.head_camera, body) < OWN_HEAD_M
        for other, body in roll
        if other is not user
    )


def may_be_an_arm(scene: Scene, user: KnownUser, own: Distance, roll: Roll) -> bool:
    """Whether who is in doubt may be the arm that somebody moves: in his reach, and hanging
    together with him as far as can be seen."""
    is_own = np.isfinite(own)
    pixels = np.count_nonzero(is_own)
    return any(
        np.linalg.norm(scene.overview_of(user.head_camera - other.head_camera)) < REACH_M
        and (
            np.count_nonzero(is_own & np.isfinite(body)) > JOINED * pixels
            or is_half_hidden(scene, body)
        )
        for other, body in roll.others_of(user)
    )


def looks_doubtful(scene: Scene, user: KnownUser, own: Distance, roll: Roll, least: int) -> bool:
    """Whether a known user's body has `least` so many marks of furniture (`is_doubtful`)."""
    head = HeadCandidate(user.head_camera, user.confidence_now)
    others = [body for other, body in roll if other is not user]
    nearest = Present([], others).left_of(own)
    return is_doubtful(scene, head, nearest, roll.settings.limits, least)


def is_undoubted(scene: Scene, user: KnownUser, own: Distance, roll: Roll, looks: float) -> bool:
    """Whether who is in doubt, half hidden say, or has no credit yet, looks like a person for long
    enough; called once for each look, which counts for so many."""
    is_like = (
        user.confidence_now >= roll.settings.new_confidence
        and not looks_doubtful(scene, user, own, roll, 1)
        and not is_torn_out(scene, own)
    )
    user.undoubted_looks = user.undoubted_looks + looks if is_like else 0.0
    return user.undoubted_looks >= UNDOUBTED_LOOKS


def has_come(scene: Scene, user: KnownUser) -> bool:
    """Whether a head that is not seen now was of late, and had gone across the floor."""
    way_m = np.hypot(*scene.overview_of(user.seen_camera - user.first_camera))
    return scene.time_s - user.seen_s < LATELY_S and bool(way_m > COME_M)


def is_proven(user: KnownUser, time_s: float) -> bool:
    """Whether somebody has gone where no thing goes."""
    way_m = np.linalg.norm(user.head_camera - user.first_camera)
    return user.seen_s == time_s and bool(way_m > PROVEN_M)
