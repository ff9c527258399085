"""What skeletons keep of the recording that they come from."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

import topview
from topview.track.run import track_recording
from topview_lab.sim import scene_by_name


def test_camera_names_floor_and_version(wave_folder: Path) -> None:
    recording = topview.open(wave_folder)
    skeletons = track_recording(recording).skeletons
    assert skeletons.camera == recording.camera
    assert skeletons.frame_names == tuple(f"{k:06d}.png" for k in range(15))
    assert skeletons.topview_version
    assert json.loads(json.dumps(skeletons.settings))["recording"] == recording.name
    mount = scene_by_name("wave", seed=2, frames=15).mount
    normal, height_m = skeletons.floor_camera[:3], skeletons.floor_camera[3]
    up = mount.T_camera_room()[:3, 2]
    assert normal @ up > np.cos(np.radians(1.0))
    assert abs(height_m - mount.height_m) < 0.03
    np.testing.assert_array_equal(skeletons.gravity_camera, -normal)


def test_without_a_floor_nothing_is_down() -> None:
    class Wall:
        name, problems = "wall", []
        camera = topview.Camera(262.5, 262.5, 159.5, 119.5, 320, 240)

        @property
        def frame_count(self) -> int:
            return 2

        def __iter__(self):
            for k in range(2):
                depth_m = np.full((240, 320), 3.0, np.float32)
                yield topview.Frame(k, k / 30, depth_m, self.camera)

    skeletons = track_recording(Wall()).skeletons
    assert np.isnan(skeletons.floor_camera).all()
    assert np.isnan(skeletons.gravity_camera).all()
    assert skeletons.frame_names == ("0", "1")
