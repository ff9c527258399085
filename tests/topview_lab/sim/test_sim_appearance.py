"""How people differ, and the folds of their skin and clothes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from topview.records import Camera
from topview_lab.sim import CHILD, TWELVE_PEOPLE
from topview_lab.sim.anthropometry import head_share, hip_share, knee_share
from topview_lab.sim.appearance import AVERAGE, Appearance, random_appearance
from topview_lab.sim.bodies import Body, build_body
from topview_lab.sim.folds import Folds
from topview_lab.sim.materials import SKIN, TROUSERS, fold_amplitudes
from topview_lab.sim.render import draw_people
from topview_lab.sim.skeleton import SEGMENTS, Pose, segment_poses
from topview_lab.sim.surface import surface_detail

FOLDS = Folds.sample(np.random.default_rng(5))
CAMERA = Camera(fx=131.0, fy=131.0, cx=79.5, cy=59.5, width=160, height=120)
R_CAMERA_ROOM = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])


def standing(body: Body) -> np.ndarray:
    """[S, 4, 4] in the frame of a camera that the body faces from 2.8 m."""
    root = np.array([0.0, 2.8, 0.0])
    T = np.eye(4)
    T[:3, :3] = R_CAMERA_ROOM
    angles = np.zeros((len(SEGMENTS), 3))
    return T @ segment_poses(body.offsets_m, Pose(root, -np.pi / 2, angles))


def test_the_twelve_are_as_different_as_people_are() -> None:
    statures = [appearance.stature_m for appearance in TWELVE_PEOPLE]
    assert len(set(TWELVE_PEOPLE)) == len({appearance.label for appearance in TWELVE_PEOPLE}) == 12
    assert (min(statures), max(statures)) == (1.50, 1.95)
    assert sum(appearance.sex == "woman" for appearance in TWELVE_PEOPLE) == 5
    assert min(appearance.girth for appearance in TWELVE_PEOPLE) < 0.87
    assert max(appearance.girth for appearance in TWELVE_PEOPLE) > 1.2
    assert any(appearance.clothes.skirt_share for appearance in TWELVE_PEOPLE)
    assert any(appearance.clothes.has_hood for appearance in TWELVE_PEOPLE)
    assert any(appearance.has_long_hair for appearance in TWELVE_PEOPLE)
    assert len({appearance.skin for appearance in TWELVE_PEOPLE}) == 6


def test_labels_tell_who_it_is() -> None:
    assert replace(TWELVE_PEOPLE[0], sex="woman", stature_m=1.62).label == "woman 1.62 m"
    assert CHILD.label == "child 1.27 m"


def test_a_child_has_a_large_head_and_short_legs() -> None:
    adult = TWELVE_PEOPLE[0]
    assert 6.0 < 1.0 / head_share(CHILD) < 6.6  # eight years: about 6.4 heads tall
    assert 1.0 / head_share(adult) > 7.4
    assert hip_share(CHILD) < hip_share(adult)


def test_random_people_vary_as_much_as_measured_ones() -> None:
    appearances = [random_appearance(np.random.default_rng(seed)) for seed in range(300)]
    for share in (hip_share, knee_share):
        shares = np.array([share(appearance) for appearance in appearances])
        assert 0.015 < shares.std() / shares.mean() < 0.05
        assert np.abs(shares / shares.mean() - 1.0).max() < 0.12
    assert len({appearance.skin for appearance in appearances}) == 6
    assert (
        0.02 < np.mean([appearance.clothes.skirt_share > 0.0 for appearance in appearances]) < 0.2
    )


@settings(max_examples=50)
@given(st.integers(0, 1000), st.floats(0.0, 0.02))
def test_folds_are_bounded_and_their_slopes_are_their_derivative(seed: int, high: float) -> None:
    rng = np.random.default_rng(seed)
    places = rng.uniform(-1.0, 1.0, (200, 3)).astype(np.float32)
    amplitudes = np.full(200, high, np.float32)
    heights, slopes = FOLDS.at(places, amplitudes)
    assert (np.abs(heights) <= high * 1.0001).all()
    step = 1e-3
    for axis in range(3):
        ahead, _ = FOLDS.at(places + np.eye(3, dtype=np.float32)[axis] * step, amplitudes)
        behind, _ = FOLDS.at(places - np.eye(3, dtype=np.float32)[axis] * step, amplitudes)
        derivative = (ahead - behind) / (2.0 * step)
        np.testing.assert_allclose(slopes[:, axis], derivative, atol=0.03 * high + 1e-5, rtol=0.01)


def test_folds_move_with_the_body() -> None:
    body = build_body(TWELVE_PEOPLE[4])
    rng = np.random.default_rng(0)
    piece = rng.integers(0, len(body.parts), 400).astype(np.int32)
    points = rng.uniform(-0.3, 0.3, (400, 3)) + np.array([0.0, 0.0, 2.8])
    normals = rng.standard_normal((400, 3))
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    Ts = standing(body)
    moved = np.eye(4)
    moved[:3, :3] = Rotation.from_euler("xyz", [0.3, 1.1, -0.2]).as_matrix()
    moved[:3, 3] = (0.2, -0.1, 0.5)
    here = surface_detail(body, Ts, piece, points, normals)
    there = surface_detail(
        body, moved @ Ts, piece, points @ moved[:3, :3].T + moved[:3, 3], normals @ moved[:3, :3].T
    )
    np.testing.assert_allclose(there.displacements, here.displacements, atol=1e-6)
    np.testing.assert_allclose(there.normals, here.normals @ moved[:3, :3].T, atol=1e-4)
    assert np.abs(here.displacements).max() > 0.002


@pytest.mark.parametrize(
    "appearance", [TWELVE_PEOPLE[4], TWELVE_PEOPLE[10]], ids=["jumper", "skirt"]
)
def test_folds_change_the_surface_by_no_more_than_their_size(
    appearance: Appearance, render_plain
) -> None:
    empty = render_plain(np.full((CAMERA.height, CAMERA.width), np.inf, np.float32))
    even, folded = (build_body(one) for one in (replace(appearance, folds_seed=None), appearance))
    images = [draw_people([body], [standing(body)], empty, CAMERA) for body in (even, folded)]
    both = np.logical_and(*(image.instance == 1 for image in images))
    both &= images[0].material == images[1].material
    change = np.abs(images[0].depth_m[both] - images[1].depth_m[both])
    assert both.sum() > 1000
    assert 0.002 < np.median(change) < max(fold_amplitudes(appearance))
    assert (images[0].instance != images[1].instance).sum() > 10  # the outline too


def test_the_same_person_is_built_alike_each_time_and_others_otherwise() -> None:
    appearance = random_appearance(np.random.default_rng(8))
    first, again = build_body(appearance), build_body(appearance)
    np.testing.assert_array_equal(first.start_radii_m, again.start_radii_m)
    np.testing.assert_array_equal(first.folds.waves, again.folds.waves)
    other = build_body(replace(appearance, folds_seed=4321))
    assert not np.array_equal(first.start_radii_m, other.start_radii_m)


@pytest.mark.parametrize("seed", range(4))
def test_an_even_body_is_its_own_mirror_image(seed: int) -> None:
    body = build_body(random_appearance(np.random.default_rng(seed)).even())
    balls = np.column_stack([body.starts_m, body.start_radii_m])
    places = np.array([np.round(row, 6) for row in balls * (-1, 1, 1, 1)])
    for row in places[::3]:
        assert np.abs(balls - row).max(-1).min() < 2e-6


def test_a_skirt_hides_the_thighs(render_plain) -> None:
    empty = render_plain(np.full((CAMERA.height, CAMERA.width), np.inf, np.float32))
    appearance = replace(TWELVE_PEOPLE[9], proportions=AVERAGE)
    trousers = replace(appearance, clothes=replace(appearance.clothes, skirt_share=0.0))
    dressed, other = (
        draw_people([body], [standing(body)], empty, CAMERA)
        for body in (build_body(appearance), build_body(trousers))
    )
    wide = [(image.material == TROUSERS).sum(1) for image in (dressed, other)]
    above_knee = slice(70, 78)  # hips are in row 60, knees in row 82
    assert (wide[0][above_knee] > wide[1][above_knee]).all()
    assert (np.diff(wide[0][62:78]) >= 0).all()  # wider the lower, as legs are not
    assert (dressed.material[84:95] == SKIN).any()
