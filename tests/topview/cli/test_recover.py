"""`topview recover`: a kill, a power failure or a full disk costs no frame that was tracked."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from made_frames import ABOUT, frames_with
from patience import HANGS_S
from tiny_recordings import wall
from topview.cli import results
from topview.io import FramesFile

STUCK_AT_3 = """
import sys, time
from topview.track import Tracker
update = Tracker.update
def stuck(self, frame):
    if frame.index == 3:
        print("stuck", flush=True)
        time.sleep(600)
    return update(self, frame)
Tracker.update = stuck
from topview.cli.main import main
main()
"""


def unfinished(out: Path, frames: int = 3) -> Path:
    """A folder that a killed run has left."""
    out.mkdir()
    with FramesFile(out / "skeletons.frames", ABOUT) as file:
        for frame in frames_with([[1, 2]] * frames):
            file.append(frame)
    return out


def arrays_in(out: Path) -> dict[str, list]:
    with np.load(out / "skeletons.npz") as arrays:
        return {name: arrays[name].tolist() for name in arrays.files}


def test_a_killed_run_is_recovered_as_if_it_had_ended_there(topview, make_recording, tmp_path):
    source, out = make_recording([wall()] * 6), tmp_path / "out"
    running = subprocess.Popen(
        [sys.executable, "-c", STUCK_AT_3, "track", str(source), "--out", str(out)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert running.stdout is not None
    assert running.stdout.readline() == "stuck\n"
    ended = topview("track", source, "--out", out)
    assert "another run writes it, or was killed" in ended.complaints[-1]
    ended = topview("recover", out)
    assert (ended.status, len(ended.complaints)) == (2, 1)
    assert "a run still writes it" in ended.complaints[0]
    running.send_signal(signal.SIGKILL)
    running.communicate(timeout=HANGS_S)

    for force in ((), ("--force",)):
        ended = topview("track", source, "--out", out, *force)
        assert (ended.status, len(ended.complaints)) == (2, 1)
        assert f"`topview recover {out}`" in ended.complaints[0]
    assert [path.name for path in out.iterdir()] == ["skeletons.frames"]
    assert topview("recover", out).status == 0
    for f in range(3, 6):
        (source / "depth" / f"{f:06d}.png").unlink()
    topview("track", source, "--out", tmp_path / "short")
    for name in ("skeletons.npz", "skeletons.csv"):
        assert (out / name).read_bytes() == (tmp_path / "short" / name).read_bytes()
    assert not (out / "skeletons.frames").exists()


def test_recovering_tells_who_was_found(topview, tmp_path):
    ended = topview("recover", unfinished(tmp_path / "out", 5))
    assert (ended.status, ended.complaints) == (0, [])
    assert "5 frames, written to" in ended.out
    assert arrays_in(tmp_path / "out")["people_ids"] == [1, 2]


def test_a_frame_that_is_not_whole_is_left_out_and_said(topview, tmp_path):
    frames = unfinished(tmp_path / "out") / "skeletons.frames"
    frames.write_bytes(frames.read_bytes()[:-1])
    ended = topview("recover", tmp_path / "out")
    assert ended.status == 0
    assert "are no whole frame and are left out" in ended.complaints[0]
    assert arrays_in(tmp_path / "out")["frame_index"] == [0, 1]
    assert (tmp_path / "out" / "skeletons.frames.damaged").exists()
    assert not frames.exists()


def test_nothing_to_recover_is_said(topview, tmp_path):
    ended = topview("recover", tmp_path)
    assert ended.status == 2
    assert "holds nothing to recover" in ended.complaints[0]
    (tmp_path / "skeletons.frames").write_bytes(b"topview fr")
    ended = topview("recover", tmp_path)
    assert ended.status == 0
    assert "holds no whole frame" in ended.out
    assert [path.name for path in tmp_path.iterdir()] == ["skeletons.frames.damaged"]


def test_an_older_result_is_replaced_only_by_force(topview, tmp_path):
    out = unfinished(tmp_path / "out")
    (out / "skeletons.npz").write_bytes(b"older")
    ended = topview("recover", out)
    assert ended.status == 2
    assert "--force replaces it" in ended.complaints[0]
    assert (out / "skeletons.npz").read_bytes() == b"older"
    assert topview("recover", out, "--force").status == 0
    assert arrays_in(out)["frame_index"] == [0, 1, 2]


def test_a_third_signal_while_the_result_is_written_leaves_the_frames(
    topview, make_recording, tmp_path, monkeypatch
):
    def stopped(*_):
        raise KeyboardInterrupt

    with monkeypatch.context() as patched:
        patched.setattr(results, "write_skeletons_csv", stopped)
        ended = topview("track", make_recording([wall()] * 4), "--out", tmp_path / "out")
    assert ended.status == 130
    assert "the 4 frames lie in" in ended.complaints[0]
    assert topview("recover", tmp_path / "out", "--force").status == 0
    assert (tmp_path / "out" / "skeletons.csv").exists()


LIMITED = """
import resource, sys
resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv.pop(1)), resource.RLIM_INFINITY))
from topview.cli.main import main
main()
"""


# The first limit stops the file of frames, and the result of these still fits; the second one is
# too small for any result.
@pytest.mark.parametrize("limit", [12_000, 3_600])
def test_a_full_disk_costs_no_frame_that_fitted(topview, make_recording, tmp_path, compiled, limit):
    source, out = make_recording([wall()] * 400), tmp_path / "out"
    ended = subprocess.run(
        [sys.executable, "-c", LIMITED, str(limit), "track", str(source), "--out", str(out)],
        capture_output=True,
        text=True,
        timeout=HANGS_S,
        check=False,
    )
    assert ended.returncode == 2
    assert "Traceback" not in ended.stderr
    assert "skeletons.frames: cannot be written: File too large" in ended.stderr
    if (out / "skeletons.frames").exists():
        assert f"`topview recover {out}`" in ended.stderr
        assert topview("recover", out).status == 0
    frames = arrays_in(out)["frame_index"]
    assert frames == list(range(len(frames)))
    assert f"the {len(frames)} frames " in ended.stderr
    assert {path.name for path in out.iterdir()} == {"skeletons.npz", "skeletons.csv"}


def test_a_full_file_system_costs_no_frame_that_fitted(topview, tmp_path, make_recording, compiled):
    """A real one, where such can be mounted."""
    out = tmp_path / "out"
    out.mkdir()
    mounted = shutil.which("mount") and subprocess.run(
        ["mount", "-t", "tmpfs", "-o", "size=32k", "tmpfs", str(out)],
        capture_output=True,
        check=False,
    )
    if not mounted or mounted.returncode:
        pytest.skip("needs leave to mount a small file system")
    try:
        ended = topview("track", make_recording([wall()] * 600), "--out", out)
        assert ended.status == 2
        assert any("No space left on device" in line for line in ended.complaints)
        assert any(f"`topview recover {out}`" in line for line in ended.complaints)
        subprocess.run(["mount", "-o", "remount,size=10M", str(out)], check=True)
        assert topview("recover", out, "--force").status == 0
        frames = arrays_in(out)["frame_index"]
        assert frames == list(range(len(frames)))
        assert any(f"the {len(frames)} frames " in line for line in ended.complaints)
    finally:
        subprocess.run(["umount", str(out)], check=True)


@pytest.mark.slow
def test_half_an_hour_of_passers_by_takes_little_memory_and_disk(tmp_path):
    script = Path(__file__).parents[3] / "scripts" / "measure_day.py"
    done = subprocess.run(
        [sys.executable, str(script), "--hours", "0.5", "--out", str(tmp_path)],
        capture_output=True,
        text=True,
        check=True,
        env=os.environ | {"OMP_NUM_THREADS": "1"},
    )
    told = dict(line.split() for line in done.stdout.splitlines())
    assert (told["frames"], told["people"], told["slots"]) == ("54000", "17", "3")
    assert float(told["memory_mb"]) < 500
    assert sum(float(told[f"skeletons.{end}_mb"]) for end in ("frames", "npz", "csv")) < 2000 / 48
