"""Who is hidden entirely and comes back: from the scene to the table."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from rich.table import Table

from topview.records import InputError
from topview.track.run import track_recording
from topview.track.settings import TrackerSettings
from topview_lab.datasets.hiding import SimulatedHiding
from topview_lab.evaluate.people import tracked_heads
from topview_lab.evaluate.run import Track, tracked_whole
from topview_lab.evaluate.tables import empty_table, number, percent
from topview_lab.metrics.returns import Return, ReturnsSummary, score_return, summarise_returns
from topview_lab.metrics.splits import ALL
from topview_lab.sim.scenes.hiding import WHO_HIDES


@dataclass(frozen=True, slots=True)
class ReturnOutcome:
    """One scene: what became of who was hidden, or None and why."""

    hiding: SimulatedHiding
    score: Return | None
    problems: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class ReturnJob:
    """One scene to be tracked, in any process.

    Attributes:
        hiding: the scene.
        settings: of the tracker.
        track: the tracker, importable by its name.
    """

    hiding: SimulatedHiding
    settings: TrackerSettings
    track: Track = track_recording

    def __call__(self) -> ReturnOutcome:
        try:
            recording = self.hiding.open()
            tracked = tracked_whole(recording, self.settings, self.track).skeletons
        except InputError as error:
            return ReturnOutcome(self.hiding, None, (f"{self.hiding.name}: {error}",))
        score = score_return(
            recording.true_heads(),
            tracked_heads(tracked),
            tracked.person_ids,
            tracked.timestamps_s,
            WHO_HIDES,
        )
        return ReturnOutcome(self.hiding, score)


def returns_by_cover(outcomes: Sequence[ReturnOutcome]) -> dict[str, ReturnsSummary]:
    """By what hides and for how long, and of `ALL`; only what was measured."""
    groups: dict[str, list[Return]] = {}
    for outcome in outcomes:
        if outcome.score is not None:
            name = f"{outcome.hiding.behind}, {outcome.hiding.hidden_s:g} s"
            groups.setdefault(name, []).append(outcome.score)
    every = [score for scores in groups.values() for score in scores]
    if every:
        groups[ALL] = every
    return {name: summarise_returns(scores) for name, scores in groups.items()}


def returns_table(rows: Mapping[str, ReturnsSummary]) -> Table:
    """A row for each name."""
    table = empty_table("hidden entirely, and back", "behind")
    for head in (
        *("count", "hidden\ns", "same\nidentity", "found\nagain"),
        *("found after\nmedian, s", "\n95 %, s"),
    ):
        table.add_column(head, justify="right")
    for name, row in rows.items():
        table.add_row(
            name,
            str(row.count),
            number(row.hidden_s),
            percent(row.kept),
            percent(row.found),
            number(row.wait_median_s, digits=2),
            number(row.wait_95_s, digits=2),
            style="bold" if name == ALL else None,
        )
    return table


def each_return_table(outcomes: Sequence[ReturnOutcome]) -> Table:
    """A row for each scene, those who lost their identity first."""
    table = empty_table("per sequence, worst first", "scene")
    for head in ("same identity", "found after, s"):
        table.add_column(head, justify="right")
    scored = [(each.hiding.name, each.score) for each in outcomes if each.score is not None]
    for name, score in sorted(scored, key=lambda row: (row[1].kept, -row[1].wait_s)):
        table.add_row(name, "yes" if score.kept else "no", number(score.wait_s, digits=2))
    return table
