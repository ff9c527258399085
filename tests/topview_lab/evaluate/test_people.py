"""People counted in recordings whose truth is known: from the folder to the table."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from skeleton_sequences import track_distance, write_rendered
from topview.records import InputError
from topview.track.settings import TrackerSettings
from topview_lab.cli import evaluate as command
from topview_lab.datasets.folder import FolderRecording
from topview_lab.datasets.true_heads import read_true_heads
from topview_lab.evaluate.people import PeopleJob, PeopleOutcome, count_by_kind, count_each

DEPTHS_M = [2.0, 2.1, 2.2, 2.3]
F = len(DEPTHS_M)


def write_people(folder: Path, **truth: Any) -> Path:
    """One person who can be seen, but for the first frame."""
    hidden = np.array([[0.8], [0.0], [0.0], [0.0]])
    shares = {"person_occ_inter": hidden, "person_outside": np.zeros((F, 1))}
    return write_rendered(folder, DEPTHS_M, **(shares | truth))


def outcome_of(folder: Path) -> PeopleOutcome:
    return PeopleJob(FolderRecording(folder), TrackerSettings(), track_distance)()


def test_what_is_counted_of_a_folder(tmp_path):
    """Somebody who is found, and of whom the truth says in the last frame that nobody is there."""
    gone = np.array([[0.8], [0.0], [0.0], [np.nan]])
    outcomes = [
        outcome_of(write_people(tmp_path / "walk_1")),
        outcome_of(write_people(tmp_path / "sit_1", person_occ_inter=gone)),
    ]
    counts = count_by_kind(outcomes)
    assert list(counts) == ["sit", "walk", "all"]
    assert (counts["walk"].due, counts["walk"].recall) == (3, 1.0)
    assert (counts["sit"].due, counts["sit"].recall) == (2, 1.0)
    assert (counts["walk"].false_per_1000, counts["sit"].false_per_1000) == (0.0, 250.0)
    assert (counts["all"].recordings, counts["all"].false_per_1000) == (2, 125.0)
    assert (counts["all"].swaps, counts["all"].fragments, counts["all"].wait_95_s) == (0, 0, 0.0)
    assert list(count_each(outcomes)) == ["walk_1", "sit_1"]


@pytest.mark.parametrize(
    ("truth", "says"),
    [
        (
            {"person_occ_inter": np.zeros((F, 2))},
            r"person_occ_inter is \(4, 2\); it must be \(4, 1\)",
        ),
        ({"person_outside": np.full((F, 1), 2.0)}, "holds -0.2; a share must be 0 to 1"),
        ({"joints": np.zeros((F, 1, 2, 3))}, r"joints is \(4, 1, 2, 3\); it must be frames x"),
        ({"present": np.ones((F, 3))}, r"present is \(4, 3\); it must be \(4, 1\)"),
    ],
)
def test_truth_that_does_not_fit_is_named(tmp_path, truth, says):
    with pytest.raises(InputError, match=says):
        read_true_heads(write_people(tmp_path / "a", **truth) / "groundtruth.npz")


def test_truth_without_people_and_heads_is_named(tmp_path):
    with pytest.raises(InputError, match="lacks person_occ_inter, person_outside"):
        read_true_heads(write_rendered(tmp_path / "a", DEPTHS_M) / "groundtruth.npz")
    headless = np.array([f"tail{k}" for k in range(16)])
    with pytest.raises(InputError, match="head must be among them"):
        read_true_heads(write_people(tmp_path / "b", names=headless) / "groundtruth.npz")


def test_more_frames_than_the_truth_has_are_one_line(tmp_path):
    folder = write_people(tmp_path / "a")
    arrays = dict(np.load(folder / "groundtruth.npz"))
    per_frame = {key for key, values in arrays.items() if len(values) == F}
    short = {key: arrays[key][:2] if key in per_frame else arrays[key] for key in arrays}
    np.savez(folder / "groundtruth.npz", **short)
    assert outcome_of(folder).problems == ("a: frame 2 was tracked; the truth has 2 frames",)


def test_the_command_prints_and_writes(tmp_path, topview):
    """Images of 8 x 6 pixels show nobody whom the tracker could find."""
    folder = write_people(tmp_path / "walk_1")
    done = topview("evaluate", "people", folder, "--workers", 1, "--json", tmp_path / "a.json")
    assert (done.status, done.complaints) == (0, [])
    assert "0.0%" in done.out
    counts = json.loads((tmp_path / "a.json").read_text())["counts"]
    assert (counts["all"]["recall"], counts["all"]["wait_95_s"]) == (0.0, None)
    assert topview("evaluate", "people").status == 2
    words = (folder, "--workers", 1, "--offline", "--json", tmp_path / "offline.json")
    assert topview("evaluate", "people", *words).status == 0
    told = [json.loads((tmp_path / f"{name}.json").read_text()) for name in ("a", "offline")]
    assert [own["offline"] for own in told] == [False, True]
    with pytest.raises(InputError, match="no folder given"):
        command.people()
