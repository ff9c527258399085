"""Ctrl-C keeps what was tracked so far."""

from __future__ import annotations

import os
import signal
import subprocess
import sys

import numpy as np

from tiny_recordings import wall

COMMAND = [sys.executable, "-c", "from topview.cli.app import main; main()", "track"]


def test_an_interrupted_run_keeps_its_frames(make_recording, tmp_path):
    source, out = make_recording([wall()] * 6), tmp_path / "out"
    third = source / "depth" / "000003.png"
    third.unlink()
    os.mkfifo(third)  # whoever reads it waits until somebody writes
    running = subprocess.Popen(
        [*COMMAND, str(source), "--out", str(out), "--pictures"],
        stderr=subprocess.PIPE,
        text=True,
    )
    with third.open("wb"):  # waits until the third frame is being read
        running.send_signal(signal.SIGINT)
        _, complaints = running.communicate(timeout=120)
    assert running.returncode == 130
    assert "interrupted: the 3 frames tracked so far are kept" in complaints
    assert "Traceback" not in complaints
    with np.load(out / "skeletons.npz") as skeletons:
        assert skeletons["frame_index"].tolist() == [0, 1, 2]
    assert (out / "skeletons.csv").exists()
    assert (out / "contact_sheet.png").exists()
