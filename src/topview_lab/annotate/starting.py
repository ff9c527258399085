"""Name the markers in a frame where people stand with their arms down or aside."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from math import cos, radians, sin
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.cluster.hierarchy import fclusterdata
from scipy.optimize import linear_sum_assignment
from scipy.spatial.distance import cdist

from topview.records import InputError
from topview_lab.annotate.blobs import Blobs
from topview_lab.annotate.landmarks import ARMS_DEG, BACK, FRONT, LANDMARKS, standing

LINK_M: Final = 0.60
"""Markers closer than this may belong to one person: somewhat more than a long shin (ours)."""
LEAST_SPOTS: Final = 10
"""Least number of joints with a spot, of 16, to name them (ours)."""
CAMERA_TILTS_DEG: Final = (-4.0, 8.0, 20.0, 32.0)
"""Downward tilts of the camera that are tried (ours)."""
MISSING_M: Final = 0.15
"""Distance charged for a joint without a spot, or with one further away (ours)."""
GOOD_M: Final = 0.07
"""Greatest mean distance of a trusted assignment (ours)."""


@dataclass(frozen=True, slots=True, eq=False)
class NamedPerson:
    """A person whose markers are named in one frame of one view.

    Attributes:
        spots: [J] index of each joint's spot, -1 if it has none.
        markers_camera: [J, 2, 3] markers of the fitted standing person.
        stature_m: of the fitted person.
        cost_m: mean distance of the spots, missing ones at `MISSING_M`.
    """

    spots: NDArray[np.intp]
    markers_camera: NDArray[np.float64]
    stature_m: float
    cost_m: float


def start_of_view(
    blobs: Sequence[Blobs], people: int, sees_backs: bool, view: str, early: int
) -> tuple[int, list[NamedPerson]]:
    """Find the frame in which the markers can be named best, and name them, left to right.

    Args:
        blobs: of each frame.
        people: number of people who wear markers.
        sees_backs: True for a view from behind.
        view: its name in error messages.
        early: frames at the beginning in which people face the front camera.

    Raises:
        InputError: in no frame there are enough spots in the shape of so many standing people.
    """
    tried = range(0, min(early, len(blobs)), max(min(early, len(blobs)) // 16, 1))
    found = {f: name_standing(blobs[f], people, sees_backs) for f in tried}
    costs = {f: max(start.cost_m for start in starts) for f, starts in found.items() if starts}
    if not costs or min(costs.values()) > GOOD_M:
        most = max((len(b) for b in blobs), default=0)
        fit = f"; the best fit is {100 * min(costs.values()):.0f} cm off" if costs else ""
        raise InputError(
            f"{view}: the markers of {people} standing {'person' if people == 1 else 'people'} are "
            f"not among the spots of the marker's colour (at most {most} in one frame{fit}); "
            "people must begin standing apart, facing the front camera, with all markers on"
        )
    best = min(costs, key=lambda f: costs[f])
    return best, found[best]


def name_standing(blobs: Blobs, people: int, sees_backs: bool) -> list[NamedPerson]:
    """Name the markers of the `people` largest groups of spots, left to right; empty if there are
    fewer."""
    if len(blobs) < LEAST_SPOTS:
        return []
    group = fclusterdata(blobs.points_camera, LINK_M, "distance", method="single")
    members = [np.flatnonzero(group == k) for k in np.unique(group)]
    members = [spots for spots in members if len(spots) >= LEAST_SPOTS]
    if len(members) < people:
        return []
    starts = [_best_fit(blobs.points_camera[spots], spots, sees_backs) for spots in members]
    chosen = sorted(starts, key=lambda start: start.cost_m)[:people]
    return sorted(chosen, key=lambda start: float(start.markers_camera[..., 0].mean()))


def _best_fit(
    points: NDArray[np.float64], spots: NDArray[np.intp], sees_backs: bool
) -> NamedPerson:
    tries = (
        _fit(points, spots, tilt, arms, sees_backs)
        for tilt, arms in product(CAMERA_TILTS_DEG, ARMS_DEG)
    )
    return min(tries, key=lambda start: start.cost_m)


FITTING_ROUNDS: Final = 10


def _fit(
    points: NDArray[np.float64],
    spots: NDArray[np.intp],
    tilt_deg: float,
    arms_deg: float,
    sees_backs: bool,
) -> NamedPerson:
    """Iterative closest points, one to one, from an upright person who faces the camera or looks
    away from it."""
    template = standing(arms_deg)
    seen = template[:, BACK if sees_backs else FRONT]
    R, scale, origin = _upright(points, seen, radians(tilt_deg), sees_backs)
    reach = 0.4
    rows, columns = np.zeros(0, np.intp), np.zeros(0, np.intp)
    distances = np.zeros(0)
    for _ in range(FITTING_ROUNDS):
        gaps = cdist(scale * seen @ R.T + origin, points)
        rows, columns = linear_sum_assignment(np.minimum(gaps, reach))
        distances = gaps[rows, columns]
        near = distances < reach
        if near.sum() < 4:
            break
        R, scale, origin = similarity(seen[rows[near]], points[columns[near]])
        reach = max(0.7 * reach, MISSING_M)
    found = np.full(len(LANDMARKS), -1, np.intp)
    near = distances < MISSING_M
    found[rows[near]] = spots[columns[near]]
    cost = (distances[near].sum() + MISSING_M * (len(LANDMARKS) - near.sum())) / len(LANDMARKS)
    return NamedPerson(found, scale * template @ R.T + origin, float(scale), float(cost))


def _upright(
    points: NDArray[np.float64], seen: NDArray[np.float64], tilt_rad: float, sees_backs: bool
) -> tuple[NDArray[np.float64], float, NDArray[np.float64]]:
    """Rotation, stature and origin of a person whose highest and lowest markers fit."""
    up = np.array((0.0, -cos(tilt_rad), -sin(tilt_rad)))
    ahead = np.array((0.0, -sin(tilt_rad), cos(tilt_rad)))
    front = ahead if sees_backs else -ahead
    R = np.stack([np.cross(up, front), up, front], 1)
    heights = points @ up
    scale = np.ptp(heights) / np.ptp(seen[:, 1])
    middle = np.median(points, axis=0)
    origin = middle + up * (heights.max() - middle @ up - scale * seen[:, 1].max())
    return R, float(scale), origin


def similarity(
    a: NDArray[np.float64], b: NDArray[np.float64], weights: NDArray[np.float64] | None = None
) -> tuple[NDArray[np.float64], float, NDArray[np.float64]]:
    """R, s, t that bring s R a + t nearest to b, points [N, 3] (S. Umeyama, IEEE PAMI 13, 1991)."""
    w = np.ones(len(a)) if weights is None else weights
    w = (w / w.sum())[:, None]
    mean_a, mean_b = (w * a).sum(0), (w * b).sum(0)
    U, S, Vt = np.linalg.svd((w * (b - mean_b)).T @ (a - mean_a))
    flip = np.array([1.0, 1.0, np.sign(np.linalg.det(U @ Vt))])
    R = (U * flip) @ Vt
    scale = float((S * flip).sum() / (w * (a - mean_a) ** 2).sum())
    return R, scale, mean_b - scale * R @ mean_a
