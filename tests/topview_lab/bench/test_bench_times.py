from __future__ import annotations

from collections.abc import Sequence

import pytest
from rich.console import Console
from rich.table import Table

from topview.records import Camera, InputError
from topview_lab.bench.finding import FindingTime
from topview_lab.bench.recording import TimedRecording, time_recording
from topview_lab.bench.tables import (
    finding_table,
    people_table,
    recording_stage_table,
    stage_table,
    tracking_table,
)
from topview_lab.bench.tracking import FrameTime, TrackingTime, summarise_times

STAGES = (
    "people", "evidence", "body", "limbs", "refinement", "facing", "visibility", "start", "recover",
)  # fmt: skip


VGA = Camera(fx=525.0, fy=525.0, cx=319.5, cy=239.5, width=640, height=480)


def frame_time(index: int, people: int, ms: float) -> FrameTime:
    """Whose tracking takes half of the time, in frames with people."""
    stages_ms = {"people": 0.5 * ms} | ({"limbs": 0.5 * ms} if people else {})
    return FrameTime(index, people, ms, stages_ms)


CHANGING = [
    frame_time(3, 0, 4.0),
    frame_time(4, 1, 10.0),
    frame_time(5, 1, 12.0),
    frame_time(6, 3, 60.0),
    frame_time(7, 0, 6.0),
]


class TestMediansOfATimedRecording:
    def test_a_person_has_the_frames_time_over_the_people_in_it(self):
        time = summarise_times(CHANGING, VGA, threads=1)
        assert time.ms_per_frame == 10.0
        assert time.ms_per_person == 12.0  # of 10, 12 and 60 / 3
        assert time.stages_ms == {"people": 5.0, "limbs": 6.0}
        assert time.stages_ms_per_person == {"people": 6.0, "limbs": 6.0}

    def test_frames_are_sorted_by_the_number_of_people(self):
        groups = summarise_times(CHANGING, VGA, threads=1).by_people
        assert list(groups) == [0, 1, 3]
        assert [group.frames for group in groups.values()] == [2, 2, 1]
        assert [group.ms_per_frame for group in groups.values()] == [5.0, 11.0, 60.0]
        assert [group.ms_per_person for group in groups.values()] == [None, 11.0, 20.0]

    def test_with_nobody_no_time_is_a_persons(self):
        time = summarise_times([frame_time(3, 0, 4.0)], VGA, threads=2)
        assert time.ms_per_person is None
        assert time.stages_ms_per_person == {}

    def test_nine_of_ten_frames_take_no_longer_than_stated(self):
        times = [frame_time(k, 1, float(k)) for k in range(1, 21)]
        assert summarise_times(times, VGA, threads=1).p90_ms_per_frame == 18.0


def printed(tables: Sequence[Table]) -> list[str]:
    console = Console(width=80)
    with console.capture() as capture:
        for table in tables:
            console.print(table)
    return capture.get().splitlines()


def long_time(people: int | None, threads: int) -> TrackingTime:
    times = [
        FrameTime(k, k % 5, 1234.5, dict.fromkeys(STAGES, 234.5)) for k in range(3, 13)
    ]  # fmt: skip
    return summarise_times(times, VGA, threads, people)


def test_tables_fit_80_columns():
    scenes = [long_time(people, threads) for people in (1, 2, 1, 2) for threads in (1, 16)]
    finding = [
        FindingTime(640, 480, 4, detector, threads, 123.4, dict.fromkeys(STAGES, 23.4))
        for detector in ("depth", "auto")
        for threads in (1, 16)
    ]
    tracking = (long_time(None, 1), long_time(None, 16))
    recording = TimedRecording("mine", 3, 12, 3, 10, (), tracking)
    lines = printed([
        tracking_table(scenes), stage_table(scenes), finding_table(finding),
        people_table(recording), recording_stage_table(recording),
    ])  # fmt: skip
    assert max(map(len, lines)) <= 80
    assert not any("…" in line for line in lines)
    rows = {line.split()[0] for line in lines if line.strip()}
    assert {*STAGES, "640x480"} <= rows


class Unreadable:
    """A recording of which no frame can be read."""

    name = "broken"
    camera = VGA

    def __init__(self) -> None:
        self.problems: list[str] = []

    @property
    def frame_count(self) -> int:
        return 9

    def __iter__(self):
        self.problems.append("depth/000000.png: is empty; it must be a 16-bit PNG")
        return iter(())


def test_a_recording_without_frames_to_time_is_refused():
    with pytest.raises(
        InputError, match=r"broken: too few of its frames could be read \(it has 9\)"
    ):
        time_recording(Unreadable(), [1])
