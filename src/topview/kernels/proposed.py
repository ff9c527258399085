"""What proposed joints tell of a body: how sure they are of lengths, and which way a trunk faces.

Scales are those of `topview.detect.joints.JointProposals`; the variance of a Laplace law is twice
its scale's square.
"""

from __future__ import annotations

import numpy as np
from numba import njit


@njit(cache=True, error_model="numpy", nogil=True)
def variances_along(places, scales, joints, directions, out_along, out_all):
    """Fill variances of joints' places.

    Args:
        places, scales: [J, 3] metres; scales may be infinite.
        joints: [N] which of them.
        directions: [N, 3] unit vectors.
        out_along: [N] become those along the directions, square metres.
        out_all: [N] become those along all three axes together.
    """
    for n in range(len(joints)):
        x, y, z = places[joints[n]]
        right, down, deep = scales[joints[n]]
        right, down, deep = 2.0 * (right * right), 2.0 * (down * down), 2.0 * (deep * deep)
        ray_x, ray_y = x / z, y / z
        dx, dy, dz = directions[n]
        along_ray = dx * ray_x + dy * ray_y + dz
        out_along[n] = right * (dx * dx) + down * (dy * dy) + deep * (along_ray * along_ray)
        out_all[n] = right + down + deep * (ray_x * ray_x + ray_y * ray_y + 1.0)


@njit(error_model="numpy")
def _dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@njit(error_model="numpy")
def _cross(a, b, out):
    out[0] = a[1] * b[2] - a[2] * b[1]
    out[1] = a[2] * b[0] - a[0] * b[2]
    out[2] = a[0] * b[1] - a[1] * b[0]


@njit(error_model="numpy")
def _unit(a, out):
    """Zeros stay zeros."""
    length = np.sqrt(_dot(a, a))
    for i in range(3):
        out[i] = a[i] / (length if length > 0.0 else 1.0)


@njit(error_model="numpy")
def _make_across(axis, way):
    """Leave of a way what is across a unit vector."""
    along = _dot(way, axis)
    for i in range(3):
        way[i] -= along * axis[i]


@njit(cache=True, error_model="numpy", nogil=True)
def face_trunks(places, scales, left, right, least_breadth, out_turn, out_sigmas):
    """Find out which way trunks face, about their own axes.

    Args:
        places, scales: [M, J, 3] metres; scales may be infinite.
        left, right: [2] the shoulder and the hip of each side.
        least_breadth: of a trunk, metres.
        out_turn: [2, M] become the sine and cosine, times a length, of the turn from the direction
            to the camera to where the trunk's front faces.
        out_sigmas: [M] become the turns' standard deviations, radians; infinite where they are
            not known.
    """
    across, to_camera, down, front = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    way = np.empty(3)
    for m in range(places.shape[0]):
        shoulder, hip = places[m, left[0]], places[m, left[1]]
        other_shoulder, other_hip = places[m, right[0]], places[m, right[1]]
        for i in range(3):
            upper, lower = shoulder[i] + other_shoulder[i], hip[i] + other_hip[i]
            way[i] = lower - upper
            across[i] = (other_shoulder[i] - shoulder[i]) + (other_hip[i] - hip[i])
            to_camera[i] = -(upper + lower)
        _unit(way, down)
        _make_across(down, across)
        _make_across(down, to_camera)
        _cross(across, down, front)
        _cross(front, to_camera, way)
        out_turn[0, m], out_turn[1, m] = _dot(way, down), _dot(front, to_camera)
        _unit(front, way)  # in which the sides move when the trunk turns
        total = 0.0
        for side in (left, right):
            for joint in side:
                along_ray = aside = 0.0
                for i in range(3):
                    along_ray += way[i] * places[m, joint, i] / places[m, joint, 2]
                for i in range(2):
                    square = scales[m, joint, i] * scales[m, joint, i]
                    aside += 2.0 * square * (way[i] * way[i])
                square = scales[m, joint, 2] * scales[m, joint, 2]
                total += aside + 2.0 * square * (along_ray * along_ray)
        sigma = np.sqrt(total) / max(np.sqrt(_dot(across, across)), least_breadth)
        out_sigmas[m] = sigma if np.isfinite(sigma) else np.inf
