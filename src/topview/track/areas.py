"""Tracked image areas of all users: how much of each the nearer users hide (Sec. 5.1.3)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.camera import project
from topview.filter.over_time import share_after
from topview.people.users import User
from topview.records import Camera

Array = NDArray[np.float64]

# All ours but where an equation is named.
STRIDE_PX: Final = 4  # of the pixels that are counted
FREE_SHARE: Final = 0.05  # an area is updated while no more than this share of it is hidden
AREA_MEMORY_S: Final = 0.0935  # after which an area is 63 % what is seen now
LEAST_AREA_PIXELS: Final = 20  # counted pixels; of fewer no area is made
CONTOUR: Final = 4.0  # squared deviations at the border of a filled ellipse (Eq. 4.7)


@dataclass(frozen=True, slots=True, eq=False)
class _Area:
    """An ellipse by its moments, in metres across the line of sight, relative to the head."""

    mean: Array  # [2]
    covariance: Array  # [2, 2]


class UserAreas:
    """Tracks the image area of every user, and updates it while nobody hides it."""

    def __init__(self) -> None:
        self._areas: dict[int, _Area] = {}
        self._last_s: float | None = None

    def hidden_shares(
        self,
        users: Sequence[User],
        labels: NDArray[np.int32],
        camera: Camera,
        timestamp_s: float,
    ) -> dict[int, float]:
        """P_occl of each user (Eq. 5.3), 0 to 1, by id.

        Args:
            users: nearest first.
            labels: [H, W] id of the user that each pixel belongs to, 0 for nobody.
            camera: of the image.
            timestamp_s: of the image.
        """
        last_s = timestamp_s if self._last_s is None else self._last_s
        learning = share_after(timestamp_s - last_s, AREA_MEMORY_S)
        self._last_s = timestamp_s
        thinned_labels = labels[::STRIDE_PX, ::STRIDE_PX]
        u, v = (np.arange(0, side, STRIDE_PX) for side in (camera.width, camera.height))
        areas: dict[int, _Area] = {}
        shares: dict[int, float] = {}
        nearer: list[int] = []
        for user in users:
            scale_m = float(user.head_camera[2]) / camera.fx
            head_u, head_v = project(user.head_camera, camera)
            right_m, down_m = (u - head_u) * scale_m, (v - head_v) * scale_m
            rows, columns = np.nonzero(thinned_labels == user.id)
            own = np.stack([right_m[columns], down_m[rows]], axis=-1)
            seen = _area_of(own) if len(own) >= LEAST_AREA_PIXELS else None
            area = self._areas.get(user.id, seen)
            shares[user.id] = 0.0
            if area and nearer:
                shares[user.id] = _covered(area, right_m, down_m, np.isin(thinned_labels, nearer))
            if area and seen and shares[user.id] <= FREE_SHARE:
                area = _Area(
                    area.mean + learning * (seen.mean - area.mean),
                    area.covariance + learning * (seen.covariance - area.covariance),
                )
            if area:
                areas[user.id] = area
            nearer.append(user.id)
        self._areas = areas
        return shares


def _area_of(offsets: Array) -> _Area:
    mean = offsets.mean(0)
    away = offsets - mean
    covariance = away.T @ away * (1.0 / (len(away) - 1))
    return _Area(mean, covariance + 1e-6 * np.eye(2))


def _covered(area: _Area, right_m: Array, down_m: Array, is_nearer: NDArray[np.bool_]) -> float:
    """Share of the ellipse that nearer users cover.

    Args:
        area: the ellipse.
        right_m, down_m: [w] and [h] metres of the columns and rows, relative to the head.
        is_nearer: [h, w] pixels of nearer users.
    """
    (xx, xy), (_, yy) = np.linalg.inv(area.covariance)
    x, y = right_m - area.mean[0], (down_m - area.mean[1])[:, None]
    inside = (xx * x**2 + 2.0 * xy * x * y + yy * y**2) <= CONTOUR
    return float(is_nearer[inside].mean()) if inside.any() else 0.0
