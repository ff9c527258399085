"""Numbers by occlusion, cause, action and body; odd input; and the report of it all."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import replace
from io import StringIO
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rich.console import Console
from scipy.spatial.transform import Rotation

from skeleton_sequences import B, J, people_standing, predicted_of, reference_of
from topview.body import JOINT_NAMES, PART_NAMES
from topview.records import InputError
from topview.skeletons import SkeletonSequence
from topview_lab.evaluate.report import print_report, write_json
from topview_lab.metrics import (
    Evaluation,
    ReferenceSequence,
    SplitRecall,
    Summary,
    evaluate_sequence,
    summarise,
)

seeds = st.integers(0, 2**32 - 1)
few = settings(max_examples=15)
F, P = 6, 2
TIERS = {"unhidden", "hidden ≥ 30%", "hidden ≥ 60%"}


def knowing_all(seed: int, noise_m: float = 0.05) -> tuple[SkeletonSequence, ReferenceSequence]:
    """People tracked roughly, with a reference that tells everything."""
    rng = np.random.default_rng(seed)
    truth = people_standing(F, 0.0, 2.0) + rng.normal(0.0, 0.03, (F, P, J, 3))
    true_Rs = Rotation.random(F * P * B, rng).as_matrix().reshape(F, P, B, 3, 3)
    turns = Rotation.from_rotvec(rng.normal(0.0, noise_m, (F * P * B, 3))).as_matrix()
    shares = rng.dirichlet([2.0, 0.5, 0.5, 0.5, 0.5], (F, P, J))
    confidence = rng.random((F, P, J)) if noise_m else np.ones((F, P, J))
    predicted = predicted_of(
        truth + rng.normal(0.0, noise_m, truth.shape),
        true_Rs @ turns.reshape(true_Rs.shape),
        joint_confidence=confidence.astype(np.float32),
        joint_state=rng.integers(1, 6, (F, P, J)).astype(np.uint8),
    )
    reference = reference_of(
        truth,
        occluded_by_person=shares[..., 1],
        occluded_by_self=shares[..., 2],
        occluded_by_object=shares[..., 3],
        outside=shares[..., 4],
        actions=np.array([["boxing", "standing"]] * 3 + [["boxing", ""]] * 3),
        bodies=("woman 1.62 m", "man 1.80 m"),
        part_names=PART_NAMES,
        Rs_camera_part=true_Rs,
    )
    return predicted, reference


def numbers(value: Any) -> Iterator[float]:
    """All numbers of a summary, in its order."""
    if isinstance(value, dict):
        for item in value.values():
            yield from numbers(item)
    elif isinstance(value, list):
        for item in value:
            yield from numbers(item)
    elif isinstance(value, (int, float)):
        yield value
    elif value is None:
        yield float("nan")


def all_numbers(summary: Summary) -> list[float]:
    return list(numbers(json.loads(msgspec.json.encode(summary))))


class TestLaws:
    @few
    @given(seeds)
    def test_a_perfect_prediction_is_perfect_in_everything(self, seed: int) -> None:
        summary = summarise(evaluate_sequence(*knowing_all(seed, noise_m=0.0)))
        for family in (
            summary.joints_cm,
            summary.relative_angles_deg,
            summary.directions_deg,
            summary.orientations_deg,
        ):
            for table in family.values():
                for comparison in table.values():
                    for s in (comparison.raw, comparison.offset_out):
                        if s.count:
                            assert s.mean == pytest.approx(0.0, abs=1e-4)
                            assert s.within_10 == 1.0
            assert family["all"]["all"].raw.count > 0
        assert summary.within_10_cm["all"].raw == summary.within_10_cm["all"].ranked == 1.0
        tracking = summary.tracking
        assert (tracking.hota, tracking.mota, tracking.motp_cm) == pytest.approx((1.0, 1.0, 0.0))
        assert summary.calibration.expected_error == summary.calibration.brier == 0.0
        assert all(found.recall == 1.0 for found in summary.found.values() if found.count)

    @few
    @given(seeds)
    def test_moving_the_camera_changes_nothing(self, seed: int) -> None:
        predicted, reference = knowing_all(seed)
        rng = np.random.default_rng(seed)
        R, t = Rotation.random(rng=rng).as_matrix(), rng.normal(0.0, 3.0, 3)
        assert reference.Rs_camera_part is not None
        Ts_moved = predicted.Ts_camera_part.copy()
        Ts_moved[..., :3, :3] = R @ Ts_moved[..., :3, :3]
        moved = (
            replace(
                predicted, joints_camera=predicted.joints_camera @ R.T + t, Ts_camera_part=Ts_moved
            ),
            replace(
                reference,
                joints_camera=reference.joints_camera @ R.T + t,
                Rs_camera_part=R @ reference.Rs_camera_part,
            ),
        )
        still = all_numbers(summarise(evaluate_sequence(predicted, reference)))
        assert all_numbers(summarise(evaluate_sequence(*moved))) == pytest.approx(
            still, nan_ok=True, abs=1e-6
        )

    @few
    @given(seeds)
    def test_splits_by_amount_nest_and_those_by_label_sum_up(self, seed: int) -> None:
        tables = summarise(evaluate_sequence(*knowing_all(seed))).joints_cm
        count = {split: table["all"].raw.count for split, table in tables.items()}
        assert count["hidden ≥ 60%"] <= count["hidden ≥ 30%"] <= count["all"] - count["unhidden"]
        assert count["body: woman 1.62 m"] + count["body: man 1.80 m"] == count["all"]
        assert (count["action: boxing"], count["action: standing"]) == (F * J, 3 * J)
        assert "action: " not in count
        for table in tables.values():
            assert table["all"].raw.count == sum(table[name].raw.count for name in JOINT_NAMES)

    @few
    @given(seeds)
    def test_pooled_recordings_keep_their_labels(self, seed: int) -> None:
        predicted, reference = knowing_all(seed)
        silent = replace(reference, actions=None, bodies=None)
        pooled = Evaluation.pooled(evaluate_sequence(predicted, r) for r in (reference, silent))
        tables = summarise(pooled).joints_cm
        assert tables["all"]["all"].raw.count == 2 * F * P * J
        assert tables["body: man 1.80 m"]["all"].raw.count == F * J

    def test_the_tiers_are_always_there(self) -> None:
        joints = people_standing(2, 0.0)
        tables = summarise(evaluate_sequence(predicted_of(joints), reference_of(joints))).joints_cm
        assert set(tables) >= TIERS
        assert all(tables[tier]["all"].raw.count == 0 for tier in TIERS)


class TestExamples:
    def test_causes(self) -> None:
        """A hand that an object hides half, and the person's own body a fifth."""
        joints = people_standing(1, 0.0)
        hand = JOINT_NAMES.index("right_hand")
        by_object, by_self = np.zeros((1, 1, J)), np.zeros((1, 1, J))
        by_object[..., hand], by_self[..., hand] = 0.5, 0.2
        reference = reference_of(joints, occluded_by_object=by_object, occluded_by_self=by_self)
        tables = summarise(evaluate_sequence(predicted_of(joints), reference)).joints_cm
        with_hand = {split for split, table in tables.items() if table["right_hand"].raw.count}
        assert with_hand == {
            "all",
            "hidden ≥ 30%",
            "hidden ≥ 60%",
            "hidden by an object ≥ 30%",
        }
        assert tables["unhidden"]["all"].raw.count == J - 1

    def test_people_found_by_what_is_hidden_of_them(self) -> None:
        truth = people_standing(4, 0.0)
        predicted = truth.copy()
        predicted[2] = np.nan
        hidden = np.zeros((4, 1, J))
        hidden[2:] = 0.7
        summary = summarise(
            evaluate_sequence(predicted_of(predicted), reference_of(truth, outside=hidden))
        )
        assert summary.found["all"] == SplitRecall(4, 0.75)
        assert summary.found["unhidden"] == SplitRecall(2, 1.0)
        assert summary.found["out of view ≥ 60%"] == SplitRecall(2, 0.5)
        assert summary.found["hidden by oneself ≥ 30%"].count == 0


