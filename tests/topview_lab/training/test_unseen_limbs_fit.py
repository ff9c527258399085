"""Where limbs out of sight are is fitted: to made-up poses, by a command, and refused in one
line."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from skeleton_sequences import write_rendered
from topview.files import read_archive
from topview.geometry.rotations import rotations_from_vectors, shortest_turns, unit
from topview.records import InputError
from topview.track.methods.topview.unseen_limbs import LIMB_PARTS, UnseenLimbs
from topview_lab.cli import train_unseen_limbs as command
from topview_lab.cli import training_runs
from topview_lab.datasets import EvaluatedRecording, SimulatedScene
from topview_lab.training.unseen_limbs import (
    FEWEST_LIMBS,
    MIRRORED_POSTURE,
    LimbRows,
    LimbsJob,
    chords_of,
    fit_unseen_limbs,
)

DOWN = np.array([0.0, 1.0, 0.0])
LIMBS, TRAITS = len(LIMB_PARTS), len(MIRRORED_POSTURE[0])


def made_up(count: int, seed: int = 0) -> LimbRows:
    """Limbs that point about as a law of two traits says, which a mirror leaves as they are. Those
    in sight are found as they are, others anywhere."""
    rng = np.random.default_rng(seed)
    traits = rng.standard_normal((count, TRAITS))
    traits[:, 0] = 1.0
    lean = np.stack([np.zeros(count), np.ones(count), traits[:, 3]], axis=-1)
    true = unit(lean[:, None] + 0.05 * rng.standard_normal((count, LIMBS, 3)))
    shares = rng.choice([0.0, 0.5, 1.0], (count, LIMBS))
    anywhere = unit(rng.standard_normal((count, LIMBS, 3)))
    found = np.where(shares[..., None] > 0.0, anywhere, true)
    return LimbRows(traits, shares, found, shortest_turns(DOWN, true))


def test_rows_in_a_mirror_twice_are_the_same() -> None:
    rows = made_up(5)
    again = rows.mirrored().mirrored()
    assert_allclose(again.traits, rows.traits)
    assert_allclose(again.found, rows.found)
    assert_allclose(again.Rs_true, rows.Rs_true)
    assert_allclose(again.shares, rows.shares)
    assert not np.allclose(rows.mirrored().found, rows.found)


def test_a_law_is_found_that_holds_for_other_poses() -> None:
    rows, others = made_up(FEWEST_LIMBS), made_up(200, seed=1)
    assert chords_of(others) > 1.0
    assert chords_of(others, fit_unseen_limbs(rows, "made up")) < 0.25


def test_what_is_in_sight_tells_only_how_the_truth_is_turned() -> None:
    """Whose joints are elsewhere in the limbs."""
    rows = made_up(FEWEST_LIMBS)
    tilted = rows.Rs_true @ rotations_from_vectors(np.array([[0.3, 0.0, 0.0]]))[0]
    changed = LimbRows(rows.traits, rows.shares, rows.found, tilted)
    assert np.linalg.norm(tilted[..., 1] - rows.Rs_true[..., 1], axis=-1).min() > 0.29
    assert_allclose(changed.axes(), rows.axes(), atol=0.01)
    laws = [fit_unseen_limbs(own, "") for own in (rows, changed)]
    assert_allclose(laws[0].weights, laws[1].weights, atol=0.01)


def test_too_little_out_of_sight_is_refused() -> None:
    rows = made_up(20)
    hidden = np.count_nonzero(rows.shares)
    with pytest.raises(InputError, match=f"{hidden} parts .* {FEWEST_LIMBS} are needed"):
        fit_unseen_limbs(rows, "made up")


def test_a_recording_gives_poses_and_their_traits() -> None:
    rows = LimbsJob(SimulatedScene("stand", frames=9))()
    assert isinstance(rows, LimbRows)
    assert len(rows.traits) > 0
    assert rows.traits.shape == (len(rows.found), TRAITS)
    assert_allclose(np.linalg.norm(rows.found, axis=-1), 1.0)
    assert np.linalg.norm(rows.Rs_true[..., 1] - rows.found, axis=-1).mean() < 0.5


class MadeUpJob:
    """In place of one that tracks."""

    def __init__(self, recording: EvaluatedRecording) -> None:
        self.recording = recording

    def __call__(self) -> LimbRows | str:
        if self.recording.name.startswith("broken"):
            return f"{self.recording.name}: is broken"
        return made_up(FEWEST_LIMBS, len(self.recording.name))


@pytest.fixture
def topview_made_up(topview, monkeypatch):
    monkeypatch.setattr(command, "LimbsJob", MadeUpJob)
    monkeypatch.setattr(training_runs, "compile_kernels", lambda: None)
    return topview


def test_the_command_fits_and_writes(tmp_path, topview_made_up) -> None:
    for name in ("walk_1", "walk_02", "broken_3"):
        write_rendered(tmp_path / "all" / name, [2.0])
    out = tmp_path / "limbs.npz"
    done = topview_made_up("train-unseen-limbs", tmp_path / "all", "--out", out, "--workers", 1)
    assert (done.status, done.complaints) == (2, ["topview: broken_3: is broken"])
    arrays = read_archive(out)
    assert str(arrays.pop("source")) == "2 recordings: walk 1, 2; topview train-unseen-limbs all"
    rows = LimbRows.joined([made_up(FEWEST_LIMBS, seed) for seed in (7, 6)])
    assert_allclose(UnseenLimbs("", **arrays).weights, fit_unseen_limbs(rows, "").weights)


def test_bad_input_is_one_line(tmp_path, topview_made_up) -> None:
    good, out = write_rendered(tmp_path / "broken_1", [2.0]), tmp_path / "limbs.npz"
    for arguments, said in (
        (("--out", out), "train-unseen-limbs: no folder given"),
        ((tmp_path / "none", "--out", out), "is not a folder"),
        ((good, "--out", out, "--workers=-1"), "workers is -1"),
        ((good, "--out", out, "--workers", 1), "none of the 1 recordings could be used"),
    ):
        refused = topview_made_up("train-unseen-limbs", *arguments)
        assert refused.status == 2
        assert said in refused.complaints[-1]
    assert not out.exists()
