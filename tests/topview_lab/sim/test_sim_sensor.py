"""The depth sensor: steps, noise that grows with depth, shadows, losses, repeatability."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from topview.records import Camera, Recording
from topview_lab.sim import SimulatedRecording, scene_by_name
from topview_lab.sim.materials import HAIR, SHIRT
from topview_lab.sim.noise import NoiseField, noise_generator
from topview_lab.sim.render import Renderer
from topview_lab.sim.sensor import KINECT_V1, DepthCamera, projector_shadow

CAMERA = Camera(fx=262.5, fy=262.5, cx=159.5, cy=119.5, width=320, height=240)


def wall(depth_m: float) -> np.ndarray:
    return np.full((CAMERA.height, CAMERA.width), depth_m, np.float32)


def sensed(render_plain, depth_m: np.ndarray) -> np.ndarray:
    depth_mm = DepthCamera(CAMERA, 0).sense(render_plain(depth_m), noise_generator(0, 0))
    return depth_mm.astype(np.float64) / 1000.0


@pytest.mark.parametrize("depth_m", [1.0, 2.0, 3.5, 5.0])
def test_noise_of_a_wall_grows_as_published(render_plain, depth_m: float) -> None:
    seen = sensed(render_plain, wall(depth_m))
    readings = seen[seen > 0.0]
    assert readings.mean() == pytest.approx(depth_m, rel=0.004)
    # Khoshelham and Elberink (2012), Eq. 13: 1.425e-5 / cm z^2, plus the steps' own spread
    steps = 2.85e-3 * depth_m**2
    assert readings.std() == pytest.approx(np.hypot(0.5, 12**-0.5) * steps, rel=0.15)
    nguyen = 0.0012 + 0.0019 * (depth_m - 0.4) ** 2
    assert 0.5 * nguyen < readings.std() < 2.0 * nguyen


@pytest.mark.parametrize("depth_m", [2.0, 4.0])
def test_depth_comes_in_steps(render_plain, depth_m: float) -> None:
    levels = np.unique(sensed(render_plain, wall(depth_m)))
    levels = levels[levels > 0.0]
    np.testing.assert_allclose(np.diff(levels), 2.85e-3 * levels[1:] * levels[:-1], atol=1.1e-3)


def test_neighbours_err_alike_as_far_as_the_matching_window_reaches() -> None:
    rng = np.random.default_rng(1)
    noise = NoiseField((480, 640), 9, rng).draw(rng)
    assert noise.std() == pytest.approx(1.0, abs=0.03)
    for apart in (1, 3, 6, 9, 14):
        alike = (noise[:, apart:] * noise[:, :-apart]).mean()
        assert alike == pytest.approx(max(1.0 - apart / 9.0, 0.0), abs=0.05)


def test_most_of_a_still_walls_error_stays(render_plain) -> None:
    camera, plain = DepthCamera(CAMERA, 3), render_plain(wall(2.6))
    seen = np.stack([camera.sense(plain, noise_generator(3, f)) for f in range(12)]) / 1000.0
    steps = 1.0 / (2.85e-3 * seen[:, (seen > 0.0).all(0)])
    passing, all_in_all = steps.std(0).mean(), steps.std()
    # a Kinect v1 before a wall at 2.6 m: 0.3 of 0.7 to 0.8 steps
    assert 0.2 < passing < 0.4
    assert 0.5 < all_in_all < 0.8


def test_what_is_narrower_than_half_of_the_window_is_not_seen(render_plain) -> None:
    depth = wall(3.0)
    depth[:, 100:101] = 2.0
    depth[:, 200:206] = 2.0
    seen = sensed(render_plain, depth)[120]
    assert (seen[95:106][seen[95:106] > 0.0] > 2.8).all()
    assert (np.abs(seen[198:208] - 2.0) < 0.1).sum() >= 3


@pytest.mark.parametrize("depth_m", [0.3, 9.0, np.inf])
def test_nothing_is_read_out_of_range(render_plain, depth_m: float) -> None:
    assert not sensed(render_plain, wall(depth_m)).any()


def test_an_edge_casts_a_shadow_to_its_left_alone() -> None:
    depth = wall(4.0)
    depth[:, 150:200] = 2.0
    shadow = projector_shadow(depth, CAMERA, KINECT_V1.baseline_m)
    width = CAMERA.fx * KINECT_V1.baseline_m * (1 / 2.0 - 1 / 4.0)
    columns = np.nonzero(shadow[100])[0]
    assert columns.max() == 149
    assert len(columns) == pytest.approx(width, abs=1.0)
    assert (shadow == shadow[0]).all()


def test_an_even_surface_has_no_shadow() -> None:
    slope = np.broadcast_to(np.linspace(1.0, 5.0, CAMERA.width, dtype=np.float32), (240, 320))
    for depth in (slope, slope[:, ::-1], wall(2.0)):
        assert not projector_shadow(depth, CAMERA, KINECT_V1.baseline_m).any()


def test_grazing_surfaces_lose_their_readings(render_plain) -> None:
    plain = render_plain(wall(2.0))
    normals = np.zeros_like(plain.normals)
    normals[..., 1], normals[..., 2] = -1.0, -0.02  # nearly along the rays of the middle rows
    grazing = replace(plain, normals=normals)
    read = DepthCamera(CAMERA, 0).sense(grazing, noise_generator(0, 0)) > 0
    assert read[118:122].mean() < 0.02
    assert read[-5:].mean() > read[150:155].mean()


def test_dark_hair_loses_more_readings_than_cloth() -> None:
    rendering = Renderer(scene_by_name("stand")).draw(0).rendering
    is_hair, is_shirt = rendering.material == HAIR, rendering.material == SHIRT
    albedo = np.where(is_hair[..., None], np.float32(0.02), rendering.albedo)
    dark = replace(rendering, albedo=albedo)
    camera = DepthCamera(CAMERA, 0)
    lost = np.mean([camera.sense(dark, noise_generator(0, f)) == 0 for f in range(5)], axis=0)
    assert lost[is_hair].mean() > 2 * lost[is_shirt].mean()


def test_same_seed_same_images_other_seed_other_images() -> None:
    first, again, other = (
        list(SimulatedRecording(scene_by_name("pass_by", seed=seed, frames=2)))
        for seed in (7, 7, 8)
    )
    for a, b, c in zip(first, again, other, strict=True):
        assert a.color is not None
        assert b.color is not None
        np.testing.assert_array_equal(a.depth_m, b.depth_m)
        np.testing.assert_array_equal(a.color, b.color)
        assert (a.depth_m != c.depth_m).mean() > 0.3
    assert (first[0].depth_m != first[1].depth_m).mean() > 0.15


def test_a_frame_does_not_depend_on_those_before() -> None:
    recording = SimulatedRecording(scene_by_name("pass_by", frames=5))
    frames = list(recording)
    np.testing.assert_array_equal(
        recording.simulate(3).depth_mm, np.rint(1000.0 * frames[3].depth_m)
    )


def test_it_is_a_recording() -> None:
    recording = SimulatedRecording(scene_by_name("wave", frames=3))
    assert isinstance(recording, Recording)
    assert (recording.name, recording.frame_count, recording.problems) == ("wave", 3, [])
    frames = list(recording)
    assert [frame.index for frame in frames] == [0, 1, 2]
    assert frames[2].timestamp_s == pytest.approx(2 / 30)


def test_larger_images_show_the_same_scene() -> None:
    full = Camera(fx=525.0, fy=525.0, cx=319.5, cy=239.5, width=640, height=480)
    small, large = (
        SimulatedRecording(scene_by_name("box", frames=1, camera=camera)).simulate(0)
        for camera in (CAMERA, full)
    )
    assert (large.mask > 0).mean() == pytest.approx((small.mask > 0).mean(), rel=0.03)
    np.testing.assert_allclose(large.truth.joints, small.truth.joints)
