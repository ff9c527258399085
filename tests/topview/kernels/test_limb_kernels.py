"""Which poses of a limb are tried: the kernels and their definitions."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from rendered_bodies import MODEL, evidence_of, standing_pose
from topview.kernels.body import assign_points
from topview.kernels.limb_scan import ending_near, left_open_without
from topview.track.pose import LIMBS

REACH_M, SCALE_M = 0.15, 0.05
NOWHERE_M = 1e6  # where a part is near nothing
limbs = pytest.mark.parametrize("upper", LIMBS)


@limbs
def test_a_point_is_left_open_as_far_as_no_part_but_the_limb_explains_it(upper):
    pose = standing_pose()
    evidence = evidence_of(pose).with_normals()
    points, normals, origins = evidence.points_camera, evidence.normals_camera, pose.origins(MODEL)
    body = MODEL.lengths_m, MODEL.shapes_m
    found = np.empty((len(LIMBS), len(points)))
    left_open_without(
        points, normals, pose.Rs, origins, *body, MODEL.surface.owners, np.array(LIMBS), REACH_M,
        SCALE_M, found,
    )  # fmt: skip

    others = origins.copy()
    others[upper : upper + 2] = NOWHERE_M
    N = len(points)
    labels, unlike_m = np.full(N, -1, np.int32), np.empty(N)
    assign_points(
        points, normals, pose.Rs, others, *body, REACH_M, labels, np.empty(N), np.empty((N, 3)),
        unlike_m,
    )  # fmt: skip
    is_open = np.where(labels < 0, 1.0, 1.0 - 1.0 / (1.0 + (unlike_m / SCALE_M) ** 2))
    away_m = np.linalg.norm(points - origins[upper], axis=1)
    is_reached = away_m < MODEL.lengths_m[upper : upper + 2].sum() + 2.0 * REACH_M
    own = found[LIMBS.index(upper)]
    assert_allclose(own, np.where(is_reached, is_open, 0.0), atol=1e-12)
    assert (own == 1.0).any()
    assert ((own > 0.0) & (own < 0.1)).any()
    assert (found == 0.0).any()


@limbs
@pytest.mark.parametrize("each", [1, 4])
def test_poses_that_end_nearest_to_places_are_marked(upper, each):
    rng = np.random.default_rng(upper)
    ends, places = rng.standard_normal((50, 6)), rng.standard_normal((5, 3))
    is_near = np.empty(len(ends), np.bool_)
    ending_near(ends, MODEL.lengths_m, upper, places, each, is_near)
    upper_m, lower_m = MODEL.lengths_m[upper : upper + 2]
    hands = upper_m * ends[:, :3] + lower_m * (ends[:, 3:] - ends[:, :3])
    away_m = np.linalg.norm(hands - places[:, None], axis=-1)
    nearest = np.unique(np.argsort(away_m, axis=1)[:, :each])
    assert_array_equal(np.flatnonzero(is_near), nearest)


def test_no_pose_ends_near_no_place():
    ends, is_near = np.ones((3, 6)), np.ones(3, np.bool_)
    ending_near(ends, MODEL.lengths_m, LIMBS[0], np.empty((0, 3)), 2, is_near)
    assert not is_near.any()
