"""The kernels that find heads against their definitions in plain NumPy."""

from __future__ import annotations

from typing import Any

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from topview.camera import project
from topview.kernels.heads import (
    BEHIND,
    EMPTY,
    HIDDEN,
    OUTSIDE,
    THERE,
    below_others,
    covered_share,
    fit_template,
    look_at,
    lowest,
    median_about,
    places_of_heads,
    relief_about,
    strongest,
    unread_shares,
)
from topview.records import Camera

CAMERA = Camera(120.0, 110.0, 31.0, 25.0, 64, 50)
BEFORE_M, BEHIND_M, FAR_BEHIND_M = 0.1, 0.15, 0.5
NOISE = (0.003, 0.005, 0.01)


def noise_at(z: Any) -> Any:
    return NOISE[0] + NOISE[1] * z + NOISE[2] * z**2


def definition(depth_m: np.ndarray, centers: np.ndarray, offsets: np.ndarray) -> np.ndarray:
    places = centers[:, None] + offsets
    pixels = project(places, CAMERA)
    seen = np.full(places.shape[:2], OUTSIDE)
    for index in np.ndindex(seen.shape):
        if not np.isfinite(pixels[index]).all():
            continue
        column, row = np.floor(pixels[index] + 0.5).astype(int)
        if not (0 <= row < CAMERA.height and 0 <= column < CAMERA.width):
            continue
        noise_m = noise_at(centers[index[0], 2])
        further_m = depth_m[row, column] - places[index][2]
        seen[index] = HIDDEN
        if depth_m[row, column] == 0.0 or further_m > FAR_BEHIND_M + noise_m:
            seen[index] = EMPTY
        elif further_m > BEHIND_M + noise_m:
            seen[index] = BEHIND
        elif further_m >= -BEFORE_M - noise_m:
            seen[index] = THERE
    return seen


def a_scene(rng: np.random.Generator) -> np.ndarray:
    depth_m = rng.uniform(0.5, 4.0, (CAMERA.height, CAMERA.width)).astype(np.float32)
    depth_m[rng.random(depth_m.shape) < 0.2] = 0.0
    return depth_m


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=50)
def test_every_place_of_the_template_is_seen_as_defined(seed: int) -> None:
    rng = np.random.default_rng(seed)
    depth_m = a_scene(rng)
    centers = rng.uniform([-1.0, -1.0, -0.2], [1.0, 1.0, 4.0], (8, 3))
    offsets = rng.uniform(-0.3, 0.3, (12, 3))

    places = (centers[:, None] + offsets).reshape(-1, 3).T.copy()
    seen = look_at(
        depth_m, (CAMERA.fx, CAMERA.fy), (CAMERA.cx, CAMERA.cy), places,
        (BEFORE_M, BEHIND_M, FAR_BEHIND_M), np.repeat(noise_at(centers[:, 2]), 12),
    )  # fmt: skip
    np.testing.assert_array_equal(seen.reshape(8, 12), definition(depth_m, centers, offsets))


@given(st.integers(0, 2**32 - 1), st.sampled_from([0.0, 0.2, 0.4]))
@settings(max_examples=30)
def test_the_evidence_is_shares_of_the_places_that_are_seen(seed: int, least: float) -> None:
    rng = np.random.default_rng(seed)
    depth_m = a_scene(rng)
    centers = rng.uniform([-1.0, -1.0, 0.5], [1.0, 1.0, 3.0], (10, 3))
    angle = rng.uniform(-1.0, 1.0)
    up = np.array([np.sin(angle), -np.cos(angle) * 0.8, -np.cos(angle) * 0.6])
    parts = tuple(rng.uniform(-0.3, 0.3, (places, 2)) for places in (5, 7, 9))
    evidence = np.empty((4, 10))
    fit_template(
        depth_m, (CAMERA.fx, CAMERA.fy), (CAMERA.cx, CAMERA.cy), centers, up,
        parts[0], parts[1], parts[2],
        (BEFORE_M, BEHIND_M, FAR_BEHIND_M), NOISE, least, evidence,
    )  # fmt: skip
    right = np.array([-up[1], up[0], 0.0]) / np.hypot(up[0], up[1])
    for n, center in enumerate(centers):
        inside, free, shoulders = (
            definition(depth_m, center[None], places @ np.stack([right, up]))[0] for places in parts
        )
        are_visible = ~np.isin(shoulders, (HIDDEN, OUTSIDE))
        expected = np.array(
            [
                (inside == THERE).sum() / max((inside != OUTSIDE).sum(), 2.5),
                np.isin(free, (BEHIND, EMPTY)).sum()
                / max((~np.isin(free, (HIDDEN, OUTSIDE))).sum(), 3.5),
                np.isin(shoulders, (THERE, BEHIND)).sum() / max(are_visible.sum(), 1),
                are_visible.mean(),
            ]
        )
        if expected[0] * expected[1] < least:
            expected[:] = 0.0
        np.testing.assert_allclose(evidence[:, n], expected)


