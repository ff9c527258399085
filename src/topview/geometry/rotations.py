"""Rotations and rigid transforms, `T_a_b` mapping b-coordinates to a-coordinates."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from topview.records import ROTATION_TOLERANCE

Array = NDArray[np.float64]

_YZX, _ZXY = np.array([1, 2, 0]), np.array([2, 0, 1])  # the next axis, and the one after it


def rotations_from_angles(angles_rad: Array) -> Array:
    """[..., 3] rotations about x, y, z to [..., 3, 3] matrices Rx(x) Rz(z) Ry(y).

    The turn about y, a part's own axis, comes first, so that x and z alone say where the part
    points: `R @ (0, 1, 0) = (-sin z, cos x cos z, sin x cos z)`.
    """
    cosines, sines = np.cos(angles_rad), np.sin(angles_rad)
    cx, cy, cz = cosines[..., 0], cosines[..., 1], cosines[..., 2]
    sx, sy, sz = sines[..., 0], sines[..., 1], sines[..., 2]
    R = np.empty((*cosines.shape, 3))
    R[..., 0, 0], R[..., 0, 1], R[..., 0, 2] = cz * cy, -sz, cz * sy
    R[..., 1, 0], R[..., 1, 1], R[..., 1, 2] = (
        cx * sz * cy + sx * sy,
        cx * cz,
        cx * sz * sy - sx * cy,
    )
    R[..., 2, 0], R[..., 2, 1], R[..., 2, 2] = (
        sx * sz * cy - cx * sy,
        sx * cz,
        sx * sz * sy + cx * cy,
    )
    return R


def angles_from_rotations(R: Array) -> Array:
    """Inverse of `rotations_from_angles`, with z in -90..90 degrees: [..., 3, 3] to [..., 3]."""
    z = np.arcsin(np.clip(-R[..., 0, 1], -1.0, 1.0))
    x = np.arctan2(R[..., 2, 1], R[..., 1, 1])
    y = np.arctan2(R[..., 0, 2], R[..., 0, 0])
    return np.stack([x, y, z], -1)


def zxy_from_rotations(R: Array) -> Array:
    """[..., 3, 3] matrices Rz(z) Rx(x) Ry(y) to [..., 3] angles z, x, y, with x in -90..90 degrees;
    animation programs and the biomechanics of hips take turns in this order."""
    x = np.arcsin(np.clip(R[..., 2, 1], -1.0, 1.0))
    is_locked = np.hypot(R[..., 0, 1], R[..., 1, 1]) < 1e-9  # only the sum of z and y is known
    z = np.where(
        is_locked,
        np.arctan2(R[..., 1, 0], R[..., 0, 0]),
        np.arctan2(-R[..., 0, 1], R[..., 1, 1]),
    )
    y = np.where(is_locked, 0.0, np.arctan2(-R[..., 2, 0], R[..., 2, 2]))
    return np.stack([z, x, y], -1)


def rotations_from_vectors(vectors_rad: Array) -> Array:
    """[..., 3] axis times angle to [..., 3, 3] (Rodrigues' formula)."""
    angle = lengths(vectors_rad)[..., None, None]
    K = skew(vectors_rad)
    small = angle < 1e-8
    safe = np.where(small, 1.0, angle)
    a = np.where(small, 1.0 - angle**2 / 6, np.sin(safe) / safe)
    b = np.where(small, 0.5 - angle**2 / 24, (1.0 - np.cos(safe)) / safe**2)
    return np.eye(3) + a * K + b * (K @ K)


def vectors_from_rotations(R: Array) -> Array:
    """Inverse of `rotations_from_vectors`, for angles below 180 degrees."""
    w = R[..., _ZXY, _YZX] - R[..., _YZX, _ZXY]
    sine = lengths(w) / 2
    trace = R[..., 0, 0] + R[..., 1, 1] + R[..., 2, 2]
    angle = np.arctan2(sine, (trace - 1) / 2)
    return w * np.where(sine > 1e-9, angle / np.where(sine > 1e-9, 2 * sine, 1.0), 0.5)[..., None]


def nearest_rotations(M: Array) -> Array:
    """[..., 3, 3] the rotation nearest to each matrix."""
    U, _, V = np.linalg.svd(M)
    U[..., 2] *= np.sign(np.linalg.det(U @ V))[..., None]
    return U @ V


def shortest_turns(directions: Array, turned: Array) -> Array:
    """[..., 3] unit vectors, and what they are to become, to the [..., 3, 3] rotations by the least
    angle; NaN stays NaN. Between opposites, any axis across will do."""
    across = cross(directions, turned)
    cosine = (directions * turned).sum(-1)[..., None, None]
    is_opposite = cosine < -1.0 + 1e-12
    K = skew(across)
    R = np.eye(3) + K + K @ K / np.where(is_opposite, 1.0, 1.0 + cosine)
    least = np.eye(3)[np.abs(directions).argmin(-1)]
    axis = unit(cross(directions, least))
    half_turn = 2.0 * axis[..., :, None] * axis[..., None, :] - np.eye(3)
    return np.where(is_opposite, half_turn, R)


def are_rotations(R: Array) -> NDArray[np.bool_]:
    """[...] whether [..., 3, 3] matrices are rotations, as nearly as three digits tell; not where
    they are NaN."""
    with np.errstate(all="ignore"):
        off = np.abs(R @ np.swapaxes(R, -1, -2) - np.eye(3)).max((-1, -2))
        return np.array((off < ROTATION_TOLERANCE) & (np.linalg.det(R) > 0.0))


def skew(vectors: Array) -> Array:
    """[..., 3] to [..., 3, 3] with `skew(a) @ b = a x b`."""
    x, y, z = vectors[..., 0], vectors[..., 1], vectors[..., 2]
    K = np.zeros((*vectors.shape, 3))
    K[..., 2, 1], K[..., 0, 2], K[..., 1, 0] = x, y, z
    K[..., 1, 2], K[..., 2, 0], K[..., 0, 1] = -x, -y, -z
    return K


def transform(R_a_b: Array, origin_a: Array) -> Array:
    """[..., 3, 3] and [..., 3] to [..., 4, 4] `T_a_b`."""
    T = np.zeros((*R_a_b.shape[:-2], 4, 4))
    T[..., :3, :3] = R_a_b
    T[..., :3, 3] = origin_a
    T[..., 3, 3] = 1.0
    return T


def levelled(up_camera: Array, height_m: float) -> Array:
    """[4, 4] `T_stage_camera`: the camera's place and heading, levelled. The stage has x right, y
    down along gravity, z forward, and its origin on the floor below the camera.

    Args:
        up_camera: [3] unit vector against gravity.
        height_m: of the camera over the floor.
    """
    down = -up_camera
    forward = np.array([0.0, 0.0, 1.0]) - down[2] * down
    forward /= np.linalg.norm(forward)
    T_stage_camera = np.eye(4)
    T_stage_camera[:3, :3] = np.stack([np.cross(down, forward), down, forward])
    T_stage_camera[1, 3] = -height_m
    return T_stage_camera


def horizontal(vector: Array, up: Array) -> Array:
    """[3] the component of a vector across the unit vector `up`: along the floor."""
    return vector - up * (vector @ up)


def unit(vectors: Array) -> Array:
    """[..., 3] scaled to length one; zeros stay zeros."""
    length = lengths(vectors)[..., None]
    return vectors / np.where(length > 0, length, 1.0)


def lengths(vectors: Array) -> Array:
    """[...] of [..., 3]; for a body's few vectors several times as fast as `np.linalg.norm`."""
    return np.sqrt(np.add.reduce(vectors * vectors, axis=-1))


def cross(one: Array, other: Array) -> Array:
    """[..., 3] cross products; for a body's few vectors several times as fast as `np.cross`."""
    yzx, zxy = one.take(_YZX, -1), one.take(_ZXY, -1)
    return yzx * other.take(_ZXY, -1) - zxy * other.take(_YZX, -1)