class TestOddInput:
    def test_no_joint_in_common(self) -> None:
        joints = people_standing(1, 0.0)
        of_predicted = predicted_of(joints, joint_names=tuple(f"j{i}" for i in range(J)))
        with pytest.raises(InputError, match=r"joints j0, .* reference joints head, .* one"):
            evaluate_sequence(of_predicted, reference_of(joints))

    @pytest.mark.parametrize("frames", [1, 3])
    @pytest.mark.parametrize("found", [0, 1])
    @pytest.mark.parametrize("there", [0, 1])
    def test_nobody_there_or_nobody_found(self, frames: int, found: int, there: int) -> None:
        somebody = people_standing(frames, 0.0)
        evaluation = evaluate_sequence(
            predicted_of(somebody[:, :found]), reference_of(somebody[:, :there])
        )
        summary = summarise(evaluation)
        assert summary.joints_cm["all"]["all"].raw.count == frames * J * found * there
        text = StringIO()
        print_report(evaluation, Console(file=text, width=80), per_sequence=True, detail=True)
        assert "nan" not in text.getvalue()

    def test_joints_that_are_not_told(self) -> None:
        predicted, reference = knowing_all(0)
        joints = predicted.joints_camera.copy()
        joints[:, 0, 3:7] = np.nan
        summary = summarise(evaluate_sequence(replace(predicted, joints_camera=joints), reference))
        assert summary.joints_cm["all"]["all"].raw.count == F * (P * J - 4)
        assert summary.within_10_cm["torso"].raw < 1.0
        assert np.isfinite(summary.directions_deg["all"]["all"].raw.mean)


class TestReport:
    def report(self, detail: bool) -> str:
        text = StringIO()
        evaluation = evaluate_sequence(*knowing_all(1))
        print_report(evaluation, Console(file=text, width=80), detail=detail)
        return text.getvalue()

    @pytest.mark.parametrize("detail", [False, True])
    def test_the_tables_fit_a_terminal(self, detail: bool) -> None:
        text = self.report(detail)
        assert max(map(len, text.splitlines())) <= 80
        assert "…" not in text
        assert "nan" not in text

    def test_detail_tells_more(self) -> None:
        brief, detailed = self.report(False), self.report(True)
        assert len(brief.splitlines()) < 80
        for word in ("boxing", "woman 1.62 m", "upper legs", "rotation of each part", "0.9 to 1.0"):
            assert word not in brief
            assert word in detailed

    def test_json_holds_it_all(self, tmp_path: Path) -> None:
        summary = summarise(evaluate_sequence(*knowing_all(2)))
        write_json(tmp_path / "numbers.json", summary, "title", {}, [])
        told = json.loads((tmp_path / "numbers.json").read_text())["summary"]
        assert told["directions_deg"]["action: boxing"]["torso joints"]["raw"]["count"] == 3 * F
        assert len(told["calibration"]["bins"]) == 10
        assert told["tracking"]["hota"] == pytest.approx(summary.tracking.hota)
        assert set(told["within_10_cm"]) >= {"upper body", "lower body", "all"}
