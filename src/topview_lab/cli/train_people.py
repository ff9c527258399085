"""`topview train-people`: what tells people from furniture, learnt from recordings with truth."""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Final

import msgspec
from cyclopts import Parameter
from rich.table import Table

from topview.cli.outputs import prepare_output_file
from topview.cli.printing import plain_console
from topview.cli.progress import warn
from topview.cli.status import INTERRUPTED, UNUSABLE_INPUT
from topview.detect.joints.network import WEIGHTS, JointNetwork
from topview.io import write_atomically
from topview.io.writers.extras import needed
from topview.people.existence import CONFIRMED
from topview.people.features import FEATURE_NAMES
from topview.people.likelihood import Likelihood, shipped_likelihood
from topview.records import InputError
from topview_lab.cli.train_people_head import collected, learn_head, split
from topview_lab.datasets import find_folder_recordings, make_simulated
from topview_lab.evaluate.tables import empty_table, number, percent
from topview_lab.metrics.statistics import share
from topview_lab.seeds import PEOPLE_LEARNT_SEEDS
from topview_lab.training.joints.simulated import check_postures
from topview_lab.training.people import Collected, CollectJob, KnownPeople, TrackRows
from topview_lab.training.people_fit import (
    WRITTEN_DIGITS,
    called_people,
    check_both_kinds,
    described,
    fit_likelihood,
    fit_motion,
)

ALL_SCENES: Final = "all"
MOST_RECORDINGS: Final = 1_000_000

Results = Sequence[Collected | None]


def train_people(
    folders: list[Path] | None = None,
    /,
    *,
    out: Path | None = None,
    joints_out: Path | None = None,
    weights: Path | None = None,
    every: int = 1,
    simulated: Annotated[list[str] | None, Parameter(consume_multiple=True, negative="")] = None,
    postures: int = 0,
    motion_only: Annotated[bool, Parameter(negative="")] = False,
    measure_on: Annotated[
        list[Path] | None, Parameter("--measure", consume_multiple=True, negative="")
    ] = None,
    workers: int = 0,
    force: Annotated[bool, Parameter(negative="")] = False,
) -> int:
    """Learn to tell people from furniture.

    Tracks the recordings, told by their truth who is a person, weighs what speaks against one,
    and prints the weights and how many are told rightly. Without --out, what there is is only
    measured. The same recordings give the same weights with any number of workers.

    Args:
        folders: recordings with groundtruth.npz, or folders of such.
        out: the .json to write.
        joints_out: the .onnx to write: the joint network, of which the last layers, which tell
            whether a window shows a person, are learnt first, from the windows that the tracker
            cuts; then the rest is learnt with it.
        weights: of the joint network to begin with, such as `topview train-joints` wrote; what
            ships by default.
        every: take only one of so many recordings of the folders.
        simulated: scenes of the simulator to learn from, too; "all" for all of them.
        postures: so many of our simulator's people to learn the network's layers from, each in 40
            postures: lying, sitting on the floor, kneeling, bent, on all fours; on a seat, ten
            times; and with hands on the own body, ten times.
        motion_only: keep what ships, and learn only what motion tells.
        measure_on: recordings of other people, to measure on; without them one of four of those to
            learn from is held back.
        workers: processes, 0 for one per core.
        force: replace the file that is there.
    """
    if not 1 <= every <= MOST_RECORDINGS:
        raise InputError(f"--every is {every}; it must be 1 to {MOST_RECORDINGS}")
    check_postures(postures)
    if postures and joints_out is None:
        raise InputError(f"--postures is {postures}; only --joints-out learns from them")
    if not folders and not simulated:
        raise InputError("there is nothing to learn from; give recordings, or --simulated")
    if motion_only and (out is None or joints_out is not None):
        raise InputError("--motion-only needs --out, and no --joints-out: nothing else is learnt")
    if out is not None:
        prepare_output_file("--out", out, force)
    if joints_out is not None:
        prepare_output_file("--joints-out", joints_out, force)
        needed("onnx", "--joints-out", "train")
    if weights is not None:
        JointNetwork(weights)  # which refuses what is none
    network = weights or WEIGHTS
    given = _given(folders or [], every, simulated or [])
    others = find_folder_recordings(measure_on) if measure_on else []
    if both := {own.name for own in given if own in others}:
        raise InputError(
            f"--measure names {min(both)}, which is to be learnt from; it must name others"
        )
    if joints_out is not None:
        table = learn_head(given, others, postures, workers, joints_out, network)
        if table is None:
            return INTERRUPTED
        plain_console().print(table)
    jobs = [CollectJob(each, joints_out or weights) for each in (*given, *others)]
    results = collected(jobs, workers, "collecting")
    if results is None:
        return INTERRUPTED
    warn(*(line for each in results if each is not None for line in each.problems))
    learnt, measured = results[: len(given)], results[len(given) :]
    if out is not None and not others:
        learnt, measured = split(learnt)
    own, other = _Set.of(learnt), _Set.of(measured)
    if not own.names:
        raise InputError(f"none of the {len(learnt)} recordings could be used")
    check_both_kinds(own.rows.is_person, "was followed")
    likelihood = shipped_likelihood()
    if out is not None:
        source = f"{described(own.names)}; {_command(folders, simulated, every, measure_on)}"
        source += f" --postures {postures}" if postures else ""
        source += f" --joints-out {joints_out.name}" if joints_out else ""
        if motion_only:
            likelihood = fit_motion(own.rows, likelihood, f"{source} --motion-only")
        else:
            likelihood = fit_likelihood(own.rows, source)
        write_atomically(out, msgspec.json.format(msgspec.json.encode(likelihood), indent=2))
    plain_console().print(_weights_table(likelihood, own.rows))
    sets = {"fitted" if out else "given": own, "others" if others else "held back": other}
    plain_console().print(_called_table(likelihood, sets))
    print(f"{out} written: {likelihood.source}" if out else f"what ships: {likelihood.source}")
    return 0 if len(own.names) + len(other.names) == len(results) else UNUSABLE_INPUT


