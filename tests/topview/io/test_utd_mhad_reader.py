"""UTD-MHAD files: depth is flipped and scaled, the skeleton follows it in place and time."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.io import savemat

import topview
from topview import InputError
from topview.camera.projection import project
from topview.io.readers import read_utd_skeleton


def write_mat(path: Path, **variables: Any) -> Path:
    savemat(path, variables)
    return path


@pytest.fixture
def depth_mm() -> np.ndarray:
    return np.random.default_rng(1).integers(0, 4000, (240, 320, 3)).astype(np.uint16)


def test_depth_is_flipped_and_in_metres(tmp_path, depth_mm):
    recording = topview.open(write_mat(tmp_path / "a1_s1_t1_depth.mat", d_depth=depth_mm))
    frames = list(recording)
    assert recording.frame_count == len(frames) == 3
    assert [frame.timestamp_s for frame in frames] == [0.0, 1 / 30, 2 / 30]
    for frame in frames:
        mirrored = depth_mm[:, ::-1, frame.index]
        np.testing.assert_array_equal(frame.depth_m, (mirrored * 0.001).astype(np.float32))
    assert recording.name == "a1_s1_t1_depth"
    assert len(list(recording)) == 3


def test_readings_that_are_no_distance_become_zero(tmp_path):
    depth_mm = np.full((240, 320, 1), 1500.0)
    depth_mm[0, -3:, 0] = np.nan, np.inf, -1.0
    (frame,) = topview.open(write_mat(tmp_path / "x.mat", d_depth=depth_mm))
    np.testing.assert_array_equal(frame.depth_m[0, :4], np.array([0.0, 0.0, 0.0, 1.5], np.float32))


@pytest.mark.parametrize("read", [topview.open, read_utd_skeleton])
def test_a_mat_cut_anywhere_is_refused_in_one_line(tmp_path, read):
    rng = np.random.default_rng(2)
    whole = write_mat(
        tmp_path / "whole.mat",
        d_depth=rng.integers(0, 4000, (240, 320, 1)).astype(np.uint16),
        d_skel=rng.normal(size=(20, 3, 4)),
    ).read_bytes()
    cut = tmp_path / "cut.mat"
    lengths = [*range(0, 200, 7), *range(200, len(whole), 9973), len(whole) - 1]
    for length in lengths:
        cut.write_bytes(whole[:length])
        with pytest.raises(InputError, match=r"cut\.mat: ") as error:
            read(cut)
        assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("variables", "message"),
    [
        ({"d_skel": np.zeros((20, 3, 5))}, r"has no variable d_depth \(it has d_skel\)"),
        ({"d_depth": np.zeros((480, 640, 2))}, r"d_depth is double \(480, 640, 2\)"),
        ({"d_depth": np.zeros((240, 320))}, r"d_depth is double \(240, 320\)"),
        ({"d_depth": np.zeros((240, 320, 1), complex)}, "d_depth is complex128"),
        ({"d_depth": "text"}, "d_depth is char"),
    ],
)
def test_another_mat_is_refused(tmp_path, variables, message):
    with pytest.raises(InputError, match=rf"x\.mat: {message}.*must be"):
        topview.open(write_mat(tmp_path / "x.mat", **variables))


def test_a_matlab_7_3_file_is_refused(tmp_path):
    header = b"MATLAB 7.3 MAT-file".ljust(116) + bytes(8) + b"\x00\x02IM"
    (tmp_path / "x.mat").write_bytes(header + bytes(1000))
    with pytest.raises(InputError, match=r"x\.mat: is a MATLAB 7.3 file"):
        topview.open(tmp_path / "x.mat")


def test_the_skeleton_lags_and_is_turned_into_the_camera_frame(tmp_path):
    samples = np.zeros((20, 3, 6))
    samples[:, 0] = np.arange(6)  # x in metres grows by 1 each sample
    samples[:, 1], samples[:, 2] = 0.5, 3.0
    names, joints_camera = read_utd_skeleton(write_mat(tmp_path / "x.mat", d_skel=samples))
    assert len(names) == len(set(names)) == 20
    assert (names[0], names[5], names[15], names[19]) == (
        "head",
        "left_elbow",
        "left_foot",
        "right_foot",
    )
    assert joints_camera.shape == (6, 20, 3)
    assert np.isnan(joints_camera[:2]).all()
    for t in range(2, 6):
        np.testing.assert_allclose(joints_camera[t], np.tile((1.5 - t, -0.5, 3.0), (20, 1)))


def test_a_skeleton_shorter_than_the_lag_is_all_unknown(tmp_path):
    path = write_mat(tmp_path / "x.mat", d_skel=np.ones((20, 3, 2)))
    assert np.isnan(read_utd_skeleton(path)[1]).all()


def test_a_missing_skeleton_is_refused(tmp_path):
    with pytest.raises(InputError, match=r"gone\.mat: cannot be read: No such file"):
        read_utd_skeleton(tmp_path / "gone.mat")


@pytest.mark.parametrize("sequence", ["a1_s1_t1", "a7_s2_t1", "a22_s3_t2", "a27_s4_t1"])
def test_the_real_skeleton_lies_on_the_real_person(recordings, sequence):
    data = recordings / "utd_mhad"
    recording = topview.open(data / "Depth" / f"{sequence}_depth.mat")
    _, joints_camera = read_utd_skeleton(data / "Skeleton" / f"{sequence}_skeleton.mat")
    assert recording.frame_count == len(joints_camera)
    behind_m, on_person = [], []
    for frame in list(recording)[2:]:
        pixels = np.rint(project(joints_camera[frame.index], frame.camera)).astype(int)
        u, v = np.clip(pixels, 0, (319, 239)).T
        surface_m = frame.depth_m[v, u]
        on_person.extend(surface_m > 0)
        behind_m.extend((joints_camera[frame.index, :, 2] - surface_m)[surface_m > 0])
    assert np.mean(on_person) > 0.8
    assert 0.03 < np.median(behind_m) < 0.12  # joints lie inside the body
