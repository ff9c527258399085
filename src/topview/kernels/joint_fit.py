"""The body fitted to proposed joints, all modes at once: a start from the joints themselves, then
Gauss-Newton (ours).

Every joint is pulled to where it was proposed, along the three axes of its scales
(`topview.detect.joints`), robustly. Joints are pushed back within their limits. Each mode is fitted
on its own and all sums are taken in one fixed order.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from topview.kernels.body import (
    HEAD,
    UPPER_TORSO,
    add_limits,
    align_hinges,
    copy,
    multiply,
    orthonormalise,
    place_axes,
    place_parts,
    relative_rotations,
    solve_lower,
    turn_parts,
    vector,
)
from topview.kernels.pulls import move_together, pull_to_joints

TRUSTED_M = 0.3  # scale of a joint by which the start goes half way; ours
BENT = 0.3  # of its upper part's length that a limb's hidden middle starts aside; ours
SLIGHT_M = 1e-6  # of a direction that counts only where nothing else tells one


@njit(error_model="numpy")
def _point(R, y, out):
    """[3, 3] turned by the shortest way so that its second axis points along y [3]."""
    norm = np.sqrt(y[0] ** 2 + y[1] ** 2 + y[2] ** 2)
    along = across = 0.0
    for i in range(3):
        along += R[i, 1] * y[i] / norm
        across += R[i, 0] * y[i] / norm
    share = across / max(1.0 + along, SLIGHT_M)
    for i in range(3):
        out[i, 0] = R[i, 0] - share * (R[i, 1] + y[i] / norm)
        out[i, 1] = y[i] / norm
    orthonormalise(out)


@njit(error_model="numpy")
def _add(places, trust, first, second, out):
    """Add the way from one joint to another to `out` [3], by how far both are trusted."""
    for i in range(3):
        out[i] += trust[first] * trust[second] * (places[second, i] - places[first, i])


@njit(error_model="numpy")
def start_at_joints(
    neck, Rs, places, scales, lengths, joints_parent, parents, joint_part, joints_part, trunk,
    limbs, hinges, bends,
):  # fmt: skip
    """Fill `neck` and `Rs` with a pose that is near the joints: the trunk as a whole, then the
    head and the limbs along their joints, as far as each is trusted.

    Args:
        trunk: [U] joints that the unbent trunk carries: the neck, torso, pelvis, then shoulders and
            hips, left before right.
        limbs: [L, 4] index of the upper part, its proximal joint, the one between, the last one.
    """
    trust = np.empty(places.shape[0])
    for j in range(places.shape[0]):
        trust[j] = 1.0 / (1.0 + (max(scales[j, 0], scales[j, 1], scales[j, 2]) / TRUSTED_M) ** 2)
    R = np.zeros((3, 3))
    way = np.zeros(3)
    way[1] = SLIGHT_M
    for upper in (0, 3, 4):
        for lower in (1, 2, 5, 6):
            _add(places, trust, trunk[upper], trunk[lower], way)
    for i in range(3):
        R[i, 1] = way[i]
        way[i] = 0.0
    way[0] = -SLIGHT_M
    _add(places, trust, trunk[3], trunk[4], way)
    _add(places, trust, trunk[5], trunk[6], way)
    for i in range(3):
        R[i, 0] = way[i]
        way[i] = neck[i] = 0.0
    orthonormalise(R)
    for k in range(Rs.shape[0]):
        copy(R, Rs[k])

    origins = np.empty((Rs.shape[0], 3))
    place_parts(neck, Rs, lengths, joints_parent, parents, origins)
    total = 0.0
    for j in trunk:
        k = joint_part[j]
        total += trust[j]
        for i in range(3):
            along = 0.0
            for a in range(3):
                along += Rs[k, i, a] * joints_part[j, a]
            way[i] += trust[j] * (places[j, i] - origins[k, i] - along)
    for i in range(3):
        neck[i] = way[i] / max(total, SLIGHT_M)
        for k in range(Rs.shape[0]):
            origins[k, i] += neck[i]

    for i in range(3):
        way[i] = trust[0] * (neck[i] - places[0, i]) + (1.0 - trust[0]) * R[i, 1] * lengths[HEAD]
    _point(R, way, Rs[HEAD])
    _point_limbs(Rs, places, trust, origins, lengths, limbs, bends)
    align_hinges(Rs, hinges, bends)


@njit(error_model="numpy")
def _point_limbs(Rs, places, trust, origins, lengths, limbs, bends):
    """Point both parts of every limb along its joints, as far as each is trusted; what is not
    goes on straight, or bends a little the way that it can."""
    way = np.empty(3)
    for limb in range(limbs.shape[0]):
        upper, first = limbs[limb, 0], limbs[limb, 1]
        middle, last = limbs[limb, 2], limbs[limb, 3]
        for i in range(3):
            start = trust[first] * places[first, i] + (1.0 - trust[first]) * origins[upper, i]
            to_last = trust[last] * (places[last, i] - start)
            to_last += (1.0 - trust[last]) * Rs[upper, i, 1] * lengths[upper]
            to_last -= BENT * trust[last] * bends[limb] * lengths[upper] * Rs[UPPER_TORSO, i, 2]
            way[i] = trust[middle] * (places[middle, i] - start) + (1.0 - trust[middle]) * to_last
        _point(Rs[UPPER_TORSO], way, Rs[upper])
        for i in range(3):
            start = trust[first] * places[first, i] + (1.0 - trust[first]) * origins[upper, i]
            straight = Rs[upper, i, 1] * lengths[upper]
            between = trust[middle] * places[middle, i]
            between += (1.0 - trust[middle]) * (start + straight)
            way[i] = trust[last] * (places[last, i] - between) + (1.0 - trust[last]) * straight
        _point(Rs[upper], way, Rs[upper + 1])


@njit(cache=True, error_model="numpy", nogil=True)
def fit_joints(
    necks, Rs_all, places, scales, lengths, joints_parent, parents, tree, joint_part, joints_part,
    trunk, limbs, limits, hinges, bends, dof_part, dof_axis, chain, n_chain, dof_of, n_dof_of,
    prior_weight, limit_weight, iterations, residuals,
):  # fmt: skip
    """Fit M poses to as many modes.

    Args:
        necks, Rs_all: [M, 3] metres and [M, B, 3, 3] `Rs_camera_part`; are filled.
        places, scales: [M, K, 3], as in `pull_to_joints`.
        lengths, joints_parent, joint_part, joints_part: the body, metres.
        trunk, limbs: as in `start_at_joints`.
        parents, tree, limits, hinges, bends, dof_part, dof_axis, chain, n_chain, dof_of, n_dof_of:
            as in `topview.kernels.body.refine_bodies`.
        prior_weight, limit_weight: of a turn away from the start, and beyond a limit, per square
            radian.
        iterations: Gauss-Newton steps.
        residuals: [M] is filled with the mean robust residual, in units of scale.
    """
    B = Rs_all.shape[1]
    D = dof_part.shape[0]
    origins = np.empty((B, 3))
    relative = np.empty((B, 3, 3))
    start = np.empty((B, 3, 3))
    R = np.empty((3, 3))
    away = np.empty(3)
    axes = np.empty((D, 3))
    centers = np.empty((D, 3))
    A = np.empty((D, D))
    g = np.empty(D)
    sums = np.empty((B, 6, 7))
    for m in range(necks.shape[0]):
        neck, Rs = necks[m], Rs_all[m]
        start_at_joints(
            neck, Rs, places[m], scales[m], lengths, joints_parent, parents, joint_part,
            joints_part, trunk, limbs, hinges, bends,
        )  # fmt: skip
        relative_rotations(Rs, tree, start)
        # the last round only measures
        for iteration in range(iterations + 1):
            place_parts(neck, Rs, lengths, joints_parent, parents, origins)
            place_axes(neck, Rs, origins, dof_part, dof_axis, axes, centers)
            A[:] = 0.0
            g[:] = 0.0
            sums[:] = 0.0
            residuals[m] = pull_to_joints(
                A, sums, Rs, origins, places[m], scales[m], joint_part, joints_part, chain, n_chain,
                axes, centers, 1.0,
            )  # fmt: skip
            if iteration == iterations:
                break
            move_together(A, g, sums, tree, dof_part, chain, n_chain, axes, centers)
            add_limits(A, g, Rs, parents, limits, limit_weight, dof_of, n_dof_of, axes)
            relative_rotations(Rs, tree, relative)
            for i in range(3):
                A[i, i] += prior_weight
            for k in range(B):
                multiply(start[k], relative[k], True, R)
                vector(R, away)
                for a in range(n_dof_of[k]):
                    d = dof_of[k, a]
                    A[d, d] += prior_weight
                    g[d] -= prior_weight * away[dof_axis[d]]
            step = solve_lower(A, g)
            for i in range(3):
                neck[i] += step[i]
            turn_parts(relative, Rs, step, tree, dof_of, n_dof_of, dof_axis)
            align_hinges(Rs, hinges, bends)
