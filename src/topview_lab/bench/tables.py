"""The tables that `topview bench` prints, at most 80 columns wide."""

from __future__ import annotations

from collections.abc import Sequence

from rich.box import SIMPLE_HEAD
from rich.table import Table

from topview_lab.bench.finding import FindingTime
from topview_lab.bench.inner_loops import KernelTime
from topview_lab.bench.recording import TimedRecording
from topview_lab.bench.tracking import GroupTime, TrackingTime

MISSING = "-"


def tracking_table(tracking: Sequence[TrackingTime]) -> Table:
    """Simulated scenes: one row for each scene and number of threads."""
    title = "tracking, median over the frames"
    columns = ("people", "threads", "ms/frame", "ms/person", "frames/s", "share of 1 thread's")
    table = _table(title, "image", columns)
    for time in tracking:
        single = next(t for t in tracking if _scene(t) == _scene(time) and t.threads == 1)
        table.add_row(
            *_scene(time),
            str(time.threads),
            _ms(time.ms_per_frame),
            _ms(time.ms_per_person),
            f"{1e3 / time.ms_per_frame:.1f}",
            f"{time.ms_per_frame / single.ms_per_frame:.2f}",
        )
    return table


def stage_table(tracking: Sequence[TrackingTime]) -> Table:
    """Simulated scenes: one row for each stage."""
    heads = ["\n".join((*_scene(time), str(time.threads))) for time in tracking]
    columns = [time.stages_ms for time in tracking]
    return _stages(
        "ms in each stage, median over the frames in which it runs",
        "image\npeople\nthreads",
        heads,
        columns,
    )


def finding_table(finding: Sequence[FindingTime]) -> Table:
    """The people finder alone: one row for each stage."""
    heads = ["\n".join((*_scene(time), time.detector, str(time.threads))) for time in finding]
    columns = [{"all": time.ms_per_frame} | time.stages_ms for time in finding]
    title = "finding people alone, ms per frame"
    return _stages(title, "image\npeople\ndetector\nthreads", heads, columns)


def kernel_table(kernels: Sequence[KernelTime]) -> Table:
    """The inner loops."""
    table = _table("inner loops, median over the calls", "loop", ("threads", "ms"))
    for time in kernels:
        table.add_row(time.name, str(time.threads), f"{time.ms:.2f}")
    return table


def people_table(recording: TimedRecording) -> Table:
    """A recording: all timed frames, then sorted by the number of people tracked in them."""
    columns = ("threads", "frames", "ms/frame", "ms/person", "frames/s", "90 % of frames")
    table = _table("tracking, median over the frames", "people", columns)
    counts = sorted({count for time in recording.tracking for count in time.by_people})
    for time in recording.tracking:
        whole = GroupTime(time.frames, time.ms_per_frame, time.ms_per_person)
        people = f"{counts[0]} to {counts[-1]}" if len(counts) > 1 else str(counts[0])
        table.add_row(*_group_cells(people, time, whole), f"{time.p90_ms_per_frame:.1f} ms")
    for count in counts if len(counts) > 1 else []:
        for time in recording.tracking:
            if count in time.by_people:
                group = time.by_people[count]
                table.add_row(*_group_cells(str(count), time, group), MISSING)
    return table


def recording_stage_table(recording: TimedRecording) -> Table:
    """A recording: one row for each stage, per frame and per person and frame."""
    heads, columns = [], []
    for time in recording.tracking:
        threads = f"{time.threads} thread{'s' if time.threads > 1 else ''}"
        heads += [f"{threads}\nms/frame", f"{threads}\nms/person"]
        columns += [time.stages_ms, time.stages_ms_per_person]
    return _stages("each stage, median over the frames in which it runs", "stage", heads, columns)


def _group_cells(people: str, time: TrackingTime, group: GroupTime) -> tuple[str, ...]:
    return (
        people,
        str(time.threads),
        str(group.frames),
        _ms(group.ms_per_frame),
        _ms(group.ms_per_person),
        f"{1e3 / group.ms_per_frame:.1f}",
    )


def _stages(
    title: str, first: str, heads: Sequence[str], columns: Sequence[dict[str, float]]
) -> Table:
    """Rows of stages; `columns` holds each column's milliseconds by stage."""
    table = _table(title, first, heads, gap=0)
    for name in dict.fromkeys(name for column in columns for name in column):
        table.add_row(name, *(_ms(column.get(name)) for column in columns))
    return table


def _ms(value: float | None) -> str:
    return MISSING if value is None else f"{value:.1f}"


def _table(title: str, first: str, others: Sequence[str], gap: int = 1) -> Table:
    """An empty table; `gap` widens the single spaces between its columns."""
    table = Table(
        first,
        title=title,
        title_justify="left",
        box=SIMPLE_HEAD,
        pad_edge=False,
        padding=(0, gap, 0, 0),
    )
    for column in others:
        table.add_column(column, justify="right")
    return table


def _scene(time: TrackingTime | FindingTime) -> tuple[str, str]:
    return f"{time.width}x{time.height}", str(time.people)
