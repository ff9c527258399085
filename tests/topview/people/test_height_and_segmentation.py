from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from people_scenes import Ball, box, frame, limb, plane, render, standing_person
from topview.body.parts import JOINTS
from topview.body.shapes import dressed_shapes
from topview.detect.cloud import Cloud
from topview.detect.heads import HEAD_HALF_HEIGHT_M
from topview.kernels.bodies import share_within
from topview.people.height import (
    HEIGHT_MEMORY_S,
    LONGEST_UPRIGHT_S,
    PRIOR_HEIGHT_M,
    QUANTILE,
    UPRIGHT_ASIDE,
    HeightEstimate,
    measured_height,
)
from topview.people.segmentation import (
    BY_OVERVIEW,
    SegmentationSettings,
    body_distance,
    split_by_overview,
    split_users,
    surface_distance,
)
from topview.room.background import KNOWN_S, Background
from topview.room.floor import FloorPlane
from topview.room.scene import Scene, SceneSettings

UP = np.array([0.0, -1.0, 0.0])


def scene_with(depth: np.ndarray, ground_y: float) -> Scene:
    floor = FloorPlane(UP.copy(), ground_y)
    cloud = Cloud.from_frame(frame(depth))
    nothing = np.zeros(cloud.depth_m.shape, np.bool_)
    return Scene.of(cloud, floor, nothing, SceneSettings())


def test_stature_is_measured_on_the_upright_alone() -> None:
    ground_y, floor = 1.1, plane(UP, 1.1)
    upright = scene_with(render(standing_person(0.0, 3.0, ground_y, 1.8), [floor]), ground_y)
    at = np.array([0.0, ground_y - 0.93 * 1.8, 3.0])
    body = np.isfinite(body_distance(upright, at, 1.8, SegmentationSettings()))
    assert measured_height(upright, at, body) == pytest.approx(1.79, abs=0.03)

    # The same head, but most of the body far aside of it: bent, or lying.
    assert measured_height(upright, at + np.array([0.6, 0.0, 0.0]), body) is None
    assert measured_height(upright, at, np.zeros_like(body)) is None


def test_an_adult_who_sits_with_the_head_over_the_lap_is_no_child_who_stands() -> None:
    """All of the body is under the head, but it is broader than a standing child's."""
    ground_y, z, head_up, ahead = 1.1, 3.0, 1.0, 0.15
    sits = scene_with(render(seated_person(z, ground_y), [plane(UP, ground_y)]), ground_y)
    at = np.array([0.0, ground_y - head_up, z - ahead])
    body = np.isfinite(body_distance(sits, at, PRIOR_HEIGHT_M, SegmentationSettings()))
    height_m = sits.height_of(at) + HEAD_HALF_HEIGHT_M
    right, forward = sits.overview_of(at).tolist()
    assert share_within(sits.plan_m, body, right, forward, UPRIGHT_ASIDE * height_m) > 0.9
    assert measured_height(sits, at, body) is None


def seated_person(z: float, ground_y: float) -> list[Ball]:
    """Of 1.6 m, on a chair, bent forward a little."""

    def at(right: float, up: float, ahead: float = 0.0) -> tuple[float, float, float]:
        return (right, ground_y - up, z - ahead)

    balls = [(np.array(at(0.0, 1.0, 0.15)), 0.1)]
    balls += limb(at(-0.08, 0.75, 0.05), at(0.08, 0.75, 0.05), 0.14)
    balls += limb(at(-0.07, 0.55), at(0.07, 0.55), 0.15)
    for side in (-1, 1):
        balls += limb(at(side * 0.18, 0.8, 0.05), at(side * 0.2, 0.55, 0.1), 0.055)
        balls += limb(at(side * 0.1, 0.5), at(side * 0.14, 0.5, 0.2), 0.09)
        balls += limb(at(side * 0.14, 0.45, 0.2), at(side * 0.13, 0.05, 0.2), 0.07)
    return balls


def test_whoever_is_off_the_floor_is_not_measured() -> None:
    """A jump is no stature; feet that are hidden tell nothing."""
    ground_y, floor = 1.1, plane(UP, 1.1)
    lifted = standing_person(0.0, 3.0, ground_y - 0.25, 1.8)
    in_air = scene_with(render(lifted, [floor]), ground_y)
    at = np.array([0.0, ground_y - 0.25 - 0.93 * 1.8, 3.0])
    body = np.isfinite(body_distance(in_air, at, 1.8, SegmentationSettings()))
    assert measured_height(in_air, at, body) is None
    stool = box((-0.6, 0.5, 2.3), (0.6, ground_y, 2.4))
    hidden = scene_with(render(lifted, [floor, stool]), ground_y)
    body &= np.abs(hidden.cloud.depth_m - in_air.cloud.depth_m) < 0.01
    assert measured_height(hidden, at, body) == pytest.approx(2.04, abs=0.03)


