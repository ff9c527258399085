"""Cameras that are live: what is dropped, what is recorded, how a run ends."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from pathlib import Path
from time import sleep

import cv2
import numpy as np
import pytest

from tiny_recordings import CAMERA, HEIGHT, WIDTH
from topview.io import open_recording
from topview.io.readers.registration import ColorCamera
from topview.live import LiveRecording, RawFrame, open_camera, registry
from topview.live.folder_writer import FolderWriter
from topview.records import Camera, Distortion, InputError
from topview_lab.sim import scene_by_name, write_scene

LENS = Distortion("brown_conrady", (0.02, -0.01, 0.001, 0.0, 0.0))


def raw(index: int, colored: bool = True) -> RawFrame:
    """A wall that comes nearer, in colours of each frame's own."""
    color = np.random.default_rng(index).integers(0, 255, (HEIGHT, WIDTH, 3), np.uint8)
    depth = np.full((HEIGHT, WIDTH), 3000 - 10 * index, np.uint16)
    return RawFrame(1000.0 + index * 0.0333333, depth, color if colored else None)


class StandIn:
    """A camera that gives these frames, each as soon as the one before is taken if it knows its
    recording; else as many as `allow` lets it."""

    name, fps, metres_per_unit = "stand-in", 30.0, 0.00025 * 4
    camera = Camera(**CAMERA, sensor="stereo", distortion=LENS)

    def __init__(self, frames: Sequence[RawFrame | Exception], allowed: int = 10_000) -> None:
        self.recording: LiveRecording | None = None
        T = np.eye(4)
        T[0, 3] = 0.05
        self.color: ColorCamera | None = ColorCamera(Camera(**CAMERA), T)
        self._frames = iter(frames)
        self._allowed = threading.Semaphore(allowed)
        self.closed = 0

    def allow(self, count: int = 1) -> None:
        self._allowed.release(count)

    def read(self) -> RawFrame | None:
        self._allowed.acquire()
        while self.recording is not None and self.recording._newest is not None:
            sleep(0.001)
        frame = next(self._frames, None)
        if isinstance(frame, Exception):
            raise frame
        return frame

    def close(self) -> None:
        self.closed += 1
        self.allow()


def paced(camera: StandIn, writer: FolderWriter | None = None) -> LiveRecording:
    """A recording that loses no frame."""
    camera.recording = LiveRecording(camera, writer)
    return camera.recording


def test_what_comes_meanwhile_is_dropped_but_for_the_newest():
    camera = StandIn([raw(index) for index in range(6)], allowed=1)
    recording = LiveRecording(camera)
    frames = iter(recording)
    first = next(frames)
    camera.allow(6)  # five frames, and the end
    while not recording._has_ended:
        sleep(0.001)
    assert [first.depth_m.max(), *(frame.depth_m.max() for frame in frames)] == pytest.approx(
        [3.0, 2.95], abs=1e-6
    )
    assert recording.dropped == 4
    assert camera.closed


def test_the_recorded_folder_gives_the_same_frames_again(tmp_path):
    given = [raw(0), raw(1, colored=False), raw(2), raw(4)]
    camera = StandIn(given)  # a frame without its colour is left out
    live = list(paced(camera, FolderWriter(tmp_path / "kept", camera)))
    again = open_recording(tmp_path / "kept")
    stored = list(again)
    assert again.camera == camera.camera
    assert len(stored) == len(live) == 3
    for one, other in zip(live, stored, strict=True):
        assert (one.index, one.timestamp_s, one.name) == (
            other.index, other.timestamp_s, other.name,
        )  # fmt: skip
        assert one.camera == other.camera
        np.testing.assert_array_equal(one.depth_m, other.depth_m)
        assert one.color is not None
        assert other.color is not None
        np.testing.assert_array_equal(one.color, other.color)


