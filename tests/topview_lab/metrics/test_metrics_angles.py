"""Relative angles, directions of bones and orientations of parts."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from skeleton_sequences import B, J, people_standing, predicted_of, reference_of
from topview.body import JOINT_NAMES, PART_NAMES
from topview_lab.metrics import (
    DIRECTION_GROUPS,
    DIRECTIONS,
    PART_GROUPS,
    RELATIVE_ANGLE_GROUPS,
    RELATIVE_ANGLES,
    Errors,
    Pool,
    direction_errors,
    evaluate_sequence,
    orientation_errors,
    pool,
    relative_angle_errors,
    summarise,
)

Array = NDArray[np.float64]
seeds = st.integers(0, 2**32 - 1)
few = settings(max_examples=25)
JOINTS_ONLY = (relative_angle_errors, direction_errors)


def pooled(predicted: Array, reference: Array, Rs: Array | None = None, **other: Any) -> Pool:
    return pool(evaluate_sequence(predicted_of(predicted, Rs), reference_of(reference, **other)))


def wrong(errors: Errors) -> dict[str, float]:
    """The columns of the first person-frame that are not right, in degrees."""
    return {
        name: round(float(error), 6)
        for name, error in zip(errors.names, errors.raw[0], strict=True)
        if error > 1e-4
    }


def turned(joints: Array, names: list[str], about: str, axis: str, degrees: float) -> Array:
    """The named joints turned about a joint."""
    out = joints.copy()
    columns = [JOINT_NAMES.index(name) for name in names]
    centre = joints[..., [JOINT_NAMES.index(about)], :]
    R = Rotation.from_euler(axis, degrees, degrees=True).as_matrix()
    out[..., columns, :] = centre + (joints[..., columns, :] - centre) @ R.T
    return out


class TestLaws:
    @few
    @given(seeds)
    def test_a_perfect_prediction_has_no_error(self, seed: int) -> None:
        joints = people_standing(3, 0.0, 2.0)
        joints += np.random.default_rng(seed).normal(0.0, 0.05, joints.shape)
        for measure in JOINTS_ONLY:
            errors = measure(pooled(joints, joints))
            assert errors.raw == pytest.approx(0.0, abs=1e-5)
            assert errors.offset_out == pytest.approx(0.0, abs=1e-5)

    @few
    @given(seeds)
    def test_relative_angles_do_not_know_where_the_camera_is(self, seed: int) -> None:
        rng = np.random.default_rng(seed)
        truth = people_standing(3, 0.0)
        R, t = Rotation.random(rng=rng).as_matrix(), rng.normal(0.0, 0.2, 3)
        predicted = (truth - truth.mean(2, keepdims=True)) @ R.T + truth.mean(2, keepdims=True)
        evaluation = evaluate_sequence(
            predicted_of(predicted + t), reference_of(truth), gate_m=100.0
        )
        assert relative_angle_errors(pool(evaluation)).raw == pytest.approx(0.0, abs=1e-5)

    @few
    @given(seeds)
    def test_directions_do_not_know_how_long_or_where_bones_are(self, seed: int) -> None:
        rng = np.random.default_rng(seed)
        truth = people_standing(3, 0.0)
        predicted = truth * rng.uniform(0.9, 1.1) + rng.normal(0.0, 0.05, 3)
        assert direction_errors(pooled(predicted, truth)).raw == pytest.approx(0.0, abs=1e-5)

    @few
    @given(seeds)
    def test_an_offset_that_is_constant_in_the_parts_frame_vanishes(self, seed: int) -> None:
        rng = np.random.default_rng(seed)
        truth = people_standing(3, 0.0)
        predicted = truth + rng.uniform(-0.05, 0.05, (J, 3))
        for measure in JOINTS_ONLY:
            errors = measure(pooled(predicted, truth))
            assert errors.raw.max() > 0.5
            assert errors.offset_out == pytest.approx(0.0, abs=1e-5)

    @few
    @given(seeds)
    def test_a_constant_turn_of_a_part_vanishes(self, seed: int) -> None:
        rng = np.random.default_rng(seed)
        joints = people_standing(4, 0.0)
        true = Rotation.random(4 * B, rng).as_matrix().reshape(4, 1, B, 3, 3)
        turn = Rotation.from_rotvec(np.radians([0.0, 25.0, 0.0])).as_matrix()
        errors = orientation_errors(
            pooled(joints, joints, true @ turn, part_names=PART_NAMES, Rs_camera_part=true)
        )
        assert errors.raw == pytest.approx(25.0)
        assert errors.offset_out == pytest.approx(0.0, abs=1e-5)

    def test_every_direction_and_relative_angle_is_in_one_group(self) -> None:
        for groups, names in (
            (RELATIVE_ANGLE_GROUPS, [angle.name for angle in RELATIVE_ANGLES]),
            (DIRECTION_GROUPS, [bone.part for bone in DIRECTIONS]),
            (PART_GROUPS, [bone.part for bone in DIRECTIONS]),
        ):
            assert sorted(name for group in groups.values() for name in group) == sorted(names)

    def test_bones_before_and_after_a_joint_are_no_straight_guess(self) -> None:
        """Each relative angle changes when its outer joint moves."""
        truth = people_standing(1, 0.0)
        for angle in RELATIVE_ANGLES:
            joints = turned(truth, [angle.after[1]], angle.after[0], "z", 20.0)
            assert angle.name in wrong(relative_angle_errors(pooled(joints, truth)))


class TestExamples:
    def test_a_forearm_lifted_30_degrees(self) -> None:
        truth = people_standing(1, 0.0)
        joints = turned(truth, ["left_hand"], "left_elbow", "x", -30.0)
        of = pooled(joints, truth)
        assert wrong(relative_angle_errors(of)) == {"left_elbow": 30.0}
        assert wrong(direction_errors(of)) == {"left_forearm": 30.0}
        table = summarise(evaluate_sequence(predicted_of(joints), reference_of(truth)))
        assert table.directions_deg["all"]["arm joints"].raw.mean == pytest.approx(30.0 / 4)
        assert table.directions_deg["all"]["arm joints"].raw.within_10 == 0.75
        assert table.directions_deg["all"]["forearms"].raw.mean == pytest.approx(15.0)
        assert table.relative_angles_deg["all"]["arm joints"].raw.mean == pytest.approx(5.0)
        assert table.relative_angles_deg["all"]["leg joints"].raw.mean == 0.0

    def test_a_leg_swung_to_the_front(self) -> None:
        """The angle to the line of the hips, about which it swings, stays right."""
        truth = people_standing(1, 0.0)
        joints = turned(truth, ["left_knee", "left_ankle"], "left_hip", "x", -40.0)
        of = pooled(joints, truth)
        assert wrong(relative_angle_errors(of)) == {"left_leg_to_spine": 40.0}
        assert wrong(direction_errors(of)) == {"left_upper_leg": 40.0, "left_lower_leg": 40.0}

    def test_a_body_that_leans_as_a_whole(self) -> None:
        """No joint angle is wrong, yet every direction but the shoulder line's."""
        truth = people_standing(1, 0.0)
        of = pooled(turned(truth, list(JOINT_NAMES), "pelvis", "x", 12.0), truth)
        assert wrong(relative_angle_errors(of)) == {}
        directions = wrong(direction_errors(of))
        assert set(directions.values()) == {12.0}
        assert set(directions) == {bone.part for bone in DIRECTIONS} - {"shoulder_line"}

    def test_a_twist_of_the_shoulders(self) -> None:
        truth = people_standing(1, 0.0)
        shoulders = [f"{side}_shoulder" for side in ("left", "right")]
        of = pooled(turned(truth, shoulders, "neck", "y", 15.0), truth)
        assert wrong(direction_errors(of))["shoulder_line"] == pytest.approx(15.0)
        table = direction_errors(of).of(PART_GROUPS["upper torso"]).compare()
        assert table.raw.mean == pytest.approx(7.5)

    def test_orientations_are_told_where_the_reference_does(self) -> None:
        joints = people_standing(2, 0.0)
        Rs = np.tile(np.eye(3), (2, 1, 1, 1, 1))
        Rs[1] = Rotation.from_euler("y", 8.0, degrees=True).as_matrix()
        of = pooled(joints, joints, part_names=("head",), Rs_camera_part=Rs)
        errors = orientation_errors(of)
        assert errors.of(("head",)).raw[:, 0] == pytest.approx([0.0, 8.0], abs=1e-6)
        assert errors.of(("head",)).offset_out[:, 0] == pytest.approx([4.0, 4.0], abs=1e-6)
        assert np.isfinite(errors.raw).sum() == 2

    def test_frames_are_chosen_by_what_is_hidden(self) -> None:
        """As Table 6.3 wants it: the torso, where others hide none or 60 % of it."""
        truth = people_standing(3, 0.0)
        joints = truth.copy()
        joints[2] = turned(truth, list(JOINT_NAMES), "pelvis", "x", 9.0)[2]
        hidden = np.zeros((3, 1, J))
        hidden[2] = 0.6
        of = pooled(joints, truth, occluded_by_person=hidden, occluded_by_self=hidden / 2.0)
        share = of.hidden_share(("neck", "torso", "pelvis"), ("another person", "an object"))
        assert share == pytest.approx([0.0, 0.0, 0.6])
        assert of.hidden_share(("neck",)) == pytest.approx([0.0, 0.0, 0.9])
        torso = direction_errors(of).of(DIRECTION_GROUPS["torso joints"])
        assert torso.compare(share < 0.05).raw.mean == pytest.approx(0.0, abs=1e-6)
        assert torso.compare(share > 0.5).raw.mean == pytest.approx(6.0)
        assert torso.compare().raw.count == 9

    def test_joints_on_the_same_spot_have_no_direction(self) -> None:
        truth = people_standing(1, 0.0)
        joints = truth.copy()
        joints[..., JOINT_NAMES.index("left_hand"), :] = joints[
            ..., JOINT_NAMES.index("left_elbow"), :
        ]
        errors = direction_errors(pooled(joints, truth))
        assert np.isnan(errors.of(("left_forearm",)).raw).all()
        assert np.isfinite(errors.raw).sum() == len(DIRECTIONS) - 1
