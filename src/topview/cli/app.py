"""The command `topview`: its subcommands."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from contextlib import redirect_stderr, redirect_stdout
from importlib.metadata import version

from cyclopts import App, CycloptsError, Parameter

from topview.cli.values import converted
from topview.laboratory import COMMANDS
from topview.records import InputError

QUIET = "--quiet"

app = App(
    name="topview",
    help="3D body tracking of several people from one depth camera.",
    version=version("topview"),
    help_epilogue="`topview COMMAND --help` tells more of each. With `--quiet` any of them prints "
    "nothing but the error that ends it.",
    default_parameter=Parameter(converter=converted),
    suppress_keyboard_interrupt=False,  # `main` tells of it, and knows which signal came
)
app.command("topview.cli.track:track", name="track", help="Track everyone in a recording.")
app.command("topview.cli.batch:batch", name="batch", help="Track many recordings.")
app.command("topview.cli.info:info", name="info", help="Tell what is in a recording.")
app.command("topview.cli.view:view", name="view", help="Show a recording or a result in 3D.")
app.command(
    "topview.cli.recover:recover", name="recover", help="Make the result of a run that was killed."
)
app.command(
    "topview.cli.convert:convert", name="convert", help="Write skeletons in another format."
)
for name, (place, sentence) in COMMANDS.items():
    app.command(place, name=name, help=sentence, group="Laboratory")


def run(arguments: Sequence[str] | None = None) -> int:
    """Run a subcommand; its exit status. Its errors are raised."""
    words = list(sys.argv[1:] if arguments is None else arguments)
    options = words[: words.index("--")] if "--" in words else words
    if QUIET not in options:
        return _run(words)
    words.remove(QUIET)
    with open(os.devnull, "w") as nowhere, redirect_stdout(nowhere), redirect_stderr(nowhere):
        return _run(words)


def _run(words: Sequence[str]) -> int:
    try:
        status = app(words, exit_on_error=False, print_error=False, result_action="return_value")
    except CycloptsError as error:
        if isinstance(error.__cause__, InputError):  # it says all that is to be said
            raise error.__cause__ from None
        raise
    return status or 0
