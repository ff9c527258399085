from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from skeleton_sequences import (
    STATURE_M,
    B,
    J,
    people_standing,
    predicted_of,
    reference_of,
    standing,
)
from topview.body import JOINT_NAMES, JOINTS, PART_NAMES
from topview.records import InputError
from topview_lab.metrics import (
    BONES,
    Evaluation,
    Summary,
    evaluate_sequence,
    statistic,
    summarise,
)

seeds = st.integers(0, 2**32 - 1)
few = settings(max_examples=25)


def random_people(rng: np.random.Generator, frames: int = 6, people: int = 2):
    """[F, P, J, 3] joints of people 2 m apart, and [F, P, B, 3, 3] part rotations."""
    joints = people_standing(frames, *np.arange(people) * 2.0)
    joints += rng.normal(0.0, 0.05, joints.shape)
    rotations = Rotation.random(frames * people * B, rng).as_matrix()
    return joints, rotations.reshape(frames, people, B, 3, 3)


def numbers(summary: Summary) -> list[float]:
    """All numbers of the tables in a fixed order."""
    return [
        value
        for tables in (summary.joints_cm, summary.axes_deg)
        for table in tables.values()
        for comparison in table.values()
        for s in (comparison.raw, comparison.offset_out)
        for value in (s.count, s.mean, s.std, s.within_10)
    ]


