"""`topview annotate` and `topview simulate markers` as commands."""

from __future__ import annotations

import socket
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from conftest import Marked
from topview.cli.main import main


def run(*arguments: str) -> int:
    with pytest.raises(SystemExit) as end:
        main(arguments)
    return int(end.value.code or 0)


def test_everything_by_itself(
    marked: Marked, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    u, v = marked.pixel("torso")
    pick = f"front:0:{u:.0f}:{v:.0f}"
    out = str(tmp_path)
    front, rear = str(marked.front), str(marked.rear)
    assert run("annotate", front, rear, "--out", out, "--pick", pick, "--automatic") == 0
    assert "written to" in capsys.readouterr().out
    truth = np.load(tmp_path / "groundtruth.npz")
    errors = np.linalg.norm(truth["joints"] - marked.joints, axis=-1)
    assert errors.mean() < 0.02
    assert truth["relative_angles_deg"].shape[-1] == len(truth["angle_joints"])


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--automatic"], "needs a marker's pixel"),
        (["--pick", "here"], "must be VIEW:FRAME:U:V"),
        (["--pick", "front:0:250:90", "--automatic"], "nearly grey"),
        (["--pick", "front:900:250:90", "--automatic"], "no frame 900"),
        (["--people", "0"], "--people is 0"),
        (["--board", "big"], "--board is 'big'"),
        (["--board", "9" * 5000 + "x6:0.03"], "--board is '999"),
        (["--pick", f"front:{'9' * 5000}:250:90"], "must be VIEW:FRAME:U:V"),
        (["--pick", f"front:0:{'9' * 5000}:90"], "must be VIEW:FRAME:U:V"),
        (["--port", "99999"], "--port is 99999; it must be a free port, 1 to 65535, or 0"),
        (["--port", "-1"], "--port is -1"),
        (["--offset", "nan"], "--offset is 'nan'"),
        (["--offset", "1e300"], "--offset is 1e+300"),
    ],
)
def test_bad_input_is_one_line_and_status_2(
    marked: Marked,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    arguments: list[str],
    said: str,
) -> None:
    front, rear = str(marked.front), str(marked.rear)
    assert run("annotate", front, rear, "--out", str(tmp_path), *arguments) == 2
    error = capsys.readouterr().err
    assert said in error
    assert error.count("\n") == 1


def test_a_port_in_use_is_refused(
    marked: Marked, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with socket.create_server(("127.0.0.1", 0)) as other:
        port = str(other.getsockname()[1])
        front, rear = str(marked.front), str(marked.rear)
        assert run("annotate", front, rear, "--out", str(tmp_path), "--port", port) == 2
    error = capsys.readouterr().err
    assert f"--port {port}: " in error
    assert error.count("\n") == 1


HOLDER = """
import sys
from pathlib import Path
from topview_lab.annotate.sole_use import SoleUse
held = SoleUse(Path(sys.argv[1]))
print("held", flush=True)
sys.stdin.read()
"""


def test_a_project_is_one_process_at_a_time(
    marked: Marked, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("fcntl", reason="needs a system with flock")
    arguments = ["annotate", str(marked.front), str(marked.rear), "--out", str(tmp_path)]
    other = subprocess.Popen(
        [sys.executable, "-c", HOLDER, str(tmp_path)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    with other:
        assert other.stdout is not None
        assert other.stdout.readline() == "held\n"
        assert run(*arguments, "--automatic") == 2
        error = capsys.readouterr().err
        assert f"{tmp_path / 'annotation.lock'}: is held by another" in error
        assert f"process {other.pid}" in error
        assert error.count("\n") == 1
        other.kill()
    assert run(*arguments, "--automatic") == 2  # the killed one's file is there, and means nothing
    assert "needs a marker's pixel" in capsys.readouterr().err


def test_two_people_who_are_one_are_refused(
    marked: Marked, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    u, v = marked.pixel("torso")
    status = run(
        "annotate", str(marked.front), str(marked.rear), "--out", str(tmp_path),
        "--pick", f"front:0:{u:.0f}:{v:.0f}", "--people", "2", "--automatic",
    )  # fmt: skip
    assert status == 2
    assert "the markers of 2 standing people are not among the spots" in capsys.readouterr().err


def test_simulate_markers_writes_two_recordings_and_the_truth(tmp_path: Path) -> None:
    assert run("simulate", "markers:stand", "--out", str(tmp_path), "--frames", "1") == 0
    for view in ("front", "rear"):
        assert (tmp_path / view / "depth" / "000000.png").exists()
        assert not (tmp_path / view / "groundtruth.npz").exists()
    truth = np.load(tmp_path / "truth.npz")
    assert truth["markers"].shape == (1, 1, len(truth["marker_joints"]), 2, 3)
    assert np.linalg.det(truth["T_front_rear"][:3, :3]) == pytest.approx(1.0)
