"""Whose each pixel is, and which part of the body."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.camera.pyramid import DepthView
from topview.records import PartMap
from topview.track.pose import FittedBody
from topview.track.surfaces import nearest_surfaces

PART_REACH_M: Final = 0.3
"""What is further than this from every part of somebody's body is of no part: a bag, a wide skirt.
Ours."""


def part_map_of(
    view: DepthView, labels: NDArray[np.int32], bodies: Sequence[FittedBody]
) -> PartMap:
    """Each pixel of somebody goes to the part whose surface, of those that face the camera, is
    nearest.

    Args:
        view: the depth of the whole image.
        labels: [H, W] id of the person that each pixel belongs to, 0 for nobody.
        bodies: of these people; of whoever has none, no part is known.
    """
    parts = np.zeros(labels.shape, np.uint8)
    for body in bodies:
        rows, columns = np.nonzero(labels == body.person)
        parts[rows, columns] = _parts_of(view.points(rows, columns), body)
    return PartMap(labels.copy(), parts)


def _parts_of(points_camera: NDArray[np.float64], body: FittedBody) -> NDArray[np.uint8]:
    """[N] 1 + the index of each point's part, 0 for none."""
    Ts = body.Ts_camera_part
    nearest = nearest_surfaces(
        points_camera,
        np.ascontiguousarray(Ts[:, :3, :3]),
        np.ascontiguousarray(Ts[:, :3, 3]),
        body.model.surface,
        PART_REACH_M,
    )
    return (nearest.labels + 1).astype(np.uint8)
