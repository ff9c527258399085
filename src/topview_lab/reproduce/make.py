"""Make the report: track what the chosen experiments need, once each, and write the pages."""

from __future__ import annotations

import os
import platform
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.metadata import version
from time import perf_counter

import msgspec
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn

from topview.io.writers import prepare_output_folder, write_atomically
from topview.records import InputError
from topview_lab.reproduce.catalogue import Experiment, chosen
from topview_lab.reproduce.context import Context
from topview_lab.reproduce.page import Report, as_html, as_markdown
from topview_lab.reproduce.plots import require_matplotlib
from topview_lab.reproduce.provenance import provenance
from topview_lab.reproduce.runs import Measured, Run, track_runs, with_findings
from topview_lab.reproduce.section import Section

MARKDOWN_FILE, PAGE_FILE, NUMBERS_FILE = "report.md", "report.html", "report.json"


@dataclass(frozen=True, slots=True)
class FinishedReport:
    """A report that was written, and whether Ctrl-C ended it early."""

    report: Report
    interrupted: bool


def make_report(
    names: Sequence[str], context: Context, workers: int = 0, console: Console | None = None
) -> FinishedReport:
    """Reproduce figures and tables into `context.out`: report.md, report.html, report.json,
    pictures/ and the simulated recordings.

    Ctrl-C ends it early; what was complete by then is reported. Workers start anew, so a script
    that calls this must guard its start with `if __name__ == "__main__"`.

    Args:
        names: some of `catalogue.EXPERIMENTS`, all of them if empty.
        context: where, how large, on what.
        workers: processes, 0 for one per core; the numbers do not depend on it.
        console: where progress goes, stderr if None.

    Raises:
        InputError: a name is unknown, something is not installed, or the folder cannot be used.
    """
    experiments = chosen(names)
    require_matplotlib()
    prepare_output_folder(context.out)
    start = perf_counter()
    wanted = {name: list(experiment.runs(context)) for name, experiment in experiments.items()}
    sought = {name: list(experiment.searches(context)) for name, experiment in experiments.items()}
    seeds = {name: experiment.seeds(context) for name, experiment in experiments.items()}
    tracked = track_runs([run for runs in wanted.values() for run in runs], workers, console)
    if not tracked.interrupted:
        searches = [search for searches in sought.values() for search in searches]
        tracked = with_findings(tracked, searches, workers, console)
    complete = {
        name: experiment
        for name, experiment in experiments.items()
        if _is_complete(wanted[name], tracked.measured)
        and all(search in tracked.measured.findings for search in sought[name])
    }
    sections = _sections(complete, context, tracked.measured, console)
    left_out = [f"{name} was not finished" for name in experiments if name not in complete]
    report = Report(
        title="The thesis's experiments, reproduced",
        preface=_preface(context, perf_counter() - start),
        sections=tuple(sections),
        problems=(*tracked.problems, *left_out),
        appendix=(provenance(seeds),),
    )
    write(report, context)
    return FinishedReport(report, tracked.interrupted)


def write(report: Report, context: Context) -> None:
    """All forms of a report."""
    out = context.out
    numbers = {
        section.name: {
            "numbers": section.numbers,
            "verdicts": [(v.word, v.claim, v.evidence) for v in section.verdicts],
        }
        for section in (*report.sections, *report.appendix)
    }
    write_atomically(out / MARKDOWN_FILE, as_markdown(report, out).encode())
    write_atomically(out / PAGE_FILE, as_html(report, out).encode())
    write_atomically(
        out / NUMBERS_FILE, msgspec.json.format(msgspec.json.encode(numbers), indent=1)
    )


def _is_complete(runs: Sequence[Run], measured: Measured) -> bool:
    """Whether all runs were done, and at least one of them, if there are any, was measured."""
    outcomes = [measured.outcomes[run] for run in runs if run in measured.outcomes]
    is_measured = any(outcome.errors is not None for outcome in outcomes)
    return len(outcomes) == len(runs) and (is_measured or not runs)


def _sections(
    experiments: dict[str, Experiment],
    context: Context,
    measured: Measured,
    console: Console | None,
) -> list[Section]:
    sections = []
    console = console or Console(stderr=True)
    with Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        console=console,
        disable=not console.is_terminal,
    ) as progress:
        task = progress.add_task("reporting", total=len(experiments))
        for experiment in experiments.values():
            sections.append(experiment.section(context, measured))
            progress.advance(task)
    return sections


def _preface(context: Context, seconds: float) -> tuple[str, ...]:
    data = (
        f"Tables 6.1 and 6.2 on Berkeley MHAD in {context.mhad}, everything else"
        if context.mhad
        else "Everything"
    )
    size = "a quick form with shorter and fewer recordings" if context.quick else "the full form"
    return (
        "Numbers of the thesis are as printed, on its own recordings; ours are measured. "
        f"{data} on simulated counterparts (topview simulate, a Kinect at 320 x 240). Numbers of "
        "different recordings do not prove who is better; they say whether the method behaves as "
        "described. Rows in grey are the thesis's or still to come.",
        "The simulated people are not unseen data: the last section says which of them were looked "
        "at while something was built. Nor are they neutral. Simulator and tracker take the places "
        "of hips, knees, ankles and shoulders and the forearm's length from the same shares of the "
        "stature (Drillis and Contini, as in Winter), and their girths from the same survey "
        "(Gordon et al.), which flatters distances that have no offsets out.",
        f"topview {version('topview')}, {size}, seed {context.seed}; made in "
        f"{seconds / 60:.0f} minutes on {os.cpu_count()} cores of {platform.machine()}, Python "
        f"{platform.python_version()}.",
    )


def check_seed(seed: int) -> None:
    """Raises InputError for a seed that cannot shift the scenes' seeds."""
    if not 0 <= seed < 10**6:
        raise InputError(f"seed is {seed}; it must be 0 to 999999")
