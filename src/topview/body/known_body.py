"""What is known of somebody's body beforehand, and the file that keeps it from one recording to the
next."""

from __future__ import annotations

from collections.abc import Sequence
from math import isfinite
from os import PathLike
from pathlib import Path
from typing import Final

import msgspec

from topview.files import file_as_json, naming, read_bytes
from topview.records import InputError, shown

BODIES_VERSION: Final = 1
"""Of the file; another version has other keys."""
STATURES_M: Final = (0.5, 2.5)
"""Least and greatest of those that are taken (ours): from a child who begins to walk to the tallest
people."""
BONE_NAMES: Final = (
    "head",
    "upper_torso",
    "lower_torso",
    "upper_arm",
    "forearm",
    "upper_leg",
    "lower_leg",
    "shoulder_breadth",
    "hip_breadth",
    "shoulder_drop",
    "shoulder_front",
)
"""Left and right count together; `topview.track.bone_lengths` says what each is."""
LONGEST_BONE_M: Final = 1.0  # ours; the thighs of the tallest people have 0.65
GREATEST_SIGMA_M: Final = 1.0  # ours; what is less sure tells nothing
MOST_FILE_BYTES: Final = 2**20  # ours; a body has 1 kB
BODIES_FILE: Final = "it must be a file that `topview track --save-body` wrote"


class KnownBone(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """How long a bone is, and how sure that is.

    Attributes:
        length_m: at most 1 m; `shoulder_drop` and `shoulder_front` may be negative.
        sigma_m: standard deviation of `length_m`, above 0, at most 1 m.
    """

    length_m: float
    sigma_m: float


class KnownBody(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """One person's body.

    Attributes:
        stature_m: 0.5 to 2.5 m; None where it was never measured.
        bones: those of `BONE_NAMES`, all of them; empty where the method learnt none.
        seconds: for how long it was learnt.

    Raises:
        InputError: a value out of range, a bone too many or too few.
    """

    stature_m: float | None = None
    bones: dict[str, KnownBone] = {}
    seconds: float = 0.0

    def __post_init__(self) -> None:
        if self.stature_m is not None:
            check_stature(self.stature_m, "stature_m")
        if not (isfinite(self.seconds) and self.seconds >= 0.0):
            raise InputError(f"seconds is {shown(self.seconds)}; it must be 0 or more")
        if self.bones and set(self.bones) != set(BONE_NAMES):
            raise InputError(
                f"bones are {', '.join(self.bones)}; they must be {', '.join(BONE_NAMES)}, or none"
            )
        for name, bone in self.bones.items():
            if not is_length(name, bone.length_m):
                raise InputError(
                    f"length_m of {name} is {shown(bone.length_m)}; "
                    f"it must be above {_least_m(name):g}, at most {LONGEST_BONE_M:g}"
                )
            if not 0.0 < bone.sigma_m <= GREATEST_SIGMA_M:
                raise InputError(
                    f"sigma_m of {name} is {shown(bone.sigma_m)}; "
                    f"it must be above 0, at most {GREATEST_SIGMA_M:g}"
                )


def is_length(name: str, length_m: float) -> bool:
    """Whether a bone may be so long."""
    return _least_m(name) < length_m <= LONGEST_BONE_M


def _least_m(name: str) -> float:
    return -LONGEST_BONE_M if name in ("shoulder_drop", "shoulder_front") else 0.0


def check_stature(stature_m: float, name: str) -> None:
    """Raises InputError, which begins with the name, for a stature that nobody has."""
    least_m, greatest_m = STATURES_M
    if not least_m <= stature_m <= greatest_m:
        raise InputError(
            f"{name} is {shown(stature_m)}; it must be metres, {least_m:g} to {greatest_m:g}"
        )


class _Version(msgspec.Struct):
    version: int


class _File(msgspec.Struct, forbid_unknown_fields=True):
    version: int
    bodies: list[KnownBody]


def bodies_as_bytes(bodies: Sequence[KnownBody]) -> bytes:
    """The file's text, from which `read_bodies` makes the same bodies, bit for bit."""
    text = msgspec.json.encode(_File(BODIES_VERSION, list(bodies)))
    return msgspec.json.format(text, indent=2) + b"\n"


def read_bodies(path: str | PathLike[str]) -> tuple[KnownBody, ...]:
    """The bodies of a file, one or more.

    Raises:
        InputError: the file cannot be read, is none of these or of another version, or says what
            no body has; names it.
    """
    path = Path(path)
    with naming(path, right=BODIES_FILE):
        text = read_bytes(path, MOST_FILE_BYTES, BODIES_FILE)
        try:
            version = msgspec.json.decode(text, type=_Version).version
            if version != BODIES_VERSION:
                raise InputError(f"version is {version}; it must be {BODIES_VERSION}")
            bodies = msgspec.json.decode(text, type=_File).bodies
        except msgspec.MsgspecError as error:
            raise InputError(f"{error}; {BODIES_FILE}") from None
        if not bodies:
            raise InputError("holds no body; it must hold one or more")
    return tuple(bodies)


def bodies_as_json(path: Path) -> dict[str, str]:
    """Which bodies these are, in JSON types: the file's name and the start of its SHA-256.

    Raises:
        InputError: the file cannot be read.
    """
    with naming(path, right=BODIES_FILE):
        return file_as_json(path, read_bytes(path, MOST_FILE_BYTES, BODIES_FILE))
