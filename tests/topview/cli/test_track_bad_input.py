"""Everything a user may get wrong: one clear line, status 2, and nothing lost that can be read."""

from __future__ import annotations

import json
import subprocess
import sys

import cv2
import numpy as np
import pytest

from tiny_recordings import HEIGHT, WIDTH, wall

PCD_HEADER = """VERSION .7
FIELDS x y z
SIZE 4 4 4
TYPE F F F
COUNT 1 1 1
WIDTH {width}
HEIGHT {height}
VIEWPOINT 0 0 0 1 0 0 0
POINTS {points}
DATA binary
"""


def assert_refused(ended, *named):
    """One line on stderr that names all of these, and status 2."""
    assert ended.status == 2
    assert len(ended.complaints) == 1, ended.complaints
    for word in named:
        assert str(word) in ended.complaints[0]


def frames_written(out):
    with np.load(out / "skeletons.npz") as skeletons:
        return skeletons["frame_index"].tolist()


def test_missing_folder(topview, tmp_path):
    assert_refused(
        topview("track", tmp_path / "nowhere", "--out", tmp_path / "out"), tmp_path / "nowhere"
    )


def test_folder_without_depth_images(topview, tmp_path):
    assert_refused(topview("track", tmp_path, "--out", tmp_path / "out"), tmp_path, "depth")


def test_missing_camera(topview, make_recording, tmp_path):
    source = make_recording()
    (source / "camera.json").unlink()
    assert_refused(topview("track", source, "--out", tmp_path / "out"), "camera.json")


@pytest.mark.parametrize(
    ("name", "value"), [("fx", -57.0), ("fy", 0.0), ("fx", 1e9), ("cx", -9000.0), ("width", -64)]
)
def test_absurd_intrinsics(topview, make_recording, tmp_path, name, value):
    source = make_recording(**{name: value})
    ended = topview("track", source, "--out", tmp_path / "out")
    assert_refused(ended, "camera.json", name, str(value))


@pytest.mark.parametrize(
    ("told", "named"),
    [
        ({"k1": -0.2}, ["k1", "distortion"]),
        ({"dist_coeffs": [0.0] * 5}, ["dist_coeffs", "distortion"]),
        ({"distortion": {"model": "fisheye", "coefficients": [0.1] * 4}}, ["fisheye", "rational"]),
        ({"distortion": {"model": "rational", "coefficients": [0.1] * 5}}, ["5 coeff", "8"]),
        ({"sensor": "radar"}, ["sensor", "radar", "tof"]),
        ({"T_world_camera": [[1, 0, 0, 0]]}, ["T_world_camera", "4 x 4"]),
    ],
)
def test_a_lens_sensor_or_pose_that_is_not_understood(
    topview, make_recording, tmp_path, told, named
):
    ended = topview("track", make_recording(**told), "--out", tmp_path / "out")
    assert_refused(ended, "camera.json", *named)


def test_depth_of_another_size_than_the_camera(topview, make_recording, tmp_path):
    source = make_recording([np.full((30, 40), 3000, np.uint16)])
    ended = topview("track", source, "--out", tmp_path / "out")
    assert ended.status == 2
    line = ended.complaints[0]
    assert all(word in line for word in ("000000.png", "40", "30", str(WIDTH), str(HEIGHT)))


def test_8_bit_depth(topview, make_recording, tmp_path):
    source = make_recording([wall().astype(np.uint8)])
    ended = topview("track", source, "--out", tmp_path / "out")
    assert ended.status == 2
    assert "000000.png" in ended.complaints[0]
    assert "16" in ended.complaints[0]


def test_a_truncated_image_costs_only_its_own_frame(topview, make_recording, tmp_path):
    source = make_recording()
    image = source / "depth" / "000001.png"
    image.write_bytes(image.read_bytes()[:40])
    ended = topview("track", source, "--out", tmp_path / "out")
    assert "000001.png" in ended.complaints[0]
    assert any("1 of 3 frames could not be read" in line for line in ended.complaints)
    assert frames_written(tmp_path / "out") == [0, 2]


def test_frames_missing_in_the_numbering_are_named(topview, make_recording, tmp_path):
    source = make_recording([wall()] * 4)
    (source / "depth" / "000002.png").unlink()
    ended = topview("track", source, "--out", tmp_path / "out")
    assert "frame 2 is missing" in ended.complaints[0]
    assert frames_written(tmp_path / "out") == [0, 1, 3]


def test_nobody_in_view(topview, make_recording, tmp_path):
    source = make_recording()
    ended = topview("track", source, "--out", tmp_path / "out", "--pictures")
    told = "no person was found in 3 frames; readings lie from 3 to 3 m; if they do not"
    assert_refused(ended, source, told)
    assert frames_written(tmp_path / "out") == [0, 1, 2]
    assert (tmp_path / "out" / "skeletons.csv").exists()
    for name in ("contact_sheet.png", "people.png"):
        assert cv2.imread(str(tmp_path / "out" / name)) is not None


def test_a_wrong_depth_scale_is_told_with_the_range_that_was_seen(
    topview, make_recording, tmp_path
):
    ended = topview("track", make_recording(depth_scale=2e-5), "--out", tmp_path / "out")
    told = "readings lie from 0.06 to 0.06 m; people must be seen at 0.3 to 10 m"
    assert_refused(ended, told, "depth_scale is 0.001 for millimetres")


@pytest.mark.parametrize("detector", ["skin", "cascade"])
def test_a_detector_that_needs_colour_where_there_is_none(
    topview, make_recording, tmp_path, detector
):
    ended = topview("track", make_recording(), "--out", tmp_path / "out", "--detector", detector)
    assert_refused(ended, f"detector is {detector}", "no colour", "auto")


