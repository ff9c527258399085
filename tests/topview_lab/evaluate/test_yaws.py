"""Which way somebody faces, against annotated yaws: from the table of yaws to the printed one."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from skeleton_sequences import predicted_of, standing, write_folder_recording
from topview.geometry.rotations import rotations_from_vectors
from topview.records import InputError, Recording
from topview.track.run import TrackingResult
from topview.track.settings import TrackerSettings
from topview_lab.cli import evaluate_facing as command
from topview_lab.evaluate.yaws import FacingJob, Yaws, read_yaws, score_facing
from topview_lab.metrics.facing import yaws_deg

TURNING_MAN = Path(__file__).parent / "data" / "turning_man_yaws.csv"
F = 61  # two seconds and the last frame


def facing(yaw_deg: float, z_m: float = 2.5) -> np.ndarray:
    """[16, 3] somebody upright whose front points there; `standing` faces the camera."""
    middle = np.array([0.0, 0.0, z_m])
    R_camera_body = rotations_from_vectors(np.array([0.0, -np.radians(yaw_deg), 0.0]))
    return (standing() - [0.0, 0.0, 2.5]) @ R_camera_body.T + middle


def track_somebody_who_turns(recording: Recording, settings: TrackerSettings) -> TrackingResult:
    """One degree in each frame, all the way to frame 89; the seed is how far that is off."""
    frames = list(recording)
    joints = np.stack([facing(frame.index + settings.seed)[None] for frame in frames])
    return TrackingResult(predicted_of(joints), 1.0, False)


@pytest.mark.parametrize("yaw_deg", [0.0, 30.0, 90.0, 179.0, -90.0, -179.0])
def test_zero_faces_the_camera_and_ninety_the_right_of_the_image(yaw_deg):
    assert yaws_deg(facing(yaw_deg)[None])[0] == pytest.approx(yaw_deg)


def test_yaws_are_interpolated_the_shorter_way_and_known_between_the_first_and_the_last():
    yaws = Yaws(np.array([2, 4, 8]), np.array([170.0, -170.0, -90.0]))
    known = yaws.of_frames(np.array([1, 2, 3, 4, 6, 8, 9]))
    np.testing.assert_allclose(known[1:-1], [170.0, 180.0, 190.0, 230.0, 270.0])
    assert np.isnan(known[[0, -1]]).all()


def test_the_nearest_person_counts_and_frames_without_anybody_do_not():
    """Right in the first second, the wrong way round later, and gone in the last frame."""
    near = [facing(0.0 if f < 30 else 180.0, z_m=2.0) for f in range(F)]
    joints = np.stack([np.stack([facing(90.0, z_m=4.0) for _ in range(F)]), np.stack(near)], 1)
    joints[-1] = np.nan
    yaws = Yaws(np.array([0, F - 1]), np.array([10.0, 10.0]))
    score = score_facing(predicted_of(joints), yaws)
    assert (score.late.count, score.late.share) == (30, 0.0)
    assert (score.whole.count, score.whole.share) == (60, 0.5)
    assert score.found == pytest.approx(60 / 61)


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("frame;yaw\n0;1\n", "begins with 'frame;yaw'"),
        ("frame,yaw_deg\n0,1\n", r"annotates the frames \[0\]"),
        ("frame,yaw_deg\n3,1\n3,2\n", r"annotates the frames \[3, 3\]"),
        ("frame,yaw_deg\n3,north\n", "has the line '3,north'"),
        ("frame,yaw_deg\n3,nan\n", "has the line '3,nan'"),
        (f"frame,yaw_deg\n{'9' * 99},1\n", "has the line '999"),
    ],
)
def test_a_table_that_does_not_fit_is_named(tmp_path, text, named):
    path = tmp_path / "yaws.csv"
    path.write_text(text)
    with pytest.raises(InputError, match=f"yaws.csv.*{named}"):
        read_yaws(path)


def test_the_command_tells_and_writes_what_was_measured(topview, tmp_path, monkeypatch):
    def measured(path, yaws, settings) -> FacingJob:
        return FacingJob(path, yaws, settings, track_somebody_who_turns)

    monkeypatch.setattr(command, "FacingJob", measured)
    folder = write_folder_recording(tmp_path / "somebody", [2.0] * F)
    table = tmp_path / "yaws.csv"
    table.write_text(f"frame,yaw_deg\r\n0,0\r\n{F - 1},{F - 1}\r\n")
    words = ("--yaws", table, "--workers", 1, "--json", tmp_path / "a.json")
    ended = topview("evaluate", "facing", folder, *words, "--seed", 44)
    assert (ended.status, ended.complaints) == (0, [])
    assert ended.out.count("100.0%") == 2
    topview("evaluate", "facing", folder, *words, "--seed", 46, "--force")
    told = json.loads((tmp_path / "a.json").read_text())["facing"]["somebody"]
    assert (told["late"], told["found"]) == ({"count": 31, "share": 0.0}, 1.0)


def test_the_yaws_of_the_man_who_turns_fit_his_recording(shared):
    """They go once round to the back, in the frames that there are."""
    folder = shared / "recordings" / "turning_man"
    if not folder.exists():
        pytest.skip(f"needs {folder}, which is not part of the project")
    yaws = read_yaws(TURNING_MAN)
    assert (yaws.frames[0], yaws.frames[-1]) == (0, len(list(folder.glob("depth/*.png"))) - 1)
    assert (np.diff(yaws.yaw_deg) > 0).all()


@pytest.mark.slow
def test_the_man_who_turns_is_followed_until_his_side_shows(shared):
    """In 64 % of all frames; from behind he is taken to face the camera."""
    folder = shared / "recordings" / "turning_man"
    if not folder.exists():
        pytest.skip(f"needs {folder}, which is not part of the project")
    score = FacingJob(folder, TURNING_MAN, TrackerSettings(threads=1))().score
    assert score is not None
    assert score.found == 1.0
    assert score.whole.share > 0.5
