"""Colour images: the light over time, what people change in a picture, and registration."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from topview_lab.sim import Scene, SimulatedRecording, scene_by_name
from topview_lab.sim.colour import COLOR_BASELINE_M, ColorCamera
from topview_lab.sim.images import Rendering
from topview_lab.sim.light import AMBIENT, GREATEST_GAIN, STEADY, Light
from topview_lab.sim.render import Renderer

LIT = STEADY.levels(0.0)
NO_FEET = np.zeros((0, 3))


@pytest.fixture(scope="module")
def scene() -> Scene:
    return scene_by_name("stand", seed=3)


@pytest.fixture(scope="module")
def drawn(scene: Scene) -> tuple[Rendering, Rendering]:
    """The empty room, and with a person."""
    renderer = Renderer(scene)
    return renderer.background, renderer.draw(0).rendering


def camera_of(scene: Scene, background: Rendering, baseline_m: float = 0.0) -> ColorCamera:
    R = scene.mount.T_camera_room()[:3, :3]
    return ColorCamera(background, scene.camera, R, 0, baseline_m)


def picture(camera: ColorCamera, rendering: Rendering, feet: NDArray = NO_FEET) -> NDArray:
    return camera.picture(rendering, feet, LIT, np.random.default_rng(1)).astype(int)


def grown(mask: NDArray[np.bool_], by_px: int) -> NDArray[np.bool_]:
    kernel = np.ones((2 * by_px + 1, 2 * by_px + 1), np.uint8)
    return np.asarray(cv2.dilate(mask.astype(np.uint8), kernel), np.bool_)


def test_off_the_people_the_kept_shading_is_that_of_the_empty_room(scene, drawn) -> None:
    empty, peopled = drawn
    camera = camera_of(scene, empty)
    off = ~grown(peopled.instance == 1, 1)
    np.testing.assert_array_equal(picture(camera, peopled)[off], picture(camera, empty)[off])


def test_kept_shading_equals_shading_anew(scene, drawn) -> None:
    """A person is shaded alike as part of the room, but for the softened normals."""
    empty, peopled = drawn
    kept = picture(camera_of(scene, empty), peopled)
    as_room = replace(peopled, instance=np.zeros_like(peopled.instance))
    anew = picture(camera_of(scene, as_room), as_room)
    difference = np.abs(kept - anew)
    assert difference[~grown(peopled.instance == 1, 1)].max() == 0
    assert np.median(difference[peopled.instance == 1]) < 6


def test_feet_darken_the_floor_around_them_alone(scene, drawn) -> None:
    empty, _ = drawn
    camera = camera_of(scene, empty)
    T = scene.mount.T_camera_room()
    foot = (T @ (0.0, 2.5, 0.05, 1.0))[:3]
    darker = picture(camera, empty) - picture(camera, empty, foot[None])
    u, v = (
        scene.camera.fx * foot[0] / foot[2] + 159.5,
        scene.camera.fy * foot[1] / foot[2] + 119.5,
    )
    assert darker.min() >= 0
    assert darker[int(v) + 2, int(u)].mean() > 20
    assert darker[:, : int(u) - 60].max() == 0
    assert darker[: int(v) - 40].max() == 0


def test_registration_leaves_ghosts_to_the_left_of_people_alone(scene, drawn) -> None:
    empty, peopled = drawn
    perfect = picture(camera_of(scene, empty), peopled)
    real = picture(camera_of(scene, empty, COLOR_BASELINE_M), peopled)
    changed = np.abs(perfect - real).max(-1) > 12
    person = peopled.instance == 1
    assert changed.sum() > 30
    # 262 px * 2.5 cm * (1 / 2.5 m - 1 / 4.7 m) = 1.2 px, and the blur's pixel
    assert not changed[~grown(person, 3)].any()
    assert (changed & ~person).sum() > 4 * (changed & person).sum()
    moved_left = np.roll(person, -2, axis=1) & ~person
    assert (changed & moved_left).sum() > 0.6 * changed.sum()


def test_a_steady_lamp_is_steady() -> None:
    for time_s in (0.0, 1.0, 100.0):
        assert STEADY.levels(time_s) == pytest.approx((AMBIENT, 1.0 - AMBIENT))


@given(st.floats(0.5, 5.0), st.floats(0.0, 5.0))
def test_exposure_makes_up_for_a_lamp_that_goes_out(switch_s: float, later_s: float) -> None:
    light = Light(switches_s=(switch_s,))
    before, after = light.levels(0.99 * switch_s), light.levels(switch_s + later_s)
    assert before == pytest.approx((AMBIENT, 1.0 - AMBIENT))
    assert after.lamp == 0.0
    assert AMBIENT <= after.ambient <= GREATEST_GAIN * AMBIENT
    assert light.levels(switch_s + later_s + 0.1).ambient >= after.ambient


def test_a_lamp_that_comes_back_is_too_bright_for_a_moment() -> None:
    light = Light(switches_s=(1.0, 3.0))
    assert light.levels(3.01).lamp > 1.3 * (1.0 - AMBIENT)
    assert light.levels(9.0) == pytest.approx((AMBIENT, 1.0 - AMBIENT), rel=1e-3)


@given(st.floats(0.0, 60.0))
def test_daylight_drifts_within_its_bounds(time_s: float) -> None:
    levels = Light(drift=0.2).levels(time_s)
    assert 0.8 * AMBIENT - 1e-9 <= levels.ambient <= 1.2 * AMBIENT + 1e-9


def test_the_scenes_light_is_in_its_pictures_and_not_in_its_depth() -> None:
    lit = scene_by_name("stand", seed=3, frames=20)
    dark = replace(lit, light=Light(switches_s=(0.2,)))
    a, b = (SimulatedRecording(one).simulate(7) for one in (lit, dark))
    assert b.color.mean() < 0.8 * a.color.mean()
    np.testing.assert_array_equal(a.depth_mm, b.depth_mm)
    np.testing.assert_array_equal(
        SimulatedRecording(lit).simulate(2).color, SimulatedRecording(dark).simulate(2).color
    )


def test_some_rooms_have_a_lamp_that_is_switched() -> None:
    lights = [Light.sample(np.random.default_rng(seed)) for seed in range(200)]
    assert 0.15 < np.mean([bool(light.switches_s) for light in lights]) < 0.35
    assert scene_by_name("jumping_jacks", seed=1).light != scene_by_name("bending", seed=1).light
