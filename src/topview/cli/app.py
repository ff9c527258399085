"""The command `topview`."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from importlib.metadata import version

from cyclopts import App, CycloptsError

from topview.cli.annotate import annotate
from topview.cli.bench import bench
from topview.cli.demo import demo
from topview.cli.evaluate import evaluate
from topview.cli.reproduce import reproduce
from topview.cli.simulate import simulate
from topview.cli.status import INTERRUPTED, UNUSABLE_INPUT
from topview.cli.track import track
from topview.cli.train_forest import train_forest
from topview.cli.train_hands import train_hands
from topview.cli.train_skin import train_skin
from topview.records import InputError

app = App(
    name="topview",
    help="Training-free 3D body tracking of several people from one depth camera.",
    version=version("topview"),
    help_epilogue="`topview COMMAND --help` tells more of each.",
)
for command in (
    demo,
    track,
    evaluate,
    reproduce,
    simulate,
    annotate,
    train_skin,
    train_hands,
    train_forest,
    bench,
):
    app.command(command)


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command line and exit: 0 done, 2 unusable input (one line on stderr), 130 Ctrl-C."""
    try:
        status = app(
            arguments, exit_on_error=False, print_error=False, result_action="return_value"
        )
    except (InputError, CycloptsError) as error:
        sys.exit(_complain(str(error)))
    except OSError as error:  # a full disk, a folder that may not be written to
        where = f"{error.filename}: " if error.filename else ""
        sys.exit(_complain(f"{where}{error.strerror or error}"))
    except KeyboardInterrupt:
        print("topview: interrupted", file=sys.stderr)
        sys.exit(INTERRUPTED)
    sys.exit(status or 0)


def _complain(message: str) -> int:
    print(f"topview: {' '.join(message.split())}", file=sys.stderr)
    return UNUSABLE_INPUT
