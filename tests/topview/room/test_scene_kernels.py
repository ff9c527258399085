"""What a cloud shows, with up and down: each kernel against its definition in NumPy."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from topview.kernels.bodies import lowest_of, measure_body, share_within
from topview.kernels.scene import (
    find_cores,
    learn_background,
    moved_share,
    plane_moments,
    set_up,
    shows_background,
    to_points,
)

SHAPE = (20, 25)
EVERY_PX = np.arange(SHAPE[0] * SHAPE[1])
AXES = np.array([[1.0, 0.0, 0.0], [0.0, -0.6, 0.8], [0.0, -0.8, -0.6]], np.float32)
CAMERA_HEIGHT_M = 1.3
JUMP = (0.05, 0.001, 0.004)

# A Kinect's noise, which grows with the square of the depth, and one with all three terms.
LAWS = [(0.0, 0.0, 0.0015), (0.001, 0.002, 0.0005)]


def law(z: NDArray[np.floating], terms: tuple[float, float, float]) -> NDArray[np.floating]:
    return terms[0] + terms[1] * z + terms[2] * z**2


@pytest.fixture(params=range(3))
def generator(request: pytest.FixtureRequest) -> np.random.Generator:
    return np.random.default_rng(request.param)


FOCAL_PX, PRINCIPAL_PX = (20.0, 21.0), (5.5, 4.5)


def cloud(generator: np.random.Generator) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """[h, w] depths and their [h, w, 3] points."""
    depth = generator.uniform(2.0, 2.1, SHAPE).astype(np.float32)
    depth[generator.random(SHAPE) < 0.1] = 0.0
    points = np.empty((*SHAPE, 3), np.float32)
    to_points(depth, FOCAL_PX, PRINCIPAL_PX, points)
    return depth, points


@pytest.mark.parametrize("noise", LAWS)
@pytest.mark.parametrize("margin_m", [0.035, -np.inf])
def test_a_scene_is_set_up_as_defined(
    generator: np.random.Generator, margin_m: float, noise: tuple[float, float, float]
) -> None:
    depth, points = cloud(generator)
    background = generator.random(SHAPE) < 0.2
    heights, plan = np.empty(SHAPE, np.float32), np.empty((2, *SHAPE), np.float32)
    free, inner = np.empty(SHAPE, np.bool_), np.empty(SHAPE, np.uint8)
    set_up(
        depth, FOCAL_PX, PRINCIPAL_PX, background, AXES, CAMERA_HEIGHT_M, margin_m, noise, JUMP,
        heights, plan, free, inner,
    )  # fmt: skip
    along = points @ AXES.T
    np.testing.assert_allclose(np.moveaxis(plan, 0, -1), along[..., :2], atol=1e-5)
    np.testing.assert_allclose(heights, along[..., 2] + CAMERA_HEIGHT_M, atol=1e-5)
    z = points[..., 2]
    descent = np.abs(heights - CAMERA_HEIGHT_M) / np.maximum(z, 0.1)
    is_floor = heights <= margin_m + law(z, noise) * descent
    np.testing.assert_array_equal(free, (z > 0.0) & ~background & ~is_floor)
    assert (margin_m > 0.0) == bool((is_floor & (z > 0.0)).any())
    jump = law(z, JUMP)
    is_edge = np.zeros(SHAPE, np.bool_)
    is_edge[:, 1:] |= np.abs(np.diff(z, axis=1)) > jump[:, 1:]
    is_edge[1:] |= np.abs(np.diff(z, axis=0)) > jump[1:]
    np.testing.assert_array_equal(inner, free & ~is_edge)
    assert 20 < inner.sum() < free.sum()


@pytest.mark.parametrize("side", [0, 3, 9])
def test_cores_are_far_from_what_surrounds_them(side: int) -> None:
    inner = np.zeros(SHAPE, np.uint8)
    inner[4 : 4 + side, 5 : 5 + side] = 1
    allowed = inner > 0
    allowed[0] = True
    depth = np.full(SHAPE, 2.0, np.float32)
    inset_px = np.asarray(cv2.distanceTransform(inner, cv2.DIST_L2, 3), np.float32)
    inset, start = np.empty(SHAPE, np.float32), np.empty(SHAPE, np.float32)
    core_m2 = find_cores(inset_px, depth, allowed, 20.0, 0.25, inset, start)
    # A pixel is 0.1 m wide: three and more pixels from the outside.
    expected = np.where(allowed, np.inf, -np.inf)
    if side > 4:
        expected[6 : 2 + side, 7 : 3 + side] = 0.0
    np.testing.assert_array_equal(start, expected)
    assert core_m2 == pytest.approx(0.01 * (expected == 0.0).sum())
    np.testing.assert_allclose(inset, inset_px * 0.1, rtol=1e-6)


def test_an_image_without_edges_has_a_finite_inset() -> None:
    inset, start = np.empty(SHAPE, np.float32), np.empty(SHAPE, np.float32)
    far_px, depth = np.full(SHAPE, 3e38, np.float32), np.full(SHAPE, 2.0, np.float32)
    find_cores(far_px, depth, np.ones(SHAPE, np.bool_), 20.0, 0.25, inset, start)
    np.testing.assert_allclose(inset, max(SHAPE) * 0.1)


@pytest.mark.parametrize("noise", LAWS)
def test_moments_are_those_of_the_points_near_the_plane(
    generator: np.random.Generator, noise: tuple[float, float, float]
) -> None:
    readings = generator.uniform([-1.0, 0.9, 1.0], [1.0, 1.1, 4.0], (300, 3)).astype(np.float32)
    readings[::10] = 0.0
    points = readings.astype(np.float64)
    normal, distance_m = np.array([0.0, -1.0, 0.0]), 1.0
    mean, covariance = np.empty(3), np.empty((3, 3))
    count = plane_moments(
        readings[None], 1, normal, distance_m, (0.04 + noise[0], *noise[1:]), mean, covariance
    )
    off = np.abs(points @ normal + distance_m)
    near = points[(points[:, 2] > 0.0) & (off < 0.04 + law(points[:, 2], noise))]
    weights = near[:, 2] ** -2
    assert count == len(near) > 50
    np.testing.assert_allclose(mean, np.average(near, axis=0, weights=weights))
    expected = np.cov(near.T, aweights=weights, bias=True)
    np.testing.assert_allclose(covariance, expected, atol=1e-12)


def test_no_points_have_no_moments() -> None:
    moments = np.empty(3), np.empty((3, 3))
    nothing, up = np.zeros((5, 3), np.float32), np.array([0.0, -1.0, 0.0])
    assert plane_moments(nothing[None], 1, up, 0.0, (0.1, 0.0, 0.0), *moments) == 0


def test_points_are_where_the_pixels_look(generator: np.random.Generator) -> None:
    depth = np.where(generator.random(SHAPE) < 0.1, 0.0, generator.uniform(1.0, 4.0, SHAPE))
    points = np.empty((*SHAPE, 3), np.float32)
    to_points(depth.astype(np.float32), (20.0, 21.0), (5.5, 4.5), points)
    rows, columns = np.indices(SHAPE)
    expected = depth * np.array([(columns - 5.5) / 20.0, (rows - 4.5) / 21.0, np.ones(SHAPE)])
    np.testing.assert_allclose(points, expected.transpose(1, 2, 0), atol=1e-5)


def test_a_depth_is_learnt_while_it_is_steady_and_anew_when_further_away() -> None:
    mean = np.array([[2.0, 2.0, 2.0, 2.0, 2.0]], np.float32)
    steady_s, age_s = np.full((2, 1, 5), 0.5, np.float32)
    # Steady, nearer, further away, nothing, somebody.
    depth = np.array([[1.98, 1.5, 2.5, 0.0, 2.0]], np.float32)
    somebody = np.array([[False, False, False, False, True]])
    tolerance = 0.03, 0.01, 0.004
    learn_background(depth, somebody, 0.1, 0.25, tolerance, mean, steady_s, age_s)
    np.testing.assert_allclose(mean, [[1.998, 2.0, 2.5, 2.0, 2.0]])
    np.testing.assert_array_equal(steady_s, [[0.75, 0.5, 0.0, 0.5, 0.5]])
    np.testing.assert_array_equal(age_s, [[0.75, 0.75, 0.0, 0.75, 0.75]])
    seen = np.empty((1, 5), np.bool_)
    shows_background(depth, mean, steady_s, 0.5, tolerance, seen)
    np.testing.assert_array_equal(seen, [[True, False, False, False, True]])


def test_what_comes_before_the_room_has_moved_and_what_comes_to_light_has_not() -> None:
    """In columns: what stays, what comes, what something has left, what nothing was read of."""
    before, now = np.full((2, 3, 4), 3.0, np.float32)
    now[:, 1], before[:, 2], before[:, 3] = 2.0, 2.0, 0.0
    tolerance, focal_px = (0.05, 0.0, 0.0), 10.0

    def moved(columns: slice, least_m2: float = 1e-3) -> float:
        is_own = np.zeros((3, 4), np.bool_)
        is_own[:, columns] = True
        return moved_share(is_own, now, before, tolerance, focal_px, least_m2)

    assert [moved(slice(k, k + 1)) for k in range(4)] == [0.0, 1.0, 0.0, 0.0]
    came_m2, stayed_m2 = 3 * 0.2**2, 3 * 0.3**2
    assert moved(slice(0, 4)) == pytest.approx(came_m2 / (came_m2 + stayed_m2))
    # What is smaller than anybody tells the less.
    assert moved(slice(1, 2), 4.0 * came_m2) == pytest.approx(0.25)
    assert moved(slice(4, 4)) == 0.0
    before[:, 0] += 0.049
    assert moved(slice(0, 1)) == 0.0


def test_the_share_within_a_circle_is_counted(generator: np.random.Generator) -> None:
    plan = generator.uniform(-1.0, 1.0, (2, *SHAPE)).astype(np.float32)
    body = generator.random(SHAPE) < 0.5
    aside = np.hypot(plan[0, body] - 0.1, plan[1, body] + 0.2)
    share = share_within(plan, body, 0.1, -0.2, 0.6)
    assert share == pytest.approx((aside < 0.6).mean())
    assert np.isnan(share_within(plan, np.zeros(SHAPE, np.bool_), 0.1, -0.2, 0.6))


def test_the_lowest_pixels_are_cut_off_by_the_border_and_by_what_is_nearer() -> None:
    body, heights = np.zeros((6, 4), np.bool_), np.zeros((6, 4), np.float32)
    depth = np.full((6, 4), 2.0, np.float32)
    assert np.isnan(lowest_of(body, depth, heights, 0.1))
    body[1:4, 1:3], heights[3, 1:3], heights[2] = True, (0.5, 0.25), 0.1
    assert lowest_of(body, depth, heights, 0.1) == 0.25
    depth[5, 2] = 0.0
    depth[5, 1] = 1.95
    assert lowest_of(body, depth, heights, 0.1) == 0.25
    assert np.isnan(lowest_of(body, depth, heights, 0.04))
    body[4] = True
    assert np.isnan(lowest_of(body, depth, heights, 0.1))


def test_a_body_is_measured_as_defined(generator: np.random.Generator) -> None:
    depth = generator.choice([2.0, 2.06, 2.5], SHAPE).astype(np.float32)
    heights, inset = generator.uniform(0.0, 2.0, (2, *SHAPE)).astype(np.float32)
    plan = generator.uniform(-1.0, 1.0, (2, *SHAPE)).astype(np.float32)
    whole = generator.choice([0.1, 0.4, 0.8, np.inf], SHAPE).astype(np.float32)
    nearest = np.where(generator.random(SHAPE) < 0.2, np.float32(0.05), whole)
    distance = np.where(nearest < whole, np.float32(np.inf), whole)
    measures = measure_body(
        EVERY_PX, whole, nearest, depth, heights, plan, inset, 20.0, (0.1, -0.2, 1.6), 0.1, 0.6,
        (0.3, 0.5), (0.5, 0.9), (0.1, 0.3), 8, JUMP,
    )  # fmt: skip
    area_m2, over_m2, bust_m2, lowest_m, roughness, radius_m, near, chest_m, head_m, kept = (
        measures[:-1]
    )
    body, bust, below = distance < np.inf, distance < 0.3, 1.6 - heights
    pixel_m2 = np.where(body, (depth / 20.0) ** 2, 0.0)
    jump = law(depth, JUMP)
    edge = np.zeros(SHAPE, np.bool_)
    edge[:, 1:] |= np.abs(np.diff(depth, axis=1)) > jump[:, 1:]
    edge[1:] |= np.abs(np.diff(depth, axis=0)) > jump[1:]
    aside = np.hypot(plan[0] - 0.1, plan[1] + 0.2)
    assert area_m2 == pytest.approx(pixel_m2.sum(), rel=1e-5)
    assert over_m2 == pytest.approx(pixel_m2[below < -0.1].sum(), rel=1e-5)
    assert bust_m2 == pytest.approx(pixel_m2[bust].sum(), rel=1e-5)
    assert lowest_m == heights[body].min()
    assert roughness == pytest.approx((edge & bust).sum() / np.sqrt(bust.sum()))
    assert radius_m == inset[distance < 0.5].max()
    assert near == pytest.approx((aside[body] < 0.6).mean())
    assert chest_m == pytest.approx(pixel_m2[(below > 0.5) & (below < 0.9)].sum() / 0.4, rel=1e-5)
    assert head_m == pytest.approx(pixel_m2[(below > 0.1) & (below < 0.3)].sum() / 0.2, rel=1e-5)
    assert kept == pytest.approx(body.sum() / (whole < np.inf).sum())


def relief_m(depth: NDArray[np.float32], body: NDArray[np.bool_]) -> float:
    """Standard deviation of means of 3 x 3 pixels from the plane that fits best."""
    bordered = cv2.copyMakeBorder(body.view(np.uint8), 1, 1, 1, 1, cv2.BORDER_CONSTANT, value=0)
    inner = cv2.erode(bordered, np.ones((3, 3), np.uint8))[1:-1, 1:-1] > 0
    v, u = np.nonzero(inner)
    seen = depth[inner].astype(np.float64)
    design = np.stack([u, v, np.ones(len(u))], axis=1)
    plane, *_ = np.linalg.lstsq(design, 1.0 / seen)
    off_m = np.zeros(SHAPE)
    off_m[inner] = (1.0 / seen - design @ plane) * seen**2
    near = cv2.blur(inner.astype(np.float64), (3, 3))
    return float((cv2.blur(off_m, (3, 3))[inner] / near[inner]).std())


BODIES = {
    "with a hole": (np.s_[3:17, 4:20], np.s_[8:10, 11:13]),
    "whose inner pixels are in a row": (np.s_[5:8, 4:20], np.s_[0:0]),
    "whose inner pixels are in a column": (np.s_[3:17, 6:9], np.s_[0:0]),
}


def measured_relief_m(distance: NDArray[np.float32], depth: NDArray[np.float32]) -> float:
    nothing = np.zeros_like(depth)
    return measure_body(
        np.arange(depth.size), distance, distance, depth, nothing,
        np.zeros((2, *depth.shape), np.float32), nothing, 20.0, (0.0, 0.0, 1.6), 0.1, 0.6,
        (0.3, 0.5), (0.5, 0.9), (0.1, 0.3), 8, JUMP,
    )[-1]  # fmt: skip


@pytest.mark.parametrize("body", BODIES)
def test_relief_is_what_is_off_the_best_plane(generator: np.random.Generator, body: str) -> None:
    depth = generator.uniform(2.0, 2.2, SHAPE).astype(np.float32)
    distance = np.full(SHAPE, np.inf, np.float32)
    block, hole = BODIES[body]
    distance[block] = generator.choice([0.1, 0.4], distance[block].shape)
    distance[hole] = 0.8
    expected = relief_m(depth, distance < 0.5)
    assert measured_relief_m(distance, depth) == pytest.approx(expected, rel=1e-6)


def test_what_has_few_pixels_or_is_flat_has_no_relief() -> None:
    distance, depth = np.full(SHAPE, 0.1, np.float32), np.empty(SHAPE, np.float32)
    depth[:] = 1.0 / (0.4 + 0.001 * np.arange(SHAPE[1]))
    assert measured_relief_m(distance, depth) == pytest.approx(0.0, abs=1e-6)
    depth[5, 5] = 2.0
    few = distance[3:7, 3:7].copy(), depth[3:7, 3:7].copy()
    assert measured_relief_m(*few) == 0.0