def _given(folders: Sequence[Path], every: int, scenes: Sequence[str]) -> list[KnownPeople]:
    """The recordings to learn from, in an order that depends on nothing else."""
    given: list[KnownPeople] = []
    if folders:
        given += find_folder_recordings(folders)[::every]
    if scenes:
        given += make_simulated(() if ALL_SCENES in scenes else scenes, PEOPLE_LEARNT_SEEDS)
    return given


def _command(
    folders: Sequence[Path] | None,
    scenes: Sequence[str] | None,
    every: int,
    measure_on: Sequence[Path] | None,
) -> str:
    """What was called, for whoever wants to do it again."""
    words = ["topview", "train-people", *(path.resolve().name for path in folders or ())]
    words += ["--every", str(every)] if every > 1 else []
    words += ["--simulated", *scenes] if scenes else []
    words += ["--measure", *(path.resolve().name for path in measure_on)] if measure_on else []
    return shlex.join(words)


@dataclass(frozen=True, slots=True, eq=False)
class _Set:
    """What was collected of some recordings."""

    names: tuple[str, ...]
    rows: TrackRows

    @classmethod
    def of(cls, results: Results) -> _Set:
        """Without those that failed."""
        done = [(each.name, each.rows) for each in results if each is not None]
        good = [(name, rows) for name, rows in done if rows is not None]
        return cls(tuple(name for name, _ in good), TrackRows.joined([rows for _, rows in good]))


def _weights_table(likelihood: Likelihood, rows: TrackRows) -> Table:
    table = empty_table("what speaks against a person", "feature, and its means")
    for column in ("weight", "people", "furniture"):
        table.add_column(column, justify="right")
    is_person = rows.is_person
    means = zip(rows.features[is_person].mean(0), rows.features[~is_person].mean(0), strict=True)
    for name, of_kinds in zip(FEATURE_NAMES, means, strict=True):
        weight = number(likelihood.weights[name], WRITTEN_DIGITS)
        table.add_row(name, weight, *(number(mean, 2) for mean in of_kinds))
    for name, value in (
        ("bias", likelihood.bias),
        ("with the network: bias", likelihood.joint_bias),
        ("what the log-odds by shape count", likelihood.by_shape),
        (f"what {FEATURE_NAMES[-1]!r} weighs", likelihood.by_stillness),
    ):
        table.add_row(name, number(value, WRITTEN_DIGITS), "", "")
    said = [rows.network[rows.is_asked & is_kind] for is_kind in (is_person, ~is_person)]
    table.add_row(
        "what the network's log-odds count",
        number(likelihood.by_network, WRITTEN_DIGITS),
        *(number(share(float(own.sum()), len(own)), 2) for own in said),
    )
    return table


def _called_table(likelihood: Likelihood, sets: Mapping[str, _Set]) -> Table:
    table = empty_table(f"called a person, from a probability of {CONFIRMED} on", "recordings")
    table.add_column("what")
    for column in ("frames\nof tracks", "by shape", "with the\nnetwork"):
        table.add_column(column, justify="right")
    for name, own in sets.items():
        if not own.names:
            continue
        called = called_people(likelihood, own.rows)
        for kind, of_kind in zip(("people", "furniture"), called, strict=True):
            shares = percent(of_kind.by_shape), percent(of_kind.with_network)
            table.add_row(f"{len(own.names)} {name}", kind, str(of_kind.frames), *shares)
    return table
