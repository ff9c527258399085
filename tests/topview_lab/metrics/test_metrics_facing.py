"""Which way people face: the turn of the trunk about its own axis."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from skeleton_sequences import people_standing, predicted_of, reference_of, standing
from topview.body import JOINT_NAMES
from topview_lab.metrics import (
    Held,
    ReferenceSequence,
    evaluate_sequence,
    facing,
    pool,
    summarise,
    turns_deg,
)

FRAMES = 60
SIDE = {"left": "right", "right": "left"}
seeds = st.integers(0, 2**32 - 1)


def turned(joints: NDArray[np.float64], degrees: float) -> NDArray[np.float64]:
    """Joints [..., 3] of somebody upright, turned about the vertical through the neck."""
    neck = joints[..., [JOINT_NAMES.index("neck")], :]
    return neck + (joints - neck) @ Rotation.from_euler("y", degrees, degrees=True).as_matrix().T


def of_one(predicted: NDArray[np.float64], reference: NDArray[np.float64]) -> float:
    return float(turns_deg(reference[None], predicted[None])[0])


@given(st.floats(-180.0, 180.0), seeds)
def test_a_turn_is_told_whichever_way_the_body_lies(degrees: float, seed: int) -> None:
    rng = np.random.default_rng(seed)
    R, at = Rotation.random(1, rng).as_matrix()[0], rng.normal(size=3)
    true, found = (joints @ R.T + at for joints in (standing(), turned(standing(), degrees)))
    assert of_one(found, true) == pytest.approx(abs(degrees), abs=1e-6)
    assert of_one(2.0 * found, true) == pytest.approx(abs(degrees), abs=1e-6)


def test_who_is_told_left_for_right_faces_the_other_way() -> None:
    swapped = [
        JOINT_NAMES.index("_".join(SIDE.get(word, word) for word in name.split("_")))
        for name in JOINT_NAMES
    ]
    assert of_one(standing()[swapped], standing()) == pytest.approx(180.0)


def test_leaning_is_no_turn() -> None:
    lean = Rotation.from_euler("x", 50.0, degrees=True).as_matrix()
    assert of_one(standing() @ lean.T, standing()) == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize("joint", ["left_shoulder", "right_hip"])
def test_without_a_shoulder_or_a_hip_nothing_is_told(joint: str) -> None:
    lacking = standing()
    lacking[JOINT_NAMES.index(joint)] = np.nan
    assert np.isnan(of_one(lacking, standing()))
    assert np.isnan(of_one(standing(), lacking))


def measured(predicted: NDArray[np.float64], reference: ReferenceSequence) -> Held:
    return facing(pool(evaluate_sequence(predicted_of(predicted), reference)))


@pytest.mark.parametrize(("degrees", "share"), [(44.0, 1.0), (46.0, 0.5)])
def test_frames_of_the_first_second_do_not_count(degrees: float, share: float) -> None:
    truth = people_standing(FRAMES, 0.0)
    found = truth.copy()
    found[:30] = turned(found[:30], 180.0)
    found[45:] = turned(found[45:], degrees)
    assert measured(found, reference_of(truth)) == Held(30, share)


def test_the_first_second_is_each_persons_own() -> None:
    truth = people_standing(FRAMES, 0.0, 1.5)
    truth[:20, 1] = np.nan
    assert measured(truth, reference_of(truth)).count == 30 + 10


def test_who_is_not_found_faces_nowhere() -> None:
    truth = people_standing(FRAMES, 0.0)
    found = truth.copy()
    found[40:50] = np.nan
    assert measured(found, reference_of(truth)) == Held(20, 1.0)


def test_recordings_count_together() -> None:
    truth = people_standing(FRAMES, 0.0)
    right = evaluate_sequence(predicted_of(truth), reference_of(truth))
    wrong = evaluate_sequence(predicted_of(turned(truth, 90.0)), reference_of(truth))
    both = summarise(right.pooled([right, wrong])).facing
    assert both.count == 60
    assert_allclose(both.share, 0.5)
