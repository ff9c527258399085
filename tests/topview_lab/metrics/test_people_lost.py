"""How often people are lost."""

from __future__ import annotations

import numpy as np

from skeleton_sequences import people_standing, predicted_of, reference_of
from topview.body import JOINT_NAMES
from topview_lab.metrics import measure_sequence, times_lost

FPS = 10.0  # half a second is five frames
FRAMES = 30


def lost(*unmatched: range, hidden: range = range(0), absent: range = range(0)) -> int:
    """Of one person of `FRAMES` frames: in which frames there is no track, somebody hides most of
    the person, or the person is out of view."""
    truth = people_standing(FRAMES, 0.0)
    tracked = truth.copy()
    for frames in unmatched:
        tracked[list(frames)] = np.nan
    truth[list(absent)] = np.nan
    shares = np.zeros((FRAMES, 1, len(JOINT_NAMES)))
    shares[list(hidden)] = 0.8
    reference = reference_of(truth, occluded_by_person=shares)
    return times_lost(measure_sequence(predicted_of(tracked), reference).samples, FPS)


def test_somebody_who_goes_unmatched_for_half_a_second_is_lost_each_time():
    assert lost() == 0
    assert lost(range(10, 14)) == 0
    assert lost(range(10, 15)) == 1
    assert lost(range(10, 15), range(16, 30)) == 2


def test_nobody_is_lost_before_being_found():
    assert lost(range(20)) == 0


def test_time_in_which_somebody_is_hidden_or_away_does_not_count():
    assert lost(range(10, 16), hidden=range(10, 16)) == 0
    assert lost(range(10, 18), hidden=range(13, 15)) == 0
    assert lost(range(10, 18), absent=range(13, 15)) == 0
    assert lost(range(10, 18), hidden=range(15, 18)) == 1
