"""What the counts behind the uTVR score mean (Sec. 3.1, 5.2.1): one hypothesis, in plain NumPy.

Read this first. `topview.kernels.utvr` counts the same for hundreds of hypotheses at once;
`topview.score.utvr.UtvrTerms.from_counts` makes the factors of Eq. 5.7 - 5.9 of them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from topview.camera.pyramid import DepthView
from topview.geometry.quadrics import closed_cylinder_depths

Array = NDArray[np.float64]


class Counts(NamedTuple):
    """The seven counts, in the order in which `UtvrTerms.from_counts` wants them.

    Attributes:
        n_3d: N_3D, the user's points inside the hypothesised cylinder.
        n_pr: N_Pr, cells of its top view that they occupy.
        n_dcyl: N_Dcyl, pixels of the rendered cylinder; each is one of the next three.
        p_in: the scene is seen within T of the cylinder's surface.
        p_occl: something is seen nearer than that, and hides the cylinder.
        p_out: nothing is seen, or something farther: the cylinder would be in free space.
        n_coll: pixels of the rendered cylinder inside parts that are already placed.
    """

    n_3d: int
    n_pr: int
    n_dcyl: int
    p_in: int
    p_occl: int
    p_out: int
    n_coll: int


@dataclass(frozen=True, slots=True, eq=False)
class Pixels:
    """The pixels of a rendered cylinder.

    Attributes:
        surface_camera: [N, 3] where their rays meet it.
        is_in, is_occluded: [N] as `Counts` has them; the others are outliers.
    """

    surface_camera: Array
    is_in: NDArray[np.bool_]
    is_occluded: NDArray[np.bool_]

    @property
    def is_out(self) -> NDArray[np.bool_]:
        """[N]"""
        return ~self.is_in & ~self.is_occluded


@dataclass(frozen=True, slots=True, eq=False)
class Cylinder:
    """A closed elliptic cylinder along the +y of its frame, from 0 to `length_m`.

    Attributes:
        T_camera_part: [4, 4].
        length_m: metres.
        radii_m: semi-axes along x and z.
    """

    T_camera_part: Array
    length_m: float
    radii_m: tuple[float, float]

    def points_part(self, points_camera: Array) -> Array:
        """[..., 3] points in the cylinder's own frame."""
        return (points_camera - self.T_camera_part[:3, 3]) @ self.T_camera_part[:3, :3]

    def contains(self, points_camera: Array) -> NDArray[np.bool_]:
        """[..., 3] points to [...]: which are inside."""
        x, y, z = np.moveaxis(self.points_part(points_camera), -1, 0)
        rx, rz = self.radii_m
        return (y >= 0) & (y <= self.length_m) & ((x / rx) ** 2 + (z / rz) ** 2 <= 1)


def top_view_cells(cylinder: Cylinder, points_camera: Array, cell_m: float) -> NDArray[np.int64]:
    """[N, 3] points to the [C, 2] distinct cells on which they fall, seen along the axis.

    Points on a surface that runs along the axis fall on top of each other: over all directions of
    view, the true axis occupies the fewest cells (Fig. 3.2).
    """
    across = cylinder.points_part(points_camera)[:, [0, 2]]
    return np.unique(np.floor(across / cell_m).astype(np.int64), axis=0)


def count(
    hypothesis: Cylinder,
    points_camera: Array,
    view: DepthView,
    placed: Sequence[Cylinder],
    cell_m: float,
    tolerance_m: float,
) -> Counts:
    """Count what one hypothesis explains.

    Args:
        hypothesis: the cylinder.
        points_camera: [N, 3] the user's remaining points, metres.
        view: the whole scene's depth, the user's own included: D_3D and D_all in one image.
        placed: parts of this or other users that already have their poses.
        cell_m: side of a top-view cell (`DepthView.cell_m`).
        tolerance_m: the T of Sec. 5.2.1.
    """
    inside = points_camera[hypothesis.contains(points_camera)]
    pixels = characterise(hypothesis, view, tolerance_m)
    collides = np.zeros(len(pixels.surface_camera), np.bool_)
    for part in placed:
        collides |= part.contains(pixels.surface_camera)

    return Counts(
        n_3d=len(inside),
        n_pr=len(top_view_cells(hypothesis, inside, cell_m)),
        n_dcyl=len(pixels.surface_camera),
        p_in=int(pixels.is_in.sum()),
        p_occl=int(pixels.is_occluded.sum()),
        p_out=int(pixels.is_out.sum()),
        n_coll=int(collides.sum()),
    )


def characterise(hypothesis: Cylinder, view: DepthView, tolerance_m: float) -> Pixels:
    """What each pixel of the rendered cylinder is (Sec. 5.2.1); arguments as of `count`."""
    rays = _pixel_rays(view)
    rendered = closed_cylinder_depths(
        rays, hypothesis.T_camera_part, hypothesis.length_m, *hypothesis.radii_m
    )
    is_covered = np.isfinite(rendered)
    depth, seen = rendered[is_covered], view.depth_m[is_covered]
    is_valid = seen > 0
    is_in = is_valid & (np.abs(seen - depth) <= tolerance_m)
    is_occluded = is_valid & (seen < depth - tolerance_m)
    return Pixels(rays[is_covered] * depth[:, None], is_in, is_occluded)


def _pixel_rays(view: DepthView) -> Array:
    """[H, W, 3] direction of each pixel's ray, scaled to z = 1."""
    v, u = np.indices(view.depth_m.shape, np.float64)
    return np.stack([(u - view.cx) / view.fx, (v - view.cy) / view.fy, np.ones_like(u)], -1)
