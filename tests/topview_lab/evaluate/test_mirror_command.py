"""`topview evaluate mirror`: from two recordings that are told to the table."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from skeleton_sequences import predicted_of, standing, write_folder_recording
from topview.body import JOINT_NAMES
from topview.records import InputError, Recording
from topview.track.run import TrackingResult
from topview.track.settings import TrackerSettings
from topview_lab.cli import evaluate_mirror as command
from topview_lab.evaluate.mirror import (
    MirrorJob,
    MirrorOutcome,
    apart_by_joint,
    apart_by_sequence,
)
from topview_lab.metrics.mirror import MIRRORED_WITHIN_CM, Apart, pooled_apart

ASIDE_CM, SEED_CM = 2.0, 5.0
DEPTHS_M = [2.0, 2.1, 2.2]


def track_with_a_bias(recording: Recording, settings: TrackerSettings) -> TrackingResult:
    """A tracker that is off to the right by the same in every recording, the left hand by twice as
    much, and further away with a higher seed."""
    aside = np.zeros((len(JOINT_NAMES), 3))
    aside[:, 0], aside[:, 2] = 0.5 * ASIDE_CM / 100.0, settings.seed * SEED_CM / 100.0
    aside[JOINT_NAMES.index("left_hand"), 0] *= 3.0
    frames = list(recording)
    joints = np.stack([(standing(z_m=float(f.depth_m.max())) + aside)[None] for f in frames])
    return TrackingResult(predicted_of(joints), 1.0, False)


def outcome_of(folder: Path, frames: int | None = None) -> MirrorOutcome:
    other = TrackerSettings(seed=1)
    return MirrorJob(folder, TrackerSettings(), frames, other, track_with_a_bias)()


def test_what_is_off_to_one_side_is_told_by_joint(tmp_path):
    """A bias to the right is twice as far from itself in the mirror; the left hand's is added to
    that of the right hand, which it is in the mirror."""
    outcome = outcome_of(write_folder_recording(tmp_path / "a", DEPTHS_M))
    assert outcome.problems == ()
    assert outcome.mirrored is not None
    assert outcome.reseeded is not None
    rows = apart_by_joint(outcome.mirrored)
    assert rows["head"].median_cm == pytest.approx(ASIDE_CM)
    assert rows["left_hand"].most_cm == pytest.approx(2.0 * ASIDE_CM)
    assert rows["right_hand"].near == 0.0
    assert (rows["head"].near, rows["head"].count) == (1.0, len(DEPTHS_M))
    assert rows["all"].near == pytest.approx(14 / 16)
    assert outcome.reseeded.quantile_cm(0.5) == pytest.approx(SEED_CM)


def test_only_the_first_frames_are_compared_where_that_is_asked(tmp_path):
    outcome = outcome_of(write_folder_recording(tmp_path / "a", DEPTHS_M), frames=2)
    assert outcome.mirrored is not None
    assert outcome.mirrored.distances_cm.shape == (2, len(JOINT_NAMES))


def test_recordings_are_pooled_and_the_worst_is_told_first():
    near, far = (Apart(np.full((2, 16), cm), alone) for cm, alone in ((1.0, 1), (9.0, 2)))
    both = pooled_apart([near, far])
    assert both.alone == 3
    assert_allclose(both.share_within(MIRRORED_WITHIN_CM), 0.5)
    assert list(apart_by_sequence([("near", near), ("far", far)])) == ["far", "near"]


def test_the_command_tells_and_writes_what_was_measured(topview, tmp_path, monkeypatch):
    def measured(path, settings, frames, other) -> MirrorJob:
        return MirrorJob(path, settings, frames, other, track_with_a_bias)

    monkeypatch.setattr(command, "MirrorJob", measured)
    folder = write_folder_recording(tmp_path / "left_and_right", DEPTHS_M)
    words = ("--other-seed", 2, "--workers", 1, "--per-sequence", "--json", tmp_path / "a.json")
    ended = topview("evaluate", "mirror", folder, *words)
    assert (ended.status, ended.complaints) == (0, [])
    assert "from the mirror image" in ended.out
    assert "left_and_right" in ended.out
    told = json.loads((tmp_path / "a.json").read_text())
    assert told["from the mirror image"]["head"]["median_cm"] == pytest.approx(ASIDE_CM)
    assert told["from another seed"]["all"]["median_cm"] == pytest.approx(2 * SEED_CM)


@pytest.mark.parametrize(
    ("words", "named"),
    [
        ((), "evaluate mirror: no recording given"),
        (("a", "--frames", "0"), "--frames is 0; it must be 1 or more"),
        (("a", "--sequences", "z*"), "no sequence matches 'z*'"),
    ],
)
def test_what_cannot_be_measured_is_one_line(topview, words, named):
    ended = topview("evaluate", "mirror", *words)
    assert (ended.status, len(ended.complaints)) == (2, 1)
    assert named in ended.complaints[0]


def test_a_recording_that_is_not_there_is_named(tmp_path):
    outcome = outcome_of(tmp_path / "nothing")
    assert outcome.mirrored is None
    assert outcome.problems[0].startswith("nothing: ")
    with pytest.raises(InputError, match="no recording given"):
        command.mirror()
