"""Joints in 3D from the markers in front of and behind them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.signal import savgol_filter

from topview.geometry.rotations import unit
from topview_lab.annotate.landmarks import PLACES
from topview_lab.annotate.tracks import NO_SPOT, Tracks, View, mean_of_views
from topview_lab.annotate.twists import resolve_twists

MOST_GAP_S: Final = 0.4
"""Gaps up to this length are interpolated automatically (ours)."""
JOINT_SMOOTHING_S: Final = 0.2
"""Window of the filter over time (Savitzky and Golay 1964, quadratic): a waving hand is not
flattened, and half of the depth sensor's noise goes (ours)."""
SAME_GAP: Final = 0.35
"""Greatest relative deviation of the distance between front and back marker from its median
(ours)."""


class JointBasis(IntEnum):
    """The source of a joint's position."""

    MISSING = 0
    BOTH_SIDES = 1
    ONE_SIDE = 2
    INTERPOLATED = 3


@dataclass(frozen=True, slots=True, eq=False)
class Joints:
    """F frames, P people, J joints.

    Attributes:
        places_front: [F, P, J, 3] metres in the front camera's frame, NaN where missing.
        seen: [F, P, J] uint8, a `JointBasis` each.
        depths_m: [P, J] median distance of front and back marker, NaN where never both are seen.
    """

    places_front: NDArray[np.float64]
    seen: NDArray[np.uint8]
    depths_m: NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Interpolation:
    """Frames first..last (both included) of a joint that are interpolated from their neighbours."""

    person: int
    joint: int
    first: int
    last: int


def marker_points(views: Sequence[View], spots: NDArray[np.intp]) -> NDArray[np.float64]:
    """[V, F, P, J, 2, 3] named spots in the front camera's frame, NaN where there is none."""
    points = np.full((*spots.shape, 3), np.nan)
    for v, view in enumerate(views):
        for f in range(spots.shape[1]):
            named = spots[v, f] != NO_SPOT
            if named.any():
                points[v, f][named] = view.points(f)[spots[v, f][named]]
    return points


def joints_from_markers(
    points: NDArray[np.float64],
    eyes: NDArray[np.float64],
    tracks: Tracks,
    fps: float,
    interpolations: Iterable[Interpolation] = (),
) -> Joints:
    """Estimate each joint from its visible markers, smooth it, and close short gaps.

    Args:
        points: [V, F, P, J, 2, 3] markers in the front camera's frame, NaN where unseen.
        eyes: [V, 3] positions of the cameras in that frame.
        tracks: the followed markers; they give the direction to the hidden one where only one is
            visible.
        fps: frames per second.
        interpolations: requested by the user; markers in those frames are not used.
    """
    front, back = mean_of_views(points)
    gap = front - back
    length = np.linalg.norm(gap, axis=-1)
    with np.errstate(invalid="ignore"):
        typical = _median(length)
        off = np.abs(length - typical) > SAME_GAP * typical
    gap[off] = np.nan  # then the tracked direction is better, with the middle kept
    depths_m = np.where(np.isnan(typical), tracks.depths_m, typical)
    outwards = np.where(np.isnan(gap), tracks.outwards_front, unit(gap))
    ahead_m = PLACES * depths_m
    both = front + PLACES[:, None] * (back - front)
    behind = (depths_m - ahead_m)[..., None] * outwards
    one = np.where(np.isnan(front), back + behind, front - ahead_m[..., None] * outwards)
    places = np.where(np.isnan(both), one, both)
    seen = np.where(
        np.isnan(places[..., 0]),
        JointBasis.MISSING,
        np.where(np.isnan(both[..., 0]), JointBasis.ONE_SIDE, JointBasis.BOTH_SIDES),
    ).astype(np.uint8)
    for p in range(places.shape[1]):
        missing = seen[:, p] == JointBasis.MISSING
        likely = np.where(np.isnan(places[:, p]), tracks.joints_front[:, p], places[:, p])
        rests_on_two = seen[:, p] == JointBasis.BOTH_SIDES
        settled, rests_on_two = resolve_twists(
            points[:, :, p], eyes, likely, rests_on_two, depths_m[p], fps
        )
        places[:, p] = np.where(missing[..., None], np.nan, settled)
        sides = np.where(rests_on_two, JointBasis.BOTH_SIDES, JointBasis.ONE_SIDE)
        seen[:, p] = np.where(missing, JointBasis.MISSING, sides)
    asked = np.zeros(seen.shape, np.bool_)
    for wish in interpolations:
        asked[wish.first : wish.last + 1, wish.person, wish.joint] = True
    places[asked], seen[asked] = np.nan, JointBasis.MISSING
    _close_gaps(places, seen, asked, max(round(MOST_GAP_S * fps), 1))
    _smooth(places, fps)
    return Joints(places, seen, depths_m)


def _median(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Over the first axis, NaN where all are."""
    some = ~np.isnan(values).all(0)
    result = np.full(values.shape[1:], np.nan)
    result[some] = np.nanmedian(values[:, some], axis=0)
    return result


def _close_gaps(
    places: NDArray[np.float64],
    seen: NDArray[np.uint8],
    asked: NDArray[np.bool_],
    most_frames: int,
) -> None:
    """Fill requested and short gaps with a cubic through both sides; in place."""
    F = len(places)
    for p, j in np.ndindex(places.shape[1:3]):
        known = np.flatnonzero(seen[:, p, j] != JointBasis.MISSING)
        for a, b in zip(known[:-1], known[1:], strict=True):
            inside = slice(a + 1, b)
            if b - a < 2 or (b - a - 1 > most_frames and not asked[inside, p, j].any()):
                continue
            places[inside, p, j] = hermite(places[:, p, j], int(a), int(b))
            seen[inside, p, j] = JointBasis.INTERPOLATED
        for end, edge in (
            ((slice(0, known[0]), known[0]), (slice(known[-1] + 1, F), known[-1]))
            if (len(known))
            else ()
        ):
            hold = asked[end, p, j]
            places[end, p, j][hold] = places[edge, p, j]
            seen[end, p, j][hold] = JointBasis.INTERPOLATED


def hermite(places: NDArray[np.float64], a: int, b: int) -> NDArray[np.float64]:
    """[b - a - 1, 3] places between frames a and b of [F, 3], with the speeds at both ends."""

    def speed(inner: int, outer: int) -> NDArray[np.float64]:
        known = 0 <= outer < len(places) and not np.isnan(places[outer]).any()
        whole = (places[b] - places[a]) / (b - a)
        return (places[inner] - places[outer]) / (inner - outer) if known else whole

    span = b - a
    t = (np.arange(1, span) / span)[:, None]
    va, vb = span * speed(a, a - 3), span * speed(b, b + 3)
    return (
        (2 * t**3 - 3 * t**2 + 1) * places[a]
        + (t**3 - 2 * t**2 + t) * va
        + (3 * t**2 - 2 * t**3) * places[b]
        + (t**3 - t**2) * vb
    )


def _smooth(places: NDArray[np.float64], fps: float) -> None:
    """Smooth each run of known places, in place."""
    window = 2 * (round(JOINT_SMOOTHING_S * fps) // 2) + 1
    if window < 5:
        return
    for p, j in np.ndindex(places.shape[1:3]):
        known = ~np.isnan(places[:, p, j, 0])
        edges = np.flatnonzero(np.diff(np.concatenate([[0], known.astype(np.int8), [0]])))
        for first, last in zip(edges[::2], edges[1::2], strict=True):
            if last - first >= window:
                run = places[first:last, p, j]
                places[first:last, p, j] = savgol_filter(run, window, 2, axis=0)
