"""Starts: what holds from half a second on."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from skeleton_sequences import J, people_standing, predicted_of, reference_of
from topview.body import JOINT_NAMES
from topview_lab.metrics import measure_sequence
from topview_lab.metrics.starts import StartScore, score_start, summarise_starts

FRAMES, LATE = 30, 15
TRUTH = people_standing(FRAMES, 0.0)


def score(found: NDArray[np.float64], hidden: NDArray[np.float64] | None = None) -> StartScore:
    """Hidden is [F, 1, J] the share that an object hides."""
    shares = {
        name: np.zeros((FRAMES, 1, J))
        for name in ("occluded_by_person", "occluded_by_self", "outside")
    }
    nothing = np.zeros((FRAMES, 1, J))
    shares["occluded_by_object"] = nothing if hidden is None else hidden
    return score_start(measure_sequence(predicted_of(found), reference_of(TRUTH, **shares)))


def off(frames: slice, joints: slice | list[int], by_m: float) -> NDArray[np.float64]:
    """Joints that are too deep."""
    found = TRUTH.copy()
    found[frames, 0, joints, 2] += by_m
    return found


def test_what_is_right_holds() -> None:
    assert score(TRUTH) == StartScore(1.0, 1.0, 1.0)
    assert score(TRUTH).holds


def test_the_first_half_second_does_not_count() -> None:
    assert score(off(slice(0, LATE), slice(None), 0.4)) == StartScore(1.0, 1.0, 1.0)
    nobody = TRUTH.copy()
    nobody[:LATE] = np.nan
    assert score(nobody) == StartScore(1.0, 1.0, 1.0)


def test_who_is_not_found_holds_nowhere() -> None:
    assert score(np.full_like(TRUTH, np.nan)) == StartScore(0.0, 0.0, 0.0)
    half = TRUTH.copy()
    half[LATE + 5 :] = np.nan
    assert score(half).joints == score(half).facing == score(half).found == pytest.approx(1 / 3)


@pytest.mark.parametrize(("count", "holds"), [(1, True), (2, False)])
def test_nine_in_ten_joints_must_be_near(count: int, holds: bool) -> None:
    hands = [JOINT_NAMES.index(f"{side}_hand") for side in ("left", "right")][:count]
    wrong = score(off(slice(None), hands, 0.16))
    assert wrong.joints == pytest.approx(1 - count / J)
    assert wrong.holds is holds
    assert score(off(slice(None), hands, 0.14)).joints == 1.0


def test_hidden_joints_do_not_count() -> None:
    hidden = np.zeros((FRAMES, 1, J))
    hidden[..., JOINT_NAMES.index("left_knee")] = 0.6  # more than what is seen of it
    knee = [JOINT_NAMES.index("left_knee")]
    assert score(off(slice(None), knee, 0.5), hidden).joints == 1.0
    nothing_seen = score(TRUTH, np.ones((FRAMES, 1, J)))
    assert np.isnan(nothing_seen.joints)
    assert not nothing_seen.holds


def test_the_trunk_must_face_right() -> None:
    neck = TRUTH[:, :, [JOINT_NAMES.index("neck")]]
    R = Rotation.from_euler("y", 46.0, degrees=True).as_matrix()
    turned = neck + (TRUTH - neck) @ R.T
    assert score(turned).facing == 0.0
    assert not score(turned).holds


def test_starts_are_summed() -> None:
    summary = summarise_starts(
        [StartScore(1.0, 1.0, 1.0), StartScore(0.8, 1.0, 1.0), StartScore(0.6, 0.0, 0.4)]
    )
    assert (summary.count, summary.holds) == (3, pytest.approx(1 / 3))
    assert summary.found == pytest.approx(0.8)
    assert (summary.joints, summary.facing) == (pytest.approx(0.8), pytest.approx(2 / 3))
    assert summarise_starts([StartScore(float("nan"), 1.0, 1.0)] * 2).facing == 1.0