@given(st.integers(0, 2**32 - 1), st.integers(1, 40))
@settings(max_examples=30)
def test_the_lowest_costs_come_first_and_the_first_of_equals(seed: int, count: int) -> None:
    costs = np.random.default_rng(seed).integers(0, 12, (6, 7)).astype(np.float64)
    expected = np.argsort(costs, axis=None, kind="stable")[:count]
    np.testing.assert_array_equal(lowest(costs, count), expected)


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=30)
def test_the_strongest_lie_apart_and_leave_nobody_out(seed: int) -> None:
    rng = np.random.default_rng(seed)
    centers, confidence = rng.uniform(0.0, 1.5, (30, 3)), rng.uniform(0.5, 1.0, 30)
    # Nothing else is like a candidate: the centres are candidates'.
    found, best = strongest(centers, confidence, 0.4, 1e-9, 0.9)
    assert best[0] == confidence.max()
    assert (np.diff(best) <= 0.0).all()
    apart = np.linalg.norm(found[:, None] - found, axis=2)
    assert (apart[~np.eye(len(found), dtype=bool)] > 0.4).all()
    assert (np.linalg.norm(centers[:, None] - found, axis=2).min(1) <= 0.4).all()


def test_the_strongest_is_the_mean_of_its_like() -> None:
    centers = np.array([[0.0, 0.0, 2.0], [0.05, 0.0, 2.0], [0.0, 0.06, 2.0], [0.0, 0.0, 2.2]])
    found, best = strongest(centers, np.array([0.8, 0.9, 0.7, 0.9]), 0.4, 0.1, 0.85)
    np.testing.assert_allclose(found, [[0.025, 0.0, 2.0]])
    np.testing.assert_array_equal(best, [0.9])


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=30)
def test_below_others_is_what_has_another_right_above_and_behind(seed: int) -> None:
    centers = np.random.default_rng(seed).uniform(0.0, 0.8, (12, 3))
    up = np.array([0.0, -0.8, -0.6])
    offset = centers - centers[:, None]
    above_m = offset @ up
    aside_m = np.linalg.norm(offset - above_m[..., None] * up, axis=-1)
    is_other = (above_m > 0.15) & (above_m < 0.45) & (aside_m < 0.3) & (offset[..., 2] > 0.04)
    below = below_others(centers, up, (0.15, 0.45), 0.3, 0.04)
    np.testing.assert_array_equal(below, is_other.any(1))


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=30)
def test_the_median_is_that_of_the_points_in_the_ball_and_the_cylinder(seed: int) -> None:
    rng = np.random.default_rng(seed)
    points = rng.uniform([-0.3, -0.3, 1.7], [0.3, 0.3, 2.3], (9, 11, 3)).astype(np.float32)
    points[rng.random((9, 11)) < 0.2] = 0.0
    center, up = np.array([0.0, 0.0, 2.0]), np.array([0.0, -0.8, -0.6])
    median = np.full(3, np.nan)
    # The ball is seen in rows 1 to 7 and columns 2 to 10.
    count = median_about(points, (20.0, 12.0), (6.0, 4.2), center, up, 0.25, 0.15, 0.2, median)
    seen = points[1:8, 2:11].reshape(-1, 3).astype(np.float64)
    off = seen - center
    up_m = off @ up
    is_near = (np.linalg.norm(off, axis=1) < 0.25) & (np.abs(up_m) < 0.15) & (seen[:, 2] > 0.0)
    is_near &= np.linalg.norm(off - up_m[:, None] * up, axis=1) < 0.2
    assert count == is_near.sum()
    if count:
        np.testing.assert_array_equal(median, np.median(seen[is_near], axis=0))


