"""Whatever ends a run, what was tracked is written, and an older result is not harmed."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from patience import HANGS_S
from tiny_recordings import wall
from topview.cli import results
from topview.records import InputError
from topview.track import Tracker


def frames_in(out: Path) -> list[int]:
    with np.load(out / "skeletons.npz") as skeletons:
        return skeletons["frame_index"].tolist()


def failing_at(frame_index: int, error: BaseException):
    update = Tracker.update

    def updated(self, frame):
        if frame.index == frame_index:
            raise error
        return update(self, frame)

    return updated


def test_a_bug_of_ours_costs_no_frame_and_asks_for_a_report(
    topview, make_recording, tmp_path, monkeypatch
):
    monkeypatch.setattr(Tracker, "update", failing_at(2, ZeroDivisionError("an odd number")))
    ended = topview("track", make_recording([wall()] * 4), "--out", tmp_path / "out")
    assert ended.status == 1
    assert frames_in(tmp_path / "out") == [0, 1]
    assert (tmp_path / "out" / "skeletons.csv").exists()
    kept, bug = ended.complaints
    assert "the 2 frames tracked so far are kept" in kept
    assert "ZeroDivisionError: an odd number" in bug
    assert "report" in bug
    assert "in updated" in Path(bug.split()[-1]).read_text()
    Path(bug.split()[-1]).unlink()


@pytest.mark.parametrize("error", [InputError("the camera has changed"), MemoryError("12 GB")])
def test_another_error_costs_no_frame_either(topview, make_recording, tmp_path, monkeypatch, error):
    monkeypatch.setattr(Tracker, "update", failing_at(3, error))
    ended = topview("track", make_recording([wall()] * 4), "--out", tmp_path / "out")
    assert ended.status == 2
    assert frames_in(tmp_path / "out") == [0, 1, 2]
    assert str(error) in ended.complaints[-1]


def test_an_error_in_the_first_frame_writes_nothing(topview, make_recording, tmp_path, monkeypatch):
    monkeypatch.setattr(Tracker, "update", failing_at(0, MemoryError("12 GB")))
    ended = topview("track", make_recording(), "--out", tmp_path / "out")
    assert ended.status == 2
    assert list((tmp_path / "out").iterdir()) == []


def test_a_result_is_replaced_only_by_force(topview, make_recording, tmp_path):
    out, source = tmp_path / "out", make_recording([wall()] * 3)
    topview("track", source, "--out", out)
    before = (out / "skeletons.npz").read_bytes()
    (source / "depth" / "000002.png").unlink()
    ended = topview("track", source, "--out", out)
    assert ended.status == 2
    assert len(ended.complaints) == 1
    assert "--force" in ended.complaints[0]
    assert "skeletons.npz" in ended.complaints[0]
    assert (out / "skeletons.npz").read_bytes() == before
    topview("track", source, "--out", out, "--force")
    assert frames_in(out) == [0, 1]


def test_a_run_that_tracked_nothing_leaves_the_older_result(
    topview, make_recording, tmp_path, monkeypatch
):
    out, source = tmp_path / "out", make_recording([wall()] * 3)
    topview("track", source, "--out", out)
    before = (out / "skeletons.npz").read_bytes()
    monkeypatch.setattr(Tracker, "update", failing_at(0, KeyboardInterrupt()))
    ended = topview("track", source, "--out", out, "--force")
    assert ended.status == 130
    assert (out / "skeletons.npz").read_bytes() == before


def test_a_file_that_cannot_be_written_does_not_cost_the_others(
    topview, make_recording, tmp_path, monkeypatch
):
    def full(*_):
        raise InputError("no space left")

    monkeypatch.setattr(results, "write_skeletons_npz", full)
    ended = topview("track", make_recording(), "--out", tmp_path / "out")
    assert ended.status == 2
    assert "no space left" in ended.complaints[-1]
    assert (tmp_path / "out" / "skeletons.csv").exists()


def test_a_frame_number_that_no_result_can_hold_is_left_out(topview, make_recording, tmp_path):
    source = make_recording([wall()] * 3)
    (source / "depth" / "000001.png").rename(source / "depth" / f"{2**63}.png")
    ended = topview("track", source, "--out", tmp_path / "out")
    assert any(str(2**63) in line for line in ended.complaints)
    assert frames_in(tmp_path / "out") == [0, 2]


# What a shell starts in the background ignores SIGINT, what nohup starts SIGHUP, and so would the
# command.
RUN = """
import signal
signal.signal(signal.SIGINT, signal.default_int_handler)
signal.signal(signal.SIGHUP, signal.SIG_DFL)
from topview.cli.main import main
main()
"""


# Whoever reads a pipe waits until somebody writes.
WAITS_IN_FRAME_3 = """
from topview.io.readers.folder import FolderRecording
read = FolderRecording.frame
def frame(self, index):
    if index == 3:
        open(PIPE).read()
    return read(self, index)
FolderRecording.frame = frame
"""


@pytest.mark.parametrize(("number", "status"), [("SIGINT", 130), ("SIGTERM", 143), ("SIGHUP", 129)])
def test_every_signal_ends_in_order_and_a_second_one_breaks_nothing(
    make_recording, tmp_path, compiled, number, status
):
    source, out, pipe = make_recording([wall()] * 6), tmp_path / "out", tmp_path / "pipe"
    os.mkfifo(pipe)
    code = WAITS_IN_FRAME_3.replace("PIPE", repr(str(pipe))) + RUN
    running = subprocess.Popen(
        [sys.executable, "-c", code, "track", str(source), "--out", str(out), "--pictures"],
        stderr=subprocess.PIPE,
        text=True,
    )
    writing = opened(pipe, running)
    running.send_signal(getattr(signal, number))
    running.send_signal(getattr(signal, number))
    time.sleep(0.005)
    running.send_signal(getattr(signal, number))
    _, complaints = running.communicate(timeout=HANGS_S)
    os.close(writing)
    assert running.returncode == status
    assert "the 3 frames tracked so far are kept" in complaints
    assert "Traceback" not in complaints
    assert frames_in(out) == [0, 1, 2]
    assert (out / "skeletons.csv").exists()
    assert (out / "contact_sheet.png").exists()


def opened(fifo: Path, reader: subprocess.Popen[str]) -> int:
    """Waits until somebody reads; fails at once if the reader has ended instead."""
    while True:
        try:
            return os.open(fifo, os.O_WRONLY | os.O_NONBLOCK)
        except OSError:
            assert reader.poll() is None, reader.communicate()
            time.sleep(0.02)


def test_a_signal_while_modules_are_imported_is_no_traceback(tmp_path):
    (tmp_path / "cyclopts.py").write_text(
        "import os, signal, time\nos.kill(os.getpid(), signal.SIGTERM)\ntime.sleep(5)\n"
    )
    ended = subprocess.run(
        [sys.executable, "-c", RUN, "--help"],
        env=os.environ
        | {"PYTHONPATH": f"{tmp_path}{os.pathsep}{os.environ.get('PYTHONPATH', '')}"},
        capture_output=True,
        text=True,
        timeout=HANGS_S,
        check=False,
    )
    assert ended.returncode == 143
    assert ended.stderr == "topview: interrupted\n"
