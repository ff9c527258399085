"""`camera.json`: lens, sensor and pose, and every key that seems to tell of a lens."""

from __future__ import annotations

import json

import numpy as np
import pytest

import topview
from lenses import LENSES, camera_with
from topview.io.camera_values import camera_from, camera_values
from topview.io.readers.camera_json import read_camera_json
from topview.records import Distortion, InputError

LENS = {"model": "brown_conrady", "coefficients": [0.1, -0.2, 0.001, 0.002, 0.05]}
COLOR = {
    "fx": 18.0, "fy": 19.0, "cx": 7.0, "cy": 5.0, "width": 16, "height": 12,
    "T_color_depth": np.eye(4).tolist(),
}  # fmt: skip


def test_what_is_given_is_read(write_folder):
    T = [[0, -1, 0, 1.5], [1, 0, 0, 0], [0, 0, 1, -2], [0, 0, 0, 1]]
    root = write_folder(
        distortion=LENS, sensor="tof", T_world_camera=T, color_camera=1, note="depth and lamps"
    )
    camera = read_camera_json(root / "camera.json").camera
    assert camera.distortion == Distortion("brown_conrady", (0.1, -0.2, 0.001, 0.002, 0.05))
    assert camera.sensor == "tof"
    assert camera.T_world_camera is not None
    assert camera.T_world_camera.tolist() == T


def test_without_them_it_is_a_kinect_without_a_lens_anywhere(write_folder):
    camera = topview.open(write_folder()).camera
    assert (camera.distortion, camera.sensor, camera.T_world_camera) == (None, "kinect1", None)


def test_the_colour_camera_has_a_lens_of_its_own(write_folder):
    root = write_folder(distortion=LENS)
    values = json.loads((root / "camera.json").read_text())
    rational = {"model": "rational", "coefficients": [0.1] * 8}
    values["color"] = {**COLOR, "distortion": rational}
    (root / "camera.json").write_text(json.dumps(values))
    file = read_camera_json(root / "camera.json")
    assert file.color is not None
    assert file.color.camera.distortion == Distortion("rational", (0.1,) * 8)
    assert file.camera.distortion == Distortion("brown_conrady", tuple(LENS["coefficients"]))


@pytest.mark.parametrize("lens", [None, Distortion("none"), *LENSES.values()])
def test_a_camera_in_words_is_the_same_camera(lens):
    T = np.eye(4)
    T[0, 3] = 0.1 + 0.2
    camera = camera_with(lens, sensor="stereo", T_world_camera=T)
    assert camera_from(json.loads(json.dumps(camera_values(camera)))) == camera


@pytest.mark.parametrize(
    "key",
    ["k1", "K3", "p2", "dist_coeffs", "distCoeffs", "distortion_model", "Distortion", "radial",
     "tangential_distortion", "lens", "lens_model", "coeffs", "D", "kc", "codx", "metric_radius",
     "undistorted", "fisheye"],
)  # fmt: skip
@pytest.mark.parametrize("where", ["", "color"])
def test_a_key_like_a_lens_that_is_not_known_is_refused_in_one_line(write_folder, key, where):
    told = {key: [0.1]}
    root = write_folder(**({} if where else told))
    if where:
        values = json.loads((root / "camera.json").read_text())
        values["color"] = {**COLOR, **told}
        (root / "camera.json").write_text(json.dumps(values))
    with pytest.raises(InputError, match=rf"camera\.json.*: {key} seems to tell of the lens") as e:
        topview.open(root)
    assert "\n" not in str(e.value)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"distortion": None}, "distortion is null; it must be"),
        ({"distortion": [0.1, 0.2, 0.0, 0.0]}, r"distortion is \[0.1, 0.2, 0.0, 0.0\]; it must"),
        ({"distortion": {"model": "plumb_bob", "coefficients": [0.0] * 5}}, "'plumb_bob'; it must"),
        ({"distortion": {"coefficients": [0.0] * 5}}, "distortion is .*; it must be"),
        ({"distortion": {"model": "rational", "coefficients": [0.0] * 5}}, "5 coefficients; it"),
        ({"distortion": {"model": "rational", "coefficients": "k1"}}, "distortion is .*k1"),
        ({"distortion": {**LENS, "centre": [0, 0]}}, "distortion is .*centre"),
        ({"distortion": {**LENS, "coefficients": [0.1, True, 0, 0]}}, "distortion is .*true"),
        ({"sensor": "lidar"}, "sensor is 'lidar'; it must be one of kinect1, tof, stereo"),
        ({"sensor": ["tof"]}, r"sensor is \['tof'\]; it must be one of"),
        ({"T_world_camera": np.eye(3).tolist()}, "T_world_camera must be 4 x 4 numbers"),
        ({"T_world_camera": np.diag([1, 1, -1, 1]).tolist()}, "T_world_camera is no rotation"),
    ],
)
def test_what_cannot_be_is_refused_in_one_line(write_folder, given, message):
    root = write_folder(**given)
    with pytest.raises(InputError, match=rf"camera\.json: .*{message}") as error:
        topview.open(root)
    assert "\n" not in str(error.value)
