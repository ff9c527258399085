"""`simulate` into a folder that holds something: never a mixture of two recordings."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest


def files(folder: Path) -> dict[str, bytes]:
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in folder.rglob("*")
        if path.is_file() and path.suffix != ".npz"  # which tells the time
    }


def test_older_frames_are_refused_and_force_replaces_them(topview, tmp_path: Path) -> None:
    old, new = tmp_path / "old", tmp_path / "new"
    assert topview("simulate", "stand", "--out", old, "--frames", "3").status == 0
    assert topview("simulate", "stand", "--out", new, "--frames", "2", "--seed", "1").status == 0
    before = files(old)
    refused = topview("simulate", "stand", "--out", old, "--frames", "2", "--seed", "1")
    assert refused.status == 2
    assert len(refused.complaints) == 1
    assert "is there already; --force replaces the recording" in refused.complaints[0]
    assert files(old) == before
    forced = topview("simulate", "stand", "--out", old, "--frames", "2", "--seed", "1", "--force")
    assert forced.status == 0
    assert files(old) == files(new)
    assert len(np.load(old / "groundtruth.npz")["joints"]) == 2


@pytest.mark.parametrize("force", [(), ("--force",)])
def test_what_no_simulation_wrote_stays(topview, tmp_path: Path, force: tuple[str, ...]) -> None:
    own = tmp_path / "rgb" / "1305031102.933333.png"
    own.parent.mkdir()
    own.write_bytes(b"somebody's")
    refused = topview("simulate", "stand", "--out", tmp_path, "--frames", "1", *force)
    assert refused.status == 2
    assert "is no simulated frame" in refused.complaints[0]
    assert own.read_bytes() == b"somebody's"
    assert not (tmp_path / "depth").exists()


def test_marked_recordings_are_refused_before_one_is_written(topview, tmp_path: Path) -> None:
    (tmp_path / "rear" / "depth").mkdir(parents=True)
    (tmp_path / "rear" / "depth" / "000000.png").write_bytes(b"older")
    refused = topview("simulate", "markers", "--out", tmp_path, "--frames", "1")
    assert refused.status == 2
    assert "000000.png: is there already" in refused.complaints[0]
    assert not (tmp_path / "front").exists()


@pytest.mark.parametrize("scene", ["markers:", "markers: ", "markers::", ":", "", "stand:"])
def test_empty_parts_of_a_scene_are_refused(topview, tmp_path: Path, scene: str) -> None:
    refused = topview("simulate", scene, "--out", tmp_path / "out", "--frames", "1")
    assert refused.status == 2
    assert len(refused.complaints) == 1
    assert f"scene {scene!r} is not known" in refused.complaints[0]
    assert "pass_by" in refused.complaints[0]
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    "arguments",
    [
        ("bench", "--frames", "1", "--json"),
        ("evaluate", "simulated", "stand", "--frames", "1", "--workers", "1", "--json"),
        ("train-forest", "--images", "1", "--out"),
        ("train-skin", "--simulated", "--out"),
        ("train-hands", "--simulated", "--out"),
    ],
)
def test_a_file_that_is_there_is_replaced_by_force_alone(
    topview, tmp_path: Path, arguments: tuple[str, ...]
) -> None:
    file = tmp_path / "result"
    file.write_bytes(b"of another day")
    refused = topview(*arguments, file)
    assert refused.status == 2
    assert refused.complaints == [
        f"topview: {arguments[-1]} {file}: is there already; --force replaces it"
    ]
    assert file.read_bytes() == b"of another day"
    assert topview(*arguments, tmp_path).status == 2
    assert topview(*arguments, "/dev/null", "--force").status == 2
