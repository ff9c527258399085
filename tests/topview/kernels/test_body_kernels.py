"""The leaves of the whole-body refinement against NumPy."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from scipy.spatial.transform import Rotation

from topview.body.kinematics import R_CAMERA_FACING
from topview.body.limits import excess_rad
from topview.body.model import BodyModel
from topview.body.parts import PARTS
from topview.body.proportions import ANATOMICAL
from topview.body.shapes import dressed_shapes
from topview.geometry.rotations import rotations_from_angles
from topview.kernels.body import (
    BACK_FACING,
    TURNED_M,
    align_hinges,
    assign_points,
    beyond_limits,
    place_axes,
    relative_rotations,
    solve_lower,
    surface_distance,
)
from topview.kernels.pulls import move_together, pull, turn_as_seen
from topview.track.degrees_of_freedom import CHAIN, DOF_AXIS, DOF_PART, N_CHAIN, N_DOFS, TREE
from topview.track.pose import HINGE_BENDS, HINGE_PAIRS, TREE_PARENT, Pose

MODEL = BodyModel.of(1.75, ANATOMICAL)
REACH_M = 0.15

metres = st.floats(-0.6, 0.6)
radii = st.floats(0.02, 0.2)
aside = st.floats(-0.03, 0.03)


def rotations(seed: int) -> np.ndarray:
    """[11, 3, 3]"""
    return Rotation.from_quat(np.random.default_rng(seed).normal(size=(len(PARTS), 4))).as_matrix()


@given(st.integers(1, 28), st.integers(0, 2**32 - 1))
def test_solve_lower_solves(n, seed):
    rng = np.random.default_rng(seed)
    J = rng.normal(size=(2 * n, n))
    A, g = J.T @ J + np.eye(n), rng.normal(size=n)
    expected = np.linalg.solve(A, g)
    lower = np.tril(A) + np.triu(np.full_like(A, np.nan), 1)  # the upper triangle is not read
    assert_allclose(solve_lower(lower, g), expected, atol=1e-9)


def section(p: np.ndarray, length: float, shape: np.ndarray) -> tuple[np.ndarray, ...]:
    """Places [..., 3] in the part's frame from the axis of a tapered part, and the semi-axes
    there."""
    x, y, z = np.moveaxis(p, -1, 0)
    share = np.clip(y / length, 0.0, 1.0)
    rx, rz = (shape[i] * (1.0 - share) + shape[2 + i] * share for i in range(2))
    return x - shape[4], y, z - shape[5], rx, rz


def defined_distance(p: np.ndarray, length: float, shape: np.ndarray) -> np.ndarray:
    """[..., 3] points in the part's frame to [...] signed distances: to the side along the line to
    the axis, to the flat or rounded end beyond it."""
    x, y, z, rx, rz = section(p, length, shape)
    radial = np.hypot(x, z)
    on_ellipse = radial / np.hypot(x / rx, z / rz)  # axis to surface in this direction
    gap = radial - on_ellipse
    beyond = y - np.clip(y, 0.0, length)
    return np.where(beyond != 0.0, np.hypot(np.maximum(gap, 0.0), beyond), gap)


@given(metres, st.floats(-0.3, 0.9), metres, st.tuples(radii, radii, radii, radii), aside, aside)
def test_surface_distance_is_as_defined_and_its_normal_points_outward(x, y, z, wide, x0, z0):
    if np.hypot(x - x0, z - z0) < 1e-3:
        x = x0 + 2e-3  # on the axis no direction is the nearest one
    p, length, shape = np.array([x, y, z]), 0.5, np.array([*wide, x0, z0])
    d, *n = surface_distance(x, y, z, length, shape[None], 0)
    assert d == pytest.approx(defined_distance(p, length, shape), abs=1e-9)
    n = np.array(n)
    if abs(d) > 1e-6:
        assert np.linalg.norm(n) == pytest.approx(1.0)
        step = 1e-4 * n
        assert defined_distance(p + step, length, shape) > defined_distance(p, length, shape)


def outward_normals(p: np.ndarray, length: float, shape: np.ndarray) -> np.ndarray:
    """[..., 3] of the surface nearest to each point."""
    x, y, z, rx, rz = section(p, length, shape)
    n = np.stack([x / rx**2, np.zeros_like(x), z / rz**2], axis=-1)
    n /= np.linalg.norm(n, axis=-1, keepdims=True)
    beyond = y - np.clip(y, 0.0, length)
    outside = np.maximum(np.hypot(x, z) * (1.0 - 1.0 / np.hypot(x / rx, z / rz)), 0.0)
    round_end = n * outside[..., None]
    round_end[..., 1] = beyond
    round_end /= np.maximum(np.linalg.norm(round_end, axis=-1, keepdims=True), 1e-12)
    return np.where((beyond != 0.0)[..., None], round_end, n)


@pytest.mark.parametrize(
    "shapes_m", [MODEL.shapes_m, dressed_shapes(1.75)], ids=["bare", "dressed"]
)
@pytest.mark.parametrize("seed", range(2))
def test_points_go_to_the_surface_most_like_theirs_of_those_that_face_the_camera(seed, shapes_m):
    rng = np.random.default_rng(seed)
    Rs = rotations(seed) if seed else np.repeat(R_CAMERA_FACING[None], len(PARTS), axis=0)
    origins = Pose(np.array([0.1, -0.4, 2.5]), Rs).origins(MODEL)
    points = origins[rng.integers(0, len(PARTS), 600)] + rng.normal(0.0, 0.15, (600, 3))

    defined = np.full((len(PARTS), len(points)), np.inf)
    normals_of = np.empty((len(PARTS), len(points), 3))
    for k in range(len(PARTS)):
        size = MODEL.lengths_m[k], shapes_m[k]
        in_part = (points - origins[k]) @ Rs[k]
        d = defined_distance(in_part, *size)
        normals_of[k] = outward_normals(in_part, *size) @ Rs[k].T
        cosine = np.einsum("ni,ni->n", normals_of[k], points)
        is_facing = cosine <= BACK_FACING * np.linalg.norm(points, axis=1)
        defined[k] = np.where(is_facing & (np.abs(d) < REACH_M), d, np.inf)
    # Where a surface is seen to face is known of every other point.
    seen = rng.normal(0.0, 1.0, (len(points), 3))
    seen *= (np.arange(len(points)) % 2 / np.linalg.norm(seen, axis=1))[:, None]
    turned = (seen * (seen - normals_of)).sum(-1)
    unlike = np.where(np.isfinite(defined), np.abs(defined) + TURNED_M * turned, np.inf)
    nearest = unlike.argmin(0)
    is_reached = unlike.min(0) < REACH_M
    assert (nearest != np.abs(defined).argmin(0))[is_reached].any()
    expected = np.where(is_reached, nearest, -1)

    labels, distances = np.full(len(points), -1, np.int32), np.empty(len(points))
    normals, found = np.empty((len(points), 3)), np.empty(len(points))
    body = MODEL.lengths_m, shapes_m, REACH_M
    assign_points(points, seen, Rs, origins, *body, labels, distances, normals, found)
    assert_array_equal(labels, expected)
    guessed = rng.integers(-1, len(PARTS), len(points)).astype(np.int32)
    again = np.empty_like(distances), np.empty_like(normals), np.empty_like(found)
    assign_points(points, seen, Rs, origins, *body, guessed, *again)
    assert_array_equal(guessed, expected)
    chosen = defined[nearest, np.arange(len(points))]
    assert_allclose(distances, np.where(is_reached, chosen, 0.0), atol=1e-9)
    chosen_normals = normals_of[nearest, np.arange(len(points))]
    assert_allclose(normals[is_reached], chosen_normals[is_reached], atol=1e-9)
    assert_allclose(found[is_reached], unlike.min(0)[is_reached], atol=1e-9)
    assert 0.2 < is_reached.mean() < 0.9


@given(st.integers(0, 2**32 - 1))
def test_what_pulls_at_parts_pulls_at_all_that_moves_them(seed):
    rng = np.random.default_rng(seed)
    pose = Pose(rng.normal((0.0, 0.0, 3.0)), rotations(seed))
    origins = pose.origins(MODEL)
    axes, centers = np.empty((2, N_DOFS, 3))
    place_axes(pose.neck_camera, pose.Rs, origins, DOF_PART, DOF_AXIS, axes, centers)

    A, g = np.zeros((N_DOFS, N_DOFS)), np.zeros(N_DOFS)
    sums = np.zeros((len(PARTS), 6, 7))
    for part in rng.integers(0, len(PARTS), 30):
        place, way = origins[part] + rng.normal(0.0, 0.2, 3), rng.normal(0.0, 1.0, 3)
        gap, weight = rng.normal(), rng.uniform(0.1, 2.0)
        (x, y, z), (nx, ny, nz) = place, way
        pull(sums, part, x, y, z, nx, ny, nz, gap, weight)
        J = np.zeros(N_DOFS)
        for d in CHAIN[part, : N_CHAIN[part]]:
            J[d] = way @ (axes[d] if d < 3 else np.cross(axes[d], place - centers[d]))
        A += weight * np.outer(J, J)
        g += weight * gap * J

    moved_A, moved_g = np.zeros_like(A), np.zeros_like(g)
    move_together(moved_A, moved_g, sums, TREE, DOF_PART, CHAIN, N_CHAIN, axes, centers)
    assert_allclose(moved_A, np.tril(A), atol=1e-9)
    assert_allclose(moved_g, g, atol=1e-9)


def moved(pose: Pose, dof: int, by: float) -> Pose:
    """With one degree of freedom changed, and what hangs from its part."""
    if dof < 3:
        return Pose(pose.neck_camera + by * np.eye(3)[dof], pose.Rs)
    relative, part = pose.relative(), DOF_PART[dof]
    turn = Rotation.from_rotvec(by * np.eye(3)[DOF_AXIS[dof]]).as_matrix()
    relative[part] = relative[part] @ turn
    return Pose.from_relative(pose.neck_camera, relative)


@given(st.integers(0, 2**32 - 1))
def test_what_turns_a_part_to_face_as_is_seen_is_the_derivative_of_how_far_it_is_turned(seed):
    """Of the sides of straight elliptic cylinders."""
    rng, by = np.random.default_rng(seed), 1e-6
    start = Pose(rng.normal((0.0, 0.0, 3.0)), rotations(seed))
    pose = Pose.from_relative(start.neck_camera, start.relative())
    origins, count = pose.origins(MODEL), 30
    parts, seen = rng.integers(0, len(PARTS), count), rng.normal(0.0, 1.0, (count, 3))
    seen /= np.linalg.norm(seen, axis=1, keepdims=True)
    weights, angles = rng.uniform(0.1, 2.0, count), rng.uniform(0.0, 2.0 * np.pi, count)
    out = rng.uniform(0.7, 1.5, count)
    in_part = np.stack(
        [
            MODEL.radii_m[parts, 0] * out * np.cos(angles),
            MODEL.lengths_m[parts] * rng.uniform(0.1, 0.9, count),
            MODEL.radii_m[parts, 1] * out * np.sin(angles),
        ],
        axis=1,
    )
    points = (pose.Rs[parts] @ in_part[..., None])[..., 0] + origins[parts]

    def normals(pose: Pose) -> np.ndarray:
        away = (points - pose.origins(MODEL)[parts])[:, None] @ pose.Rs[parts]
        return np.array(
            [
                pose.Rs[k] @ outward_normals(p[0], float(MODEL.lengths_m[k]), MODEL.shapes_m[k])
                for k, p in zip(parts, away, strict=True)
            ]
        )

    sums, own = np.zeros((len(PARTS), 6, 7)), normals(pose)
    for i, k in enumerate(parts):
        (x, y, z), (nx, ny, nz) = points[i], own[i]
        turn_as_seen(
            sums, k, x, y, z, nx, ny, nz, seen[i], pose.Rs[k], origins[k], MODEL.lengths_m[k],
            MODEL.shapes_m, k, weights[i],
        )  # fmt: skip
    axes, centers = np.empty((2, N_DOFS, 3))
    place_axes(pose.neck_camera, pose.Rs, origins, DOF_PART, DOF_AXIS, axes, centers)
    A, g = np.zeros((N_DOFS, N_DOFS)), np.zeros(N_DOFS)
    move_together(A, g, sums, TREE, DOF_PART, CHAIN, N_CHAIN, axes, centers)

    for dof in range(N_DOFS):
        one, other = (
            weights @ (1.0 - (seen * normals(moved(pose, dof, sign * by))).sum(1))
            for sign in (-1.0, 1.0)
        )
        assert g[dof] == pytest.approx((one - other) / (2.0 * by), abs=1e-4)
    assert np.linalg.eigvalsh(A).min() > -1e-9


@given(st.floats(-np.pi, 0.0), st.floats(0.0, np.pi), st.floats(-np.pi, np.pi))
@example(low=-0.2, high=np.pi, angle=-np.pi)  # the limit itself, told the other way round
def test_beyond_the_limits_is_the_shorter_way_back_to_them(low, high, angle):
    beyond = beyond_limits(low, high, angle)
    turns = angle + 2 * np.pi * np.array([-1, 0, 1])
    assert abs(beyond) == pytest.approx(np.abs(turns - np.clip(turns, low, high)).min(), abs=1e-9)
    back = (turns - beyond)[:, None]
    assert ((low - 1e-9 <= back) & (back <= high + 1e-9)).any()


@given(st.integers(0, 2**32 - 1))
def test_relative_rotations_are_those_of_the_pose(seed):
    Rs = rotations(seed)
    relative = np.empty_like(Rs)
    relative_rotations(Rs, np.array(TREE_PARENT), relative)
    assert_allclose(relative, Pose(np.zeros(3), Rs).relative(), atol=1e-12)


@given(st.integers(0, 2**32 - 1))
def test_aligned_hinges_turn_about_x_alone_and_keep_their_directions(seed):
    Rs = rotations(seed)
    aligned = Rs.copy()
    bends = np.array([HINGE_BENDS[upper] for upper, _ in HINGE_PAIRS])
    align_hinges(aligned, np.array(HINGE_PAIRS), bends)
    assert_allclose(aligned[:, :, 1], Rs[:, :, 1], atol=1e-12)
    assert_allclose(aligned @ np.swapaxes(aligned, 1, 2), np.eye(3)[None].repeat(11, 0), atol=1e-9)
    for upper, lower in HINGE_PAIRS:
        flexion = aligned[upper].T @ aligned[lower]
        sine = np.linalg.norm(np.cross(Rs[upper][:, 1], Rs[lower][:, 1]))
        if sine > 0.26:  # the limb is bent enough to tell the plane of its hinge
            assert_allclose(flexion[0], (1.0, 0.0, 0.0), atol=1e-9)
            assert np.sign(flexion[2, 1]) == HINGE_BENDS[upper]


@given(st.floats(5, 155), st.integers(0, 2**32 - 1))
def test_an_aligned_elbow_keeps_its_limits(degrees, seed):
    """A forearm bent to any side of an upper arm becomes one that is bent to the front."""
    Rs = rotations(seed)
    upper, lower = HINGE_PAIRS[0]
    side = rotations_from_angles(np.array([0.0, seed % 7, 0.0]))
    Rs[lower] = Rs[upper] @ side @ rotations_from_angles(np.array([np.radians(degrees), 0.0, 0.0]))
    align_hinges(Rs, np.array([[upper, lower]]), np.array([1.0]))
    if np.sin(np.radians(degrees)) > 0.26:
        assert excess_rad(lower, Rs[upper].T @ Rs[lower]) == pytest.approx(0.0, abs=1e-6)
