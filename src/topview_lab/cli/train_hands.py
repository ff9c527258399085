"""`topview train-hands`: what faces and hands look like, learnt from labelled recordings."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter
from rich.table import Table

from topview.cli.outputs import prepare_output_file
from topview.cli.printing import plain_console
from topview.cli.progress import progress_bar, warn
from topview.detect.beliefs import FEATURES, THESIS_FEATURES, BeliefTables, Kind
from topview.detect.skin import SkinHistograms
from topview.io import write_atomically
from topview.records import InputError
from topview_lab.seeds import HANDS_HELD_OUT_SEEDS, HANDS_LEARNT_SEEDS
from topview_lab.training.hands import (
    LabelledFrame,
    LabelledRecording,
    Sequences,
    learn_beliefs,
    score_beliefs,
)
from topview_lab.training.renders import simulated_hands

SIZES = ("major_m", "minor_m")


def train_hands(
    recordings: list[Path] | None = None,
    /,
    *,
    simulated: Annotated[bool, Parameter(negative="")] = False,
    test: Annotated[list[Path] | None, Parameter(consume_multiple=True, negative="")] = None,
    skin: Path | None = None,
    out: Path | None = None,
    force: Annotated[bool, Parameter(negative="")] = False,
) -> None:
    """Learn to tell faces, left and right hands by form, motion, place and size.

    Prints how often they are told rightly in other recordings, with which of the features.

    Args:
        recordings: folders with rgb/, depth/, camera.json, groundtruth.npz, and best with mask/,
            as `topview simulate` writes them.
        simulated: learn from the simulator's scenes, as the default was.
        test: recordings to measure on; simulated ones with --simulated if not given.
        skin: histograms of `topview train-skin`, the default's if not given.
        out: the .npz to write; without it, what there is is only measured.
        force: replace the file that is there.
    """
    if out is not None and not recordings and not simulated:
        raise InputError("there is nothing to learn from; give recordings, or --simulated")
    if out is None and (recordings or simulated):
        raise InputError("--out is missing; it must name the .npz to write what is learnt to")
    if out is not None:
        prepare_output_file("--out", out, force)
    histograms = SkinHistograms.load() if skin is None else SkinHistograms.load(skin)
    tables = BeliefTables.load() if out is None else None
    if out is not None:
        tables = _learn(recordings or [], simulated, histograms)
        write_atomically(out, tables.npz())
        print(f"trained on {tables.trained_on}; written to {out}")
    assert tables is not None
    if test:
        labelled = [LabelledRecording(path) for path in test]
        frames = [list(recording) for recording in labelled]
        warn(*(problem for recording in labelled for problem in recording.problems))
        _report(frames, histograms, tables, "test recordings")
    elif simulated:
        held_out = [list(frames) for frames in simulated_hands(HANDS_HELD_OUT_SEEDS)]
        _report(held_out, histograms, tables, "other simulated people")


def _learn(recordings: Sequence[Path], simulated: bool, histograms: SkinHistograms) -> BeliefTables:
    labelled = [LabelledRecording(path) for path in recordings]
    with progress_bar() as progress:
        bar = progress.add_task("frames", total=None)

        def sequences() -> Iterator[Iterator[LabelledFrame]]:
            yield from map(counted, labelled)
            if simulated:
                yield from (counted(frames) for frames in simulated_hands(HANDS_LEARNT_SEEDS))

        def counted(frames: Iterable[LabelledFrame]) -> Iterator[LabelledFrame]:
            for frame in frames:
                yield frame
                progress.advance(bar)

        sources = [f"{len(recordings)} recordings"] if recordings else []
        sources += ["the simulator's scenes"] if simulated else []
        tables = learn_beliefs(sequences(), histograms, " and ".join(sources))
    warn(*(problem for recording in labelled for problem in recording.problems))
    return tables


def _report(
    sequences: Sequences, histograms: SkinHistograms, tables: BeliefTables, what: str
) -> None:
    table = Table("features", title=f"rightly told in {what} / of what was told, right, %")
    for kind in Kind:
        table.add_column(kind.name.lower().replace("_", " "), justify="right")
    for title, names, know_heads in (
        ("Eq. 4.10", THESIS_FEATURES, False),
        ("and true sizes", (*THESIS_FEATURES, *SIZES), False),
        ("and known heads", tuple(FEATURES), True),
    ):
        score = score_beliefs(sequences, histograms, tables.only(names), know_heads=know_heads)
        cells = zip(score.accuracy, score.precision, strict=True)
        table.add_row(title, *(f"{100 * right:.0f} / {100 * true:.0f}" for right, true in cells))
    plain_console().print(table)
