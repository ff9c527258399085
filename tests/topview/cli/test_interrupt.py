"""Ctrl-C keeps what was tracked so far."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

from patience import HANGS_S
from tiny_recordings import wall

# What a shell starts in the background ignores SIGINT, and so would the command.
RUN = """
import signal
signal.signal(signal.SIGINT, signal.default_int_handler)
from topview.cli.app import main
main()
"""


def open_when_read(fifo: Path, reader: subprocess.Popen[str]) -> int:
    """Waits until somebody reads; fails at once if the reader has ended instead."""
    while True:
        try:
            return os.open(fifo, os.O_WRONLY | os.O_NONBLOCK)
        except OSError:  # nobody reads it yet
            assert reader.poll() is None, reader.communicate()
            time.sleep(0.02)


def test_an_interrupted_run_keeps_its_frames(make_recording, tmp_path, compiled):
    source, out = make_recording([wall()] * 6), tmp_path / "out"
    third = source / "depth" / "000003.png"
    third.unlink()
    os.mkfifo(third)  # whoever reads it waits until somebody writes
    running = subprocess.Popen(
        [sys.executable, "-c", RUN, "track", str(source), "--out", str(out), "--pictures"],
        stderr=subprocess.PIPE,
        text=True,
    )
    writing = open_when_read(third, running)
    running.send_signal(signal.SIGINT)
    _, complaints = running.communicate(timeout=HANGS_S)
    os.close(writing)
    assert running.returncode == 130
    assert "interrupted: the 3 frames tracked so far are kept" in complaints
    assert "Traceback" not in complaints
    with np.load(out / "skeletons.npz") as skeletons:
        assert skeletons["frame_index"].tolist() == [0, 1, 2]
    assert (out / "skeletons.csv").exists()
    assert (out / "contact_sheet.png").exists()
