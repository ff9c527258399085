"""Which head is whose: one assignment over log-likelihood ratios."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import exp, log
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.detect.head_template import track_head
from topview.detect.heads import HeadCandidate
from topview.people.appearance import clothes_under, head_colors_against, unlikeness
from topview.people.existence import is_too_near
from topview.people.height import sunk_m
from topview.people.scene import Scene
from topview.people.track import Track

Vector = NDArray[np.float64]

# All ours. Density of things that look like heads, per cubic metre.
CLUTTER_PER_M3: Final = 0.3
# And of new people who appear in the middle of the picture where another is missed.
NEW_PER_M3: Final = 0.003
# A head in plain view is missed in this share of frames.
MISSED: Final = 0.05
# Log-likelihood ratios of a candidate without and with all marks of a head; of one with the colours
# of the head against the body's; and of clothes that are alike and not.
UNLIKE_HEAD, LIKE_HEAD = -2.0, 2.0
HEAD_COLOR_WEIGHT, CLOTHES_WEIGHT = 4.0, 10.0
# The unlikeness of clothes between that of one person and that of two.
SAME_CLOTHES: Final = 0.45
# Nobody becomes taller: a head above the stature, besides an error, by so much is unlikely.
TALLER_M: Final = 0.04
# A head that something comes to cover does not move down, but what is seen of it does.
COVERED, SLIP_M, SLIP_M_PER_S = 0.15, 0.02, 0.3
SLIPPED: Final = 8.0
# On somebody else's body, so near to the head, is no other head, if it is not a good one.
OWN_HEAD_M, ANOTHERS_HEAD, GOOD_HEAD = 0.4, 6.0, 0.75
# A head this near to where it is expected, and as sure, is not searched for again.
AT_ONCE_M, AT_ONCE = 0.06, 0.75
# Of one who was hidden for longer the head's shape of then is no more followed.
FOLLOWED_S: Final = 0.5
# Less likely places are not looked at.
FARTHEST: Final = -8.0
# Two heads' centres are farther apart.
SAME_HEAD_M: Final = 0.2


def associate(
    tracks: Sequence[Track],
    scene: Scene,
    heads: Sequence[HeadCandidate],
    log_odds_of: Callable[[HeadCandidate], float],
) -> tuple[dict[int, HeadCandidate], list[HeadCandidate]]:
    """The head of each track that has one, by the track's index; and the detected heads that nobody
    took.

    Args:
        tracks: as they were in the last frame.
        scene: of this frame.
        heads: that are detected.
        log_odds_of: of a person's body below a head that nobody else explains.
    """
    options = [*heads]
    scores = np.full((len(tracks), len(heads) + len(tracks)), -np.inf)
    missed = np.array([_missed(track, scene) for track in tracks])
    for row, track in enumerate(tracks):
        others = [*tracks[:row], *tracks[row + 1 :]]
        for column, head in enumerate(heads):
            scores[row, column] = _ratio(track, others, scene, head, log_odds_of)
        followed = _followed(track, others, scene, heads, scores[row])
        if followed is not None:
            scores[row, len(options)] = _ratio(track, others, scene, followed, log_odds_of)
            options.append(followed)
    gains = scores[:, : len(options)] - missed[:, None]
    matches = assign(np.where(gains > 0.0, gains, -np.inf))
    taken: dict[int, HeadCandidate] = {}
    for row, column in sorted(matches.items(), key=lambda match: -scores[match]):
        head = options[column]
        if all(_apart_m(head, other) > SAME_HEAD_M for other in taken.values()):
            taken[row] = head
    left = [
        head
        for head in heads
        if all(
            head is not other and _apart_m(head, other) > SAME_HEAD_M for other in taken.values()
        )
    ]
    return taken, left


def _missed(track: Track, scene: Scene) -> float:
    """Log-likelihood of no measurement: unlikely of a head that is in plain view."""
    if track.places is not None:
        return 0.0
    is_free = 1.0 - scene.covered_share(track.expected(scene.time_s).position_camera)
    return log(1.0 - (1.0 - MISSED) * is_free)


def _ratio(
    track: Track,
    others: Sequence[Track],
    scene: Scene,
    head: HeadCandidate,
    log_odds_of: Callable[[HeadCandidate], float],
) -> float:
    """Log-likelihood ratio of a head: this track's against clutter or somebody new."""
    center = head.center_camera
    if track.places is not None:
        ratio = track.places.log_density(scene, center, track.unseen_s(scene.time_s))
        if ratio < FARTHEST:
            return -np.inf
        by_shape = log_odds_of(head)
        ratio += by_shape - log(CLUTTER_PER_M3 + NEW_PER_M3 * exp(min(by_shape, 50.0)))
        ratio += _by_clothes(track, others, scene, head)
    else:
        ratio = track.expected(scene.time_s).log_density(center) - log(CLUTTER_PER_M3)
        if ratio < FARTHEST:
            return -np.inf
        ratio += UNLIKE_HEAD + (LIKE_HEAD - UNLIKE_HEAD) * head.confidence
    ratio += _by_stature(track, scene, head) + _by_colors(track, others, scene, head)
    ratio -= ANOTHERS_HEAD * _is_anothers(track, others, scene, head)
    return ratio - SLIPPED * _slips(track, scene, head)


