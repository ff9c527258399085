"""Round cones: exact ray intersections, many at once, each in its own image window only.

A round cone is the hull of two balls; under an affine map its cross-section becomes an ellipse,
and with both balls at one place it is an ellipsoid. Rays start at the camera and are scaled to
z = 1, so that the ray parameter is the depth. Each surface (two balls, the cone between them) is a
quadric k2 t^2 + 2 k1 t + k0 = 0 along a ray, whose coefficients are polynomials in the pixel.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from topview.records import Camera
from topview_lab.kernels.round_cones import draw_round_cones

NEAREST_DRAWN_M = 0.05
"""Surfaces nearer than this are not drawn (ours)."""

Window = tuple[slice, slice]


@dataclass(frozen=True, slots=True, eq=False)
class RoundCones:
    """N round cones in one frame, the camera's where they are drawn; metres.

    Attributes:
        starts, ends: [N, 3] centres of the two balls.
        start_radii, end_radii: [N] of the balls, before `scales`.
        axes: [N, 3, 3] rotations whose columns are the axes along which `scales` stretches.
        scales: [N, 3] stretch of the cross-section along those axes.
    """

    starts: NDArray[np.float64]
    ends: NDArray[np.float64]
    start_radii: NDArray[np.float64]
    end_radii: NDArray[np.float64]
    axes: NDArray[np.float64]
    scales: NDArray[np.float64]

    def __len__(self) -> int:
        return len(self.starts)

    def local_maps(self) -> NDArray[np.float64]:
        """[N, 3, 3] linear maps into the frames in which the cross-sections are round."""
        return np.swapaxes(self.axes, -1, -2) / self.scales[..., None]

    def lowest(self) -> NDArray[np.float64]:
        """[2, N] z of the lowest places of the first and the second balls; z points up."""
        drop = np.linalg.norm(self.axes[:, 2, :] * self.scales, axis=-1)
        return np.stack(
            [
                self.starts[:, 2] - self.start_radii * drop,
                self.ends[:, 2] - self.end_radii * drop,
            ]
        )


class _Quadrics(NamedTuple):
    """[N] quadrics seen from the camera: k2 = ray' Q ray, k1 = q . ray, k0."""

    Q: NDArray[np.float64]
    q: NDArray[np.float64]
    k0: NDArray[np.float64]

    def rows(self) -> NDArray[np.float64]:
        """[N, 10] as the kernel takes them."""
        return np.column_stack([self.Q[:, *np.triu_indices(3)], self.q, self.k0])


class _Cones(NamedTuple):
    """The lateral surfaces, with the bounds 0 < y0 + t (w . ray) < y1 between the balls."""

    surfaces: _Quadrics
    y0: NDArray[np.float64]
    w: NDArray[np.float64]
    y1: NDArray[np.float64]


