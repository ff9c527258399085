"""Skeletons of several people over time: frames as they are tracked, and what they become.

Frames come one after the other, each with whoever is there. Their arrays have *slots*, as many as
people were ever there at once, so that a day of passers-by takes little more than those who passed.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Any, Final, Protocol

import numpy as np
from numpy.typing import NDArray

from topview.records import Camera, InputError, Person, read_only

NOBODY_ID: Final = 0


@dataclass(frozen=True, slots=True)
class About:
    """What belongs to no frame of some skeletons; attributes as of `SkeletonSequence`."""

    joint_names: tuple[str, ...]
    part_names: tuple[str, ...]
    settings: dict[str, Any] = field(default_factory=dict)
    camera: Camera | None = None
    topview_version: str = ""

    @property
    def person_type(self) -> np.dtype[np.void]:
        """How people of a frame are packed."""
        return _person_type(len(self.joint_names), len(self.part_names))

    def packed(self, people: Sequence[Person]) -> NDArray[np.void]:
        """[N] of `person_type`: people of one frame as one array."""
        packed = np.zeros(len(people), self.person_type)
        for row, person in zip(packed, people, strict=True):
            for name in self.person_type.names or ():
                row[name] = getattr(person, name)
        return packed


@cache
def _person_type(joints: int, parts: int) -> np.dtype[np.void]:
    """A `Person` as one record; little-endian, as it is stored."""
    return np.dtype(
        [
            ("id", "<i8"),
            ("height_m", "<f8"),
            ("joints_camera", "<f8", (joints, 3)),
            ("joint_state", "u1", (joints,)),
            ("joint_confidence", "<f4", (joints,)),
            ("Ts_camera_part", "<f8", (parts, 4, 4)),
            ("joint_covariance_m2", "<f4", (joints, 3, 3)),
        ]
    )


@dataclass(frozen=True, slots=True, eq=False)
class TrackedFrame:
    """What a tracker made of one frame.

    Attributes:
        index: its number in the recording.
        timestamp_s: since the recording's start.
        name: what the source calls it.
        people: who is there, as `About.packed`.
        floor_camera: [4] the floor as it was seen last, as in `SkeletonSequence`; None before.
    """

    index: int
    timestamp_s: float
    name: str
    people: NDArray[np.void]
    floor_camera: tuple[float, ...] | None = None


class Skeletons(Protocol):
    """Skeletons of any length, which need not all be in memory."""

    def blocks(self) -> Iterator[SkeletonSequence]:
        """All frames, some at a time, as often as asked for; at least one block. Each tells of all
        people of the whole, and all that belongs to no frame."""
        ...


@dataclass(frozen=True, slots=True, eq=False)
class SkeletonSequence:
    """People over time: F frames, S slots, P people, J joints, B body parts; what `skeletons.npz`
    holds.

    There are as many slots as people were ever there at once. Somebody keeps a slot while there,
    and gets it back after an absence if nobody else has taken it.

    Attributes:
        frame_index: [F] int64.
        timestamps_s: [F] float64.
        person_ids: [F, S] int64, who is in each slot; 0 is nobody.
        joint_names: J names.
        joints_camera: [F, S, J, 3] float64 metres, NaN where absent.
        joint_state: [F, S, J] uint8, an index into `JOINT_STATE_NAMES`.
        joint_confidence: [F, S, J] float32 in 0..1, 0 where absent.
        part_names: B names.
        Ts_camera_part: [F, S, B, 4, 4] float64, NaN where absent.
        people_ids: [P] int64, everybody, in order.
        heights_m: [P] float64 statures.
        first_frame: [P] int64, the `frame_index` in which each came.
        last_frame: [P] int64, and was last there.
        settings: what made it (method, settings, seed), plain JSON types.
        frame_names: F names, as the source calls its frames; their numbers if it does not.
        camera: what took the frames, with its lens; None if not known.
        floor_camera: [4] upward unit normal n and height h of the camera over the floor, whose
            points p have n @ p + h = 0; NaN if no floor was seen.
        gravity_camera: [3] unit vector that points down: the camera's, if it was given one, else
            by the floor; NaN if not known.
        topview_version: what wrote it; empty if nothing told.
        joint_covariance_m2: [F, S, J, 3, 3] float32 of each joint's error, camera frame, square
            metres; NaN where absent or not known.
    """

    frame_index: NDArray[np.int64]
    timestamps_s: NDArray[np.float64]
    person_ids: NDArray[np.int64]
    joint_names: tuple[str, ...]
    joints_camera: NDArray[np.float64]
    joint_state: NDArray[np.uint8]
    joint_confidence: NDArray[np.float32]
    part_names: tuple[str, ...]
    Ts_camera_part: NDArray[np.float64]
    people_ids: NDArray[np.int64]
    heights_m: NDArray[np.float64]
    first_frame: NDArray[np.int64]
    last_frame: NDArray[np.int64]
    settings: dict[str, Any] = field(default_factory=dict)
    frame_names: tuple[str, ...] = ()
    camera: Camera | None = None
    floor_camera: NDArray[np.float64] = field(default_factory=lambda: np.full(4, np.nan))
    gravity_camera: NDArray[np.float64] = field(default_factory=lambda: np.full(3, np.nan))
    topview_version: str = ""
    joint_covariance_m2: NDArray[np.float32] = field(
        default_factory=lambda: np.empty(0, np.float32)
    )

    def __post_init__(self) -> None:
        F, P = len(self.frame_index), len(self.people_ids)
        S = self.person_ids.shape[-1] if self.person_ids.ndim == 2 else 0
        if not self.frame_names:
            object.__setattr__(self, "frame_names", tuple(map(str, self.frame_index.tolist())))
        if len(self.frame_names) != F:
            raise InputError(f"has {len(self.frame_names)} frame_names; it must have {F}")
        J, B = len(self.joint_names), len(self.part_names)
        if not self.joint_covariance_m2.size:
            unknown = np.full((F, S, J, 3, 3), np.nan, np.float32)
            object.__setattr__(self, "joint_covariance_m2", unknown)
        expected = {
            "timestamps_s": (F,),
            "person_ids": (F, S),
            "joints_camera": (F, S, J, 3),
            "joint_state": (F, S, J),
            "joint_confidence": (F, S, J),
            "Ts_camera_part": (F, S, B, 4, 4),
            "joint_covariance_m2": (F, S, J, 3, 3),
            "heights_m": (P,),
            "first_frame": (P,),
            "last_frame": (P,),
            "floor_camera": (4,),
            "gravity_camera": (3,),
        }
        for name, shape in expected.items():
            array = getattr(self, name)
            if array.shape != shape:
                raise InputError(f"{name} has shape {array.shape}; it must be {shape}")
            read_only(array)

    @property
    def present(self) -> NDArray[np.bool_]:
        """[F, S] True where somebody is."""
        return np.asarray(self.person_ids != NOBODY_ID)

    def slots_of(self, person_id: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """The frames (rows of the arrays) in which somebody is, and the slot in each; so
        `joints_camera[sequence.slots_of(3)]` is [N, J, 3] of person 3."""
        rows, slots = np.nonzero(self.person_ids == person_id)
        return rows, slots

    def people_in(self, row: int) -> list[Person]:
        """Whoever is there in a frame, as the tracker told them; statures as told last."""
        statures_m = dict(zip(self.people_ids.tolist(), self.heights_m.tolist(), strict=True))
        return [
            Person(
                person_id,
                statures_m[person_id],
                self.joints_camera[row, slot],
                self.joint_state[row, slot],
                self.joint_confidence[row, slot],
                self.Ts_camera_part[row, slot],
                self.joint_covariance_m2[row, slot],
            )
            for slot, person_id in enumerate(self.person_ids[row].tolist())
            if person_id != NOBODY_ID
        ]

    def of_person(self, person_id: int) -> SkeletonSequence:
        """One person alone, in one slot; all frames stay.

        Raises:
            InputError: nobody has this id.
        """
        people = self.people_ids == person_id
        if not people.any():
            known = ", ".join(map(str, self.people_ids.tolist())) or "none"
            raise InputError(f"has no person {person_id}; its people are {known}")
        slots = np.argmax(self.person_ids == person_id, axis=1)
        is_here = np.any(self.person_ids == person_id, axis=1)
        rows = np.arange(len(slots))

        def alone(array: NDArray[Any], empty: float) -> NDArray[Any]:
            here = is_here.reshape(-1, *[1] * (array.ndim - 2))
            return np.where(here, array[rows, slots], np.array(empty, array.dtype))[:, None]

        return replace(
            self,
            person_ids=alone(self.person_ids, NOBODY_ID),
            joints_camera=alone(self.joints_camera, np.nan),
            joint_state=alone(self.joint_state, 0),
            joint_confidence=alone(self.joint_confidence, 0.0),
            Ts_camera_part=alone(self.Ts_camera_part, np.nan),
            joint_covariance_m2=alone(self.joint_covariance_m2, np.nan),
            people_ids=self.people_ids[people],
            heights_m=self.heights_m[people],
            first_frame=self.first_frame[people],
            last_frame=self.last_frame[people],
        )

    def blocks(self) -> Iterator[SkeletonSequence]:
        """Itself: it is in memory already."""
        yield self

    @classmethod
    def from_frames(cls, frames: Sequence[TrackedFrame], about: About) -> SkeletonSequence:
        """Stack tracked frames."""
        return stacked(frames, about, Totals.of(frames), Slots())


def in_memory(skeletons: Skeletons) -> SkeletonSequence:
    """All frames at once."""
    blocks = list(skeletons.blocks())
    if len(blocks) == 1:
        return blocks[0]
    of_frames = ("frame_index", "timestamps_s", "person_ids", "joints_camera", "joint_state")
    arrays = {
        name: np.concatenate([getattr(block, name) for block in blocks])
        for name in (*of_frames, "joint_confidence", "Ts_camera_part", "joint_covariance_m2")
    }
    names = tuple(name for block in blocks for name in block.frame_names)
    return replace(blocks[0], frame_names=names, **arrays)


@dataclass(slots=True)
class Presence:
    """Somebody, over all frames so far.

    Attributes:
        height_m: stature, as it was told last.
        first_frame: the number of the first frame with them.
        last_frame: of the last one.
        frames: how many they are in.
        confidence: sum over these of their joints' mean confidence.
    """

    height_m: float
    first_frame: int
    last_frame: int
    frames: int = 0
    confidence: float = 0.0


@dataclass(slots=True)
class Totals:
    """What only all frames together tell.

    Attributes:
        frames: how many there are.
        slots: the most people at once.
        people: by id.
        floor_camera: as it was seen last.
    """

    frames: int = 0
    slots: int = 0
    people: dict[int, Presence] = field(default_factory=dict)
    floor_camera: tuple[float, ...] | None = None

    @classmethod
    def of(cls, frames: Iterable[TrackedFrame]) -> Totals:
        """Go through frames once. Raises InputError for one with somebody twice, or with id 0."""
        totals = cls()
        for frame in frames:
            totals._add(frame)
        return totals

    def _add(self, frame: TrackedFrame) -> None:
        self.frames += 1
        self.slots = max(self.slots, len(frame.people))
        self.floor_camera = frame.floor_camera or self.floor_camera
        ids = frame.people["id"].tolist()
        if len(set(ids)) < len(ids) or NOBODY_ID in ids:
            raise InputError(
                f"frame {frame.index} has people {', '.join(map(str, ids))}; "
                f"each must be there once, and {NOBODY_ID} is nobody"
            )
        for person_id, person in zip(ids, frame.people, strict=True):
            presence = self.people.setdefault(person_id, Presence(0.0, frame.index, frame.index))
            presence.height_m = float(person["height_m"])
            presence.last_frame = frame.index
            presence.frames += 1
            presence.confidence += float(person["joint_confidence"].mean())

    def arrays(self) -> dict[str, NDArray[Any]]:
        """Of `SkeletonSequence`, those that belong to no frame."""
        ids = sorted(self.people)
        people = [self.people[person_id] for person_id in ids]
        floor = None if self.floor_camera is None else np.array(self.floor_camera)
        return {
            "people_ids": np.array(ids, np.int64),
            "heights_m": np.array([person.height_m for person in people], np.float64),
            "first_frame": np.array([person.first_frame for person in people], np.int64),
            "last_frame": np.array([person.last_frame for person in people], np.int64),
            "floor_camera": np.full(4, np.nan) if floor is None else floor,
            "gravity_camera": np.full(3, np.nan) if floor is None else -floor[:3],
        }


def columns_as_slots(
    column_ids: NDArray[np.int64],
    present: NDArray[np.bool_],
    frame_index: NDArray[np.int64],
    heights_m: NDArray[np.float64],
) -> dict[str, NDArray[Any]]:
    """Where everybody has a column of their own: `person_ids` and the arrays by person of a
    `SkeletonSequence` whose slots are the columns.

    Args:
        column_ids: [P] who each column is.
        present: [F, P].
        frame_index: [F].
        heights_m: [P].

    Raises:
        InputError: two columns are the same person.
    """
    ids = column_ids.tolist()
    twice = sorted({i for i in ids if ids.count(i) > 1})
    if twice:
        raise InputError(f"person_ids has {twice[0]} twice; each person must be told once")
    if NOBODY_ID in ids:
        raise InputError(f"person_ids has {NOBODY_ID}, which is nobody; it must be other numbers")
    person_ids = np.where(present, column_ids, NOBODY_ID).astype(np.int64)
    people = people_of(person_ids, frame_index)
    order = np.argsort(column_ids)
    columns = order[np.searchsorted(column_ids[order], people["people_ids"])]
    return people | {"person_ids": person_ids, "heights_m": heights_m[columns].astype(np.float64)}


def people_of(
    person_ids: NDArray[np.int64], frame_index: NDArray[np.int64]
) -> dict[str, NDArray[np.int64]]:
    """`people_ids`, `first_frame` and `last_frame` of [F, S] slots."""
    rows, slots = np.nonzero(person_ids != NOBODY_ID)
    ids = person_ids[rows, slots]
    people, first = np.unique(ids, return_index=True)
    _, last = np.unique(ids[::-1], return_index=True)
    return {
        "people_ids": people,
        "first_frame": frame_index[rows[first]],
        "last_frame": frame_index[rows[::-1][last]],
    }


class Slots:
    """Gives a slot to everybody who is there, frame by frame."""

    def __init__(self) -> None:
        self._slot_of: dict[int, int] = {}  # of the frame before
        self._last_slot_of: dict[int, int] = {}  # of everybody, ever

    def of(self, ids: Sequence[int]) -> list[int]:
        """Of the people of the next frame: their own, if they were there before; else the one that
        they had once, if it is free; else the first that is."""
        slot_of = {i: self._slot_of[i] for i in ids if i in self._slot_of}
        for person_id in ids:
            if person_id not in slot_of:
                taken = set(slot_of.values())
                slot = self._last_slot_of.get(person_id)
                if slot is None or slot in taken:
                    slot = next(s for s in range(len(taken) + 1) if s not in taken)
                slot_of[person_id] = slot
        self._slot_of = slot_of
        self._last_slot_of |= slot_of
        return [slot_of[i] for i in ids]


def stacked(
    frames: Sequence[TrackedFrame], about: About, totals: Totals, slots: Slots
) -> SkeletonSequence:
    """The arrays of frames that come next; `slots` has given those of all frames before them."""
    crowded = [frame.people for frame in frames if len(frame.people)]
    people = np.concatenate(crowded) if crowded else about.packed([])
    rows = np.repeat(np.arange(len(frames)), [len(frame.people) for frame in frames])
    columns = [s for frame in frames for s in slots.of(frame.people["id"].tolist())]

    def in_slots(key: str, empty: float) -> NDArray[Any]:
        values = people[key]
        array = np.full((len(frames), totals.slots, *values.shape[1:]), empty, values.dtype)
        array[rows, columns] = values
        return array

    of_all = totals.arrays()
    if about.camera is not None and about.camera.gravity_camera is not None:
        of_all["gravity_camera"] = about.camera.gravity_camera
    return SkeletonSequence(
        frame_index=np.array([frame.index for frame in frames], np.int64),
        timestamps_s=np.array([frame.timestamp_s for frame in frames], np.float64),
        person_ids=in_slots("id", NOBODY_ID),
        joint_names=about.joint_names,
        joints_camera=in_slots("joints_camera", np.nan),
        joint_state=in_slots("joint_state", 0),
        joint_confidence=in_slots("joint_confidence", 0.0),
        part_names=about.part_names,
        Ts_camera_part=in_slots("Ts_camera_part", np.nan),
        joint_covariance_m2=in_slots("joint_covariance_m2", np.nan),
        settings=about.settings,
        frame_names=tuple(frame.name for frame in frames),
        camera=about.camera,
        topview_version=about.topview_version,
        **of_all,
    )
