"""Every figure and table that can be reproduced, by its name on the command line."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

from topview.records import InputError
from topview_lab.reproduce.angles import runs_6_4, table_6_4
from topview_lab.reproduce.context import Context
from topview_lab.reproduce.detection import detection, searches
from topview_lab.reproduce.factors import runs_6_3, table_6_3
from topview_lab.reproduce.finding import Search
from topview_lab.reproduce.hypotheses import figure_6_3, runs_figure_6_3
from topview_lab.reproduce.mhad import runs_6_1, runs_6_2, table_6_1, table_6_2
from topview_lab.reproduce.pixel_kinds import figure_5_7, scenes_5_7
from topview_lab.reproduce.rivals import rivals, runs_of_rivals
from topview_lab.reproduce.runs import Counterpart, Measured, Run
from topview_lab.reproduce.score_surfaces import figure_5_4
from topview_lab.reproduce.section import Section
from topview_lab.reproduce.shells import figure_3_2
from topview_lab.reproduce.snapshots import (
    figure_5_5,
    figure_5_6,
    figure_6_1,
    figure_6_4,
    runs_5_5,
    runs_5_6,
    runs_figure_6_1,
    runs_figure_6_4,
)
from topview_lab.reproduce.top_views import figure_5_2, scenes_5_2
from topview_lab.reproduce.upper_body import runs_5_2, table_5_2
from topview_lab.reproduce.users import runs_of_users, users


@dataclass(frozen=True, slots=True)
class Experiment:
    """One figure or table.

    Attributes:
        section: what it has to tell, given what was measured of its runs.
        runs: what it needs to have tracked.
        searches: where it needs to have people found.
        scenes: what it simulates by itself.
    """

    section: Callable[[Context, Measured], Section]
    runs: Callable[[Context], Sequence[Run]] = lambda context: ()
    searches: Callable[[Context], Sequence[Search]] = lambda context: ()
    scenes: Callable[[Context], Sequence[Counterpart]] = lambda context: ()

    def seeds(self, context: Context) -> list[int]:
        """Of the simulated recordings, sorted; recordings of a data set have none."""
        recordings = [*(run.recording for run in self.runs(context)), *self.scenes(context)]
        seeds = {recording.seed for recording in recordings if isinstance(recording, Counterpart)}
        return sorted(seeds | {search.case.seed for search in self.searches(context)})


EXPERIMENTS: Final[dict[str, Experiment]] = {
    "figure-3.2": Experiment(lambda context, _: figure_3_2(context)),
    "detection": Experiment(detection, searches=searches),
    "figure-5.2": Experiment(lambda context, _: figure_5_2(context), scenes=scenes_5_2),
    "table-5.2": Experiment(table_5_2, runs_5_2),
    "figure-5.4": Experiment(
        lambda context, _: figure_5_4(context), scenes=Context.dummy_sequences
    ),
    "figure-5.5": Experiment(figure_5_5, runs_5_5),
    "figure-5.6": Experiment(figure_5_6, runs_5_6),
    "figure-5.7": Experiment(lambda context, _: figure_5_7(context), scenes=scenes_5_7),
    "figure-6.1": Experiment(figure_6_1, runs_figure_6_1),
    "table-6.1": Experiment(table_6_1, runs_6_1),
    "table-6.2": Experiment(table_6_2, runs_6_2),
    "table-6.3": Experiment(table_6_3, runs_6_3),
    "figure-6.3": Experiment(figure_6_3, runs_figure_6_3),
    "table-6.4": Experiment(table_6_4, runs_6_4),
    "figure-6.4": Experiment(figure_6_4, runs_figure_6_4),
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