def test_where_a_network_is_asked_a_board_before_the_trunk_is_not_the_body() -> None:
    """As the back of a chair on which somebody sits who turns the own back to the camera."""
    ground_y, floor = 1.1, plane(UP, 1.1)
    board = box((-0.08, ground_y - 1.0, 2.74), (0.08, ground_y - 0.4, 2.76))
    before = scene_with(render(standing_person(0.0, 3.0, ground_y, 1.8), [floor, board]), ground_y)
    at = np.array([0.0, ground_y - 0.93 * 1.8, 3.0])
    is_board = (np.abs(before.cloud.depth_m - 2.74) < 0.01) & (before.heights_m > 0.3)
    assert is_board.sum() > 200
    shape, asked = (
        np.isfinite(body_distance(before, at, 1.8, how))
        for how in (SegmentationSettings(), SegmentationSettings().where_asked())
    )
    assert shape[is_board].all()
    assert not asked[is_board].any()
    assert (asked | is_board)[shape].all()


def test_the_estimate_starts_at_the_mean_and_ignores_frames_without_a_measurement() -> None:
    estimate = HeightEstimate()
    estimate.add(None, 0.0)
    assert estimate.height_m == PRIOR_HEIGHT_M
    for k, bent in enumerate(np.linspace(0.0, 0.1, 50)):
        estimate.add(1.65 - bent, k / 30)
    assert estimate.height_m == pytest.approx(1.63, abs=0.02)


@given(st.lists(st.floats(1.5, 1.9), min_size=1, max_size=100), st.sampled_from((2, 8, 64)))
@settings(max_examples=20)
def test_the_estimate_is_a_quantile_of_the_latest_measurements(
    heights_m: list[float], fps: int
) -> None:
    """Of so many seconds, at any rate of frames."""
    estimate = HeightEstimate()
    for k, height_m in enumerate(heights_m):
        estimate.add(height_m, k / fps)
    latest = round(HEIGHT_MEMORY_S / min(1 / fps, LONGEST_UPRIGHT_S))
    expected = np.quantile(np.array(heights_m[-latest:]), QUANTILE)
    assert estimate.height_m == pytest.approx(expected, abs=1e-12)


@given(st.integers(0, 2**32 - 1), st.floats(1.1, 2.0), st.floats(-1.0, 3.0))
@settings(max_examples=20)
def test_beside_a_lone_bone_the_surface_is_as_far_as_the_bone_less_its_radius(
    seed: int, height_m: float, aside_m: float
) -> None:
    generator = np.random.default_rng(seed)
    radii_m = dressed_shapes(height_m)[:, :4].mean(1)
    for end, joint in enumerate(JOINTS):
        if joint.bone_to < 0:
            continue
        joints = np.full((len(JOINTS), 3), np.nan)
        joints[[joint.bone_to, end]] = generator.normal(size=(2, 3))
        along = joints[end] - joints[joint.bone_to]
        across = np.cross(along, generator.normal(size=3))
        points = 0.4 * joints[end] + 0.6 * joints[joint.bone_to]
        points = (points + aside_m * across / np.linalg.norm(across))[None]
        expected_m = abs(aside_m) - radii_m[joint.part]
        assert surface_distance(points, joints, height_m)[0] == pytest.approx(expected_m)


def test_of_several_bones_the_nearest_surface_counts() -> None:
    """A point of a wide trunk is nearer to it than to a thin arm whose bone is as near."""
    x = np.linspace(-1.0, 1.0, 41)
    points = np.stack([x, np.zeros(41), np.full(41, 3.0)], 1)
    joints = np.full((len(JOINTS), 3), np.nan)
    thin, wide = (
        max(
            (end for end, joint in enumerate(JOINTS) if joint.bone_to >= 0),
            key=lambda end: sign * dressed_shapes(1.0)[JOINTS[end].part, :4].mean(),
        )
        for sign in (-1.0, 1.0)
    )
    alone = []
    for end, at in ((thin, -0.5), (wide, 0.5)):
        ends = np.array([[at, -0.5, 3.0], [at, 0.5, 3.0]])
        joints[[JOINTS[end].bone_to, end]] = ends
        own = np.full((len(JOINTS), 3), np.nan)
        own[[JOINTS[end].bone_to, end]] = ends
        alone.append(surface_distance(points, own, 1.7))
    np.testing.assert_allclose(surface_distance(points, joints, 1.7), np.minimum(*alone))
    assert alone[1][20] < alone[0][20] - 0.02


def test_bones_are_thicker_by_what_their_ends_may_be_off() -> None:
    generator = np.random.default_rng(3)
    joints, points = generator.normal(size=(len(JOINTS), 3)), generator.normal(size=(50, 3))
    exact_m = surface_distance(points, joints, 1.7)
    everywhere_m = surface_distance(points, joints, 1.7, np.full(len(JOINTS), 0.2))
    np.testing.assert_allclose(everywhere_m, exact_m - 0.2)
    end = next(end for end, joint in enumerate(JOINTS) if joint.bone_to >= 0)
    ends = [JOINTS[end].bone_to, end]
    alone, spread_m = np.full(joints.shape, np.nan), np.zeros(len(JOINTS))
    alone[ends], spread_m[ends] = joints[ends], (0.1, 0.3)
    thicker_m = surface_distance(points, alone, 1.7) - surface_distance(
        points, alone, 1.7, spread_m
    )
    np.testing.assert_allclose(thicker_m, 0.2)


