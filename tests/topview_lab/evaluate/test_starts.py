"""Starts measured: from the scene to the table."""

from __future__ import annotations

import json

import numpy as np
import pytest
from rich.console import Console

from skeleton_sequences import predicted_of
from topview.records import Recording
from topview.track.run import TrackingResult
from topview.track.settings import TrackerSettings
from topview_lab.cli import evaluate as command
from topview_lab.datasets import SimulatedStart, make_starts
from topview_lab.datasets.simulated import RecordingWithTruth
from topview_lab.evaluate.starts import (
    ALL_STARTS,
    StartJob,
    StartOutcome,
    each_start_table,
    starts_as_json,
    starts_by_pose,
    starts_table,
)
from topview_lab.metrics.starts import StartScore, StartsSummary
from topview_lab.sim.scenes.starts import START_DIRECTIONS, START_FRAMES, START_POSES

RIGHT, WRONG = StartScore(1.0, 1.0, 1.0), StartScore(0.5, 0.0, 1.0)


def track_truth(recording: Recording, settings: TrackerSettings) -> TrackingResult:
    """A tracker that knows everything."""
    assert isinstance(recording, RecordingWithTruth)
    list(recording)  # what is known of a frame is told once it is read
    reference = recording.reference()
    names = predicted_of(np.zeros((1, 1, 16, 3))).joint_names
    joints = reference.joints_camera[:, :, [reference.joint_names.index(name) for name in names]]
    return TrackingResult(predicted_of(joints), 1.0, False)


def test_a_tracker_that_knows_everything_holds() -> None:
    outcome = StartJob(SimulatedStart("squatting", "back"), TrackerSettings(), track_truth)()
    assert outcome.problems == ()
    assert outcome.score == RIGHT


def outcomes() -> list[StartOutcome]:
    scores = {("bent", "back"): WRONG, ("lunge", "left"): None}
    return [
        StartOutcome(SimulatedStart(pose, direction), scores.get((pose, direction), RIGHT))
        for pose in ("bent", "lunge")
        for direction in START_DIRECTIONS
    ]


def test_rows_are_poses_and_columns_directions() -> None:
    rows = starts_by_pose(outcomes())
    assert list(rows) == ["bent", "lunge", ALL_STARTS]
    assert list(rows["bent"]) == [*START_DIRECTIONS, ALL_STARTS]
    assert rows["bent"]["back"] == StartsSummary(1, 0.5, 0.0, 1.0, 0.0)
    assert rows["bent"][ALL_STARTS] == StartsSummary(4, 0.875, 0.75, 1.0, 0.75)
    assert "left" not in rows["lunge"]
    assert rows[ALL_STARTS]["back"] == StartsSummary(2, 0.75, 0.5, 1.0, 0.5)
    assert rows[ALL_STARTS][ALL_STARTS].count == 7
    assert starts_as_json(rows)["bent"]["front"] == {
        "count": 1, "joints": 1.0, "facing": 1.0, "found": 1.0, "holds": 1.0,
    }  # fmt: skip


def test_tables_fit_a_terminal_and_tell_the_worst_first() -> None:
    console = Console(width=80, record=True)
    console.print(starts_table(starts_by_pose(outcomes())))
    console.print(each_start_table(outcomes()))
    text = console.export_text()
    assert "50/0" in text
    assert "100    75" in text
    assert text.index("bent_back_1") < text.index("bent_front_1")
    assert "lunge_left_1" not in text


def test_all_starts_are_made() -> None:
    starts = make_starts(seeds=(1, 2))
    assert len({start.name for start in starts}) == 2 * len(START_POSES) * len(START_DIRECTIONS)
    assert starts[0].make().frames == START_FRAMES


@pytest.mark.parametrize(
    ("words", "named"),
    [
        (("flying",), "pose is 'flying'; it must be one of"),
        (("bent", "--seeds", "x"), "--seeds is 'x'"),
        (("bent", "--sequences", "z*"), "no sequence matches 'z*'"),
    ],
)
def test_what_there_is_not_is_one_line(topview, words, named) -> None:
    ended = topview("evaluate", "starts", *words)
    assert (ended.status, len(ended.complaints)) == (2, 1)
    assert named in ended.complaints[0]


def test_the_command_tells_and_writes_what_was_measured(topview, tmp_path, monkeypatch) -> None:
    def measured(start: SimulatedStart, settings: TrackerSettings) -> StartJob:
        return StartJob(start, settings, track_truth)

    monkeypatch.setattr(command, "StartJob", measured)
    path = tmp_path / "starts.json"
    words = ("--sequences", "*_back_1", "--workers", "1", "--per-sequence", "--json", path)
    ended = topview("evaluate", "starts", "lunge", "squatting", *words)
    assert (ended.status, ended.complaints) == (0, [])
    assert "squatting_back_1" in ended.out
    assert json.loads(path.read_text())["starts"]["all"]["all"]["holds"] == 1.0
