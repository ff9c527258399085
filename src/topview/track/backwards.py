"""A recording tracked from its end to its start, and who of it is whom (ours).

Whoever comes out from behind somebody is known before, where time runs backwards. So what was
tracked that way tells of hidden joints what comes later, as tracking forward tells what was before.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.records import Frame
from topview.skeletons import About, TrackedFrame
from topview.track.settings import TrackerSettings
from topview.track.tracker import Tracker

# All ours.
TOLD_S: Final = 8.0  # what is told at a time; so many images are held, and those of the lead
LEAD_S: Final = 3.0  # of what comes after it, tracked before
ALIKE_M: Final = 0.15  # half of the joints of one person, tracked both ways, are at most so far off
ALIKE_SHARE: Final = 0.5  # of the frames that tell of both; whoever is alike in more is the same


def tracked_backwards(
    frames: Iterable[Frame], settings: TrackerSettings, about: About
) -> Iterator[TrackedFrame]:
    """Frames in their order, each as it is where time runs from the last to the first; undistorted.

    Some `TOLD_S` and `LEAD_S` of frames are held at a time, and each time people get new numbers.
    """
    held: list[Frame] = []
    used = 0  # numbers of people
    for frame in frames:
        held.append(frame)
        start_s = held[0].timestamp_s
        if frame.timestamp_s - start_s < TOLD_S + LEAD_S:
            continue
        told = _from_the_last(held, settings, about, used)
        end = next(k for k, own in enumerate(held) if own.timestamp_s >= start_s + TOLD_S)
        used = max([used, *(int(own) for frame in told for own in frame.people["id"])])
        yield from told[:end]
        held = held[end:]
    yield from _from_the_last(held, settings, about, used)


def _from_the_last(
    frames: Sequence[Frame], settings: TrackerSettings, about: About, used: int
) -> list[TrackedFrame]:
    """In their order, of a tracker that knows none of what was before the first."""
    tracker = Tracker(settings)
    told = []
    for frame in reversed(frames):
        turned = replace(frame, timestamp_s=frames[-1].timestamp_s - frame.timestamp_s)
        people = about.packed(tracker.update(turned))
        people["id"] += used
        told.append(TrackedFrame(frame.index, frame.timestamp_s, frame.name, people))
    return told[::-1]


Partners = dict[int, np.void]
"""People of a frame as they were tracked backwards, by their numbers forward."""


def partners(
    forward: Sequence[TrackedFrame], backward: Sequence[NDArray[np.void]]
) -> list[Partners]:
    """Of each frame, of the people who were tracked either way. Who is alike in a frame is the same
    there; else who is alike in most frames. Whoever is told of backwards alone has the number of
    who it is in the frame that is nearest in time."""
    alike = [_alike(own.people, others) for own, others in zip(forward, backward, strict=True)]
    same = _same_people(forward, backward, alike)
    places = _frames_of(forward)
    found: list[Partners] = []
    for f, (frame, people) in enumerate(zip(forward, backward, strict=True)):
        own: Partners = {}
        others: list[np.void] = []
        for person, is_alike in zip(people, alike[f].T, strict=True):
            if is_alike.any():
                own.setdefault(int(frame.people["id"][is_alike.argmax()]), person)
            else:
                others.append(person)
        for person in others:
            ids = same.get(int(person["id"]), [])
            if ids:
                own.setdefault(min(ids, key=lambda i: int(np.abs(places[i] - f).min())), person)
        found.append(own)
    return found


def _same_people(
    forward: Sequence[TrackedFrame],
    backward: Sequence[NDArray[np.void]],
    alike: Sequence[NDArray[np.bool_]],
) -> dict[int, list[int]]:
    """Numbers backward: those forward of who it is, most frames first; `alike` as of `_alike`."""
    of_pairs: dict[tuple[int, int], list[bool]] = defaultdict(list)
    for frame, people, is_alike in zip(forward, backward, alike, strict=True):
        for (one, other), own in np.ndenumerate(is_alike):
            of_pairs[int(people["id"][other]), int(frame.people["id"][one])].append(bool(own))
    same: dict[int, list[int]] = defaultdict(list)
    for (other, one), each in sorted(of_pairs.items(), key=lambda own: -sum(own[1])):
        if np.mean(each) > ALIKE_SHARE:
            same[other].append(one)
    return same


def _alike(people: NDArray[np.void], others: NDArray[np.void]) -> NDArray[np.bool_]:
    """[N, M] whether each of N people is where each of M others is."""
    ways = people["joints_camera"][:, None] - others["joints_camera"]
    return np.nanmedian(np.linalg.norm(ways, axis=-1), axis=-1) <= ALIKE_M


def _frames_of(frames: Sequence[TrackedFrame]) -> dict[int, NDArray[np.int64]]:
    """In which frames each number is told of."""
    where: dict[int, list[int]] = defaultdict(list)
    for f, frame in enumerate(frames):
        for person_id in frame.people["id"].tolist():
            where[person_id].append(f)
    return {person_id: np.array(own) for person_id, own in where.items()}
