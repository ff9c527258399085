"""A camera that moves ends the tracking; one that stands still does not, whatever goes on before
it. Nobody's pixels are taken away here, so that whoever moves is taken for the room."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from math import exp, radians, sin

import numpy as np
import pytest
from numpy.typing import NDArray

from topview.camera.pyramid import Pyramid
from topview.records import SENSOR_NOISE, Camera, Frame, InputError, SensorName
from topview.room.camera_motion import LOOK_EVERY_S, CameraMotion, Shift
from topview.track import Tracker, TrackerSettings
from topview_lab.sim.recording import SimulatedRecording
from topview_lab.sim.scene import Box, Scene
from topview_lab.sim.scenes import scene_by_name

CAMERA = Camera(fx=65.625, fy=65.625, cx=39.5, cy=29.5, width=80, height=60)
Depth = NDArray[np.float32]
Change = Callable[[Scene, float], Scene]
LOOKS = 11


def moved(
    scene: Scene, pan_deg: float = 0.0, tilt_deg: float = 0.0, forward_m: float = 0.0
) -> Scene:
    mount = scene.mount
    x, y = mount.position_room
    there = replace(
        mount,
        heading_rad=mount.heading_rad + radians(pan_deg),
        tilt_rad=mount.tilt_rad + radians(tilt_deg),
        position_room=(x, y + forward_m),
    )
    return replace(scene, mount=there)


def depths_of(
    name: str, change: Change = lambda scene, _: scene, looks: int = LOOKS
) -> list[Depth]:
    """Looks at a scene that changes with the time."""
    scene = scene_by_name(name, seed=1, camera=CAMERA)
    depths_m = []
    for time_s in (LOOK_EVERY_S * np.arange(looks)).tolist():
        seen = SimulatedRecording(change(scene, time_s)).simulate(round(time_s * scene.fps))
        depths_m.append((seen.depth_mm / 1000.0).astype(np.float32))
    return depths_m


def frames_of(depths_m: Sequence[Depth], camera: Camera = CAMERA) -> list[Frame]:
    return [
        Frame(index, index * LOOK_EVERY_S, depth_m, camera)
        for index, depth_m in enumerate(depths_m)
    ]


def shift_in(frames: Sequence[Frame]) -> Shift | None:
    """The last that is told."""
    motion = CameraMotion()
    nobodys = np.zeros((CAMERA.height, CAMERA.width), np.int32)
    told = [motion.update(Pyramid(frame), nobodys) for frame in frames]
    return next((shift for shift in reversed(told) if shift is not None), None)


def track(tracker: Tracker, frames: Sequence[Frame]) -> None:
    for frame in frames:
        tracker.update(frame)


@pytest.fixture(scope="module")
def room() -> Depth:
    return depths_of("walk", looks=1)[0]


@pytest.fixture(scope="module")
def panned() -> list[Frame]:
    """5 degrees a second."""
    return frames_of(depths_of("enter_and_leave", lambda scene, t: moved(scene, pan_deg=5 * t)))


def test_a_pan_is_told_of_as_large_as_it_is(panned: list[Frame]) -> None:
    shift = shift_in(panned)
    assert shift is not None
    assert shift.turn_rad == pytest.approx(radians(5 * shift.elapsed_s), rel=0.2)


@pytest.mark.parametrize("way", [{"tilt_deg": 5.0}, {"forward_m": 0.3}])
def test_a_tilt_and_a_way_forward_are_told_of(way: dict[str, float]) -> None:
    def change(scene: Scene, time_s: float) -> Scene:
        return moved(scene, **{name: rate * time_s for name, rate in way.items()})

    shift = shift_in(frames_of(depths_of("walk", change)))
    assert shift is not None
    assert shift.turn_rad == pytest.approx(
        radians(way.get("tilt_deg", 0.0)) * shift.elapsed_s, abs=radians(0.5)
    )
    assert shift.way_m == pytest.approx(way.get("forward_m", 0.0) * shift.elapsed_s, abs=0.04)


@pytest.mark.parametrize("name", ["crossing", "hug", "four_users"])
def test_people_who_move_are_no_camera_that_moves(name: str) -> None:
    assert shift_in(frames_of(depths_of(name))) is None


def shaken(scene: Scene, time_s: float) -> Scene:
    """By 3 degrees, three times a second, for a moment."""
    return moved(scene, pan_deg=3.0 * exp(-time_s / 0.4) * sin(2 * np.pi * 3.1 * time_s))


def pushed(scene: Scene, time_s: float) -> Scene:
    """A sofa comes nearer."""
    sofa = Box((0.0, 4.0 - 0.4 * time_s, 0.45), (2.4, 0.9, 0.9), (0.5, 0.5, 0.5))
    return replace(scene, furniture=(*scene.furniture, sofa))


@pytest.mark.parametrize("change", [shaken, pushed])
def test_a_tripod_that_shakes_and_a_sofa_that_is_moved_end_nothing(change: Change) -> None:
    assert shift_in(frames_of(depths_of("walk", change))) is None


def test_somebody_who_fills_the_picture_ends_nothing(room: Depth) -> None:
    near_m = np.linspace(3.0, 0.6, LOOKS, dtype=np.float32)
    columns = np.abs(np.arange(CAMERA.width) - CAMERA.cx)
    come = [np.where(columns < 30.0 / z, np.minimum(room, z), room) for z in near_m]
    assert shift_in(frames_of(come)) is None


@pytest.mark.parametrize("sensor", SENSOR_NOISE)
def test_noise_is_no_motion(sensor: SensorName, room: Depth) -> None:
    rng = np.random.default_rng(1)
    camera = replace(CAMERA, sensor=sensor)
    sigma_m = camera.noise.sigma_m(room)
    noisy = [(room + rng.normal(0.0, sigma_m)).astype(np.float32) for _ in range(LOOKS)]
    assert shift_in(frames_of(noisy, camera)) is None


def test_the_tracker_ends_with_one_line_unless_told_to_go_on(panned: list[Frame]) -> None:
    refusing = Tracker(TrackerSettings(proposals="none", threads=1))
    with pytest.raises(InputError, match=r"frame \d+: the camera moves.* must stand still"):
        track(refusing, panned)
    settings = TrackerSettings(proposals="none", threads=1, moving_camera=True)
    track(Tracker(settings), panned)
    assert settings.as_json()["moving_camera"] is True
