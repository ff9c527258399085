"""How far joints are off is fitted: to made-up errors, by a command, and refused in one line."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import cast

import msgspec
import numpy as np
import pytest
from scipy.special import fdtri

from skeleton_sequences import write_rendered
from topview.records import InputError
from topview.track import TrackerSettings
from topview.track.joint_errors import (
    COUNTED_SHARES,
    ELLIPSOID,
    ELLIPSOID_SHARE,
    PROPOSED,
    TERMS,
    ErrorLaw,
    JointErrors,
    kinds_of,
)
from topview_lab.cli import train_confidence as command
from topview_lab.cli import training_runs
from topview_lab.datasets import EvaluatedRecording, SimulatedScene
from topview_lab.metrics import SequenceErrors
from topview_lab.training.joint_errors import (
    KINDS,
    KNOWN_HELD,
    TAILS,
    ErrorRows,
    ErrorsJob,
    TermErrors,
    _unlikelihood,
    fit_joint_errors,
    log_likelihoods,
    with_counts,
)

SHIPPED = Path(command.__file__).parents[2] / "topview/track/joint_errors.json"
WEIGHTS = 0.4, 1.2, 0.8, 0.1, 0.0005, 0.01, 0.01, 0.02, 0.05
TRUE_TAILS = 6.0, 3.0, 5.0, 4.0


def law_of(tails: float) -> ErrorLaw:
    return ErrorLaw(tails, 12.0, tuple(3.0 * fdtri(3.0, tails, COUNTED_SHARES)))


TRUE = JointErrors("made up", tuple(map(law_of, TRUE_TAILS)), *WEIGHTS)


def made_up(count: int, seed: int = 0) -> ErrorRows:
    """Errors of the true law: half of the joints proposed, a tenth of these very unsure; a third of
    all behind others."""
    rng = np.random.default_rng(seed)
    is_behind, is_proposed = rng.random(count) < 0.33, rng.random(count) < 0.5
    amounts = np.zeros((len(TERMS), count))
    stated_m2 = rng.uniform(1e-4, 0.01, count) * np.where(rng.random(count) < 0.1, 50.0, 1.0)
    amounts[0] = np.where(is_behind, 0.0, stated_m2)
    amounts[1] = np.where(is_behind, stated_m2, 0.0)
    amounts[2] = np.where(rng.random(count) < 0.3, amounts[1], 0.0)
    amounts[3] = rng.exponential(0.01, count)
    amounts[4] = 1.0
    amounts[5:] = rng.uniform(0.0, 1.0, (3, count))
    amounts[:PROPOSED] *= is_proposed
    amounts[PROPOSED:] *= ~is_proposed
    terms = amounts[..., None, None] * np.eye(3)
    sigma = np.sqrt(TRUE.matrices(terms)[:, 0, 0])
    kinds = kinds_of(is_proposed, is_behind)
    tails = np.array(TRUE_TAILS)[kinds]
    errors = sigma[:, None] * rng.normal(size=(count, 3))
    errors /= np.sqrt(rng.chisquare(tails) / tails)[:, None]
    return ErrorRows(errors, terms, kinds, rng.integers(0, 3, count))


def some_of(rows: ErrorRows, index: np.ndarray) -> ErrorRows:
    """Those rows, in this order."""
    return ErrorRows(
        rows.errors_camera[index], rows.terms[:, index], rows.kinds[index], rows.recording[index]
    )


@pytest.mark.slow
def test_the_law_that_made_the_errors_is_found() -> None:
    fitted = fit_joint_errors(made_up(10000), "these")
    assert fitted.source == "these"
    assert fitted.weights == pytest.approx(TRUE.weights, rel=0.35, abs=0.001)
    assert fitted.most_m2 == pytest.approx(TRUE.most_m2, rel=0.35)
    assert [law.tails for law in fitted.laws] == pytest.approx(TRUE_TAILS, rel=0.25)


def test_a_likelihood_sums_to_one() -> None:
    """Over a fine grid of errors."""
    side_m = np.linspace(-0.6, 0.6, 61)
    grid = np.stack(np.meshgrid(side_m, side_m, side_m), -1).reshape(-1, 3)
    matrix = np.diag([0.002, 0.003, 0.006])
    matrices = np.broadcast_to(matrix, (len(grid), 3, 3))
    densities = np.exp(log_likelihoods(grid, matrices, np.full(len(grid), 8.0))[0])
    assert densities.sum() * (side_m[1] - side_m[0]) ** 3 == pytest.approx(1.0, abs=0.01)


def test_how_a_likelihood_changes_is_how_it_differs() -> None:
    """Against finite differences, of each number that is fitted."""
    rows = made_up(300)
    args = rows.errors_camera, rows.terms, rows.kinds, np.full(300, 1.0 / 300.0)
    place = np.log([*WEIGHTS, *TRUE_TAILS])
    _, told = _unlikelihood(place, *args)
    found = [
        (_unlikelihood(place + step, *args)[0] - _unlikelihood(place - step, *args)[0]) / 2e-5
        for step in 1e-5 * np.eye(len(place))
    ]
    np.testing.assert_allclose(told, found, rtol=1e-4, atol=1e-8)


@pytest.mark.slow
def test_each_recording_counts_the_same_however_long() -> None:
    """A recording given twice as often as part of itself changes nothing."""
    rows = made_up(1500)
    longer = np.concatenate([np.arange(1500), np.flatnonzero(rows.recording == 1)])
    first, second = (fit_joint_errors(own, "") for own in (rows, some_of(rows, longer)))
    assert second.weights == pytest.approx(first.weights, rel=0.02)


def test_counts_are_those_of_each_kind_of_joints() -> None:
    rows = made_up(6000)
    told = with_counts(TRUE, rows)
    squared = (rows.errors_camera**2).sum(-1) / TRUE.matrices(rows.terms)[:, 0, 0]
    is_held = squared < told.ellipsoids_of(rows.kinds)
    within = told.shares_within(squared[:, None], rows.kinds)[:, 0]
    for kind, held in enumerate((KNOWN_HELD, KNOWN_HELD, ELLIPSOID_SHARE, ELLIPSOID_SHARE)):
        is_kind = rows.kinds == kind
        assert is_held[is_kind].mean() == pytest.approx(held, abs=0.01)
        deciles = np.quantile(within[is_kind], np.arange(0.1, 1.0, 0.1))
        assert deciles == pytest.approx(np.arange(0.1, 1.0, 0.1), abs=0.03)


def test_of_kinds_that_are_not_there_what_was_counted_before_is_kept() -> None:
    rows = made_up(2000)
    told = with_counts(TRUE, some_of(rows, np.flatnonzero(rows.kinds < 2)))
    assert told.laws[:2] == with_counts(TRUE, rows).laws[:2]
    assert told.laws[2:] == TRUE.laws[2:]


def test_joined_rows_are_of_recordings_of_their_own() -> None:
    rows = ErrorRows.joined([made_up(200), made_up(100)])
    assert len(np.unique(rows.recording)) == 6
    assert len(np.unique(rows.recording[:200])) == 3


class MadeUpJob:
    """Measures nothing; a recording that is called broken cannot be measured."""

    def __init__(self, recording: EvaluatedRecording, settings: TrackerSettings) -> None:
        self.name = recording.name

    def __call__(self) -> TermErrors | str:
        if self.name.startswith("broken"):
            return f"{self.name}: is broken"
        return TermErrors((), cast(SequenceErrors, SimpleNamespace(name=self.name)))


def write_person(folder: Path) -> Path:
    return write_rendered(folder, [2.0])


def test_a_recording_gives_errors_and_what_was_told_of_them() -> None:
    measured = ErrorsJob(SimulatedScene("stand", frames=3), TrackerSettings(threads=1))()
    assert isinstance(measured, TermErrors)
    rows = ErrorRows.of([measured])
    assert len(rows.errors_camera) > 0
    assert rows.terms.shape == (len(TERMS), len(rows.errors_camera), 3, 3)
    assert not rows.kinds.any()  # one person alone, whose joints are proposed
    assert (np.linalg.eigvalsh(rows.terms[0]) > 0.0).all()  # what the network states
    assert not rows.terms[PROPOSED:].any()  # all joints are proposed
    assert np.median(np.linalg.norm(rows.errors_camera, axis=-1)) < 0.1


def test_the_command_fits_and_writes(tmp_path, topview, monkeypatch) -> None:
    monkeypatch.setattr(command, "ErrorsJob", MadeUpJob)
    monkeypatch.setattr(training_runs, "compile_kernels", lambda: None)
    monkeypatch.setattr(ErrorRows, "of", lambda own: made_up(500, seed=len(own)))
    for name in ("walk_1", "walk_2", "broken_3"):
        write_person(tmp_path / "all" / name)
    out = tmp_path / "a.json"
    done = topview("train-confidence", tmp_path / "all", "--out", out, "--workers", 1)
    assert (done.status, done.complaints) == (2, ["topview: broken_3: is broken"] * 2)
    written = msgspec.json.decode(out.read_bytes(), type=JointErrors)
    assert written.source == "2 recordings: walk 1, 2; topview train-confidence all"
    rows = ErrorRows.joined([made_up(500, seed=2)] * 2)
    assert written == fit_joint_errors(rows, written.source)


def test_the_command_counts_alone(tmp_path, topview, monkeypatch) -> None:
    monkeypatch.setattr(command, "ErrorsJob", MadeUpJob)
    monkeypatch.setattr(training_runs, "compile_kernels", lambda: None)
    monkeypatch.setattr(ErrorRows, "of", lambda own: made_up(500, seed=len(own)))
    write_person(tmp_path / "all" / "walk_1")
    out = tmp_path / "a.json"
    done = topview("train-confidence", tmp_path / "all", "--out", out, "--counts")
    assert done.status == 0
    shipped, written = (
        msgspec.json.decode(path.read_bytes(), type=JointErrors) for path in (SHIPPED, out)
    )
    laws = shipped.source.split("; counts: ")[0]
    assert written.source == (
        f"{laws}; counts: 1 recordings: walk 1; topview train-confidence all --counts"
    )
    expected = with_counts(shipped, ErrorRows.joined([made_up(500, seed=1)] * 2))
    assert written == msgspec.structs.replace(expected, source=written.source)


def test_bad_input_is_one_line(tmp_path, topview, monkeypatch) -> None:
    monkeypatch.setattr(command, "ErrorsJob", MadeUpJob)
    monkeypatch.setattr(training_runs, "compile_kernels", lambda: None)
    good, out = write_person(tmp_path / "broken_1"), tmp_path / "a.json"
    for arguments, said in (
        (("--out", out), "no folder given"),
        ((tmp_path / "none", "--out", out), "is not a folder"),
        ((good, "--out", out, "--workers=-1"), "workers is -1"),
        ((good, "--out", out, "--workers", 1), "none of the 1 recordings could be used"),
    ):
        refused = topview("train-confidence", *arguments)
        assert refused.status == 2
        assert said in refused.complaints[-1]
    assert not out.exists()
    out.write_text("kept")
    assert "--force" in topview("train-confidence", good, "--out", out).complaints[-1]
    assert out.read_text() == "kept"


def test_too_few_joints_are_refused() -> None:
    """Of each kind."""
    rows = made_up(900)
    for kind, what in enumerate(KINDS):
        few = some_of(rows, np.flatnonzero(rows.kinds != kind))
        with pytest.raises(InputError, match=f"0 joints {what} were found; 100 are needed"):
            fit_joint_errors(few, "few")


def test_what_ships_is_whole() -> None:
    shipped = msgspec.json.decode(SHIPPED.read_bytes(), type=JointErrors)
    assert shipped.source
    assert (shipped.weights > 0.0).all()
    assert len(shipped.laws) == len(KINDS)
    assert min(law.tails for law in shipped.laws[:2]) > 2.0  # of proposed joints
    for law in shipped.laws:
        assert law.tails >= TAILS[0]
        assert law.ellipsoid > ELLIPSOID
        assert len(law.squared) == len(COUNTED_SHARES)
        assert (np.diff([0.0, *law.squared]) > 0.0).all()
