"""Fixtures that every room's tests share: recordings, and the command line in this process."""

from __future__ import annotations

import json
import os
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import hypothesis
import pytest
from numpy.typing import NDArray

from tiny_recordings import CAMERA, wall
from topview.cli.main import main
from topview.kernels.compiling import compile_ahead

ROOT = Path(__file__).resolve().parents[1]

# No example has a time limit: a busy machine is no failure. Random examples for a developer, the
# same ones on every run where CI is set (`.ci/run` sets it).
_UNTIMED = hypothesis.settings(
    deadline=None, suppress_health_check=[hypothesis.HealthCheck.too_slow]
)
hypothesis.settings.register_profile("developer", _UNTIMED)
hypothesis.settings.register_profile("repeatable", _UNTIMED, derandomize=True, print_blob=True)
hypothesis.settings.load_profile("repeatable" if os.environ.get("CI") else "developer")


def pytest_sessionstart() -> None:
    """Of several processes of tests one compiles; numba's cache of a kernel is for one writer.
    What test files do as they are collected calls kernels, too."""
    if "PYTEST_XDIST_WORKER" in os.environ:
        compile_ahead()


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Files with slow tests come first, so that of several processes, each of which takes whole
    files, none is left alone with them at the end."""
    slow = {item.path for item in items if item.get_closest_marker("slow")}
    items.sort(key=lambda item: item.path not in slow)


@pytest.fixture(scope="session")
def shared() -> Path:
    """The folder beside the project with recordings that are not part of it."""
    folder = ROOT.parent / "shared"
    if not folder.is_dir():
        pytest.skip(f"needs the recordings in {folder}, which are not part of the project")
    return folder


MakeRecording = Callable[..., Path]


@dataclass(frozen=True)
class Finished:
    """A command that has ended."""

    status: int
    out: str
    complaints: list[str]


RunCommand = Callable[..., Finished]


@pytest.fixture(scope="session")
def compiled() -> None:
    """The tracker's kernels, so that no command says that it compiles them."""
    compile_ahead()


@pytest.fixture
def topview(capsys: pytest.CaptureFixture[str], compiled: None) -> RunCommand:
    """Run `topview` with these arguments; stderr may hold only lines that begin with its name."""

    def run(*arguments: object) -> Finished:
        # A user would see a warning on stderr.
        with warnings.catch_warnings(action="error"), pytest.raises(SystemExit) as ended:
            main([str(argument) for argument in arguments])
        printed = capsys.readouterr()
        complaints = printed.err.splitlines()
        assert all(line.startswith("topview: ") for line in complaints), printed.err
        return Finished(int(ended.value.code or 0), printed.out, complaints)

    return run


@pytest.fixture
def make_recording(tmp_path: Path) -> MakeRecording:
    def make(depths_mm: Sequence[NDArray[Any]] | None = None, **camera: Any) -> Path:
        """A folder recording, by default three frames of a bare wall at 3 m."""
        folder = tmp_path / "recording"
        (folder / "depth").mkdir(parents=True)
        (folder / "camera.json").write_text(json.dumps(CAMERA | {"depth_scale": 0.001} | camera))
        for index, depth_mm in enumerate(depths_mm if depths_mm is not None else [wall()] * 3):
            cv2.imwrite(str(folder / "depth" / f"{index:06d}.png"), depth_mm)
        return folder

    return make
