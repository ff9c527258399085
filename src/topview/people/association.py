"""Which head is whose, from frame to frame."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from topview.detect.head_template import HeadTemplate, track_head
from topview.detect.heads import HeadCandidate
from topview.people.doubts import (
    ALIKE,
    COVERED,
    is_no_head,
    is_unlike,
    likeness,
    slips,
)
from topview.people.height import sunk_m
from topview.people.identity import KnownUser, assign
from topview.people.looks import colors_of_head
from topview.people.present import SAME_HEAD_M, SUSPECT, Present, reached
from topview.people.roll import Roll
from topview.people.scene import Scene
from topview.people.settings import PeopleSettings
from topview.people.unseen import miss

Vector = NDArray[np.float64]
Distance = NDArray[np.float32]

# Ours: a head that scores this (`KnownUser.score`) is not doubted.
SURE_SCORE = 0.75
# Ours: of one who was hidden for longer the head's looks of then are no more followed.
FOLLOWED_S = 0.5
# Ours: how much more confidence makes a head out of something else on a body.
MUCH_MORE = 0.12
# Ours: a head is this near to the height that its stature gives, and what is so much lower was not.
UPRIGHT_M, SUNK_M = 0.1, 0.25
# Ours: a head that is not where it was expected may be so much lower.
LOWER_M = 0.3


def find_again(roll: Roll, scene: Scene, heads: Sequence[HeadCandidate]) -> list[HeadCandidate]:
    """Tell everybody on the roll where the head is now, and find their bodies; gives the detected
    heads that nobody took."""
    known, time_s = roll.known, scene.time_s
    options, scores = _options(roll, scene, heads)
    bodies: dict[int, Distance] = {}
    taken: set[int] = set()
    present = Present()
    for turn in _turns(known, time_s):
        now = scores.copy()
        now[:, _are_near(options, present.heads)] = -np.inf
        matches = {turn[row]: column for row, column in assign(now[turn]).items()}
        for index in sorted(turn, key=lambda i: -now[i, matches[i]] if i in matches else 0.0):
            user = known[index]
            head = options[matches[index]] if index in matches else None
            if head is not None and _continues(scene, user, head, present, roll.settings):
                user.see(head, HeadTemplate.of(scene.cloud, head.center_camera), time_s)
                bodies[index] = roll.body_of(scene, user)
                present.add(user.head_camera, bodies[index])
                taken.add(matches[index])
        for index in turn:
            if index not in bodies:
                bodies[index] = miss(roll, scene, known[index])
                if time_s - known[index].seen_s < FOLLOWED_S:
                    present.add(known[index].head_camera, bodies[index])
    roll.bodies = [bodies[index] for index in range(len(known))]
    return [head for i, head in enumerate(heads) if i not in taken]


def _are_near(heads: Sequence[HeadCandidate], places: Sequence[Vector]) -> NDArray[np.bool_]:
    """[heads] which of them are at one of the places, [3] each."""
    if not heads or not places:
        return np.zeros(len(heads), np.bool_)
    centers = np.array([head.center_camera for head in heads])
    offsets_m = np.linalg.norm(centers[:, None] - np.array(places), axis=-1)
    return offsets_m.min(1) < SAME_HEAD_M


def _options(
    roll: Roll, scene: Scene, heads: Sequence[HeadCandidate]
) -> tuple[list[HeadCandidate], NDArray[np.float64]]:
    """The heads, and what each user's head looked like, found again; with [users, options] how well
    each continues each user."""
    known, time_s, options = roll.known, scene.time_s, list(heads)
    scores = [user.scores(heads, scene.up_camera, time_s) for user in known]
    own: list[tuple[int, float]] = []
    for index, user in enumerate(known):
        is_lost = time_s - user.seen_s > FOLLOWED_S
        if is_lost or max(scores[index], default=-np.inf) > SURE_SCORE:
            continue
        expected, colors = user.predicted(time_s), colors_of_head(roll, scene, user)
        head = track_head(
            scene.cloud, user.view, expected, scene.up_camera, user.step_s(time_s), colors
        )
        if head is not None:
            options.append(head)
            own.append((index, user.score(head, scene.up_camera, time_s)))
    table = np.full((len(known), len(options)), -np.inf)
    table[:, : len(heads)] = np.reshape(scores, (len(known), len(heads)))
    for column, (index, score) in enumerate(own, start=len(heads)):
        table[index, column] = score
    return options, table


def _turns(known: Sequence[KnownUser], time_s: float) -> list[list[int]]:
    """In which order users find their heads again: whoever is hidden takes nobody's who is not, and
    who may be furniture comes last."""

    def rank(user: KnownUser) -> int:
        if user.is_suspect:
            return 3
        if user.confidence_now > 0.0:
            return 0
        return 1 if time_s - user.seen_s < FOLLOWED_S else 2

    ranks = [rank(user) for user in known]
    return [[i for i, own in enumerate(ranks) if own == turn] for turn in sorted(set(ranks))]


def _continues(
    scene: Scene, user: KnownUser, head: HeadCandidate, present: Present, settings: PeopleSettings
) -> bool:
    """Whether the best head for a user is the user's."""
    if present.owns(scene, head, settings.new_confidence):
        return False
    if user.was_hidden(scene.time_s) and (
        is_unlike(scene, user, head) or present.person_under(scene, head, settings) is None
    ):
        return False
    return not slips(scene, user, head) and not is_no_head(scene, user, head)


