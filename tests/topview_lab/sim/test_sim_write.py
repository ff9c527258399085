"""Simulated folders: the layout, the truth's keys, and what the command says."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np
import pytest
from cyclopts import App, CycloptsError

from topview.records import InputError
from topview_lab.cli.simulate import simulate
from topview_lab.sim import SimulatedRecording, scene_by_name, simulate_truth, write_scene
from topview_lab.sim.bodies import SIM_PART_NAMES


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("scene") / "new" / "pass_by"
    done: list[int] = []
    write_scene(scene_by_name("pass_by", seed=3, frames=4), folder, on_frame=done.append)
    assert done == [0, 1, 2, 3]
    return folder


def test_images_are_those_of_the_recording(folder: Path) -> None:
    recording = SimulatedRecording(scene_by_name("pass_by", seed=3, frames=4))
    for index in range(4):
        frame = recording.simulate(index)
        depth, rgb, mask, part = (
            cv2.imread(str(folder / kind / f"{index:06d}.png"), cv2.IMREAD_UNCHANGED)
            for kind in ("depth", "rgb", "mask", "part")
        )
        assert depth is not None
        assert rgb is not None
        assert depth.dtype == np.uint16
        np.testing.assert_array_equal(depth, frame.depth_mm)
        np.testing.assert_array_equal(rgb[..., ::-1], frame.color)
        np.testing.assert_array_equal(mask, frame.mask)
        np.testing.assert_array_equal(part, frame.part)
        np.testing.assert_array_equal(frame.part > 0, frame.mask > 0)
        assert frame.part.max() <= len(SIM_PART_NAMES)
        assert len(np.unique(frame.part)) > 10
        assert set(np.unique(frame.mask)) == {0, 1, 2}


def test_the_camera_is_a_kinect_at_half_resolution(folder: Path) -> None:
    camera = json.loads((folder / "camera.json").read_text())
    assert camera == {
        "fx": 262.5, "fy": 262.5, "cx": 159.5, "cy": 119.5, "width": 320, "height": 240,
        "depth_scale": 0.001, "fps": 30.0,
    }  # fmt: skip


def test_the_truth_on_disk_is_that_of_the_scene(folder: Path) -> None:
    truth = simulate_truth(scene_by_name("pass_by", seed=3, frames=4))
    with np.load(folder / "groundtruth.npz") as stored:
        assert set(stored.files) == set(truth.arrays())
        for name, array in truth.arrays().items():
            np.testing.assert_array_equal(stored[name], array)


def test_the_truth_has_the_keys_of_the_rendered_recordings(folder: Path, shared: Path) -> None:
    bench = np.load(shared / "bench" / "b1_pass_by" / "groundtruth.npz")
    stored = np.load(folder / "groundtruth.npz")
    assert list(stored["names"]) == list(bench["names"])
    shared_keys = set(bench.files) - {"characters"}
    assert shared_keys <= set(stored.files)
    for name in shared_keys:
        assert stored[name].dtype == bench[name].dtype, name
        assert stored[name].shape[1:] == bench[name].shape[1:], name


def test_the_command_writes_a_recording(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    simulate("wave", out=tmp_path / "out", people=2, seed=4, frames=2)
    assert "2 frames with 2 people" in capsys.readouterr().out
    assert len(list((tmp_path / "out" / "depth").glob("*.png"))) == 2
    assert np.load(tmp_path / "out" / "groundtruth.npz")["joints"].shape == (2, 2, 21, 3)


def test_files_do_not_depend_on_the_number_of_threads(folder: Path, tmp_path: Path) -> None:
    for threads in (1, 3):
        write_scene(
            scene_by_name("pass_by", seed=3, frames=4), tmp_path, threads=threads, force=True
        )
        for path in folder.rglob("*.*"):
            written = tmp_path / path.relative_to(folder)
            if path.suffix != ".npz":  # which tells the time
                assert written.read_bytes() == path.read_bytes(), path
        with (
            np.load(tmp_path / "groundtruth.npz") as truth,
            np.load(folder / "groundtruth.npz") as other,
        ):
            for name in other.files:
                np.testing.assert_array_equal(truth[name], other[name])


def test_the_command_writes_images_of_the_size_that_is_asked_for(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    simulate("stand", out=tmp_path, frames=1, size="640x480")
    assert json.loads((tmp_path / "camera.json").read_text())["fx"] == 525.0
    image = cv2.imread(str(tmp_path / "depth" / "000000.png"), cv2.IMREAD_UNCHANGED)
    assert image is not None
    assert image.shape == (480, 640)
    assert "1 frames with 1 people" in capsys.readouterr().out


def test_a_size_that_the_camera_does_not_have_is_refused(tmp_path: Path) -> None:
    app = App(exit_on_error=False, print_error=False)
    app.default(simulate)
    with pytest.raises(CycloptsError, match=r'"100x100".*--size.*"320x240", "640x480"'):
        app(["stand", "--out", str(tmp_path), "--size", "100x100"])


def test_a_folder_that_cannot_be_made_is_named(tmp_path: Path) -> None:
    blocking = tmp_path / "file"
    blocking.write_text("in the way")
    with pytest.raises(InputError, match=r"file.*must be one that can be written to"):
        write_scene(scene_by_name("stand", frames=1), blocking)
