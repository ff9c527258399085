"""The judgement of limb poses, and whose points are whose, against NumPy and the body's limits."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy.spatial.transform import Rotation

from topview.body.limits import excess_rad
from topview.body.parts import LEFT_UPPER_ARM, PARTS, RIGHT_UPPER_LEG
from topview.geometry.rotations import unit
from topview.kernels.limbs import judge_limbs, pick_scored, share_out_points
from topview.track.pose import HINGE_BENDS

LENGTHS = np.array([0.3, 0.28])
RADII = np.array([0.05, 0.04])
JOINT = np.array([0.2, -0.3, 2.4])
TOLERANCE_M = 0.04
FLOOR = np.array([0.0, -1.0, 0.0, 0.1])  # 0.1 m below the camera, so that many limbs end below it

RNG = np.random.default_rng(3)
AXES = unit(RNG.normal(size=(60, 2, 3)))
PREDICTED = unit(RNG.normal(size=(2, 3)))
R_PARENT = Rotation.from_quat(RNG.normal(size=4)).as_matrix()
POINTS = JOINT + RNG.uniform(-0.5, 0.5, (400, 3))

limbs = pytest.mark.parametrize("upper", [LEFT_UPPER_ARM, RIGHT_UPPER_LEG], ids=["arm", "leg"])


def judged(upper: int, axes: np.ndarray = AXES) -> tuple[np.ndarray, np.ndarray]:
    """[M, 2, 3, 3] rotations and [M, 5] verdicts."""
    Rs, verdicts = np.empty((len(axes), 2, 3, 3)), np.empty((len(axes), 5))
    limits = np.array([PARTS[part].limits_rad for part in (upper, upper + 1)])
    judge_limbs(
        axes, R_PARENT[:, 0].copy(), HINGE_BENDS[upper], R_PARENT, limits, PREDICTED, JOINT,
        LENGTHS, RADII, FLOOR, POINTS, TOLERANCE_M, Rs, verdicts,
    )  # fmt: skip
    return Rs, verdicts


def distance_to_segment(
    points: np.ndarray, start: np.ndarray, direction: np.ndarray, length: float
):
    along = np.clip((points - start) @ direction, 0.0, length)
    return np.linalg.norm(points - start - along[:, None] * direction, axis=1)


@limbs
def test_rotations_are_proper_and_point_along_the_parts(upper):
    Rs, _ = judged(upper)
    assert_array_equal(Rs[..., 1], AXES)
    assert_allclose(Rs @ np.swapaxes(Rs, -1, -2), np.broadcast_to(np.eye(3), Rs.shape), atol=1e-9)
    assert_allclose(np.linalg.det(Rs), 1.0)


@limbs
def test_a_bent_limb_is_a_hinge_that_bends_the_right_way(upper):
    Rs, _ = judged(upper)
    flexion = np.swapaxes(Rs[:, 0], -1, -2) @ Rs[:, 1]
    is_bent = np.linalg.norm(np.cross(AXES[:, 0], AXES[:, 1]), axis=1) > 0.26
    assert is_bent.sum() > 40
    assert_allclose(flexion[is_bent, 0], np.eye(3)[[0]].repeat(is_bent.sum(), 0), atol=1e-9)
    assert (np.sign(flexion[is_bent, 2, 1]) == HINGE_BENDS[upper]).all()


@limbs
def test_a_straight_limb_keeps_its_parents_side(upper):
    straight = np.repeat(R_PARENT[:, 1][None, None], 2, axis=1)
    Rs, _ = judged(upper, straight)
    assert_allclose(Rs, np.broadcast_to(R_PARENT, (1, 2, 3, 3)), atol=1e-9)


def test_explained_points_are_those_near_either_part():
    _, verdicts = judged(LEFT_UPPER_ARM)
    for (upper, lower), explained in zip(AXES, verdicts[:, 0], strict=True):
        near = distance_to_segment(POINTS, JOINT, upper, LENGTHS[0]) <= RADII[0] + TOLERANCE_M
        elbow = JOINT + LENGTHS[0] * upper
        near |= distance_to_segment(POINTS, elbow, lower, LENGTHS[1]) <= RADII[1] + TOLERANCE_M
        assert explained == near.sum()
    assert verdicts[:, 0].max() > 5


def test_turns_are_angles_to_the_prediction():
    _, verdicts = judged(LEFT_UPPER_ARM)
    assert_allclose(np.cos(verdicts[:, 1:3]), (AXES * PREDICTED).sum(-1), atol=1e-9)
    _, same = judged(LEFT_UPPER_ARM, PREDICTED[None])
    assert_allclose(same[0, 1:3], 0.0, atol=1e-6)


@limbs
def test_excess_is_that_of_the_limits(upper):
    Rs, verdicts = judged(upper)
    beyond = excess_rad(upper, R_PARENT.T @ Rs[:, 0])
    beyond += excess_rad(upper + 1, np.swapaxes(Rs[:, 0], -1, -2) @ Rs[:, 1])
    assert_allclose(verdicts[:, 3], beyond, atol=1e-9)
    assert (beyond > 0).any()


def test_depth_below_the_floor_is_that_of_the_limbs_end():
    _, verdicts = judged(LEFT_UPPER_ARM)
    ends = JOINT + LENGTHS[0] * AXES[:, 0] + LENGTHS[1] * AXES[:, 1]
    heights = ends @ FLOOR[:3] + FLOOR[3]
    assert_allclose(verdicts[:, 4], np.maximum(-heights, 0.0), atol=1e-12)
    assert 0 < (heights < 0).sum() < len(heights)


def test_each_pose_is_judged_on_its_own():
    Rs, verdicts = judged(LEFT_UPPER_ARM)
    Rs_alone, verdicts_alone = judged(LEFT_UPPER_ARM, AXES[17:18].copy())
    assert_array_equal(Rs_alone[0], Rs[17])
    assert_array_equal(verdicts_alone[0], verdicts[17])


def assigned() -> tuple[np.ndarray, np.ndarray]:
    """[N] the part that each point is nearest to, -1 for none, and how far off it is."""
    rng = np.random.default_rng(8)
    return rng.integers(-1, len(PARTS), len(POINTS), np.int32), rng.normal(0.0, 0.06, len(POINTS))


@limbs
def test_a_limb_may_explain_what_others_do_not(upper):
    labels, distances = assigned()
    reach, taken, exclusive = 0.6, 0.04, 0.08
    out_open, out_exclusive = np.empty_like(POINTS), np.empty_like(POINTS)
    n_open, n_exclusive, n_own = share_out_points(
        POINTS, labels, distances, JOINT, reach, upper, taken, exclusive, out_open, out_exclusive
    )
    is_near = ((POINTS - JOINT) ** 2).sum(1) < reach**2
    is_others = ~np.isin(labels, (upper, upper + 1, -1))
    off = np.abs(distances)
    assert_array_equal(out_open[:n_open], POINTS[is_near & ~(is_others & (off < taken))])
    assert_array_equal(
        out_exclusive[:n_exclusive], POINTS[is_near & ~(is_others & (off < exclusive))]
    )
    assert n_own == (is_near & np.isin(labels, (upper, upper + 1)) & (off < taken)).sum()


@limbs
def test_a_limb_is_scored_on_what_others_have_not_taken(upper):
    labels, distances = assigned()
    reach, taken = 0.6, 0.04
    shape = 31, 47
    rng = np.random.default_rng(0)
    pixels = rng.permutation(shape[0] * shape[1])[: len(POINTS)].astype(np.int32)
    fine, coarse = np.zeros(shape, np.uint8), np.zeros((16, 24), np.uint8)
    pick_scored(POINTS, pixels, labels, distances, JOINT, reach, upper, taken, fine, coarse)
    is_near = ((POINTS - JOINT) ** 2).sum(1) < reach**2
    is_others = ~np.isin(labels, (upper, upper + 1, -1))
    is_scored = is_near & ~(is_others & (np.abs(distances) < taken))
    assert_array_equal(np.flatnonzero(fine), np.sort(pixels[is_scored]))
    assert_array_equal(coarse, fine[::2, ::2])
