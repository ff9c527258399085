"""Ray casting of closed elliptic cylinders through quadrics (Sec. 4.2), in readable NumPy.

A quadric is a symmetric 4 x 4 matrix Q; with X = (x, y, z, 1), `X^T Q X` is negative inside, zero
on the surface and positive outside. A body part is the meeting of two of them, an infinite cylinder
and the slab between a pair of planes. The fast form is `topview.kernels.cylinders`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def elliptic_cylinder(rx: float, rz: float) -> Array:
    """[4, 4] infinite cylinder along y with semi-axes `rx` and `rz`, the a and b of Eq. 4.11."""
    return np.diag([1.0 / rx**2, 0.0, 1.0 / rz**2, -1.0])


def pair_of_planes(y0: float, y1: float) -> Array:
    """[4, 4] with `X^T Q X = (y - y0) (y - y1)` (Eq. 4.12): negative between the planes.

    Eq. 4.13 and 4.15 ask for >= 0, which with this matrix is outside of the planes: a misprint.
    """
    Q = np.zeros((4, 4))
    Q[1, 1] = 1.0
    Q[1, 3] = Q[3, 1] = -0.5 * (y0 + y1)
    Q[3, 3] = y0 * y1
    return Q


def transformed(Q_b: Array, T_a_b: Array) -> Array:
    """The quadric in frame a: `Q' = T^-T Q T^-1`."""
    T_b_a = np.linalg.inv(T_a_b)
    return T_b_a.T @ Q_b @ T_b_a


def evaluate(Q: Array, points: Array) -> Array:
    """[..., 3] points to [...] `X^T Q X`."""
    X = np.concatenate([points, np.ones((*points.shape[:-1], 1))], axis=-1)
    return np.einsum("...i,ij,...j->...", X, Q, X)


def ray_roots(Q: Array, rays: Array) -> Array:
    """[..., 3] rays to [..., 2] solutions t of `X(t)^T Q X(t) = 0`, X(t) = t ray (Eq. 4.14).

    Rays start at the frame's origin. NaN or infinite where there is no such solution.
    """
    a = np.einsum("...i,ij,...j->...", rays, Q[:3, :3], rays)
    b = rays @ Q[:3, 3]
    c = Q[3, 3]
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        # of the two textbook forms of each root, the one that does not cancel
        q = -(b + np.copysign(np.sqrt(b * b - a * c), b))
        return np.stack([q / a, c / q], axis=-1)


def closed_cylinder_depths(
    rays: Array, T_camera_part: Array, length: float, rx: float, rz: float
) -> Array:
    """How far along each ray a closed elliptic cylinder is first met.

    The thesis leaves the ends open; here (ours) discs close them, or an arm that points at the
    camera would vanish. The surface of the closed cylinder is where one of its two quadrics is
    zero and the other is not positive.

    Args:
        rays: [..., 3] from the camera's centre, which must be outside of the cylinder.
        T_camera_part: [4, 4] pose of the part: axis along +y, from 0 to `length`.
        length, rx, rz: metres.

    Returns:
        [...] in units of the rays, so metres of depth if these have z = 1; inf where a ray misses.
    """
    side = transformed(elliptic_cylinder(rx, rz), T_camera_part)
    ends = transformed(pair_of_planes(0.0, length), T_camera_part)
    depths = np.full(rays.shape[:-1], np.inf)
    for surface, bound in ((side, ends), (ends, side)):
        for t in np.moveaxis(ray_roots(surface, rays), -1, 0):
            is_ahead = np.isfinite(t) & (t > 0)
            points = np.where(is_ahead, t, 0.0)[..., None] * rays
            is_hit = is_ahead & (evaluate(bound, points) <= 0)
            depths = np.where(is_hit, np.minimum(depths, t), depths)
    return depths