class TestLaws:
    @few
    @given(seeds)
    def test_identical_sequences_have_no_error(self, seed: int) -> None:
        joints, rotations = random_people(np.random.default_rng(seed))
        summary = summarise(
            evaluate_sequence(predicted_of(joints, rotations), reference_of(joints))
        )
        everything = summary.joints_cm["all"]["all"].raw
        assert everything.count == 6 * 2 * J
        assert everything.mean == 0.0
        assert everything.within_10 == 1.0
        assert (summary.recall, summary.precision) == (1.0, 1.0)
        assert summary.people.id_swaps == summary.people.false_people == 0

    @few
    @given(seeds)
    def test_an_offset_that_is_constant_in_the_parts_frame_vanishes(self, seed: int) -> None:
        rng = np.random.default_rng(seed)
        joints, rotations = random_people(rng)
        statures_m = np.array([1.2, 1.9])
        offsets = rng.uniform(-0.05, 0.05, (J, 3))
        part = [joint.part for joint in JOINTS]
        moved = np.einsum("fpjab,jb->fpja", rotations[:, :, part], offsets)
        reference = reference_of(joints + moved * statures_m[:, None, None])
        summary = summarise(
            evaluate_sequence(predicted_of(joints, rotations, heights_m=statures_m), reference)
        )
        for j, name in enumerate(JOINT_NAMES):
            comparison = summary.joints_cm["all"][name]
            expected_cm = 100.0 * np.linalg.norm(offsets[j]) * statures_m.mean()
            assert comparison.raw.mean == pytest.approx(expected_cm)
            assert comparison.offset_out.mean == pytest.approx(0.0, abs=1e-9)
            assert summary.joint_offsets[name] == pytest.approx(offsets[j])

    @few
    @given(seeds)
    def test_an_axis_that_is_constantly_off_is_right_once_that_is_out(self, seed: int) -> None:
        angles = np.random.default_rng(seed).uniform(-180.0, 180.0, (6, 1))
        turned = Rotation.from_euler("y", angles, degrees=True).as_matrix()
        lean = Rotation.from_euler("x", 20.0, degrees=True).as_matrix()
        # Every part leans in its own frame, and turns about the vertical from frame to frame.
        rotations = np.broadcast_to((turned @ lean)[:, None, None], (6, 1, B, 3, 3))
        upright = people_standing(6, 0.0)
        summary = summarise(
            evaluate_sequence(predicted_of(upright, rotations), reference_of(upright))
        )
        for bone in BONES:
            comparison = summary.axes_deg["all"][bone.part]
            assert comparison.raw.mean == pytest.approx(20.0)
            assert comparison.offset_out.mean == pytest.approx(0.0, abs=1e-5)

    @few
    @given(seeds)
    def test_moving_both_rigidly_changes_nothing(self, seed: int) -> None:
        rng = np.random.default_rng(seed)
        joints, rotations = random_people(rng)
        truth = joints + rng.normal(0.0, 0.04, joints.shape)
        still = evaluate_sequence(predicted_of(joints, rotations), reference_of(truth))
        R, t = Rotation.random(rng=rng).as_matrix(), rng.normal(0.0, 3.0, 3)
        moved = evaluate_sequence(
            predicted_of(joints @ R.T + t, R @ rotations), reference_of(truth @ R.T + t)
        )
        assert numbers(summarise(moved)) == pytest.approx(numbers(summarise(still)), nan_ok=True)

    @few
    @given(seeds, st.permutations(range(3)))
    def test_the_order_of_reference_people_changes_nothing(
        self, seed: int, order: list[int]
    ) -> None:
        rng = np.random.default_rng(seed)
        joints, rotations = random_people(rng, people=3)
        truth = joints + rng.normal(0.0, 0.04, joints.shape)
        hidden = rng.uniform(0.0, 1.0, truth.shape[:3])
        predicted = predicted_of(joints, rotations)
        one = evaluate_sequence(predicted, reference_of(truth, occluded_by_person=hidden))
        other = evaluate_sequence(
            predicted, reference_of(truth[:, order], occluded_by_person=hidden[:, order])
        )
        for offsets in ("set", "person"):
            one_summary, other_summary = summarise(one, offsets), summarise(other, offsets)
            assert numbers(other_summary) == pytest.approx(numbers(one_summary), nan_ok=True)
            assert other_summary.people == one_summary.people

    @few
    @given(seeds, st.integers(1, 5))
    def test_a_recording_cut_in_two_pools_to_the_same_numbers(self, seed: int, cut: int) -> None:
        rng = np.random.default_rng(seed)
        joints, rotations = random_people(rng)
        truth = joints + rng.normal(0.0, 0.04, joints.shape)
        whole = evaluate_sequence(predicted_of(joints, rotations), reference_of(truth), "", 3.0)
        parts = Evaluation.pooled(
            evaluate_sequence(
                predicted_of(joints[frames], rotations[frames]),
                reference_of(truth[frames]),
                "",
                1.5,
            )
            for frames in (slice(None, cut), slice(cut, None))
        )
        pooled, expected = summarise(parts), summarise(whole)
        assert numbers(pooled) == pytest.approx(numbers(expected), nan_ok=True)
        assert pooled.people == expected.people
        assert pooled.frames_per_second == pytest.approx(expected.frames_per_second)
        assert [sequence.people.frames for sequence in pooled.sequences] == [cut, 6 - cut]

    @few
    @given(seeds)
    def test_the_offset_of_each_person_takes_out_at_least_what_the_offset_of_the_set_does(
        self, seed: int
    ) -> None:
        rng = np.random.default_rng(seed)
        joints, _ = random_people(rng)
        truth = joints + rng.normal(0.0, 0.03, (1, 2, J, 3))
        evaluation = evaluate_sequence(predicted_of(joints), reference_of(truth))
        by_person = summarise(evaluation, "person")
        assert by_person.joints_cm["all"]["all"].offset_out.mean == pytest.approx(0.0, abs=1e-9)
        assert summarise(evaluation, "set").joints_cm["all"]["all"].offset_out.mean > 0.1
        assert by_person.joint_offsets == {}


