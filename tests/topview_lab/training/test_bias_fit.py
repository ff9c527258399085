"""How far off poses are is fitted: to made-up poses, by a command, and refused in one line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from rendered_bodies import MODEL, joints_of, standing_pose
from skeleton_sequences import write_rendered
from topview.body.parts import PARTS
from topview.files import read_archive
from topview.geometry.rotations import rotations_from_vectors
from topview.records import InputError
from topview.track.methods.topview.bias import MIRRORED_TRAITS, N_STEPS, PoseBias, stepped
from topview.track.pose import MIRRORED, Pose
from topview_lab.cli import train_bias as command
from topview_lab.cli import training_runs
from topview_lab.datasets import EvaluatedRecording, SimulatedScene
from topview_lab.training import bias
from topview_lab.training.bias import (
    FEWEST_POSES,
    BiasJob,
    BiasRows,
    errors_m,
    fit_bias,
    gaps_of,
    moves_of,
)

TRAITS = len(MIRRORED_TRAITS[0])
# Steps, of the trunk, and traits that are the same in a mirror.
EVEN_STEPS, EVEN_TRAITS = [1, 2, 3, 6, 9], [0, 2, 3, 37]


def some_pose(rng: np.random.Generator) -> Pose:
    pose = standing_pose(rng.uniform(-1.0, 1.0))
    turns = rotations_from_vectors(rng.normal(0.0, 0.15, (len(PARTS), 3)))
    return Pose.from_relative(pose.neck_camera, pose.relative() @ turns)


def made_up(count: int, seed: int = 0) -> BiasRows:
    """Poses that are off by a law of four traits, alike in a mirror, and whose truth has its
    joints elsewhere."""
    rng = np.random.default_rng(seed)
    law = np.zeros((N_STEPS, TRAITS))
    shape = len(EVEN_STEPS), len(EVEN_TRAITS)
    law[np.ix_(EVEN_STEPS, EVEN_TRAITS)] = np.random.default_rng(9).normal(0.0, 0.01, shape)
    traits = rng.standard_normal((count, TRAITS))
    traits[:, 0] = 1.0
    found = [some_pose(rng) for _ in range(count)]
    true = [stepped(pose, law @ own) for pose, own in zip(found, traits, strict=True)]
    elsewhere = 0.03 * np.random.default_rng(8).standard_normal((16, 3))
    elsewhere[4:] = 0.0  # the trunk's, which are in the middle
    return BiasRows(
        traits,
        np.array([pose.Rs for pose in found]),
        np.array([pose.origins(MODEL) for pose in found]),
        np.array([joints_of(pose) for pose in found]),
        np.array([joints_of(pose) for pose in true]) + elsewhere * (0.0, 1.0, 0.0),
    )


def test_joints_move_with_steps_as_is_told() -> None:
    """Against finite differences."""
    rows = made_up(3)
    moves, small = moves_of(rows), 1e-6
    for n, (Rs, neck) in enumerate(zip(rows.Rs, rows.origins[:, 1], strict=True)):
        pose = Pose(neck, Rs)
        for d in range(N_STEPS):
            steps = np.zeros(N_STEPS)
            steps[d] = small
            moved = (joints_of(stepped(pose, steps)) - joints_of(pose)) / small
            assert_allclose(moves[n, :, :, d], moved, atol=1e-4)


def test_rows_in_a_mirror_twice_are_the_same() -> None:
    rows = made_up(4)
    again = rows.mirrored().mirrored()
    assert_allclose(again.traits, rows.traits)
    assert_allclose(again.joints_camera, rows.joints_camera)
    assert_allclose(rows.mirrored().true_camera[:, 0], rows.true_camera[:, 0] @ MIRRORED)


def test_gaps_are_without_what_is_constant() -> None:
    rows = made_up(200)
    inside = np.einsum("njab,nja->njb", rows.Rs[:, [0] * 16], gaps_of(rows))
    assert np.abs(inside[:, 0].mean(0)).max() < 1e-9


def test_a_law_is_found_that_holds_for_other_poses(monkeypatch) -> None:
    monkeypatch.setattr(bias, "REWEIGHTED", 1)
    rows, others = made_up(FEWEST_POSES), made_up(200, seed=1)
    assert errors_m(others) > 0.02
    assert errors_m(others, fit_bias(rows, "made up")) < 0.4 * errors_m(others)


def test_too_few_poses_are_refused() -> None:
    rows = made_up(20)
    with pytest.raises(InputError, match=f"20 poses were found; {FEWEST_POSES} are needed"):
        fit_bias(rows, "made up")


def test_a_recording_gives_poses_and_their_traits() -> None:
    rows = BiasJob(SimulatedScene("stand", frames=9), None)()
    assert isinstance(rows, BiasRows)
    assert rows.traits.shape == (len(rows.Rs), TRAITS)
    assert len(rows.Rs) > 0
    assert np.linalg.norm(rows.true_camera - rows.joints_camera, axis=-1).mean() < 0.2


class MadeUpJob:
    """In place of one that tracks."""

    def __init__(self, recording: EvaluatedRecording, law: PoseBias | None) -> None:
        self.recording, self.law = recording, law

    def __call__(self) -> BiasRows | str:
        if self.recording.name.startswith("broken"):
            return f"{self.recording.name}: is broken"
        seed = len(self.recording.name) + 10 * (self.law is not None)
        return made_up(FEWEST_POSES // 2, seed)


def write_person(folder: Path) -> Path:
    return write_rendered(folder, [2.0])


@pytest.fixture
def topview_made_up(topview, monkeypatch):
    monkeypatch.setattr(command, "BiasJob", MadeUpJob)
    monkeypatch.setattr(training_runs, "compile_kernels", lambda: None)
    monkeypatch.setattr(bias, "REWEIGHTED", 1)
    return topview


def test_the_command_fits_twice_and_writes(tmp_path, topview_made_up) -> None:
    for name in ("walk_1", "walk_02", "broken_3"):
        write_person(tmp_path / "all" / name)
    out = tmp_path / "bias.npz"
    done = topview_made_up("train-bias", tmp_path / "all", "--out", out, "--workers", 1)
    assert (done.status, done.complaints) == (2, ["topview: broken_3: is broken"] * 2)
    arrays = read_archive(out)
    assert str(arrays.pop("source")) == "2 recordings: walk 1, 2; topview train-bias all"
    law = PoseBias("", **arrays)
    rows = BiasRows.joined([made_up(FEWEST_POSES // 2, seed) for seed in (17, 16)])
    assert_allclose(law.weights, fit_bias(rows, "").weights, atol=1e-9)


def test_bad_input_is_one_line(tmp_path, topview_made_up) -> None:
    good, out = write_person(tmp_path / "broken_1"), tmp_path / "bias.npz"
    for arguments, said in (
        (("--out", out), "no folder given"),
        ((tmp_path / "none", "--out", out), "is not a folder"),
        ((good, "--out", out, "--workers=-1"), "workers is -1"),
        ((good, "--out", out, "--workers", 1), "none of the 1 recordings could be used"),
    ):
        refused = topview_made_up("train-bias", *arguments)
        assert refused.status == 2
        assert said in refused.complaints[-1]
    assert not out.exists()
    out.write_text("kept")
    assert "--force" in topview_made_up("train-bias", good, "--out", out).complaints[-1]
    assert out.read_text() == "kept"
