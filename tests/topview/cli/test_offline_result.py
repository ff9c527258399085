"""What `track --offline` does when all is tracked: nothing is lost, pictures show the result."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import cast

import numpy as np
import pytest

from made_frames import ABOUT, frames_with
from topview.cli import results
from topview.cli.results import SMOOTHED_NAME, look_both_ways, show_again
from topview.cli.track import tracked_both_ways
from topview.io import FramesFile, StoredFrames
from topview.records import Camera, Frame, InputError, Person
from topview.skeletons import TrackedFrame
from topview.track import TrackingRun
from topview.track.offline import looked_at_both_ways
from topview.track.run import read_again

CAMERA = Camera(fx=60.0, fy=60.0, cx=15.5, cy=11.5, width=32, height=24)
WHO = [[1], [1, 2], [], [2, 1], [2]]


def stored(folder: Path) -> StoredFrames:
    with FramesFile(folder / "skeletons.frames", ABOUT) as file:
        for frame in frames_with(WHO):
            file.append(frame)
    return StoredFrames(folder / "skeletons.frames")


def told(frames: Sequence[TrackedFrame]) -> list[tuple]:
    return [(f.index, f.timestamp_s, f.name, f.people.tobytes(), f.floor_camera) for f in frames]


def test_the_file_holds_what_was_smoothed_and_nothing_is_left_beside_it(tmp_path):
    (tmp_path / SMOOTHED_NAME).write_bytes(b"of a run that was killed")
    before = stored(tmp_path)
    expected = told(list(looked_at_both_ways(before.frames(), ABOUT.settings)))
    after = look_both_ways(before)
    assert told(list(after.frames())) == expected
    assert expected != told(frames_with(WHO))
    assert [path.name for path in tmp_path.iterdir()] == ["skeletons.frames"]


def test_a_stop_in_the_middle_leaves_what_was_tracked(tmp_path, monkeypatch):
    def stopped(frames, *_):
        yield from list(frames)[:2]
        raise KeyboardInterrupt

    before = stored(tmp_path)
    monkeypatch.setattr(results, "looked_at_both_ways", stopped)
    with pytest.raises(KeyboardInterrupt):
        look_both_ways(before)
    assert told(list(StoredFrames(before.path).frames())) == told(frames_with(WHO))
    assert [path.name for path in tmp_path.iterdir()] == ["skeletons.frames"]


class Run:
    """A run that is told as it was tracked backwards: as forward, by other numbers."""

    def __init__(self, *, stops: BaseException | None = None, interrupted: bool = False) -> None:
        self.stops, self.interrupted, self.asked = stops, interrupted, 0

    def backwards(self) -> Iterator[TrackedFrame]:
        self.asked += 1
        for frame in frames_with(WHO if self.stops is None else WHO[:2]):
            frame.people["joints_camera"] += 0.05
            frame.people["id"] += 10
            yield frame
        if self.stops is not None:
            raise self.stops


def test_all_is_tracked_backwards_and_told_of_both(tmp_path):
    expected = told(list(looked_at_both_ways(frames_with(WHO), ABOUT.settings, Run().backwards())))
    run = cast(TrackingRun, Run())
    after = tracked_both_ways(stored(tmp_path), run, ended_early=False)
    assert told(list(after.frames())) == expected
    assert expected != smoothed_alone()
    assert not run.interrupted


def test_who_stops_that_gets_what_was_tracked_smoothed(tmp_path):
    run = cast(TrackingRun, Run(stops=KeyboardInterrupt()))
    after = tracked_both_ways(stored(tmp_path), run, ended_early=False)
    assert told(list(after.frames())) == smoothed_alone()
    assert run.interrupted


def test_what_cannot_be_tracked_backwards_is_told_and_loses_nothing(tmp_path, capsys):
    run = cast(TrackingRun, Run(stops=InputError("the camera moves")))
    after = tracked_both_ways(stored(tmp_path), run, ended_early=False)
    assert told(list(after.frames())) == smoothed_alone()
    assert capsys.readouterr().err == "topview: not tracked backwards: the camera moves\n"
    assert not run.interrupted


@pytest.mark.parametrize("ended", [{"interrupted": True}, {"ended_early": True}])
def test_what_ended_early_is_not_tracked_backwards(tmp_path, ended):
    run = Run(interrupted=ended.get("interrupted", False))
    after = tracked_both_ways(
        stored(tmp_path), cast(TrackingRun, run), ended_early=ended.get("ended_early", False)
    )
    assert told(list(after.frames())) == smoothed_alone()
    assert run.asked == 0


def smoothed_alone() -> list[tuple]:
    return told(list(looked_at_both_ways(frames_with(WHO), ABOUT.settings)))


class Images:
    """A recording of which frame 1 is no longer read; it names that each time."""

    name, camera, frame_count = "images", CAMERA, len(WHO)

    def __init__(self) -> None:
        self.problems: list[str] = ["1.png: cannot be read"]

    def __iter__(self):
        self.problems.append("1.png: cannot be read")
        for index in range(len(WHO)):
            if index != 1:
                yield Frame(index, index / 30.0, np.zeros((24, 32), np.float32), CAMERA)


def test_what_is_told_of_a_second_reading_that_stops_early_is_not_kept():
    recording = Images()
    assert next(read_again(recording)).index == 0
    assert recording.problems == ["1.png: cannot be read"]


class Shown:
    def __init__(self) -> None:
        self.told: list[tuple[int, list[int]]] = []

    def show(self, frame: Frame, people: Sequence[Person]) -> None:
        self.told.append((frame.index, sorted(person.id for person in people)))


def test_pictures_show_the_stored_people_with_their_frames(tmp_path):
    recording, shown = Images(), Shown()
    show_again(recording, stored(tmp_path), shown)
    assert shown.told == [(0, [1]), (2, []), (3, [1, 2]), (4, [2])]
    assert recording.problems == ["1.png: cannot be read"]