class TestExamples:
    def test_statistics_of_three_numbers(self) -> None:
        result = statistic(np.array([0.0, 10.0, np.nan, 20.0]))
        assert (result.count, result.mean) == (3, 10.0)
        assert result.std == pytest.approx(8.16497, abs=1e-5)
        assert result.within_10 == pytest.approx(2 / 3)

    def test_statistics_of_nothing(self) -> None:
        result = statistic(np.array([np.nan]))
        assert result.count == 0
        assert np.isnan([result.mean, result.std, result.within_10]).all()

    def test_one_hand_12_cm_too_high(self) -> None:
        truth = people_standing(4, 0.0)
        joints = truth.copy()
        hand = JOINT_NAMES.index("left_hand")
        joints[:, 0, hand] += (0.0, -0.12, 0.0)
        summary = summarise(evaluate_sequence(predicted_of(joints), reference_of(truth)))
        table = summary.joints_cm["all"]
        assert table["left_hand"].raw.mean == pytest.approx(12.0)
        assert table["left_hand"].raw.within_10 == 0.0
        assert table["left_hand"].offset_out.mean == pytest.approx(0.0, abs=1e-9)
        assert table["right_hand"].raw.mean == 0.0
        assert table["all"].raw.mean == pytest.approx(12.0 / J)
        assert table["all"].raw.within_10 == pytest.approx(15 / 16)
        assert summary.joint_offsets["left_hand"] == pytest.approx((0.0, 0.12 / STATURE_M, 0.0))

    def test_a_jittering_hand_keeps_its_jitter(self) -> None:
        truth = people_standing(2, 0.0)
        joints = truth.copy()
        hand = JOINT_NAMES.index("left_hand")
        joints[0, 0, hand, 0] += 0.10
        joints[1, 0, hand, 0] += 0.04
        summary = summarise(evaluate_sequence(predicted_of(joints), reference_of(truth)))
        table = summary.joints_cm["all"]["left_hand"]
        assert table.raw.mean == pytest.approx(7.0)
        assert table.raw.std == pytest.approx(3.0)
        assert table.offset_out.mean == pytest.approx(3.0)

    def test_what_is_wrong_where_a_hand_is_hidden_is_no_offset(self) -> None:
        truth = people_standing(4, 0.0)
        joints, hidden = truth.copy(), np.zeros(truth.shape[:3])
        hand = JOINT_NAMES.index("left_hand")
        joints[:, 0, hand] += (0.0, -0.02, 0.0)
        joints[2:, 0, hand] += (0.4, 0.0, 0.0)
        hidden[2:, 0, hand] = (0.06, 1.0)
        reference = reference_of(truth, occluded_by_person=hidden)
        summary = summarise(evaluate_sequence(predicted_of(joints), reference))
        assert summary.joint_offsets["left_hand"] == pytest.approx((0.0, 0.02 / STATURE_M, 0.0))
        assert summary.joints_cm["all"]["left_hand"].offset_out.mean == pytest.approx(20.0)

    def test_a_joint_that_is_never_in_view_has_an_offset_too(self) -> None:
        truth = people_standing(2, 0.0)
        joints = truth.copy()
        joints[:, 0, JOINT_NAMES.index("left_hand")] += (0.0, -0.02, 0.0)
        reference = reference_of(truth, occluded_by_person=np.ones(truth.shape[:3]))
        summary = summarise(evaluate_sequence(predicted_of(joints), reference))
        assert summary.joints_cm["all"]["left_hand"].offset_out.mean == pytest.approx(0.0, abs=1e-9)

    def test_few_frames_in_view_tell_no_offset(self) -> None:
        """They may be of one wrong pose."""
        truth = people_standing(20, 0.0)
        joints, hidden = truth.copy(), np.ones(truth.shape[:3])
        ankle = JOINT_NAMES.index("left_ankle")
        joints[:, 0, ankle] += (0.0, -0.02, 0.0)
        joints[0, 0, ankle] += (0.4, 0.0, 0.0)
        hidden[0, 0, ankle] = 0.0
        reference = reference_of(truth, occluded_by_person=hidden)
        summary = summarise(evaluate_sequence(predicted_of(joints), reference))
        table = summary.joints_cm["all"]["left_ankle"]
        assert table.offset_out.mean < table.raw.mean + 1e-9

    def test_a_forearm_30_degrees_off(self) -> None:
        joints = people_standing(1, 0.0)
        rotations = np.tile(np.eye(3), (1, 1, B, 1, 1))
        part = PART_NAMES.index("left_forearm")
        rotations[0, 0, part] = Rotation.from_euler("x", 30, degrees=True).as_matrix()
        table = summarise(
            evaluate_sequence(predicted_of(joints, rotations), reference_of(joints))
        ).axes_deg["all"]
        assert table["left_forearm"].raw.mean == pytest.approx(30.0)
        assert table["left_forearm"].raw.within_10 == 0.0
        assert table["head"].raw.mean == pytest.approx(0.0)
        assert table["all"].raw.mean == pytest.approx(30.0 / 11)

    def test_errors_are_split_by_who_hides_the_joint(self) -> None:
        truth = people_standing(1, 0.0)
        joints = truth.copy()
        shares = dict.fromkeys(JOINT_NAMES, np.nan)
        for name, share, error_m in (
            ("left_elbow", 0.0, 0.01),
            ("left_hand", 0.3, 0.02),
            ("right_elbow", 0.6, 0.04),
        ):
            shares[name] = share
            joints[0, 0, JOINT_NAMES.index(name), 2] += error_m
        hidden = np.array(list(shares.values())).reshape(1, 1, J)
        summary = summarise(
            evaluate_sequence(predicted_of(joints), reference_of(truth, occluded_by_person=hidden))
        )
        means = {
            occlusion: (table["all"].raw.count, round(table["all"].raw.mean, 6))
            for occlusion, table in summary.joints_cm.items()
            if table["all"].raw.count
        }
        assert means == {
            "all": (16, round(7.0 / 16, 6)),
            "unhidden": (1, 1.0),
            "hidden ≥ 30%": (2, 3.0),
            "hidden ≥ 60%": (1, 4.0),
            "hidden by another person ≥ 30%": (2, 3.0),
            "hidden by another person ≥ 60%": (1, 4.0),
        }

    def test_a_part_is_hidden_as_much_as_its_two_joints_on_average(self) -> None:
        shares = np.full((1, 1, J), np.nan)
        shares[..., JOINT_NAMES.index("left_elbow")] = 0.2
        shares[..., JOINT_NAMES.index("left_hand")] = 0.6
        joints = people_standing(1, 0.0)
        summary = summarise(
            evaluate_sequence(predicted_of(joints), reference_of(joints, occluded_by_self=shares))
        )
        hidden = summary.axes_deg["hidden by oneself ≥ 30%"]
        assert {name for name, c in hidden.items() if c.raw.count} == {"left_forearm", "all"}
        assert summary.axes_deg["hidden ≥ 60%"]["all"].raw.count == 0

    def test_the_references_stature_scales_the_offsets_where_it_is_known(self) -> None:
        truth = people_standing(1, 0.0)
        joints = truth + np.array([0.0, 0.0, 0.06])
        reference = reference_of(truth, statures_m=np.array([1.2]))
        summary = summarise(evaluate_sequence(predicted_of(joints), reference))
        assert summary.joint_offsets["neck"] == pytest.approx((0.0, 0.0, -0.05))

    def test_only_frames_that_both_have_are_evaluated(self) -> None:
        joints = people_standing(5, 0.0)
        predicted = predicted_of(joints[:3], frame_index=np.array([0, 2, 3]))
        reference = reference_of(joints[1:])
        reference = replace(reference, frame_index=np.arange(1, 5))
        (sequence,) = evaluate_sequence(predicted, reference).sequences
        assert sequence.people.frames == 2
        assert sequence.people.frames_unread == 2
        assert sequence.people.missed == 0

    def test_joints_that_a_system_does_not_have_are_not_counted(self) -> None:
        joints = people_standing(2, 0.0)
        few_joints = ("neck", "left_hand")
        columns = [JOINT_NAMES.index(name) for name in few_joints]
        predicted = predicted_of(
            joints[:, :, columns],
            joint_names=few_joints,
            joint_state=np.ones((2, 1, 2), np.uint8),
            joint_confidence=np.ones((2, 1, 2), np.float32),
        )
        table = summarise(evaluate_sequence(predicted, reference_of(joints))).joints_cm["all"]
        counts = {name: c.raw.count for name, c in table.items() if c.raw.count}
        assert counts == {"neck": 2, "left_hand": 2, "all": 4}

    def test_without_orientations_only_the_offsets_are_unknown(self) -> None:
        joints = people_standing(2, 0.0)
        predicted = predicted_of(joints, np.full((2, 1, B, 3, 3), np.nan))
        summary = summarise(evaluate_sequence(predicted, reference_of(joints)))
        assert summary.joints_cm["all"]["all"].raw.count == 2 * J
        assert summary.joints_cm["all"]["all"].offset_out.count == 0
        assert summary.axes_deg["all"]["all"].raw.count == 0


