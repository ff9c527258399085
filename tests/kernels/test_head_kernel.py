"""The head template's lookup against its definition in plain NumPy."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from topview.camera import project
from topview.kernels.heads import BEHIND, EMPTY, HIDDEN, THERE, look_at_template
from topview.records import Camera

CAMERA = Camera(120.0, 110.0, 31.0, 25.0, 64, 50)
BEFORE_M, BEHIND_M, FAR_BEHIND_M, NOISE_PER_SQUARE_M = 0.1, 0.15, 0.5, 0.01


def definition(depth_m: np.ndarray, centers: np.ndarray, offsets: np.ndarray) -> np.ndarray:
    places = centers[:, None] + offsets
    pixels = project(places, CAMERA)
    seen = np.full(places.shape[:2], HIDDEN)
    for index in np.ndindex(seen.shape):
        if not np.isfinite(pixels[index]).all():
            continue
        column, row = np.floor(pixels[index] + 0.5).astype(int)
        if not (0 <= row < CAMERA.height and 0 <= column < CAMERA.width):
            continue
        noise_m = NOISE_PER_SQUARE_M * centers[index[0], 2] ** 2
        further_m = depth_m[row, column] - places[index][2]
        if depth_m[row, column] == 0.0 or further_m > FAR_BEHIND_M + noise_m:
            seen[index] = EMPTY
        elif further_m > BEHIND_M + noise_m:
            seen[index] = BEHIND
        elif further_m >= -BEFORE_M - noise_m:
            seen[index] = THERE
    return seen


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=50, deadline=None)
def test_every_place_of_the_template_is_seen_as_defined(seed: int) -> None:
    rng = np.random.default_rng(seed)
    depth_m = rng.uniform(0.5, 4.0, (CAMERA.height, CAMERA.width)).astype(np.float32)
    depth_m[rng.random(depth_m.shape) < 0.2] = 0.0
    centers = rng.uniform([-1.0, -1.0, -0.2], [1.0, 1.0, 4.0], (8, 3))
    offsets = rng.uniform(-0.3, 0.3, (12, 3))
    seen = np.empty((8, 12), np.uint8)
    look_at_template(
        depth_m, (CAMERA.fx, CAMERA.fy), (CAMERA.cx, CAMERA.cy), centers, offsets,
        BEFORE_M, BEHIND_M, FAR_BEHIND_M, NOISE_PER_SQUARE_M, seen,
    )  # fmt: skip
    np.testing.assert_array_equal(seen, definition(depth_m, centers, offsets))
