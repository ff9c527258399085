"""`topview annotate` and `topview simulate markers` as commands."""

from __future__ import annotations

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