def test_tracked_bodies_decide_between_two_who_touch() -> None:
    ground_y = 1.1
    balls = standing_person(-0.25, 3.0, ground_y) + standing_person(0.25, 3.0, ground_y)
    scene = scene_with(render(balls, [plane(UP, ground_y)]), ground_y)
    sizes = SegmentationSettings()
    heads = [np.array([x, ground_y - 0.93 * 1.75, 3.0]) for x in (-0.25, 0.25)]
    bodies = [body_distance(scene, at, 1.75, sizes) for at in heads]
    # All bones upright, one body's beside the other's.
    left = np.tile(heads[0], (len(JOINTS), 1))
    left[:, 1] = np.linspace(heads[0][1], ground_y, len(JOINTS))
    right = left + np.array([0.5, 0.0, 0.0])
    statures_m = [1.75, 1.75]

    def split(joints: Sequence[NDArray[np.float64] | None]) -> NDArray[np.bool_]:
        own_m = np.stack(bodies)
        split_users(scene, own_m, [True, True], joints, statures_m, sizes)
        return np.isfinite(own_m)

    over_surface, by_bodies = split([None, None]), split([left, right])
    x = scene.cloud.points_camera[..., 0]
    for masks in (over_surface, by_bodies):
        assert (x[masks[0]] < 0.05).mean() > 0.97
        assert (x[masks[1]] > -0.05).mean() > 0.97
    assert not (by_bodies[0] & by_bodies[1]).any()
    crossed = split([right, left])
    is_contested = np.isfinite(bodies[0]) & np.isfinite(bodies[1])
    assert (x[crossed[0] & is_contested] > -0.1).mean() > 0.97


def test_the_background_learns_the_room_but_nobody() -> None:
    background = Background()
    depth = np.full((4, 6), 3.0, np.float32)
    somebody = np.zeros((4, 6), np.bool_)
    somebody[:, :2] = True
    for time_s in np.arange(0.0, 2.0 * KNOWN_S, 0.1):
        background.update(depth, somebody, time_s)
    np.testing.assert_array_equal(background.is_seen_in(depth), ~somebody)
    assert not background.is_seen_in(depth - 0.5).any()
    # What is seen further away was never there.
    background.update(depth + 1.0, np.zeros_like(somebody), 2.0 * KNOWN_S)
    assert not background.is_seen_in(depth).any()


def test_how_long_a_depth_has_been_the_same() -> None:
    steady, nobody = Background(np.inf), np.zeros((4, 6), np.bool_)
    depth = np.full((4, 6), 3.0, np.float32)
    steady.update(depth, nobody, 0.0)
    depth[:, 0] += 0.5  # farther away: what was there has gone
    steady.update(depth, nobody, 2.0)
    depth[:, 1] -= 0.5  # nearer: something has come before it
    steady.update(depth, nobody, 5.0)
    for column, seconds in ((0, 3.0), (1, 0.0), (2, 5.0)):
        is_own = np.zeros((4, 6), np.bool_)
        is_own[:, column] = True
        assert steady.changed_share(is_own, depth, seconds - 0.1) == float(seconds == 0.0)
        assert steady.changed_share(is_own, depth, seconds + 0.1) == 1.0


def test_what_something_hides_for_a_while_has_not_changed() -> None:
    steady, nobody = Background(np.inf), np.zeros((4, 6), np.bool_)
    thing, passer = np.full((4, 6), 3.0, np.float32), np.full((4, 6), 1.5, np.float32)
    for time_s, depth in ((0.0, thing), (1.0, thing), (2.0, passer), (3.0, passer), (4.0, thing)):
        steady.update(depth, nobody, time_s)
    assert steady.changed_share(~nobody, thing, 3.9) == 0.0
    assert steady.changed_share(~nobody, passer, 3.9) == 1.0


def test_by_overview_who_is_near_a_head_is_one_user_and_what_touches_both_is_both() -> None:
    ground_y = 1.1
    xs = (-0.45, 0.45)
    arms = [(np.array([x, -0.25, 2.95]), 0.06) for x in np.arange(-0.4, 0.41, 0.05)]
    balls = [ball for x in xs for ball in standing_person(x, 3.0, ground_y)] + arms
    scene = scene_with(render(balls, [plane(UP, ground_y)]), ground_y)
    heads = [np.array([x, ground_y - 0.93 * 1.75, 3.0]) for x in xs]
    bodies = [body_distance(scene, at, 1.75, BY_OVERVIEW) for at in heads]
    own_m = np.stack(bodies)
    split_by_overview(scene, own_m, heads, [0.3, 0.3])
    masks = np.isfinite(own_m)
    for mask, other, head in zip(masks, masks[::-1], heads, strict=True):
        is_near = scene.aside_of(head) < 0.3
        assert (mask & is_near).sum() > 100
        assert not (other & is_near).any()
    assert (masks[0] & masks[1]).any()
    np.testing.assert_array_equal(masks[0] | masks[1], np.isfinite(np.minimum(*bodies)))