@pytest.mark.parametrize(("level", "told"), [(5, "underexposed"), (128, "grey"), (255, "overex")])
def test_colours_that_tell_nothing_are_named_once(topview, make_recording, tmp_path, level, told):
    source = make_recording()
    (source / "rgb").mkdir()
    for index in range(3):
        image = np.full((HEIGHT, WIDTH, 3), level, np.uint8)
        cv2.imwrite(str(source / "rgb" / f"{index:06d}.png"), image)
    ended = topview("track", source, "--out", tmp_path / "out", "--proposals", "none")
    lines = [line for line in ended.complaints if "colour image" in line]
    assert len(lines) == 1
    assert told in lines[0]
    assert "in 3 of 3 frames" in lines[0]
    assert frames_written(tmp_path / "out") == [0, 1, 2]


def test_frames_of_zeros(topview, make_recording, tmp_path):
    source = make_recording([wall(0)] * 2)
    ended = topview("track", source, "--out", tmp_path / "out", "--pictures")
    assert_refused(ended, "no person was found in 2 frames")


def test_truncated_mat(topview, tmp_path):
    source = tmp_path / "a1_s1_t1_depth.mat"
    source.write_bytes(b"MATLAB 5.0 MAT-file".ljust(124) + b"\x00\x01IM" + b"\x0f\x00\x00\x00")
    assert_refused(topview("track", source, "--out", tmp_path / "out"), source)


def test_truncated_mat_of_real_data(topview, shared, tmp_path):
    whole = shared / "recordings" / "utd_mhad" / "Depth" / "a1_s1_t1_depth.mat"
    if not whole.exists():
        pytest.skip(f"needs {whole}")
    source = tmp_path / whole.name
    source.write_bytes(whole.read_bytes()[:20_000])
    assert_refused(topview("track", source, "--out", tmp_path / "out"), source)


def test_truncated_pcd(topview, tmp_path):
    source = tmp_path / "cloud.pcd"
    source.write_bytes(PCD_HEADER.format(width=8, height=6, points=48).encode() + bytes(100))
    assert_refused(topview("track", source, "--out", tmp_path / "out"), source)


def test_a_pcd_of_nothing_but_nan(topview, tmp_path):
    source = tmp_path / "cloud.pcd"
    points = np.full((HEIGHT * WIDTH, 3), np.nan, np.float32)
    header = PCD_HEADER.format(width=WIDTH, height=HEIGHT, points=len(points))
    source.write_bytes(header.encode() + points.tobytes())
    assert_refused(topview("track", source, "--out", tmp_path / "out"), source)


def test_output_in_the_place_of_a_file(topview, make_recording, tmp_path):
    (tmp_path / "out").write_text("in the way")
    ended = topview("track", make_recording(), "--out", tmp_path / "out")
    assert_refused(ended, tmp_path / "out")


def test_output_that_cannot_be_made(topview, make_recording):
    assert_refused(topview("track", make_recording(), "--out", "/proc/topview"), "/proc/topview")


def test_full_disk(make_recording, tmp_path):
    """A limit on the size of files fails as a full disk does: late, while writing."""
    limited = (
        "import resource, sys\n"
        "from topview.cli.main import main\n"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))\n"
        "main(sys.argv[1:])\n"
    )
    command = ["track", str(make_recording([wall()] * 40)), "--out", str(tmp_path / "out")]
    ended = subprocess.run(
        [sys.executable, "-c", limited, *command],
        env={"NUMBA_DISABLE_JIT": "1", "PYTHONDONTWRITEBYTECODE": "1"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert ended.returncode == 2, ended.stderr
    assert ended.stderr.count("\n") == 1, ended.stderr
    assert "skeletons" in ended.stderr
    assert not list((tmp_path / "out").glob("*.npz"))


def test_settings_are_written_with_the_skeletons(topview, make_recording, tmp_path):
    topview("track", make_recording(), "--out", tmp_path, "--method", "thesis", "--seed", "7")
    with np.load(tmp_path / "skeletons.npz") as skeletons:
        written = json.loads(str(skeletons["settings"]))
    # "thesis" is another word for it.
    assert (written["method"], written["seed"], written["body"]["hypotheses"]) == ("utvr", 7, 120)


def test_a_method_that_does_not_exist_is_refused(topview, make_recording, tmp_path):
    finished = topview("track", make_recording(), "--out", tmp_path, "--method", "openpose")
    assert finished.status == 2
    (line,) = finished.complaints
    assert "method is 'openpose'; it must be one of topview, utvr, btvr," in line


def test_the_camera_with_its_lens_is_written_with_the_skeletons(topview, make_recording, tmp_path):
    lens = {"model": "brown_conrady", "coefficients": [-0.2, 0.05, 0.001, 0.002]}
    ended = topview("track", make_recording(distortion=lens, sensor="tof"), "--out", tmp_path)
    assert_refused(ended, "no person was found in 3 frames")
    with np.load(tmp_path / "skeletons.npz") as skeletons:
        written = json.loads(str(skeletons["camera"]))
        assert skeletons["frame_names"].tolist() == ["000000.png", "000001.png", "000002.png"]
    assert (written["distortion"], written["sensor"]) == (lens, "tof")


def test_nobody_looks_ahead_in_what_is_live(topview, make_recording, tmp_path):
    """A live camera, and programs that are sent each frame at once."""
    out = tmp_path / "out"
    live = topview("track", "realsense:", "--out", out, "--offline")
    assert_refused(live, "--offline realsense:", "--record")
    sent = topview(
        "track", make_recording(), "--out", out, "--offline", "--stream", "osc:127.0.0.1:9"
    )
    assert_refused(sent, "--stream osc:127.0.0.1:9", "--offline")
    assert not out.exists()
