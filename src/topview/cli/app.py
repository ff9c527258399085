"""The command `topview`."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from importlib.metadata import version

from cyclopts import App, CycloptsError

from topview.cli.status import INTERRUPTED, UNUSABLE_INPUT
from topview.laboratory import COMMANDS
from topview.records import InputError

app = App(
    name="topview",
    help="3D body tracking of several people from one depth camera.",
    version=version("topview"),
    help_epilogue="`topview COMMAND --help` tells more of each.",
)
app.command("topview.cli.track:track", name="track", help="Track everyone in a recording.")
for name, (place, sentence) in COMMANDS.items():
    app.command(place, name=name, help=sentence, group="Laboratory")


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
