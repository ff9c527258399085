"""How far joints may be off: the terms of their covariances.

Variances go along the image's axes and along the ray through a joint, by a metre of depth. Scales
are those of `topview.detect.joints.JointProposals`; the variance of a Laplace law is twice its
scale's square.
"""

from __future__ import annotations

import numpy as np
from numba import njit


@njit(error_model="numpy")
def _fill_along(joint, right, down, deep, factor, out):
    """Fill [3, 3] with a factor times variances to the right, down, and along a joint's ray."""
    z = joint[2]
    for a in range(3):
        for b in range(3):
            across = right if a == 0 and b == 0 else down if a == 1 and b == 1 else 0.0
            out[a, b] = factor * (across + joint[a] / z * deep * (joint[b] / z))


@njit(error_model="numpy")
def _is_proposed(scales, j):
    for m in range(scales.shape[0]):
        for i in range(3):
            if not np.isfinite(scales[m, j, i]):
                return False
    return scales.shape[0] > 0


@njit(error_model="numpy")
def _nearest_mode(joints_camera, places, scales):
    """The mode whose places are nearest to the joints, in scales; joints that are absent do not
    count."""
    nearest, least = 0, np.inf
    for m in range(places.shape[0]):
        total = 0.0
        for j in range(places.shape[1]):
            square = 0.0
            for i in range(3):
                off = (places[m, j, i] - joints_camera[j, i]) / scales[m, j, i]
                square += off * off
            if not np.isnan(square):
                total += np.sqrt(square)
        if total < least:
            nearest, least = m, total
    return nearest


@njit(cache=True, error_model="numpy", nogil=True)
def fill_terms(joints_camera, is_behind, is_on_arm, factors, places, scales, weights, out):
    """Fill the terms that `topview.track.joint_errors.TERMS` names.

    Args:
        joints_camera: [J, 3] metres, as tracked; NaN of absent ones.
        is_behind: [J] whether another person hides the joint.
        is_on_arm: [J].
        factors: [4, J] of joints that are not proposed, square metres.
        places, scales: [M, J, 3] metres, as proposed; infinite scales of joints that are not.
        weights: [M] of the modes.
        out: [8, J, 3, 3] zeros: four terms of joints that are proposed, four of the others.
    """
    own = _nearest_mode(joints_camera, places, scales)
    for j in range(joints_camera.shape[0]):
        joint = joints_camera[j]
        if not _is_proposed(scales, j):
            for k in range(4):
                _fill_along(joint, 1.0, 1.0, 1.0, factors[k, j], out[4 + k, j])
            continue
        right, down, deep = scales[own, j, 0], scales[own, j, 1], scales[own, j, 2]
        right, down, deep = 2.0 * (right * right), 2.0 * (down * down), 2.0 * (deep * deep)
        _fill_along(joint, right, down, deep, 1.0, out[1 if is_behind[j] else 0, j])
        if is_behind[j] and is_on_arm[j]:
            _fill_along(joint, right, down, deep, 1.0, out[2, j])
        for m in range(weights.shape[0]):
            for a in range(3):
                weighted = weights[m] * (places[m, j, a] - joint[a])
                for b in range(3):
                    out[3, j, a, b] += weighted * (places[m, j, b] - joint[b])
