"""Every figure and table that can be reproduced, by its name on the command line."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

from topview.evaluate.reproduce.angles import runs_6_4, table_6_4
from topview.evaluate.reproduce.context import Context
from topview.evaluate.reproduce.detection import detection, searches
from topview.evaluate.reproduce.factors import runs_6_3, table_6_3
from topview.evaluate.reproduce.finding import Search
from topview.evaluate.reproduce.hypotheses import figure_6_3, runs_figure_6_3
from topview.evaluate.reproduce.mhad import runs_6_1, runs_6_2, table_6_1, table_6_2
from topview.evaluate.reproduce.rivals import rivals, runs_of_rivals
from topview.evaluate.reproduce.runs import Measured, Run
from topview.evaluate.reproduce.score_surfaces import figure_5_4
from topview.evaluate.reproduce.section import Section
from topview.evaluate.reproduce.shells import figure_3_2
from topview.evaluate.reproduce.upper_body import runs_5_2, table_5_2
from topview.evaluate.reproduce.users import runs_of_users, users
from topview.records import InputError


@dataclass(frozen=True, slots=True)
class Experiment:
    """One figure or table.

    Attributes:
        section: what it has to tell, given what was measured of its runs.
        runs: what it needs to have tracked.
        searches: where it needs to have people found.
    """

    section: Callable[[Context, Measured], Section]
    runs: Callable[[Context], Sequence[Run]] = lambda context: ()
    searches: Callable[[Context], Sequence[Search]] = lambda context: ()


EXPERIMENTS: Final[dict[str, Experiment]] = {
    "figure-3.2": Experiment(lambda context, _: figure_3_2(context)),
    "detection": Experiment(detection, searches=searches),
    "table-5.2": Experiment(table_5_2, runs_5_2),
    "figure-5.4": Experiment(lambda context, _: figure_5_4(context)),
    "table-6.1": Experiment(table_6_1, runs_6_1),
    "table-6.2": Experiment(table_6_2, runs_6_2),
    "table-6.3": Experiment(table_6_3, runs_6_3),
    "figure-6.3": Experiment(figure_6_3, runs_figure_6_3),
    "table-6.4": Experiment(table_6_4, runs_6_4),
    "users": Experiment(users, runs_of_users),
    "rivals": Experiment(rivals, runs_of_rivals),
}
ALL: Final = "all"


def chosen(names: Sequence[str]) -> dict[str, Experiment]:
    """Those of these names in the thesis's order, everything for "all" or none.

    Raises:
        InputError: a name is unknown.
    """
    unknown = [name for name in names if name != ALL and name not in EXPERIMENTS]
    if unknown:
        raise InputError(
            f"reproduce: {', '.join(unknown)} is not known; it must be {ALL} or some of "
            f"{', '.join(EXPERIMENTS)}"
        )
    if not names or ALL in names:
        return dict(EXPERIMENTS)
    return {name: experiment for name, experiment in EXPERIMENTS.items() if name in names}
