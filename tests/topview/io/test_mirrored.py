"""Recordings whose images are flipped left-right, flipped back."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import pytest
from numpy.testing import assert_array_equal

import topview
from topview.io import MirroredRecording
from topview.records import Camera
from topview.track import TrackerSettings, track_recording
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
    assert (mirrored.name, len(mirrored)) == (flipped.name, FRAMES)
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


def test_what_cannot_be_read_is_named(straight_and_flipped, tmp_path):
    camera = json.loads((straight_and_flipped[1] / "camera.json").read_text())
    (tmp_path / "depth").mkdir()
    (tmp_path / "depth" / "000000.png").write_bytes(b"")
    (tmp_path / "camera.json").write_text(json.dumps(camera))
    mirrored = MirroredRecording(topview.open(tmp_path))
    assert list(mirrored) == []
    assert mirrored.problems == ["depth/000000.png: is empty (0 bytes); it must be a PNG image"]