def correct(roll: Roll, scene: Scene, heads: Sequence[HeadCandidate]) -> list[HeadCandidate]:
    """Where something higher on a user's body looks much more like a head, for long enough, than
    what has been followed: that is the head; somewhat lower too, where the expected place is in
    view and the head is not there. Gives the heads that are left."""
    left = list(heads)
    for index, (user, body) in enumerate(roll):
        rivals = _rivals(roll, scene, user, body, left)
        if user.rival_since_s is None or not rivals:
            user.rival_since_s = scene.time_s if rivals else None
        elif scene.time_s - user.rival_since_s >= roll.settings.new_s:
            user.jump(
                rivals[0], HeadTemplate.of(scene.cloud, rivals[0].center_camera), scene.time_s
            )
            roll.bodies[index] = roll.body_of(scene, user)
            left.remove(rivals[0])
    return left


def _rivals(
    roll: Roll, scene: Scene, user: KnownUser, body: Distance, heads: Sequence[HeadCandidate]
) -> list[HeadCandidate]:
    """Those that may rather be the user's head than what is followed."""
    sure = roll.others_of(user)
    # Heads may be near to each other in a hug, but are no two heads of one.
    others = Present(bodies=[body for _, body in sure])
    return [
        head
        for head in heads
        if _is_better(scene, user, head, roll.settings.new_confidence)
        and _is_high_enough(scene, user, head)
        and not is_no_head(scene, user, head)
        and reached(scene, head.center_camera, body) < np.inf
        and all(
            np.linalg.norm(head.center_camera - other.head_camera) > SAME_HEAD_M
            for other, _ in sure
        )
        and others.person_under(scene, head, roll.settings) is not None
    ]


def _is_high_enough(scene: Scene, user: KnownUser, head: HeadCandidate) -> bool:
    """Whether a head is no lower than what is followed; it may be somewhat where that is not seen,
    and neither hidden nor of other colours than this."""
    up_m = float((head.center_camera - user.head_camera) @ scene.up_camera)
    if up_m > 0.0 or user.confidence_now > 0.0:
        return up_m > 0.0
    is_covered = scene.covered_share(user.head_camera) > COVERED
    return up_m > -LOWER_M and (not is_covered or likeness(scene, user, head) > ALIKE)


def _is_better(scene: Scene, user: KnownUser, head: HeadCandidate, new_confidence: float) -> bool:
    """Whether a head looks much more like a user's than what is followed; not quite as much if it
    is where that of one of this stature would be, and what is followed is far below."""
    up_m = float((head.center_camera - user.head_camera) @ scene.up_camera)
    below_m = sunk_m(scene, head.center_camera, user.height)
    if below_m is not None and up_m > SUNK_M and abs(below_m) < UPRIGHT_M:
        return head.confidence > SUSPECT
    return head.confidence > max(user.confidence_now + MUCH_MORE, new_confidence)
