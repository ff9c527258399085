"""Each kernel against its definition in NumPy."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from topview.kernels.pieces import join_pieces, small_pieces
from topview.kernels.scene import gather_standing
from topview.kernels.segmentation import (
    full_pixels_of,
    geodesic_distance,
    grow_body,
    share_bodies,
)

JUMP = (0.045, 0.002, 0.004)


def jump_at(z: Any) -> Any:
    return JUMP[0] + JUMP[1] * z + JUMP[2] * z**2


@pytest.fixture(params=range(5))
def generator(request: pytest.FixtureRequest) -> np.random.Generator:
    return np.random.default_rng(request.param)


def bumpy_depth(generator: np.random.Generator, shape: tuple[int, int]) -> NDArray[np.float32]:
    coarse = generator.uniform(1.5, 2.2, (4, 5))
    rows = np.linspace(0, 3.999, shape[0]).astype(int)
    columns = np.linspace(0, 4.999, shape[1]).astype(int)
    depth = coarse[rows[:, None], columns] + generator.normal(0, 0.02, shape)
    return depth.astype(np.float32)


def geodesic_by_relaxation(
    depth: NDArray[np.float32],
    allowed: NDArray[np.bool_],
    focal: float,
    limit: float,
    start: NDArray[np.float32],
) -> NDArray[np.float64]:
    """Bellman and Ford: let every pixel hear from its 8 neighbours until nothing changes."""
    height, width = depth.shape
    distance = np.where(allowed & (start <= limit), start, np.inf).astype(np.float64)
    padded_z = np.pad(depth.astype(np.float64), 1, constant_values=np.nan)
    while True:
        padded = np.pad(distance, 1, constant_values=np.inf)
        best = distance.copy()
        for i in range(3):
            for j in range(3):
                z = padded_z[i : i + height, j : j + width]
                dz = np.abs(z - depth)
                nearer = np.fmin(z, depth)
                across = (nearer / focal) ** 2 * ((i != 1) + (j != 1))
                way = padded[i : i + height, j : j + width] + np.sqrt(across + dz**2)
                may = allowed & (dz <= jump_at(nearer)) & (way <= limit)
                best = np.where(may & (way < best), way, best)
        if np.array_equal(best, distance):
            return distance
        distance = best


def test_geodesic_distance_is_the_shortest_way(generator: np.random.Generator) -> None:
    depth = bumpy_depth(generator, (30, 40))
    allowed = generator.uniform(size=depth.shape) > 0.15
    start = np.full(depth.shape, np.inf, np.float32)
    start[5, 5], start[20, 30] = 0.0, 0.1
    allowed[5, 5] = allowed[20, 30] = True
    expected = geodesic_by_relaxation(depth, allowed, 60.0, 0.8, start)
    out = np.where(allowed, start, np.float32(-np.inf))
    geodesic_distance(depth, 60.0, JUMP, 0.8, out)
    # Single precision may fall on the other side of the limit.
    is_clear = ~(np.abs(expected - 0.8) < 1e-4) & ~(np.abs(out - 0.8) < 1e-4)
    np.testing.assert_allclose(out[is_clear], expected[is_clear], rtol=1e-4)
    assert np.isfinite(out).sum() > 50
    assert not np.isfinite(out[~allowed]).any()


@pytest.mark.parametrize("is_known", [True, False])
@pytest.mark.parametrize("from_head", [True, False])
def test_a_body_grows_from_the_head_and_from_what_is_remembered(
    generator: np.random.Generator, from_head: bool, is_known: bool
) -> None:
    shape = (30, 40)
    depth = bumpy_depth(generator, shape)
    points = generator.uniform(-0.5, 0.5, (*shape, 3)).astype(np.float32)
    points[..., 2] = depth
    plan = points.transpose(2, 0, 1)[[0, 2]].copy()
    heights = (-points[..., 1]).copy()
    free = generator.uniform(size=shape) > 0.2
    bulky = generator.uniform(size=shape) > 0.5
    head = np.array([0.05, -0.1, 2.1], np.float32)
    last_depth = depth + generator.normal(0.0, 0.08, shape).astype(np.float32)
    last_body = np.full(shape, np.inf, np.float32)
    last_body[10:14, 20:25] = generator.choice([0.4, 0.7], (4, 5))
    out = np.empty(shape, np.float32)
    standing = gather_standing(np.flatnonzero(free), plan, heights, points, bulky)
    grow_body(
        np.flatnonzero(free), standing, depth, 60.0, JUMP, JUMP,
        (0.05, -0.1, 2.1), (0.05, 2.1), 0.15, (0.25, -0.4, 0.2), 0.35, 0.8,
        last_body if is_known else np.empty((0, 0), np.float32), last_depth, 0.05, from_head, out,
    )  # fmt: skip
    aside = np.hypot(*(plan - head[[0, 2], None, None]))
    from_head_m = np.linalg.norm(points - head, axis=-1)
    allowed = free & ~(bulky & (aside >= 0.35))
    core = (aside < 0.25) & (heights > -0.4) & (heights < 0.2)
    start = np.full(shape, np.inf)
    if from_head:
        start = np.where(core | (from_head_m < 0.15), from_head_m, np.inf)
    if is_known:
        stays = np.abs(depth - last_depth) < jump_at(depth)
        start = np.where((start == np.inf) & stays, last_body + 0.05, start)
    expected = geodesic_by_relaxation(depth, allowed, 60.0, 0.8, start.astype(np.float32))
    is_clear = ~(np.abs(expected - 0.8) < 1e-4) & ~(np.abs(out - 0.8) < 1e-4)
    np.testing.assert_allclose(out[is_clear], expected[is_clear], rtol=1e-4)
    assert np.isfinite(out).any() == (from_head or is_known)


def noise_2_at(z: float) -> float:
    return NOISE_2[0] + NOISE_2[1] * z + NOISE_2[2] * z**2


FLOOR, MARGIN, NOISE_2 = (0.0, -0.8, -0.6, 1.5), 0.035, (0.001, 0.002, 0.003)


@pytest.mark.parametrize("stride", [1, 2, 3])
@pytest.mark.parametrize("margin", [MARGIN, -np.inf])
def test_full_pixels_are_those_next_to_a_small_one_and_no_floor(
    generator: np.random.Generator, stride: int, margin: float
) -> None:
    full = bumpy_depth(generator, (41, 50))
    full[generator.uniform(size=full.shape) < 0.1] = 0.0
    small = np.ascontiguousarray(full[::stride, ::stride])
    users = generator.uniform(size=small.shape) > 0.8
    found = full_pixels_of(
        full, small, users, stride, JUMP, (40.0, 42.0), (24.5, 20.0), FLOOR, margin, NOISE_2
    )
    expected = []
    for row in range(full.shape[0]):
        for column in range(full.shape[1]):
            z = float(full[row, column])
            i, j = row // stride, column // stride
            near = users[i : i + 2, j : j + 2] & (
                np.abs(small[i : i + 2, j : j + 2] - z) < jump_at(z)
            )
            point = z * np.array([(column - 24.5) / 40.0, (row - 20.0) / 42.0, 1.0])
            descent = abs(point @ FLOOR[:3]) / max(z, 0.1)
            is_floor = point @ FLOOR[:3] + FLOOR[3] <= margin + noise_2_at(z) * descent
            if z > 0.0 and near.any() and not is_floor:
                expected.append(row * full.shape[1] + column)
    np.testing.assert_array_equal(found, expected)
    assert len(found) > 50


def test_bodies_are_shared_by_the_nearest(generator: np.random.Generator) -> None:
    bodies = generator.choice([0.3, 0.34, 0.8, np.inf], (3, 12, 15)).astype(np.float32)
    is_tracked = np.array([True, False, True])
    own, is_contested = bodies.copy(), np.empty(bodies.shape[1:], np.bool_)
    count = share_bodies(own, np.ones(3, np.bool_), is_tracked, 0.06, is_contested)
    is_own = bodies <= bodies.min(0) + 0.06
    is_own |= is_tracked[:, None, None] & is_contested
    np.testing.assert_array_equal(own, np.where(is_own, bodies, np.inf))
    np.testing.assert_array_equal(is_contested, (bodies[is_tracked] < np.inf).all(0))
    assert count == is_contested.sum() > 0


def test_what_a_person_reaches_is_no_other_things(generator: np.random.Generator) -> None:
    bodies = generator.choice([0.3, 0.34, 0.8, np.inf], (3, 12, 15)).astype(np.float32)
    own, nobody = bodies.copy(), np.zeros(3, np.bool_)
    is_contested = np.empty(bodies.shape[1:], np.bool_)
    is_persons = np.array([False, True, False])
    assert share_bodies(own, is_persons, nobody, 0.06, is_contested) == 0
    np.testing.assert_array_equal(own[1], bodies[1])
    for index in (0, 2):
        is_own = (bodies[1] == np.inf) & (bodies[index] <= bodies[[0, 2]].min(0) + 0.06)
        np.testing.assert_array_equal(own[index], np.where(is_own, bodies[index], np.inf))


def test_only_small_pieces_are_kept() -> None:
    labels = np.array([[1, 1, 0, 2], [1, 1, 0, 0], [0, 0, 0, 0], [0, 0, 3, 3]], np.int32)
    depth = np.full(labels.shape, 2.0, np.float32)
    # A pixel covers 0.01 m^2.
    found = np.empty(labels.shape, np.int32)
    is_loose = labels > 0
    pixels, count = small_pieces(
        np.arange(labels.size),
        labels == 0,
        np.zeros_like(is_loose),
        depth,
        20.0,
        0.015,
        0.035,
        found,
    )
    nowhere = np.zeros_like(labels)
    assert not len(
        small_pieces(np.arange(labels.size), is_loose, ~is_loose, depth, 20.0, 0.0, 9.0, nowhere)[0]
    )
    np.testing.assert_array_equal(pixels, [14, 15])
    np.testing.assert_array_equal(found, labels)
    assert count == 4


def a_body_beside_a_piece(
    piece_m: float,
) -> tuple[NDArray[np.float32], NDArray[np.int32], NDArray[np.float32]]:
    depth = np.full((4, 6), 2.0, np.float32)
    depth[:, 3:] = piece_m
    labels = np.zeros((4, 6), np.int32)
    labels[:, 3:] = 1
    body = np.full((4, 6), np.inf, np.float32)
    body[:, :3] = 0.5
    return depth, labels, body


@pytest.mark.parametrize(
    ("piece_m", "height_m", "reach_m", "joins"),
    [
        (1.8, 0.1, 1.0, True),
        (1.4, 0.1, 1.0, False),
        (2.1, 0.5, 1.0, True),
        (2.1, 0.1, 1.0, False),
        (2.6, 0.5, 1.0, False),
        (1.8, 0.5, 0.15, False),
    ],
    ids=[
        "before it",
        "too far before it",
        "behind it, high up",
        "behind it, as furniture stands",
        "too far behind it",
        "out of reach",
    ],
)
def test_a_piece_joins_a_body_that_it_touches_before_or_behind(
    piece_m: float, height_m: float, reach_m: float, joins: bool
) -> None:
    depth, labels, body = a_body_beside_a_piece(piece_m)
    points = np.stack([np.zeros_like(depth), np.zeros_like(depth), depth], axis=-1)
    heights = np.full_like(depth, 0.5)
    heights[0] = height_m
    whole = body.copy()
    pixels = np.flatnonzero(labels).astype(np.int32)
    head = np.array([0.0, 0.0, 2.0], np.float32)
    join_pieces(pixels, labels, 2, depth, points, heights, head, reach_m, 0.45, 0.3, whole)
    np.testing.assert_array_equal(whole[:, :3], body[:, :3])
    np.testing.assert_allclose(whole[:, 3:], abs(2.0 - piece_m) if joins else np.inf, atol=1e-6)
