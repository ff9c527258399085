"""The command `topview`: its subcommands."""

from __future__ import annotations

from collections.abc import Sequence
from importlib.metadata import version

from cyclopts import App

from topview.laboratory import COMMANDS

app = App(
    name="topview",
    help="3D body tracking of several people from one depth camera.",
    version=version("topview"),
    help_epilogue="`topview COMMAND --help` tells more of each.",
)
app.command("topview.cli.track:track", name="track", help="Track everyone in a recording.")
app.command(
    "topview.cli.recover:recover", name="recover", help="Make the result of a run that was killed."
)
for name, (place, sentence) in COMMANDS.items():
    app.command(place, name=name, help=sentence, group="Laboratory")


def run(arguments: Sequence[str] | None = None) -> int:
    """Run a subcommand; its exit status. Its errors are raised."""
    status = app(arguments, exit_on_error=False, print_error=False, result_action="return_value")
    return status or 0
