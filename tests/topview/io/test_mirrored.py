"""Recordings whose images are flipped left-right, flipped back."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy.io import savemat

import topview
from lenses import LENSES, camera_with
from topview.camera import undistorted
from topview.geometry.rotations import rotations_from_vectors, transform
from topview.io import MirroredRecording
from topview.records import Camera, Frame, InputError
from topview.track import Tracker, TrackerSettings, TrackingRun, track_recording
from topview_lab.sim import scene_by_name
from topview_lab.sim.write import write_scene

FRAMES = 8
CAMERA = Camera(fx=262.5, fy=262.5, cx=150.5, cy=119.5, width=320, height=240)  # off the middle


def flip_images(folder: Path) -> None:
    """As a driver in mirror mode would have stored the recording."""
    for path in (*folder.glob("depth/*.png"), *folder.glob("rgb/*.png")):
        image = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
        assert image is not None
        cv2.imwrite(str(path), image[:, ::-1])
    camera_json = json.loads((folder / "camera.json").read_text())
    camera_json["cx"] = camera_json["width"] - 1 - camera_json["cx"]
    (folder / "camera.json").write_text(json.dumps(camera_json))


@pytest.fixture(scope="module")
def straight_and_flipped(tmp_path_factory) -> tuple[Path, Path]:
    folders = [tmp_path_factory.mktemp(name) for name in ("straight", "flipped")]
    for folder in folders:
        write_scene(scene_by_name("wave", camera=CAMERA, seed=802, frames=FRAMES), folder)
    flip_images(folders[1])
    return folders[0], folders[1]


def test_the_camera_and_every_frame_are_as_they_were_seen(straight_and_flipped):
    straight, flipped = map(topview.open, straight_and_flipped)
    mirrored = MirroredRecording(flipped)
    assert mirrored.camera == straight.camera == CAMERA
    assert (mirrored.name, mirrored.frame_count) == (flipped.name, FRAMES)
    for seen, given in zip(mirrored, straight, strict=True):
        assert (seen.index, seen.timestamp_s) == (given.index, given.timestamp_s)
        assert seen.camera == mirrored.camera
        assert_array_equal(seen.depth_m, given.depth_m)
        assert seen.color is not None
        assert given.color is not None
        assert_array_equal(seen.color, given.color)


def test_skeletons_are_the_same_bit_for_bit(straight_and_flipped):
    """So that the person's left is on the left."""
    straight, flipped = map(topview.open, straight_and_flipped)
    settings = TrackerSettings(threads=1)
    ours = track_recording(MirroredRecording(flipped), settings).skeletons
    given = track_recording(straight, settings).skeletons
    assert given.present.any()
    assert_array_equal(ours.person_ids, given.person_ids)
    assert_array_equal(ours.joints_camera, given.joints_camera)
    assert_array_equal(ours.joint_state, given.joint_state)


class One:
    """A recording of one frame."""

    name = "one"

    def __init__(self, frame: Frame) -> None:
        self._frame, self.camera = frame, frame.camera
        self.problems: list[str] = []

    @property
    def frame_count(self) -> int:
        return 1

    def __iter__(self) -> Iterator[Frame]:
        yield self._frame


def test_gravity_is_flipped_and_outlives_the_lens():
    camera = replace(camera_with(LENSES["rational"]), gravity_camera=np.array([0.6, 0.8, 0.0]))
    depth_m = np.zeros((camera.height, camera.width), np.float32)
    (mirrored,) = MirroredRecording(One(Frame(0, 0.0, depth_m, camera)))
    assert undistorted(mirrored).camera.gravity_camera == pytest.approx([-0.6, 0.8, 0.0])


@pytest.mark.parametrize("lens", LENSES.values(), ids=list(LENSES))
def test_to_mirror_and_to_undistort_may_change_places(lens):
    rng = np.random.default_rng(3)
    depth_m = rng.uniform(0.5, 4.0, (240, 320)).astype(np.float32)
    color = rng.integers(0, 256, (240, 320, 3), np.uint8)
    frame = Frame(0, 0.0, depth_m, camera_with(lens), color)
    (mirrored,) = MirroredRecording(One(frame))
    (after,) = MirroredRecording(One(undistorted(frame)))
    before = undistorted(mirrored)
    assert replace(before.camera, cx=0.0) == replace(after.camera, cx=0.0)
    assert before.camera.cx == pytest.approx(after.camera.cx, abs=1e-9)
    assert_array_equal(before.depth_m, after.depth_m)
    assert before.color is not None
    assert after.color is not None
    # Places are rounded to 1/32 pixel.
    assert np.abs(before.color.astype(int) - after.color).mean() < 1.0


def test_a_pose_is_mirrored_with_the_world_that_it_is_in():
    T = transform(rotations_from_vectors(np.array([0.3, -0.5, 0.2])), np.array([1.0, -2.0, 0.5]))
    frame = Frame(0, 0.0, np.ones((240, 320), np.float32), camera_with(None, T_world_camera=T))
    mirrored = MirroredRecording(One(frame))
    point, flip = np.array([0.4, -0.2, 2.0, 1.0]), np.diag([-1.0, 1.0, 1.0, 1.0])
    assert mirrored.camera.T_world_camera is not None
    assert_allclose(mirrored.camera.T_world_camera @ (flip @ point), flip @ (T @ point))
    assert MirroredRecording(mirrored).camera == frame.camera


def test_what_cannot_be_read_is_named(straight_and_flipped, tmp_path):
    camera = json.loads((straight_and_flipped[1] / "camera.json").read_text())
    (tmp_path / "depth").mkdir()
    (tmp_path / "depth" / "000000.png").write_bytes(b"")
    (tmp_path / "camera.json").write_text(json.dumps(camera))
    mirrored = MirroredRecording(topview.open(tmp_path))
    assert list(mirrored) == []
    assert mirrored.problems == ["depth/000000.png: is empty (0 bytes); it must be a PNG image"]


def test_what_its_reader_flips_back_is_refused(tmp_path):
    wall = np.full((240, 320, 1), 3000, np.uint16)
    savemat(tmp_path / "a1_s1_t1_depth.mat", {"d_depth": wall})
    with pytest.raises(InputError, match="--mirrored: a1_s1_t1_depth is flipped back by its read"):
        MirroredRecording(topview.open(tmp_path / "a1_s1_t1_depth.mat"))


def test_the_settings_of_a_run_say_so():
    one = One(Frame(0, 0.0, np.ones((240, 320), np.float32), CAMERA))
    assert TrackingRun(MirroredRecording(one), Tracker()).about.settings["mirrored"] is True
    assert "mirrored" not in TrackingRun(one, Tracker()).about.settings
