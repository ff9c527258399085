"""Slots: everybody who is there has one, keeps it, and no more are used than people at once."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from made_frames import ABOUT, frames_with
from topview.records import InputError
from topview.skeletons import NOBODY_ID, SkeletonSequence, columns_as_slots

who_is_there = st.lists(st.lists(st.integers(1, 7), unique=True, max_size=4), max_size=12)


@given(who_is_there)
def test_everybody_who_is_there_has_one_slot_with_what_was_told_of_them(who):
    frames = frames_with(who)
    sequence = SkeletonSequence.from_frames(frames, ABOUT)
    assert sequence.person_ids.shape == (len(who), max(map(len, who), default=0))
    for f, frame in enumerate(frames):
        ids = sequence.person_ids[f]
        assert sorted(ids[ids != NOBODY_ID]) == sorted(frame.people["id"])
        for person in frame.people:
            (slot,) = np.flatnonzero(ids == person["id"])
            for name in (frame.people.dtype.names or ())[2:]:  # behind id and stature
                np.testing.assert_array_equal(getattr(sequence, name)[f, slot], person[name])
        assert np.isnan(sequence.joints_camera[f, ids == NOBODY_ID]).all()
        assert not sequence.joint_state[f, ids == NOBODY_ID].any()


@given(who_is_there)
def test_a_slot_is_kept_while_there_and_had_again_if_free(who):
    ids = SkeletonSequence.from_frames(frames_with(who), ABOUT).person_ids
    last_slot: dict[int, int] = {}
    for f in range(len(who)):
        slot_of = {int(i): s for s, i in enumerate(ids[f]) if i != NOBODY_ID}
        for person_id, slot in slot_of.items():
            old = last_slot.get(person_id, slot)
            was_there = f > 0 and person_id in ids[f - 1]
            assert slot == old if was_there else slot == old or ids[f, old] != NOBODY_ID
        last_slot |= slot_of


@given(who_is_there)
def test_the_table_tells_of_everybody(who):
    sequence = SkeletonSequence.from_frames(frames_with(who), ABOUT)
    everybody = sorted({i for ids in who for i in ids})
    assert sequence.people_ids.tolist() == everybody
    for p, person_id in enumerate(everybody):
        there = [f for f, ids in enumerate(who) if person_id in ids]
        assert (sequence.first_frame[p], sequence.last_frame[p]) == (there[0], there[-1])
        rows, slots = sequence.slots_of(person_id)
        assert rows.tolist() == there
        assert (sequence.person_ids[rows, slots] == person_id).all()


@given(who_is_there)
def test_columns_become_the_same_people(who):
    """A column for each person, as earlier files have it, tells the same."""
    sequence = SkeletonSequence.from_frames(frames_with(who), ABOUT)
    present = np.array([[i in ids for i in sequence.people_ids] for ids in who]).reshape(
        len(who), len(sequence.people_ids)
    )
    shuffled = np.random.default_rng(0).permutation(len(sequence.people_ids))
    told = columns_as_slots(
        sequence.people_ids[shuffled],
        present[:, shuffled],
        sequence.frame_index,
        sequence.heights_m[shuffled],
    )
    for name in ("people_ids", "first_frame", "last_frame", "heights_m"):
        np.testing.assert_array_equal(told[name], getattr(sequence, name))
    for f, ids in enumerate(who):
        assert sorted(told["person_ids"][f][told["person_ids"][f] != NOBODY_ID]) == sorted(ids)


@pytest.mark.parametrize("ids", [[3, 3], [0]])
def test_somebody_twice_and_nobody_are_refused(ids):
    with pytest.raises(InputError, match=r"frame 0 has people [03, ]+; each must be there once"):
        SkeletonSequence.from_frames(frames_with([ids]), ABOUT)
