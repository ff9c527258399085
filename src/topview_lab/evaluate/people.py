"""Who was found in recordings whose people are known: the tracker against true heads."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray
from rich.table import Table

from topview.records import InputError, Recording
from topview.skeletons import SkeletonSequence
from topview.track.run import track_recording
from topview.track.settings import TrackerSettings
from topview_lab.datasets.true_heads import HEAD_NAME
from topview_lab.evaluate.run import Track, tracked_whole
from topview_lab.evaluate.tables import empty_table, number, percent
from topview_lab.metrics.heads import PeopleFound, TrueHeads, due_of, measure_heads, recall_of
from topview_lab.metrics.statistics import share

ALL_KINDS = "all"


@runtime_checkable
class KnowsHeads(Protocol):
    """A recording that knows the true heads of its frames once they are read."""

    def true_heads(self) -> TrueHeads: ...


class CountedRecording(Protocol):
    """A recording whose people can be counted; small and picklable."""

    @property
    def name(self) -> str:
        """What the tables call it."""
        ...

    def open(self) -> Recording:
        """The frames. Raises InputError where they cannot be read."""
        ...

    def true_heads(self) -> TrueHeads:
        """Of all frames. Raises InputError where they cannot be read."""
        ...


@dataclass(frozen=True, slots=True)
class PeopleOutcome:
    """One recording: who was found, or None and why; what could not be read, one line each."""

    name: str
    found: PeopleFound | None
    problems: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class PeopleJob:
    """One recording to be tracked and its people counted, in any process.

    Attributes:
        recording: what to track.
        settings: of the tracker.
        track: the tracker, importable by its name.
    """

    recording: CountedRecording
    settings: TrackerSettings
    track: Track = track_recording

    def __call__(self) -> PeopleOutcome:
        name = self.recording.name
        try:
            recording = self.recording.open()
            if isinstance(recording, KnowsHeads):
                tracked = tracked_whole(recording, self.settings, self.track).skeletons
                truth = recording.true_heads()
            else:  # the truth first: it may be unreadable
                truth = self.recording.true_heads()
                tracked = tracked_whole(recording, self.settings, self.track).skeletons
            found = measure_heads(
                truth.of_frames(tracked.frame_index),
                tracked_heads(tracked),
                tracked.person_ids,
                tracked.timestamps_s,
            )
        except InputError as error:
            return PeopleOutcome(name, None, (f"{name}: {error}",))
        problems = tuple(f"{name}: {problem}" for problem in recording.problems)
        return PeopleOutcome(name, found, problems)


def tracked_heads(skeletons: SkeletonSequence) -> NDArray[np.float64]:
    """[F, S, 3] metres, NaN in slots without anybody."""
    return skeletons.joints_camera[:, :, skeletons.joint_names.index(HEAD_NAME)]


@dataclass(frozen=True, slots=True)
class PeopleCount:
    """What is counted of some recordings; NaN where there was nothing to count.

    Attributes:
        recordings: how many.
        due: person-frames that had to be found.
        recall: share of them that were.
        false_per_1000: tracks that match nobody, in 1000 frames.
        swaps, fragments: times that somebody went on under the id of another, or a fresh one.
        wait_median_s, wait_95_s: from when half of a person is to be seen until found; infinite
            where that many never were.
    """

    recordings: int
    due: int
    recall: float
    false_per_1000: float
    swaps: int
    fragments: int
    wait_median_s: float
    wait_95_s: float


def count_found(found: Sequence[PeopleFound]) -> PeopleCount:
    """Of some recordings together."""
    people = [person for each in found for person in each.people]
    waits_s = [person.wait_s for person in people if person.wait_s is not None]
    median_s, late_s = (
        np.quantile(waits_s, (0.5, 0.95), method="inverted_cdf") if waits_s else (float("nan"),) * 2
    )
    return PeopleCount(
        recordings=len(found),
        due=due_of(people),
        recall=recall_of(people),
        false_per_1000=share(1000.0 * sum(e.false for e in found), sum(e.frames for e in found)),
        swaps=sum(person.swaps for person in people),
        fragments=sum(person.fragments for person in people),
        wait_median_s=float(median_s),
        wait_95_s=float(late_s),
    )


def count_by_kind(outcomes: Sequence[PeopleOutcome]) -> dict[str, PeopleCount]:
    """Of the recordings whose names are alike before the first underscore, and of all."""
    by_kind: dict[str, list[PeopleFound]] = {}
    for outcome in outcomes:
        if outcome.found is not None:
            by_kind.setdefault(outcome.name.partition("_")[0], []).append(outcome.found)
    everything = [found for kind in by_kind.values() for found in kind]
    counts = {kind: count_found(found) for kind, found in sorted(by_kind.items())}
    return counts | {ALL_KINDS: count_found(everything)}


def count_each(outcomes: Sequence[PeopleOutcome]) -> dict[str, PeopleCount]:
    """Of each recording, the one with the lowest recall first."""
    counts = {o.name: count_found([o.found]) for o in outcomes if o.found is not None}
    return dict(sorted(counts.items(), key=lambda item: item[1].recall))


def found_people_table(title: str, counts: dict[str, PeopleCount]) -> Table:
    """A row for each name."""
    table = empty_table(title, "recordings")
    for column in (
        *("", "person-\nframes", "recall", "false in\n1000", "swaps", "frag-\nments"),
        *("found after\nmedian, s", "\n95 %, s"),
    ):
        table.add_column(column, justify="right")
    for name, count in counts.items():
        table.add_row(
            name,
            str(count.recordings),
            str(count.due),
            percent(count.recall),
            number(count.false_per_1000),
            str(count.swaps),
            str(count.fragments),
            number(count.wait_median_s, digits=2),
            number(count.wait_95_s, digits=2),
            style="bold" if name == ALL_KINDS else None,
        )
    return table
