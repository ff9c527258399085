"""Which part of a body each point is of: the one whose visible surface is nearest."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from topview.kernels import body as kernel

Array = NDArray[np.float64]


class NearestSurfaces(NamedTuple):
    """Of N points; that of none says nothing but its label.

    Attributes:
        labels: [N] int32 parts, -1 where none is within reach.
        distances_m: [N] signed, from their surface.
        normals_camera: [N, 3] of it there.
    """

    labels: NDArray[np.int32]
    distances_m: Array
    normals_camera: Array


def nearest_surfaces(
    points_camera: Array,
    Rs: Array,
    origins: Array,
    lengths_m: Array,
    shapes_m: Array,
    reach_m: float,
) -> NearestSurfaces:
    """Of points [N, 3] and B parts: their rotations [B, 3, 3], origins [B, 3], lengths [B] and
    shapes [B, 6] (`BodyModel.shapes_m`)."""
    N = len(points_camera)
    labels = np.full(N, -1, np.int32)
    distances, normals = np.empty(N), np.empty((N, 3))
    kernel.assign_points(
        points_camera, np.zeros((N, 3)), Rs, origins, lengths_m, shapes_m, reach_m, labels,
        distances, normals, np.empty(N),
    )  # fmt: skip
    return NearestSurfaces(labels, distances, normals)