def _by_stature(track: Track, scene: Scene, head: HeadCandidate) -> float:
    below_m = sunk_m(scene, head.center_camera, track.height)
    return 0.0 if below_m is None else -0.5 * (min(below_m, 0.0) / TALLER_M) ** 2


def _by_colors(track: Track, others: Sequence[Track], scene: Scene, head: HeadCandidate) -> float:
    colors = head_colors_against(track, others, scene)
    share = None if colors is None else colors.share_at(scene.cloud, head.center_camera)
    return 0.0 if share is None else HEAD_COLOR_WEIGHT * (share - 0.5)


def _by_clothes(track: Track, others: Sequence[Track], scene: Scene, head: HeadCandidate) -> float:
    if track.clothes is None:
        return 0.0
    near = [other.place_camera for other in others if other.is_seen]
    worn = clothes_under(scene, head.center_camera, near)
    if worn is None:
        return 0.0
    return CLOTHES_WEIGHT * (SAME_CLOTHES - unlikeness(track.clothes, worn))


def _is_anothers(track: Track, others: Sequence[Track], scene: Scene, head: HeadCandidate) -> bool:
    """Whether a head is a part of another whose head is seen: too near to that, for one that comes
    back; or on the other's body and not a good one."""
    seen = [other for other in others if other.is_seen and other.id]
    if not track.is_seen and is_too_near(head.center_camera, seen, scene):
        return True
    if head.confidence >= GOOD_HEAD:
        return False
    row, column, in_view = scene.cloud.pixel_at(head.center_camera)
    return in_view and any(
        other.body_m is not None and other.body_m[row, column] < OWN_HEAD_M for other in seen
    )


def _slips(track: Track, scene: Scene, head: HeadCandidate) -> bool:
    """Whether a head seems to move down as something comes before it."""
    if track.places is not None:
        return False
    expected = track.expected(scene.time_s).position_camera
    down_m = -float((head.center_camera - expected) @ scene.up_camera)
    step_s = scene.time_s - track.time_s
    if down_m < SLIP_M + SLIP_M_PER_S * step_s:
        return False
    above = head.center_camera + down_m * scene.up_camera
    return max(scene.covered_share(expected), scene.covered_share(above)) > COVERED


def _followed(
    track: Track,
    others: Sequence[Track],
    scene: Scene,
    heads: Sequence[HeadCandidate],
    scores: NDArray[np.float64],
) -> HeadCandidate | None:
    """The head found again by its shape, where none that was detected is as good."""
    if track.unseen_s(scene.time_s) > FOLLOWED_S:
        return None
    expected = track.expected(scene.time_s).position_camera
    if heads:
        best = heads[int(np.argmax(scores[: len(heads)]))]
        off_m = float(np.linalg.norm(best.center_camera - expected))
        if off_m < AT_ONCE_M and best.confidence > AT_ONCE:
            return None
    return track_head(
        scene.cloud,
        track.view,
        expected,
        scene.up_camera,
        max(scene.time_s - track.time_s, 0.0),
        head_colors_against(track, others, scene),
    )


def assign(scores: NDArray[np.float64], unmatched: float = 0.0) -> dict[int, int]:
    """Row to column of the assignment with the highest sum of [tracks, heads] scores; pairs whose
    score is -inf are never made, but count as `unmatched`."""
    if not scores.size or not np.isfinite(scores).any():
        return {}
    from scipy.optimize import linear_sum_assignment  # slow; not before it is needed

    is_pair = np.isfinite(scores)
    rows, columns = linear_sum_assignment(np.where(is_pair, scores, unmatched), maximize=True)
    return {
        int(row): int(column)
        for row, column in zip(rows, columns, strict=True)
        if is_pair[row, column]
    }


def _apart_m(one: HeadCandidate, other: HeadCandidate) -> float:
    return float(np.linalg.norm(one.center_camera - other.center_camera))
