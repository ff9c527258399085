"""The whole-body comparison against its definition in plain NumPy."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from topview.geometry.quadrics import closed_cylinder_depths
from topview.geometry.rotations import rotations_from_vectors, transform
from topview_lab.kernels.swarm import BOTH, DEPTH_DIFFERENCE, EITHER, UNITS_PER_M, compare_bodies

H, W, FOCAL, CX, CY = 48, 64, 60.0, 31.0, 23.0
CLAMP_M, MATCH_M = 0.1, 0.05
LENGTHS_M = np.array([0.5, 0.3, 0.4])
RADII_M = np.array([(0.15, 0.1), (0.05, 0.05), (0.06, 0.06)])

# The kernel renders in float32: a pixel within about a micrometre of a border may fall on the other
# side, and a difference may lose a tenth of a millimetre to rounding.
BORDER_PIXELS = 2


def rays() -> np.ndarray:
    v, u = np.indices((H, W), np.float64)
    return np.stack([(u - CX) / FOCAL, (v - CY) / FOCAL, np.ones((H, W))], axis=-1)


def rendered(Rs: np.ndarray, origins: np.ndarray) -> np.ndarray:
    """[3, 3, 3] and [3, 3] to the [H, W] depth map, infinite beside the body."""
    Ts = transform(Rs, origins)
    parts = zip(Ts, LENGTHS_M, RADII_M, strict=True)
    return np.min([closed_cylinder_depths(rays(), T, y, *radii) for T, y, radii in parts], axis=0)


def definition(drawn: np.ndarray, seen: np.ndarray, mine: np.ndarray) -> tuple[float, int, int]:
    """Sum of the differences in metres, pixels in both maps, pixels in either."""
    is_drawn = np.isfinite(drawn)
    gap = np.abs(seen - np.where(is_drawn, drawn, 1e6))
    hidden = is_drawn & ~mine & (seen > 0) & (seen < drawn - MATCH_M)
    matched = is_drawn & (gap < MATCH_M)
    counted = mine | (is_drawn & ~hidden)
    difference_m = np.minimum(gap, CLAMP_M)[counted].sum()
    return difference_m, int((mine & matched).sum()), int((mine | matched).sum())


def random_scene(seed: int, poses: int = 9) -> tuple[np.ndarray, ...]:
    """Poses [3, M, ...], the first of which is seen, among noise, holes, a wall and an obstacle."""
    rng = np.random.default_rng(seed)
    Rs = rotations_from_vectors(rng.normal(0.0, 1.0, (3, poses, 3)))
    origins = rng.normal([0.0, -0.2, 2.0], 0.2, (3, poses, 3))
    Rs, origins = Rs.astype(np.float32), origins.astype(np.float32)
    drawn = rendered(Rs[:, 0], origins[:, 0])
    mine = np.isfinite(drawn)
    seen = np.where(mine, drawn + rng.normal(0.0, 0.01, (H, W)), 2.6)
    seen[:, 40:46], mine[:, 40:46] = 1.3, False
    hole = rng.random((H, W)) < 0.1
    seen[hole], mine[hole] = 0.0, False
    return Rs, origins, seen.astype(np.float32), mine


def compared(scene: tuple[np.ndarray, ...], chunks: int = 1) -> np.ndarray:
    """[M, 3] counts of the kernel."""
    Rs, origins, seen, mine = scene
    f4 = np.float32
    out = np.full((Rs.shape[1], 3), -1, np.int32)
    compare_bodies(
        Rs, origins, LENGTHS_M.astype(f4), RADII_M.astype(f4), seen, mine,
        f4(FOCAL), f4(FOCAL), f4(CX), f4(CY), f4(CLAMP_M), f4(MATCH_M), chunks, out,
    )  # fmt: skip
    return out


@pytest.mark.parametrize("seed", range(10))
def test_the_kernel_counts_what_the_definition_counts(seed):
    Rs, origins, seen, mine = random_scene(seed)
    for m, counts in enumerate(compared((Rs, origins, seen, mine))):
        drawn = rendered(Rs[:, m], origins[:, m])
        difference_m, both, either = definition(drawn, seen, mine)
        pixels = np.isfinite(drawn).sum() + mine.sum()
        assert_allclose(
            counts[DEPTH_DIFFERENCE] / UNITS_PER_M,
            difference_m,
            atol=1e-4 * pixels + BORDER_PIXELS * CLAMP_M,
        )
        assert abs(counts[BOTH] - both) <= BORDER_PIXELS
        assert abs(counts[EITHER] - either) <= BORDER_PIXELS


def test_the_pose_that_is_seen_differs_least():
    for seed in range(5):
        terms = compared(random_scene(seed))
        assert (terms[:, DEPTH_DIFFERENCE] / terms[:, EITHER]).argmin() == 0
        assert (terms[:, BOTH] / terms[:, EITHER]).argmax() == 0


@pytest.mark.parametrize("chunks", [2, 4, 30])
def test_counts_do_not_depend_on_how_the_work_is_dealt(chunks):
    scene = random_scene(3)
    assert_array_equal(compared(scene, chunks), compared(scene))


def test_a_body_out_of_sight_leaves_every_pixel_of_the_user_unexplained():
    Rs, origins, seen, mine = random_scene(4)
    aside = compared((Rs, origins + np.array([50, 0, 0], np.float32), seen, mine))
    assert_allclose(aside[:, DEPTH_DIFFERENCE] / UNITS_PER_M, CLAMP_M * mine.sum(), rtol=1e-6)
    assert_array_equal(aside[:, BOTH], 0)
    assert_array_equal(aside[:, EITHER], mine.sum())


def test_what_something_else_hides_has_no_difference():
    Rs, origins, seen, _ = random_scene(5)
    nobody = np.zeros((H, W), np.bool_)
    behind_a_wall = compared((Rs, origins, np.full_like(seen, 0.5), nobody))
    assert_array_equal(behind_a_wall, 0)
    for far in (9.0, 0.0):  # a far wall, and no reading at all
        in_free_space = compared((Rs, origins, np.full_like(seen, far), nobody))
        assert (in_free_space[:, DEPTH_DIFFERENCE] > 0).all()
        assert_array_equal(in_free_space[:, EITHER], 0)