def test_relief_is_cut_off_and_goes_on_beyond_the_border() -> None:
    depth_m = np.array([[2.0, 2.1], [0.0, 3.0]], np.float32)
    relief = np.empty((3, 3), np.float32)
    relief_about(depth_m, 0, 0, 1.95, 0.25, relief)
    expected = [[0.05, 0.05, 0.15], [0.05, 0.05, 0.15], [0.25, 0.25, 0.25]]
    np.testing.assert_allclose(relief, expected, atol=1e-6)


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=30)
def test_shares_of_places_that_are_unread_and_covered(seed: int) -> None:
    rng = np.random.default_rng(seed)
    depth_m = a_scene(rng)
    centers = rng.uniform([-1.0, -1.0, 0.5], [1.0, 1.0, 3.0], (6, 3))
    angles = rng.uniform(-1.0, 1.0, 6)
    ups = np.stack([np.sin(angles), -np.cos(angles) * 0.8, -np.cos(angles) * 0.6], axis=1)
    rights = np.stack([-ups[:, 1], ups[:, 0], np.zeros(6)], axis=1)
    rights /= np.hypot(ups[:, 0], ups[:, 1])[:, None]
    offsets_m = rng.uniform(-0.3, 0.3, (9, 2))
    places = centers[:, None] + offsets_m[:, :1] * rights[:, None] + offsets_m[:, 1:] * ups[:, None]
    columns, rows = np.rint(project(places, CAMERA)).astype(int).transpose(2, 0, 1)
    is_in_view = (rows >= 0) & (rows < CAMERA.height) & (columns >= 0) & (columns < CAMERA.width)
    seen_m = depth_m[np.clip(rows, 0, CAMERA.height - 1), np.clip(columns, 0, CAMERA.width - 1)]
    focal, principal = (CAMERA.fx, CAMERA.fy), (CAMERA.cx, CAMERA.cy)
    unread = unread_shares(depth_m, focal, principal, centers, ups, offsets_m)
    np.testing.assert_allclose(unread, (is_in_view & (seen_m == 0.0)).mean(1))
    is_nearer = (seen_m > 0.0) & (seen_m < places[..., 2] - 0.2)
    for n in range(6):
        center, up = tuple(centers[n].tolist()), tuple(ups[n].tolist())
        covered = covered_share(depth_m, focal, principal, center, up, offsets_m, 0.2)
        assert covered == (is_nearer | ~is_in_view)[n].mean()


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=30)
def test_heads_are_below_tops_with_free_space_above_them(seed: int) -> None:
    rng = np.random.default_rng(seed)
    depth_m = rng.choice([0.0, 1.0, 1.05, 1.5], (CAMERA.height, CAMERA.width)).astype(np.float32)
    rows, columns = np.indices(depth_m.shape)
    x, y = (columns - CAMERA.cx) / CAMERA.fx * depth_m, (rows - CAMERA.cy) / CAMERA.fy * depth_m
    points = np.stack([x, y, depth_m], axis=-1).astype(np.float32)
    ups = np.array([[0.0, -0.8, -0.6], [0.6, -0.8, 0.0]])
    found, directions = places_of_heads(
        depth_m, points, (CAMERA.fx, CAMERA.fy), (CAMERA.cx, CAMERA.cy), ups,
        1.4, 0.12, 0.11, 0.2,
    )  # fmt: skip
    above_m = np.vstack([np.full((1, CAMERA.width), 1e-3, np.float32), depth_m[:-1]])
    is_top = (depth_m > 0.0) & (depth_m < 1.4)
    is_top &= (above_m == 0.0) | (above_m > depth_m + np.float32(0.12))
    expected = []
    for direction, up in enumerate(ups):
        for place in points[is_top] - 0.11 * up:
            column, row = np.rint(project(place, CAMERA)).astype(int)
            is_in_view = 0 <= row < CAMERA.height and 0 <= column < CAMERA.width
            if is_in_view and abs(depth_m[row, column] - place[2]) < 0.2:
                expected.append([direction, *place])
    assert len(expected) > 20
    np.testing.assert_allclose(np.column_stack([directions, found]), expected)