def test_a_frame_that_was_not_tracked_is_not_kept(tmp_path):
    camera = StandIn([raw(0), raw(1), raw(2)])
    recording = paced(camera, FolderWriter(tmp_path / "kept", camera))
    frames = iter(recording)
    next(frames)
    recording.note_written()
    next(frames)
    frames.close()  # pyright: ignore[reportAttributeAccessIssue] - a generator, ended in frame 1
    assert [path.name for path in (tmp_path / "kept" / "depth").iterdir()] == ["000000.png"]
    assert open_recording(tmp_path / "kept").frame_count == 1


@pytest.mark.parametrize("odd", [raw(1), raw(7, colored=False)])
def test_frames_of_no_use_are_told_and_left_out(odd):
    recording = paced(StandIn([raw(5), odd, raw(8)]))
    assert [frame.index for frame in recording] == [0, 1]
    (problem,) = recording.problems
    assert "left out" in problem


def test_a_camera_that_is_gone_is_an_error_after_its_frames(tmp_path):
    camera = StandIn([raw(0), RuntimeError("unplugged")])
    frames = iter(paced(camera))
    assert next(frames).index == 0
    with pytest.raises(InputError, match="gives no more frames: unplugged"):
        next(frames)
    assert camera.closed


@pytest.fixture
def stand_in(monkeypatch, tmp_path) -> list[StandIn]:
    """A camera before which two people pass each other."""
    room = tmp_path / "room"
    write_scene(scene_by_name("pass_by", frames=3), room)
    recording = open_recording(room)
    made: list[StandIn] = []

    def image(kind: str, index: int) -> np.ndarray:
        return np.asarray(cv2.imread(str(room / kind / f"{index:06d}.png"), cv2.IMREAD_UNCHANGED))

    def make(which: str) -> StandIn:
        images = [(image("depth", n), image("rgb", n)[..., ::-1]) for n in range(3)]
        camera = StandIn([RawFrame(5.0 + n / 30, *both) for n, both in enumerate(images)])
        camera.camera, camera.color, camera.metres_per_unit = recording.camera, None, 0.001
        made.append(camera)
        return camera

    monkeypatch.setitem(registry.LIVE_CAMERAS, "made", "topview.live.registry:LIVE_CAMERAS")
    monkeypatch.setattr(registry, "resolve_name", lambda place: make)
    return made


def test_track_a_camera_and_then_what_it_recorded(topview, stand_in, tmp_path):
    kept = tmp_path / "kept"
    ended = topview("track", "made:7", "--out", tmp_path / "live", "--record", kept)
    assert ended.status == 0
    assert "ms in the median" in ended.out
    assert stand_in[0].closed
    assert topview("track", kept, "--out", tmp_path / "again").status == 0
    live, again = (np.load(tmp_path / name / "skeletons.npz") for name in ("live", "again"))
    assert live["people_ids"].tolist() == [1, 2]
    for key in live.files:
        if key not in ("settings", "camera"):
            np.testing.assert_array_equal(live[key], again[key], err_msg=key)
    assert str(live["camera"]) == str(again["camera"])
    ended = topview("track", "made:", "--out", tmp_path / "third", "--record", kept)
    assert "is there already; record to a new folder" in ended.complaints[-1]


def test_colour_of_another_size_is_told():
    camera = StandIn([raw(0)])
    camera.color = ColorCamera(Camera(57.0, 57.0, 15.5, 11.5, 32, 24), np.eye(4))
    with pytest.raises(InputError, match="colour has 64 x 48 pixels; it must have 32 x 24"):
        list(LiveRecording(camera))


def test_a_recording_is_not_recorded_again(topview, make_recording, tmp_path):
    ended = topview("track", make_recording(), "--out", tmp_path / "o", "--record", tmp_path / "r")
    assert ended.status == 2
    assert "is a recording already" in ended.complaints[-1]


def test_another_camera_is_named():
    with pytest.raises(InputError, match="must be one of realsense:, orbbec:, oak:, ros2:"):
        open_camera("kinect:")
    assert not registry.is_camera("recordings/monday")
    assert not registry.is_camera(str(Path("C:/recordings")))
