"""Which way a surface faces, of planes and balls whose normals are known."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from topview.kernels.normals import SIDE_PIXELS, surface_normals

W, H, F = 40, 30, 60.0
INTRINSICS = F, F, 19.5, 14.5
RAYS = np.stack(
    [
        (np.arange(W)[None, :] - INTRINSICS[2]) / F * np.ones((H, 1)),
        (np.arange(H)[:, None] - INTRINSICS[3]) / F * np.ones((1, W)),
        np.ones((H, W)),
    ],
    axis=-1,
)


def normals_of(depth_m: np.ndarray, mine: np.ndarray, pixels: np.ndarray) -> np.ndarray:
    normals = np.full((len(pixels), 3), np.nan)
    points = (RAYS * depth_m[..., None]).reshape(-1, 3)[pixels]
    surface_normals(points, depth_m.astype(np.float32), mine, *INTRINSICS, normals)
    return normals


@given(st.integers(0, 2**32 - 1))
def test_a_plane_faces_where_it_faces_from_all_of_its_pixels(seed):
    rng = np.random.default_rng(seed)
    normal = np.append(rng.uniform(-0.1, 0.1, 2), -1.0)
    normal /= np.linalg.norm(normal)
    depth_m = normal @ (0.0, 0.0, 2.5) / (RAYS @ normal)
    normals = normals_of(depth_m, np.ones((H, W), np.bool_), np.arange(W * H))
    inner = np.zeros((H, W), dtype=np.bool_)
    inner[SIDE_PIXELS:-SIDE_PIXELS, SIDE_PIXELS:-SIDE_PIXELS] = True
    assert_allclose(normals[inner.ravel()], np.tile(normal, (inner.sum(), 1)), atol=1e-3)
    is_known = np.linalg.norm(normals, axis=1) > 0.0
    assert_allclose(normals[is_known], np.tile(normal, (is_known.sum(), 1)), atol=1e-3)
    assert not is_known[0]  # in the corner a quarter of a window is seen


def test_a_ball_faces_away_from_its_middle_towards_the_camera():
    middle, radius_m = np.array([0.02, -0.03, 2.0]), 0.3
    b = RAYS @ middle
    square = b**2 - (RAYS**2).sum(-1) * (middle @ middle - radius_m**2)
    mine = square > 0.0
    depth_m = np.where(mine, (b - np.sqrt(np.maximum(square, 0.0))) / (RAYS**2).sum(-1), 0.0)
    pixels = np.flatnonzero(mine)
    normals = normals_of(depth_m, mine, pixels)
    places = (RAYS * depth_m[..., None]).reshape(-1, 3)[pixels]
    cosines = (normals * (places - middle)).sum(1) / radius_m
    is_known = np.linalg.norm(normals, axis=1) > 0.0
    assert is_known.mean() > 0.5
    assert cosines[is_known].min() > np.cos(np.radians(10.0))


def test_too_few_pixels_tell_nothing():
    depth_m = np.full((H, W), 2.0)
    depth_m[:, 20:] = 3.0  # a step is no surface
    mine = np.zeros((H, W), np.bool_)
    mine[10:13, 18:22] = True
    assert_array_equal(normals_of(depth_m, mine, np.flatnonzero(mine)), np.zeros((12, 3)))