def _dot(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.einsum("...i,...i->...", a, b)


def _balls(
    maps: NDArray[np.float64], centres_local: NDArray[np.float64], radii: NDArray[np.float64]
) -> _Quadrics:
    return _Quadrics(
        Q=np.swapaxes(maps, -1, -2) @ maps,
        q=-np.einsum("nij,ni->nj", maps, centres_local),
        k0=_dot(centres_local, centres_local) - radii**2,
    )


def _cones(solids: RoundCones) -> _Cones:
    """After I. Quilez, "round cone" (iquilezles.org/articles/intersectors), for any ray length."""
    maps = solids.local_maps()
    start = np.einsum("nij,nj->ni", maps, solids.starts)
    axis = np.einsum("nij,nj->ni", maps, solids.ends) - start
    radius, taper = solids.start_radii, solids.start_radii - solids.end_radii
    length2, along = _dot(axis, axis), -_dot(axis, start)
    side2 = length2 - taper**2  # squared length of the tangent between the balls
    w = np.einsum("nij,ni->nj", maps, axis)
    balls = _balls(maps, start, radius)
    side2_ = side2[:, None]
    surfaces = _Quadrics(
        Q=side2_[..., None] * balls.Q - w[:, :, None] * w[:, None, :],
        q=side2_ * balls.q + (radius * taper - along)[:, None] * w,
        k0=side2 * _dot(start, start)
        - along**2
        + 2.0 * radius * taper * along
        - length2 * radius**2,
    )
    return _Cones(surfaces, along - radius * taper, w, side2)


class RayCaster:
    """Depth along the rays of an image, for one set of round cones and one camera.

    Attributes:
        windows: of the image, within which each solid is looked for.
    """

    def __init__(self, solids: RoundCones, camera: Camera) -> None:
        maps = solids.local_maps()
        ends = (solids.starts, solids.start_radii), (solids.ends, solids.end_radii)
        balls = [_balls(maps, np.einsum("nij,nj->ni", maps, at), radii) for at, radii in ends]
        cones = _cones(solids)
        self._balls = np.stack([ball.rows() for ball in balls], 1)
        self._cones = cones.surfaces.rows()
        self._bounds = np.column_stack([cones.y0, cones.w, cones.y1])
        self._x = (np.arange(camera.width, dtype=np.float64) - camera.cx) / camera.fx
        self._y = (np.arange(camera.height, dtype=np.float64) - camera.cy) / camera.fy
        self.windows = image_windows(solids, camera)

    def draw(self, depth_m: NDArray[np.float64], solid: NDArray[np.int32]) -> None:
        """Fill in the depth of what the rays enter before [H, W] `depth_m`, and the number of the
        solid."""
        edges = [(v.start, v.stop, u.start, u.stop) for v, u in self.windows]
        draw_round_cones(
            self._x, self._y, np.array(edges), self._balls, self._cones, self._bounds,
            NEAREST_DRAWN_M, depth_m, solid,
        )  # fmt: skip


def surface_normals(
    solids: RoundCones, index: NDArray[np.int32], points: NDArray[np.float64]
) -> NDArray[np.float64]:
    """[M, 3] outward unit normals in the camera frame at points [M, 3] on solids `index` [M]."""
    maps = solids.local_maps()
    start = np.einsum("nij,nj->ni", maps, solids.starts)
    axis = np.einsum("nij,nj->ni", maps, solids.ends) - start
    taper = solids.start_radii - solids.end_radii
    side2 = _dot(axis, axis) - taper**2
    lift = solids.start_radii * taper

    from_start = np.einsum("mij,mj->mi", maps[index], points) - start[index]
    axis, side2, lift = axis[index], side2[index], lift[index]
    height = _dot(from_start, axis) - lift
    holds = side2 <= 0.0
    on_start = np.where(holds, taper[index] >= 0.0, height <= 0.0)
    on_end = ~on_start & (holds | (height >= side2))
    cone = side2[:, None] * from_start - height[:, None] * axis
    local = np.where(
        on_start[:, None], from_start, np.where(on_end[:, None], from_start - axis, cone)
    )
    normals = np.einsum("mij,mi->mj", maps[index], local)
    return normals / np.sqrt(_dot(normals, normals))[:, None]


def image_windows(solids: RoundCones, camera: Camera) -> list[Window]:
    """The smallest window of the image that holds each solid, empty where it is out of view.

    A plane x = k z through the camera touches an ellipsoid (centre c, shape M) where
    k^2 (c_z^2 - M_zz) - 2 k (c_x c_z - M_xz) + c_x^2 - M_xx = 0.
    """
    stretched = solids.axes * solids.scales[:, None, :]
    shapes = stretched @ np.swapaxes(stretched, -1, -2)
    bounds = np.empty((2, 2, 2, len(solids)))  # ball, axis, low/high
    balls = ((solids.starts, solids.start_radii), (solids.ends, solids.end_radii))
    behind = np.zeros((2, len(solids)), np.bool_)
    for ball, (centre, radius) in enumerate(balls):
        M = shapes * (radius**2)[:, None, None]
        z = centre[:, 2]
        curvature = z**2 - M[:, 2, 2]
        crosses = curvature <= 0.0
        behind[ball] = z < -np.sqrt(M[:, 2, 2])
        for axis in (0, 1):
            middle = centre[:, axis] * z - M[:, axis, 2]
            spread = middle**2 - curvature * (centre[:, axis] ** 2 - M[:, axis, axis])
            root = np.sqrt(np.maximum(spread, 0.0))
            safe = np.where(crosses, 1.0, curvature)
            bounds[ball, axis, 0] = np.where(crosses, -np.inf, (middle - root) / safe)
            bounds[ball, axis, 1] = np.where(crosses, np.inf, (middle + root) / safe)
    # A ball behind the camera drags its hull across the whole half plane.
    partly = behind.any(0)
    low = np.where(partly, -np.inf, bounds[:, :, 0].min(0))
    high = np.where(partly, np.inf, bounds[:, :, 1].max(0))
    sides = np.array([camera.width, camera.height])
    scale, centre_px = np.array([camera.fx, camera.fy]), np.array([camera.cx, camera.cy])
    first = np.clip(np.ceil(low.T * scale + centre_px), 0, sides).astype(int)
    last = np.clip(np.floor(high.T * scale + centre_px) + 1, 0, sides).astype(int)
    last[behind.all(0)] = 0
    return [
        (slice(v0, max(v0, v1)), slice(u0, max(u0, u1)))
        for (u0, v0), (u1, v1) in zip(first, last, strict=True)
    ]
