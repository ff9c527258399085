"""The command `topview`: its subcommands."""

from __future__ import annotations

from collections.abc import Sequence
from importlib.metadata import version

from cyclopts import App, CycloptsError, Parameter

from topview.cli.values import converted
from topview.laboratory import COMMANDS
from topview.records import InputError

app = App(
    name="topview",
    help="3D body tracking of several people from one depth camera.",
    version=version("topview"),
    help_epilogue="`topview COMMAND --help` tells more of each.",
    default_parameter=Parameter(converter=converted),
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
    try:
        status = app(
            arguments, exit_on_error=False, print_error=False, result_action="return_value"
        )
    except CycloptsError as error:
        if isinstance(error.__cause__, InputError):  # it says all that is to be said
            raise error.__cause__ from None
        raise
    return status or 0
