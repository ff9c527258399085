"""Every command of the documents runs, but for the demo and data sets that are not there."""

from __future__ import annotations

import shlex
import shutil
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import pytest

import topview as library
from documented import COMMANDS
from moving_bodies import STATURES_M, moving_people
from tiny_recordings import CAMERA, wall
from topview.batch.job import do
from topview.cli import batch, track, view
from topview.live import RawFrame, registry
from topview.view.rerun_server import free_port
from topview_lab.sim import scene_by_name, write_scene

# `demo` has a test of its own (test_demo.py), and another as a wheel.
RUN = sorted({command for _, command in COMMANDS if not command.endswith((" PATH", "demo"))})
NEEDED = {
    "view": "rerun",
    "websocket": "websockets",
    "osc": "pythonosc",
    ".glb": "pygltflib",
    "c3d": "ezc3d",
    ".mp4": "av",
    "--video": "av",
}


class StandIn:
    """A live camera that gives two frames of a wall."""

    name, fps, metres_per_unit, color = "stand-in", 30.0, 0.001, None
    camera = library.Camera(**CAMERA)

    def __init__(self, which: str) -> None:
        self._frames = iter([RawFrame(0.1 * n, wall()) for n in range(2)])

    def read(self) -> RawFrame | None:
        return next(self._frames, None)

    def close(self) -> None: ...


@pytest.fixture(scope="module")
def room(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two frames of the simulated scene that the documents track."""
    folder = tmp_path_factory.mktemp("simulated") / "room"
    write_scene(scene_by_name("pass_by", frames=2), folder)
    return folder


@pytest.fixture
def at_work(make_recording: Callable[..., Path], room: Path, monkeypatch: Any) -> None:
    """Where a reader of the documents is: recordings and a result are there. No viewer waits, a
    camera gives a wall, batches stay in this process."""
    recording = make_recording([wall()] * 5)
    monkeypatch.chdir(recording.parent)
    for name in ("my_recording", "kept", "recordings/monday"):
        shutil.copytree(recording, name)
    shutil.copytree(room, "room")
    Path("list.txt").write_text("room\n")
    Path("results").mkdir()
    monkeypatch.setitem(STATURES_M, 2, 1.7)
    people = moving_people({0.0: [1], 0.1: [1, 2], 0.2: [2]})
    library.write_skeletons(people, "results/skeletons.npz")
    for module in (view, track):
        monkeypatch.setattr(module, "tell_address", lambda viewer: None)
        monkeypatch.setattr(module, "wait_for_end", lambda: None)
    monkeypatch.setattr(registry, "resolve_name", lambda place: StandIn)
    monkeypatch.setattr(batch, "scheduler_named", lambda *_: partial(map, do))


@pytest.mark.parametrize("command", RUN)
def test_every_command_runs(command: str, topview: Callable[..., Any], at_work: None) -> None:
    for word, module in NEEDED.items():
        if word in command:
            pytest.importorskip(module, exc_type=ImportError)
    words = shlex.split(command.replace("8765", str(free_port())))
    if "--record" in words:
        shutil.rmtree("kept")
    if words[0] in ("track", "batch"):
        shutil.rmtree("results")
    if words[0] == "simulate":
        words += ["--frames", "2"]
        shutil.rmtree("room")
    ended = topview(*words)
    nobody = words[0] == "track" and "room" not in words  # a wall
    assert (ended.status, "no person was found" in str(ended.complaints)) == (2 * nobody, nobody)
