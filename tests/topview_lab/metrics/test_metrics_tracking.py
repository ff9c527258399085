"""HOTA and CLEAR MOT of people in 3D."""

from __future__ import annotations

from dataclasses import astuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from skeleton_sequences import people_standing, predicted_of, reference_of
from topview_lab.metrics import (
    PERSON_GATE_M,
    Evaluation,
    PeopleCounts,
    TrackingCounts,
    TrackingScores,
    evaluate_sequence,
    people_distances,
    score_tracking,
    summarise,
)

Array = NDArray[np.float64]
seeds = st.integers(0, 2**32 - 1)
few = settings(max_examples=25)

# HOTA, DetA, AssA, as TrackEval 1.3.0 has them.
TRACKEVAL_ON_SEED_3 = (0.472206735, 0.580095119, 0.384891184)


def measured(predicted: Array, reference: Array) -> tuple[PeopleCounts, TrackingCounts]:
    (sequence,) = evaluate_sequence(predicted_of(predicted), reference_of(reference)).sequences
    return sequence.people, sequence.tracking


def scores(predicted: Array, reference: Array) -> TrackingScores:
    return score_tracking(*measured(predicted, reference))


def wandering(
    seed: int, frames: int = 12, people: int = 3, apart_m: float = 0.5
) -> tuple[Array, Array]:
    """[F, P, J, 3] predicted and true people who come, go, are missed and exchange ids."""
    rng = np.random.default_rng(seed)
    truth = people_standing(frames, *np.arange(people) * apart_m)
    truth += np.cumsum(rng.normal(0.0, 0.05, (frames, people, 1, 3)), axis=0)
    predicted = truth + rng.normal(0.0, 0.15, (frames, people, 1, 3))
    exchanged = rng.random(frames) < 0.3
    predicted[exchanged] = np.roll(predicted[exchanged], 1, axis=1)
    truth[rng.random((frames, people)) < 0.1] = np.nan
    predicted[rng.random((frames, people)) < 0.1] = np.nan
    return predicted, truth


def is_there(joints_camera: Array) -> NDArray[np.bool_]:
    """[F, P]"""
    return np.asarray(np.isfinite(joints_camera).all((2, 3)))


class TestLaws:
    @few
    @given(seeds)
    def test_scores_are_shares(self, seed: int) -> None:
        result = scores(*wandering(seed))
        for value in (result.hota, result.detection, result.association):
            assert 0.0 <= value <= 1.0
        assert result.mota <= 1.0

    @few
    @given(seeds)
    def test_the_perfect_tracker_scores_perfectly(self, seed: int) -> None:
        _, truth = wandering(seed, apart_m=2.0)
        assert astuple(scores(truth, truth)) == pytest.approx((1.0, 1.0, 1.0, 1.0, 0.0))

    @few
    @given(seeds, st.permutations(range(3)), st.permutations(range(3)))
    def test_names_do_not_matter(self, seed: int, ids: list[int], people: list[int]) -> None:
        predicted, truth = wandering(seed, apart_m=2.0)
        assert astuple(scores(predicted[:, ids], truth[:, people])) == pytest.approx(
            astuple(scores(predicted, truth))
        )

    @few
    @given(seeds)
    def test_ids_shuffled_in_every_frame_are_never_better(self, seed: int) -> None:
        rng = np.random.default_rng(seed)
        _, truth = wandering(seed, apart_m=2.0)
        shuffled = np.stack([frame[rng.permutation(3)] for frame in truth])
        result = scores(shuffled, truth)
        assert result.detection == pytest.approx(1.0)
        assert result.association <= 1.0 + 1e-12
        assert result.mota <= 1.0

    @few
    @given(seeds)
    def test_recordings_add_up(self, seed: int) -> None:
        one, other = wandering(seed), wandering(seed + 1)
        pooled = Evaluation.pooled(
            evaluate_sequence(predicted_of(p), reference_of(t)) for p, t in (one, other)
        )
        counts = [s.tracking for s in pooled.sequences]
        assert (counts[0] + counts[1]).hits.tolist() == (counts[0].hits + counts[1].hits).tolist()
        total = summarise(pooled).tracking
        expected = score_tracking(
            pooled.sequences[0].people + pooled.sequences[1].people, counts[0] + counts[1]
        )
        assert total == expected


