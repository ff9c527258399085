"""What is finer than the pieces of flesh: folds and patterns, which move with the body."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from topview_lab.sim.bodies import Body


class SurfaceDetail(NamedTuple):
    """[M] outward displacements in metres, [M, 3] normals, [M] shares of the colour."""

    displacements: NDArray[np.floating]
    normals: NDArray[np.floating]
    shades: NDArray[np.floating]


def surface_detail(
    body: Body,
    Ts_camera_segment: NDArray[np.float64],
    piece: NDArray[np.int32],
    points: NDArray[np.float64],
    normals: NDArray[np.float64],
) -> SurfaceDetail:
    """What folds and patterns do to a posed body.

    Args:
        body: whose.
        Ts_camera_segment: [S, 4, 4] its pose.
        piece: [M] of the body's flesh.
        points: [M, 3] on their even surfaces, camera frame, metres.
        normals: [M, 3] of these surfaces.
    """
    segments = body.start_segments[piece]
    R = Ts_camera_segment[segments, :3, :3]
    local = np.einsum("mji,mj->mi", R, points - Ts_camera_segment[segments, :3, 3])
    places = (body.places_m[piece] + local).astype(np.float32)
    amplitudes = body.fold_amplitudes_m[piece].astype(np.float32)
    displacements, slopes = body.folds.at(places, amplitudes)
    tilted = normals - np.einsum("mij,mj->mi", R, slopes)  # along the normal, they change nothing
    tilted /= np.sqrt(np.einsum("mi,mi->m", tilted, tilted))[:, None]
    return SurfaceDetail(displacements, tilted, body.pattern(piece, places))
