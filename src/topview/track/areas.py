"""The image areas of all users, tracked: how much of each the nearer ones hide (Sec. 5.1.3)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from topview.camera import project
from topview.people.users import User
from topview.records import Camera

Array = NDArray[np.float64]

# Ours.
STRIDE_PX = 4  # of the pixels that are counted
FREE_SHARE = 0.05  # an area that is hidden by no more than this is taken as it is seen
LEARNING = 0.3  # share of what is seen now in what is remembered
LEAST_PIXELS = 20
CONTOUR = 4.0  # an ellipse with these moments ends at two standard deviations (Eq. 4.7)


@dataclass(frozen=True, slots=True, eq=False)
class _Area:
    """An ellipse by its moments, in metres across the line of sight, from the head's centre."""

    mean: Array  # [2]
    covariance: Array  # [2, 2]


class UserAreas:
    """Remembers the area that every user has when nobody stands in front."""

    def __init__(self) -> None:
        self._areas: dict[int, _Area] = {}

    def hidden_shares(
        self, users: Sequence[User], owner: NDArray[np.int32], camera: Camera
    ) -> dict[int, float]:
        """P_occl of each user, 0 to 1, by id.

        Args:
            users: nearest first.
            owner: [H, W] id of the user that each pixel belongs to, 0 for none.
            camera: of the image.
        """
        owners = owner[::STRIDE_PX, ::STRIDE_PX]
        u, v = (np.arange(0, side, STRIDE_PX) for side in (camera.width, camera.height))
        areas: dict[int, _Area] = {}
        shares: dict[int, float] = {}
        nearer: list[int] = []
        for user in users:
            scale_m = float(user.head_camera[2]) / camera.fx
            head_u, head_v = project(user.head_camera, camera)
            right_m, down_m = (u - head_u) * scale_m, (v - head_v) * scale_m
            rows, columns = np.nonzero(owners == user.id)
            own = np.stack([right_m[columns], down_m[rows]], axis=-1)
            seen = _area_of(own) if len(own) >= LEAST_PIXELS else None
            area = self._areas.get(user.id, seen)
            shares[user.id] = 0.0
            if area and nearer:
                shares[user.id] = _covered(area, right_m, down_m, np.isin(owners, nearer))
            if area and seen and shares[user.id] <= FREE_SHARE:
                area = _Area(
                    area.mean + LEARNING * (seen.mean - area.mean),
                    area.covariance + LEARNING * (seen.covariance - area.covariance),
                )
            if area:
                areas[user.id] = area
            nearer.append(user.id)
        self._areas = areas
        return shares


def _area_of(offsets: Array) -> _Area:
    return _Area(offsets.mean(0), np.cov(offsets.T) + 1e-6 * np.eye(2))


def _covered(area: _Area, right_m: Array, down_m: Array, is_nearer: NDArray[np.bool_]) -> float:
    """Share of the ellipse that lies on nearer users; `right_m` [w] and `down_m` [h] are the
    places of the image's columns and rows."""
    (xx, xy), (_, yy) = np.linalg.inv(area.covariance)
    x, y = right_m - area.mean[0], (down_m - area.mean[1])[:, None]
    inside = (xx * x**2 + 2.0 * xy * x * y + yy * y**2) <= CONTOUR
    return float(is_nearer[inside].mean()) if inside.any() else 0.0
