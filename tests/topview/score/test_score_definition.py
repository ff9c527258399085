"""What the counts mean, on images made by hand, and the top view's one law."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from score_scenes import DISTANCE_M, SHAPE, TOLERANCE_M, rays, rendered, view_of

from topview.geometry.rotations import transform
from topview.score.definition import Cylinder, count, top_view_cells

UPRIGHT = Cylinder(transform(np.eye(3), np.array([0.0, -0.25, DISTANCE_M])), 0.5, (0.15, 0.1))
SURFACE_M = rendered(UPRIGHT)
IS_COVERED = SURFACE_M > 0
NO_POINTS = np.empty((0, 3))


def counts_before(depth_m, points=NO_POINTS, placed=()):
    return count(UPRIGHT, points, view_of(depth_m), placed, 0.015, TOLERANCE_M)


@pytest.mark.parametrize(
    ("offset_m", "kind"),
    [
        pytest.param(0.0, "p_in", id="seen where it is"),
        pytest.param(0.04, "p_in", id="a little behind"),
        pytest.param(-0.04, "p_in", id="a little before"),
        pytest.param(-0.06, "p_occl", id="something in front"),
        pytest.param(-1.0, "p_occl", id="something far in front"),
        pytest.param(0.06, "p_out", id="the scene is farther"),
    ],
)
def test_every_pixel_is_inlier_occluded_or_outlier(offset_m, kind):
    counts = counts_before(np.where(IS_COVERED, SURFACE_M + offset_m, 0.0))
    expected = {"p_in": 0, "p_occl": 0, "p_out": 0, kind: IS_COVERED.sum()}
    assert counts.n_dcyl == IS_COVERED.sum() > 500
    assert {name: getattr(counts, name) for name in expected} == expected


def test_where_nothing_is_read_the_cylinder_would_be_in_free_space():
    counts = counts_before(np.zeros(SHAPE))
    assert counts.p_out == counts.n_dcyl


def test_halves_of_an_image_are_counted_each():
    depth = SURFACE_M.copy()
    depth[:, :80] = np.where(IS_COVERED[:, :80], 1.0, 0.0)
    counts = counts_before(depth)
    assert counts.p_occl == IS_COVERED[:, :80].sum()
    assert counts.p_in == IS_COVERED[:, 80:].sum()


def test_points_inside_are_counted_and_share_cells_along_the_axis():
    column = np.stack([np.zeros(20), np.linspace(-0.24, 0.24, 20), np.full(20, DISTANCE_M)], axis=1)
    beside = column + np.array([0.02, 0.0, 0.0])
    outside = column + np.array([0.2, 0.0, 0.0])
    below = np.array([[0.0, 0.26, DISTANCE_M]])
    points = np.concatenate([column, beside, outside, below])
    counts = counts_before(SURFACE_M, points)
    assert (counts.n_3d, counts.n_pr) == (40, 2)


def test_collisions_are_pixels_inside_placed_parts_each_counted_once():
    lower_half = Cylinder(transform(np.eye(3), np.array([0.0, 0.0, DISTANCE_M])), 0.5, (0.3, 0.3))
    surface_y = (rays()[..., 1] * SURFACE_M)[IS_COVERED]
    counts = counts_before(SURFACE_M, placed=(lower_half,))
    assert counts.n_coll == (surface_y > 0).sum()
    assert counts_before(SURFACE_M, placed=(lower_half, lower_half)).n_coll == counts.n_coll
    far = Cylinder(transform(np.eye(3), np.array([0.0, 0.0, 3.0])), 0.5, (0.3, 0.3))
    assert counts_before(SURFACE_M, placed=(far,)).n_coll == 0


def shell(kind: str) -> np.ndarray:
    """[N, 3] points on the side of `UPRIGHT`, as the camera spaces them."""
    if kind == "seen":
        return view_of(SURFACE_M).points(*np.nonzero(IS_COVERED))
    turns, along = np.meshgrid(np.linspace(0, 2 * np.pi, 90, False), np.linspace(0.0, 0.5, 36))
    points = np.stack([0.15 * np.cos(turns), along, 0.1 * np.sin(turns)], axis=-1)
    if kind == "half":
        points = points[np.sin(turns) < 0]
    elif kind == "partly occluded":
        is_hidden = (np.cos(turns) > 0.2) & (along > 0.2)
        points = points[(np.sin(turns) < 0) & ~is_hidden]
    return points.reshape(-1, 3) + UPRIGHT.T_camera_part[:3, 3]


@pytest.mark.parametrize("kind", ["full", "half", "partly occluded", "seen"])
@pytest.mark.parametrize("noise_m", [0.0, 0.004])
def test_a_shell_covers_the_fewest_cells_when_seen_along_its_axis(kind, noise_m):
    """Fig. 3.2: over directions of view, f_reproj has its least value at the true axis."""
    points = shell(kind)
    points = points + noise_m * np.random.default_rng(7).normal(size=points.shape)
    centre = points.mean(0)

    def reproj(pitch: float, roll: float) -> float:
        R = Rotation.from_euler("xz", [pitch, roll], degrees=True).as_matrix()
        direction = Cylinder(transform(R, centre), 1.0, (1.0, 1.0))
        return len(top_view_cells(direction, points, 0.014)) / len(points)

    tilts = [(p, r) for p in range(-80, 81, 20) for r in range(-80, 81, 20) if (p, r) != (0, 0)]
    least_tilted = min(reproj(*tilt) for tilt in tilts)
    assert reproj(0, 0) < 0.8 * least_tilted