class TestBadInput:
    def test_no_common_frame(self) -> None:
        joints = people_standing(2, 0.0)
        late = replace(reference_of(joints), frame_index=np.array([7, 8]))
        with pytest.raises(InputError, match=r"clip: no tracked frame .* 0 to 1, reference 7 to 8"):
            evaluate_sequence(predicted_of(joints), late, "clip")

    def test_a_present_person_needs_a_joint(self) -> None:
        joints = people_standing(3, 0.0)
        joints[1] = np.nan
        with pytest.raises(InputError, match="person 1 is present in frame 1 but"):
            reference_of(joints, present=np.ones((3, 1), bool))

    def test_shapes(self) -> None:
        with pytest.raises(InputError, match=r"occluded_by_person has shape \(3, 1\)"):
            reference_of(people_standing(3, 0.0), occluded_by_person=np.zeros((3, 1)))

    @pytest.mark.parametrize(
        ("field", "message"),
        [
            ({"occluded_by_object": np.zeros((3, 1))}, r"occluded_by_object has shape \(3, 1\)"),
            ({"occluded_by_self": np.zeros((3, 2, J))}, "occluded_by_self has shape"),
            ({"outside": np.full((3, 1, J), 30.0)}, "outside has the share 30; it must be 0 to 1"),
            ({"occluded_by_person": np.full((3, 1, J), -1.0)}, "the share -1; it must be 0 to 1"),
            ({"actions": np.array(["boxing"])}, r"actions has shape .* must be \(3, 1\)"),
            ({"bodies": ("man", "woman")}, "bodies describes 2 people; it must be 1"),
            ({"Rs_camera_part": np.zeros((3, 1, 2, 3, 3))}, r"must be \(3, 1, 0, 3, 3\)"),
        ],
    )
    def test_what_else_is_known(self, field: dict, message: str) -> None:
        with pytest.raises(InputError, match=message):
            reference_of(people_standing(3, 0.0), **field)

    def test_unknown_shares_and_rounded_ones_are_right(self) -> None:
        shares = np.array([np.nan, np.float32(1.0000001), *[0.0] * (J - 2)]).reshape(1, 1, J)
        assert reference_of(people_standing(1, 0.0), outside=shares).outside is shares

    def test_frames_given_twice(self) -> None:
        with pytest.raises(InputError, match="does not rise"):
            reference_of(people_standing(3, 0.0), frame_index=np.array([0, 0, 1]))


def test_standing_people_have_straight_parts() -> None:
    """What the other tests rest on."""
    joints = standing()
    for bone in BONES:
        start, end = (joints[JOINT_NAMES.index(name)] for name in (bone.start, bone.end))
        direction = (end - start) / np.linalg.norm(end - start)
        assert direction == pytest.approx((0.0, 1.0, 0.0))
