"""It does not matter to any number whether people share slots or have columns of their own."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from made_frames import frames_with
from skeleton_sequences import people_standing, predicted_of, reference_of
from topview.body import JOINT_NAMES, PART_NAMES
from topview.skeletons import About, SkeletonSequence, TrackedFrame
from topview_lab.metrics import evaluate_sequence, summarise

ABOUT = About(JOINT_NAMES, PART_NAMES)
PLACES_M = (-0.9, -0.3, 0.3, 0.9)
who_is_there = st.lists(
    st.lists(st.integers(1, 5), unique=True, max_size=3), min_size=2, max_size=10
)


@given(who_is_there, st.integers(0, 2**32 - 1))
def test_slots_are_measured_as_columns(who, seed):
    rng = np.random.default_rng(seed)
    truth = people_standing(len(who), *PLACES_M)
    truth[rng.random(truth.shape[:2]) < 0.2] = np.nan
    reference = reference_of(truth)
    frames = [moved(frame, rng) for frame in frames_with(who, ABOUT)]
    slots = SkeletonSequence.from_frames(frames, ABOUT)
    columns = in_columns(slots)
    told = [summarise(evaluate_sequence(each, reference)) for each in (slots, columns)]
    np.testing.assert_equal(told[0].people, told[1].people)
    for name in ("hota", "detection", "association", "mota", "motp_cm"):
        a, b = (getattr(each.tracking, name) for each in told)
        np.testing.assert_allclose(a, b, rtol=1e-12, err_msg=name)
    a, b = (evaluate_sequence(each, reference).sequences[0].samples for each in (slots, columns))
    for name in ("found", "stature_m", "predicted_camera", "joint_state", "Rs_camera_part"):
        np.testing.assert_array_equal(getattr(a, name), getattr(b, name), err_msg=name)


def moved(frame: TrackedFrame, rng: np.random.Generator) -> TrackedFrame:
    """With its people near somebody, or between two."""
    for row in range(len(frame.people)):
        place_m = rng.choice(PLACES_M) + rng.normal(0.0, 0.15)
        frame.people["joints_camera"][row] = people_standing(1, place_m)[0, 0]
    return frame


def in_columns(slots: SkeletonSequence) -> SkeletonSequence:
    """Everybody in a slot of their own."""
    F, P = len(slots.frame_index), len(slots.people_ids)
    arrays = {}
    for name, nothing in (
        ("joints_camera", np.nan),
        ("joint_state", 0),
        ("joint_confidence", 0),
        ("Ts_camera_part", np.nan),
    ):
        of_slots = getattr(slots, name)
        arrays[name] = np.full((F, P, *of_slots.shape[2:]), nothing, of_slots.dtype)
        for p, person_id in enumerate(slots.people_ids):
            rows, columns = slots.slots_of(person_id)
            arrays[name][rows, p] = of_slots[rows, columns]
    assert arrays["joints_camera"].shape[2] == len(JOINT_NAMES)
    return predicted_of(
        arrays.pop("joints_camera"),
        arrays.pop("Ts_camera_part")[..., :3, :3],
        person_ids=slots.people_ids,
        heights_m=slots.heights_m,
        **arrays,
    )
