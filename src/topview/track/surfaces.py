"""Which part of a body each point is of: the one whose visible surface is nearest."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from topview.body.surface import Surface
from topview.kernels import body as kernel

Array = NDArray[np.float64]


class NearestSurfaces(NamedTuple):
    """Of N points; that of none says nothing but its label.

    Attributes:
        labels: [N] int32 parts, -1 where none is within reach.
        distances_m: [N] signed, from their surface.
        normals_camera: [N, 3] of it there.
        unlike_m: [N] how far it is from what is seen, and how far turned; infinite of none.
    """

    labels: NDArray[np.int32]
    distances_m: Array
    normals_camera: Array
    unlike_m: Array


def nearest_surfaces(
    points_camera: Array,
    Rs: Array,
    origins: Array,
    surface: Surface,
    reach_m: float,
    seen_normals_camera: Array | None = None,
) -> NearestSurfaces:
    """Of points [N, 3] and B parts with this surface: their rotations [B, 3, 3] and origins [B, 3],
    NaN of those that are nowhere; and [N, 3] which way what is seen faces, zeros or None where that
    is not known."""
    N = len(points_camera)
    labels = np.full(N, -1, np.int32)
    distances, normals, unlike = np.empty(N), np.empty((N, 3)), np.empty(N)
    seen_normals = np.zeros((N, 3)) if seen_normals_camera is None else seen_normals_camera
    kernel.assign_points(
        points_camera, seen_normals, *surface.placed(Rs, origins), surface.lengths_m,
        surface.shapes_m, reach_m, labels, distances, normals, unlike,
    )  # fmt: skip
    owners = np.append(surface.owners, -1).astype(np.int32)
    return NearestSurfaces(owners[labels], distances, normals, unlike)
