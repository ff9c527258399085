"""The interface that every data set yields."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Protocol, TypeVar, runtime_checkable

from topview.records import InputError, Recording
from topview_lab.metrics import ReferenceSequence
from topview_lab.sim import Scene


class EvaluatedRecording(Protocol):
    """A recording with a reference; small and picklable, nothing is read before it is opened."""

    @property
    def name(self) -> str:
        """What the tables call it."""
        ...

    def open(self) -> Recording:
        """The frames. Raises InputError where they cannot be read."""
        ...

    def reference(self) -> ReferenceSequence:
        """The reference skeletons. Raises InputError where they cannot be read."""
        ...


@runtime_checkable
class KnowsReference(Protocol):
    """A recording that computes the reference of its frames while they are read."""

    def reference(self) -> ReferenceSequence: ...


class Named(Protocol):
    """What has a name to be chosen by."""

    @property
    def name(self) -> str: ...


AnyNamed = TypeVar("AnyNamed", bound=Named)


class Simulated(Named, Protocol):
    """A scene of the simulator; small, nothing is made before it is needed."""

    def make(self) -> Scene:
        """Raises InputError where a name or a number is wrong."""
        ...


AnySimulated = TypeVar("AnySimulated", bound=Simulated)


def lacking(root: Path, kinds: Mapping[str, str]) -> list[str]:
    """The kinds of file, each with a glob, that a data set's folder lacks."""
    return [kind for kind, glob in kinds.items() if next(root.glob(glob), None) is None]


def select_by_name(recordings: Sequence[AnyNamed], pattern: str, source: str) -> list[AnyNamed]:
    """Those whose name matches one of the comma-separated globs (`a1_s*_t1,a2_*`), in order.

    Raises:
        InputError: none does.
    """
    globs = [glob.strip() for glob in pattern.split(",")]
    chosen = [r for r in recordings if any(fnmatchcase(r.name, glob) for glob in globs)]
    if not chosen:
        raise InputError(
            f"{source}: no sequence matches {pattern!r}; there are {len(recordings)}, "
            f"{recordings[0].name} to {recordings[-1].name}"
        )
    return chosen


def select_simulated(
    made: Sequence[AnySimulated], seeds: Sequence[int], pattern: str, source: str
) -> list[AnySimulated]:
    """As `select_by_name`; the seeds are the innermost of what they were made of.

    Raises:
        InputError: there is no seed, a name or a number is wrong, or no name matches.
    """
    if not seeds:
        raise InputError("no seed given; give at least one, such as 1,2,3")
    for simulated in (*made[:: len(seeds)], *made[: len(seeds)]):
        simulated.make()  # not to find out after the first were tracked
    return select_by_name(made, pattern, source)


def check_same_frames(recording: Recording, reference: ReferenceSequence) -> None:
    """Raises InputError if the two differ in length and the recording does not say why."""
    expected = int(reference.frame_index.max(initial=-1)) + 1
    frames_missing = bool(recording.problems)
    frame_count = recording.frame_count or 0
    if frame_count > expected or (frame_count < expected and not frames_missing):
        raise InputError(
            f"the recording has {frame_count} frames, its reference {expected}; "
            "they must be the same frames"
        )