class TestExamples:
    @pytest.mark.parametrize("ids", [1, 2, 4])
    def test_one_person_under_several_ids(self, ids: int) -> None:
        """Found throughout, under each id for an equal share of the time: AssA is that share."""
        frames = 8
        truth = people_standing(frames, 0.0)
        predicted = np.full((frames, ids, *truth.shape[2:]), np.nan)
        predicted[np.arange(frames), np.arange(frames) * ids // frames] = truth[:, 0]
        result = scores(predicted, truth)
        assert (result.detection, result.association) == pytest.approx((1.0, 1.0 / ids))
        assert result.hota == pytest.approx(np.sqrt(1.0 / ids))
        assert result.mota == pytest.approx(1.0 - (ids - 1) / frames)

    def test_found_half_of_the_time(self) -> None:
        truth = people_standing(8, 0.0)
        predicted = truth.copy()
        predicted[::2] = np.nan
        result = scores(predicted, truth)
        expected = TrackingScores(hota=0.5, detection=0.5, association=0.5, mota=0.5, motp_cm=0.0)
        assert astuple(result) == pytest.approx(astuple(expected))

    def test_two_people_exchange_ids_half_way(self) -> None:
        """Each pair is together for half of the frames: 5 of 10 + 10 - 5, a third."""
        truth = people_standing(10, 0.0, 2.0)
        predicted = truth.copy()
        predicted[5:] = truth[5:, ::-1]
        result = scores(predicted, truth)
        assert (result.detection, result.association) == pytest.approx((1.0, 1 / 3))
        assert result.mota == pytest.approx(1.0 - 2 / 20)

    def test_a_constant_distance_passes_as_many_thresholds(self) -> None:
        """0.3 m of 2 x 0.5 m: 0.7 alike, which is enough for 0.05, 0.10 ... 0.70: 14 of 19."""
        truth = people_standing(4, 0.0)
        result = scores(truth + np.array([0.0, 0.0, 0.3]), truth)
        assert (result.hota, result.detection) == pytest.approx((14 / 19, 14 / 19))
        assert result.motp_cm == pytest.approx(30.0)

    def test_a_false_person(self) -> None:
        truth = people_standing(4, 0.0)
        predicted = people_standing(4, 0.0, 3.0)
        result = scores(predicted, truth)
        assert (result.detection, result.association) == pytest.approx((0.5, 1.0))
        assert result.mota == 0.0

    def test_a_handed_on_id_is_a_swap_but_no_mismatch(self) -> None:
        truth = people_standing(6, 0.0, 1.5)
        truth[3:, 0] = np.nan
        truth[:3, 1] = np.nan
        predicted = np.where(np.arange(6)[:, None, None, None] < 3, truth[:, :1], truth[:, 1:])
        people, _ = measured(predicted, truth)
        assert (people.id_swaps, people.mismatches) == (1, 0)

    def test_nobody_is_there(self) -> None:
        nobody = np.full((3, 1, 16, 3), np.nan)
        assert np.isnan(astuple(scores(nobody, nobody))).all()
        assert np.isnan(astuple(scores(people_standing(3, 0.0), nobody))).all()

    def test_nobody_is_found(self) -> None:
        truth = people_standing(3, 0.0)
        for nobody in (np.full_like(truth, np.nan), truth[:, :0]):
            result = scores(nobody, truth)
            assert (result.hota, result.detection, result.association) == (0.0, 0.0, 0.0)
            assert result.mota == 0.0
            assert np.isnan(result.motp_cm)


class TestAgainstLibraries:
    def test_hota_as_trackeval_has_it(self) -> None:
        result = scores(*wandering(3, frames=30))
        assert (result.hota, result.detection, result.association) == pytest.approx(
            TRACKEVAL_ON_SEED_3, abs=1e-6
        )

    @pytest.mark.parametrize("seed", range(5))
    def test_hota_as_trackeval_tells_it_now(self, seed: int) -> None:
        hota = pytest.importorskip("trackeval.metrics.hota", reason="needs TrackEval")
        predicted, truth = wandering(seed, frames=30)
        distances_m = people_distances(truth, predicted)
        alike = np.maximum(1.0 - distances_m / (2.0 * PERSON_GATE_M), 0.0)
        of_truth, of_predicted = is_there(truth), is_there(predicted)
        ids = [[np.flatnonzero(frame) for frame in of] for of in (of_truth, of_predicted)]
        result = hota.HOTA().eval_sequence(
            {
                "num_gt_dets": of_truth.sum(),
                "num_tracker_dets": of_predicted.sum(),
                "num_gt_ids": 3,
                "num_tracker_ids": 3,
                "gt_ids": ids[0],
                "tracker_ids": ids[1],
                "similarity_scores": [s[np.ix_(r, p)] for s, r, p in zip(alike, *ids, strict=True)],
            }
        )
        expected = [result[name].mean() for name in ("HOTA", "DetA", "AssA")]
        ours = scores(predicted, truth)
        assert [ours.hota, ours.detection, ours.association] == pytest.approx(expected)

    @pytest.mark.parametrize("seed", range(5))
    def test_mota_as_motmetrics_tells_it(self, seed: int) -> None:
        mm = pytest.importorskip("motmetrics", reason="needs motmetrics")
        predicted, truth = wandering(seed, frames=30, apart_m=2.0)
        accumulator = mm.MOTAccumulator(auto_id=True)
        for distances_m, t, p in zip(
            people_distances(truth, predicted),
            is_there(truth),
            is_there(predicted),
            strict=True,
        ):
            r, c = np.flatnonzero(t), np.flatnonzero(p)
            cost = distances_m[np.ix_(r, c)]
            accumulator.update(r, c, np.where(cost <= PERSON_GATE_M, cost, np.nan))
        result = mm.metrics.create().compute(accumulator, metrics=["mota", "motp", "num_switches"])
        people, counts = measured(predicted, truth)
        ours = score_tracking(people, counts)
        assert ours.mota == pytest.approx(result["mota"].item())
        assert ours.motp_cm == pytest.approx(100.0 * result["motp"].item())
        assert people.mismatches == result["num_switches"].item()
