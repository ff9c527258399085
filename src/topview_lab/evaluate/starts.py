"""Starts in any pose: whether somebody is tracked soon, by pose and direction."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from rich.table import Table

from topview.records import InputError
from topview.track.run import track_recording
from topview.track.settings import TrackerSettings
from topview_lab.datasets.starts import SimulatedStart
from topview_lab.evaluate.run import Track, tracked_whole
from topview_lab.evaluate.tables import empty_table, number
from topview_lab.metrics.measure import measure_sequence
from topview_lab.metrics.starts import StartScore, StartsSummary, score_start, summarise_starts

ALL_STARTS = "all"


@dataclass(frozen=True, slots=True)
class StartOutcome:
    """One start: its score, or None and why."""

    start: SimulatedStart
    score: StartScore | None
    problems: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class StartJob:
    """One start to be tracked and scored, in any process.

    Attributes:
        start: what to track.
        settings: of the tracker.
        track: the tracker, importable by its name.
    """

    start: SimulatedStart
    settings: TrackerSettings
    track: Track = track_recording

    def __call__(self) -> StartOutcome:
        try:
            recording = self.start.open()
            skeletons = tracked_whole(recording, self.settings, self.track).skeletons
            errors = measure_sequence(skeletons, recording.reference(), self.start.name)
        except InputError as error:
            return StartOutcome(self.start, None, (f"{self.start.name}: {error}",))
        return StartOutcome(self.start, score_start(errors))


Rows = dict[str, dict[str, StartsSummary]]


def starts_by_pose(outcomes: Sequence[StartOutcome]) -> Rows:
    """By pose and `ALL_STARTS`, then by direction and `ALL_STARTS`; only what was measured."""
    poses = dict.fromkeys(outcome.start.pose for outcome in outcomes)
    directions = dict.fromkeys(outcome.start.direction for outcome in outcomes)

    def summed(is_meant: Callable[[SimulatedStart], bool]) -> StartsSummary | None:
        scores = [o.score for o in outcomes if o.score is not None and is_meant(o.start)]
        return summarise_starts(scores) if scores else None

    rows: Rows = {}
    for pose in (*poses, ALL_STARTS):
        cells = {
            direction: summed(
                lambda start, pose=pose, direction=direction: (
                    pose in (start.pose, ALL_STARTS) and direction in (start.direction, ALL_STARTS)
                )
            )
            for direction in (*directions, ALL_STARTS)
        }
        rows[pose] = {name: cell for name, cell in cells.items() if cell is not None}
    return {pose: cells for pose, cells in rows.items() if cells}


def starts_table(rows: Mapping[str, Mapping[str, StartsSummary]]) -> Table:
    """A row for each pose; in each direction the share of visible joints that are near, and of
    frames that face right; of all directions the share of frames in which somebody is found, and of
    starts that hold."""
    table = empty_table("starts: joints near/frames that face right, %", "pose")
    names = list(rows[ALL_STARTS])
    for name in names:
        table.add_column(name, justify="right")
    table.add_column("found", justify="right")
    table.add_column("hold", justify="right")
    for pose, cells in rows.items():
        shown = (_cell(cells[name]) if name in cells else "" for name in names)
        style = "bold" if pose == ALL_STARTS else None
        every = cells[ALL_STARTS]
        ends = (number(100.0 * one, digits=0) for one in (every.found, every.holds))
        table.add_row(pose, *shown, *ends, style=style)
    return table


def each_start_table(outcomes: Sequence[StartOutcome]) -> Table:
    """A row for each start, the worst first."""
    table = empty_table("per sequence, worst first, %", "start")
    table.add_column("joints/facing", justify="right")
    table.add_column("found", justify="right")
    scored = [(outcome.start.name, outcome.score) for outcome in outcomes if outcome.score]
    for name, score in sorted(scored, key=lambda row: (row[1].facing, row[1].joints)):
        table.add_row(name, _cell(score), number(100.0 * score.found, digits=0))
    return table


def starts_as_json(rows: Rows) -> dict[str, Any]:
    """JSON types."""
    return {
        pose: {direction: asdict(cell) for direction, cell in cells.items()}
        for pose, cells in rows.items()
    }


def _cell(score: StartsSummary | StartScore) -> str:
    return "/".join(number(100.0 * one, digits=0) for one in (score.joints, score.facing))
