"""The project file: the user's choices and edits, saved as a whole after every step."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Final, Literal

import msgspec

from topview.files import naming
from topview.io import write_atomically
from topview.records import InputError
from topview_lab.annotate.blobs import GREATEST_RADIUS_M, LEAST_RADIUS_M
from topview_lab.annotate.landmarks import INDEX, NAMES, SIDE_NAMES

FORMAT: Final = "topview annotation 1"
PROJECT_FILE: Final = "annotation.json"

ViewName = Literal["front", "rear"]
VIEW_NAMES: Final[tuple[ViewName, ViewName]] = ("front", "rear")


Level = Annotated[int, msgspec.Meta(ge=0, le=255)]


class Look(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A colour that was picked."""

    red: Level
    green: Level
    blue: Level
    radius_m: Annotated[float, msgspec.Meta(ge=LEAST_RADIUS_M, le=GREATEST_RADIUS_M)]


class Change(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """One edit by the user.

    Attributes:
        kind: place a marker at a pixel, delete it from a view's frame, or interpolate a joint.
        person: counted from 0.
        joint: its name.
        frame: of the front recording; of an interpolation, the first.
        last: of an interpolation, the last frame.
        view, side: of a placed or deleted marker.
        pixel: where it was placed, or where the deleted spot was.
    """

    kind: Literal["place", "delete", "interpolate"]
    person: int
    joint: str
    frame: int
    last: int = -1
    view: ViewName = "front"
    side: Literal["front", "back"] = "front"
    pixel: tuple[float, float] | None = None

    @property
    def marker(self) -> tuple[int, int, int]:
        """Person, joint and side as numbers."""
        return self.person, INDEX[self.joint], SIDE_NAMES.index(self.side)


class Project(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Everything that cannot be recomputed.

    Attributes:
        front, rear: the recordings.
        people: number of people who wear markers.
        looks: the picked colours of the markers.
        changes: the user's edits, in order.
        accepted: True if `groundtruth.npz` is up to date with this file.
    """

    front: str
    rear: str
    people: int = 1
    looks: tuple[Look, ...] = ()
    changes: tuple[Change, ...] = ()
    accepted: bool = False
    format: str = FORMAT


def load_project(path: Path) -> Project:
    """Read and check a project file.

    Raises:
        InputError: not readable, not a project file, or of another version.
    """
    with naming(path, right="it must be an annotation project"):
        data = path.read_bytes()
        try:
            project = msgspec.json.decode(data, type=Project)
        except (msgspec.MsgspecError, UnicodeDecodeError, RecursionError) as error:
            raise InputError(f"is not an annotation project ({error})") from None
        if project.format != FORMAT:
            raise InputError(f"has the format {project.format!r}; it must be {FORMAT!r}")
        return project


def save_project(project: Project, path: Path) -> None:
    write_atomically(path, msgspec.json.format(msgspec.json.encode(project), indent=1) + b"\n")


def change_of(value: Any, people: int, frames: int) -> Change:
    """A change from plain JSON types.

    Raises:
        InputError: a wrong kind, joint, person or frame.
    """
    try:
        change = msgspec.convert(value, Change)
    except msgspec.ValidationError as error:
        raise InputError(f"the change cannot be used: {error}") from None
    check_change(change, people, frames)
    return change


def check_change(change: Change, people: int, frames: int) -> None:
    """Raises InputError for a joint, person or frame that is not there."""
    if change.joint not in INDEX:
        raise InputError(f"joint is {change.joint!r}; it must be one of {', '.join(NAMES)}")
    if not 0 <= change.person < people:
        raise InputError(f"person is {change.person}; it must be 0 to {people - 1}")
    for frame in (change.frame, change.last if change.kind == "interpolate" else change.frame):
        if not 0 <= frame < frames:
            raise InputError(f"frame is {frame}; it must be 0 to {frames - 1}")
    if change.kind == "place" and change.pixel is None:
        raise InputError("a placed marker has no pixel; it must have [u, v]")
