"""Does the tracker treat left and right alike? A recording against its mirror image."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from rich.table import Table

from topview.body import JOINT_NAMES
from topview.io import MirroredRecording, open_recording
from topview.records import Frame, InputError, Recording
from topview.track.run import track_recording
from topview.track.settings import TrackerSettings
from topview_lab.evaluate.run import Track, tracked_whole
from topview_lab.evaluate.tables import empty_table, number, percent
from topview_lab.metrics.mirror import (
    MIRRORED_WITHIN_CM,
    Apart,
    measure_apart,
    mirrored_joints,
)
from topview_lab.metrics.splits import ALL


def compare_with_mirror_image(
    recording: Recording, settings: TrackerSettings, track: Track = track_recording
) -> Apart:
    """Track a recording and its images flipped left-right; how far the first lies from the second,
    flipped back. Random numbers are not mirrored, so that some way remains."""
    seen, flipped = (
        _joints_tracked(each, settings, track) for each in (recording, MirroredRecording(recording))
    )
    return measure_apart(seen, mirrored_joints(flipped))


def compare_with_other_seed(
    recording: Recording,
    settings: TrackerSettings,
    other: TrackerSettings,
    track: Track = track_recording,
) -> Apart:
    """How far two trackings of a recording lie apart that differ in their settings, as the seed:
    what random numbers alone do."""
    first, second = (_joints_tracked(recording, each, track) for each in (settings, other))
    return measure_apart(first, second)


def _joints_tracked(
    recording: Recording, settings: TrackerSettings, track: Track
) -> NDArray[np.float64]:
    """[F, S, 16, 3] in the order of `JOINT_NAMES`, metres."""
    skeletons = tracked_whole(recording, settings, track).skeletons
    columns = [skeletons.joint_names.index(name) for name in JOINT_NAMES]
    return skeletons.joints_camera[:, :, columns]


class FirstFrames:
    """A recording's first frames, whichever way round its reader gives them."""

    def __init__(self, recording: Recording, count: int | None) -> None:
        """Take the first `count` frames, or all if None."""
        self._recording = recording
        self._count = count
        self.name, self.camera = recording.name, recording.camera
        self.problems = recording.problems

    @property
    def frame_count(self) -> int | None:
        whole = self._recording.frame_count
        return whole if self._count is None or whole is None else min(whole, self._count)

    def __iter__(self) -> Iterator[Frame]:
        return islice(self._recording, self._count)


@dataclass(frozen=True, slots=True)
class MirrorOutcome:
    """One recording: how far it is from its mirror image and from another seed, or None and why."""

    name: str
    mirrored: Apart | None
    reseeded: Apart | None
    problems: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class MirrorJob:
    """One recording to be tracked as it is and in the mirror, in any process.

    Attributes:
        path: of the recording.
        settings: of the tracker.
        frames: how many, from the first on; all if None.
        other: settings to be compared with, too, or None.
        track: the tracker, importable by its name.
    """

    path: Path
    settings: TrackerSettings
    frames: int | None = None
    other: TrackerSettings | None = None
    track: Track = track_recording

    @property
    def name(self) -> str:
        return self.path.resolve().name

    def __call__(self) -> MirrorOutcome:
        try:
            recording = FirstFrames(open_recording(self.path), self.frames)
            apart = compare_with_mirror_image(recording, self.settings, self.track)
            reseeded = self.other and compare_with_other_seed(
                recording, self.settings, self.other, self.track
            )
        except InputError as error:
            return MirrorOutcome(self.name, None, None, (f"{self.name}: {error}",))
        problems = tuple(dict.fromkeys(f"{self.name}: {each}" for each in recording.problems))
        return MirrorOutcome(self.name, apart, reseeded, problems)


@dataclass(frozen=True, slots=True)
class ApartRow:
    """How far some joints lie apart; NaN where there is none.

    Attributes:
        count: of joints that both have.
        median_cm, most_cm: the distance of half of them, and of 95 %.
        near: share 0..1 within `MIRRORED_WITHIN_CM`.
        alone: person-frames that only one of the two has.
    """

    count: int
    median_cm: float
    most_cm: float
    near: float
    alone: int

    @classmethod
    def of(cls, apart: Apart) -> ApartRow:
        """All joints of two trackings."""
        count = int(np.isfinite(apart.distances_cm).sum())
        ends = apart.quantile_cm(0.5), apart.quantile_cm(0.95)
        return cls(count, *ends, apart.share_within(MIRRORED_WITHIN_CM), apart.alone)


def apart_by_joint(apart: Apart) -> dict[str, ApartRow]:
    """By joint, and of `ALL`."""
    joints = {name: ApartRow.of(apart.of_joint(j)) for j, name in enumerate(JOINT_NAMES)}
    return joints | {ALL: ApartRow.of(apart)}


def apart_by_sequence(aparts: Sequence[tuple[str, Apart]]) -> dict[str, ApartRow]:
    """By name, the one with the fewest joints that are near first."""
    rows = {name: ApartRow.of(apart) for name, apart in aparts}
    return dict(sorted(rows.items(), key=lambda row: row[1].near))


def apart_table(title: str, what: str, rows: Mapping[str, ApartRow]) -> Table:
    """A row for each name."""
    table = empty_table(f"{title}, cm", what)
    heads = "median", "95 %", f"≤ {MIRRORED_WITHIN_CM:g} cm", "count", "only in\none"
    for head in heads:
        table.add_column(head, justify="right")
    for name, row in rows.items():
        table.add_row(
            name,
            number(row.median_cm, digits=2),
            number(row.most_cm, digits=2),
            percent(row.near),
            str(row.count),
            str(row.alone),
            style="bold" if name == ALL else None,
        )
    return table
