"""`topview reproduce`: the thesis's figures and tables, made again."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter
from rich.text import Text

from topview.cli.printing import plain_console
from topview.cli.progress import compile_kernels, warn
from topview.cli.status import INTERRUPTED
from topview_lab.reproduce.catalogue import ALL, EXPERIMENTS, chosen
from topview_lab.reproduce.context import Context
from topview_lab.reproduce.make import MARKDOWN_FILE, PAGE_FILE, check_seed, make_report
from topview_lab.reproduce.page import Report


def reproduce(
    *names: str,
    out: Path = Path("reproduced"),
    quick: Annotated[bool, Parameter(negative="")] = False,
    mhad: Path | None = None,
    bridge: Path | None = None,
    seed: int = 0,
    workers: int = 0,
) -> int:
    """Reproduce the thesis's figures and tables beside its printed numbers.

    Simulates the recordings, tracks them and writes report.html, report.md, report.json and
    pictures.

    Args:
        names: NAMES.
        out: folder of the report.
        quick: shorter and fewer recordings, a few minutes instead of half an hour.
        mhad: folder of Berkeley MHAD, for Tables 6.1 and 6.2.
        bridge: folder of another system's skeletons, NAME.npz for each of the rivals' recordings,
            which are in OUT/recordings after a first call: see docs/bridge.md.
        seed: of all scenes; the tracker's stays.
        workers: processes, 0 for one per core; the numbers do not depend on it.
    """
    check_seed(seed)
    chosen(names)  # a wrong name is not told after compiling
    compile_kernels()
    made = make_report(names, Context(out, quick, seed, mhad, bridge), workers)
    warn(*made.report.problems)
    _print_verdicts(made.report)
    print(f"written to {out / PAGE_FILE} and {out / MARKDOWN_FILE}")
    return INTERRUPTED if made.interrupted else 0


def _print_verdicts(report: Report) -> None:
    console = plain_console()
    for verdict in report.verdicts:
        told = f": {verdict.claim}: {verdict.evidence}"
        console.print(Text.assemble((verdict.word, "bold"), told))


reproduce.__doc__ = (reproduce.__doc__ or "").replace("NAMES", f"{ALL}, {', '.join(EXPERIMENTS)}")
