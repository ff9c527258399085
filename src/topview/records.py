"""The records that pass between the rooms of topview: cameras, frames, people, recordings.

All arrays are validated on construction and made read-only, so that a record can be handed
around freely. The camera frame is x right, y down, z forward; units are metres, radians, seconds.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from enum import IntEnum
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

MAX_FOCAL_LENGTH_PX = 20_000.0
MAX_IMAGE_SIDE_PX = 16_384


class InputError(ValueError):
    """Something a user gave cannot be used; the message is one line: what, value, what is right.

    The command line prints the message and exits with status 2.
    """


def read_only(array: NDArray[Any]) -> NDArray[Any]:
    """The array itself, made read-only."""
    array.setflags(write=False)
    return array


@dataclass(frozen=True, slots=True)
class Camera:
    """Pinhole intrinsics in pixels: pixel centres at integers, image already undistorted.

    Raises:
        InputError: a value is not finite, not positive where it must be, or absurd.
    """

    fx: float
    fy: float
    cx: float
    cy: float
    width: int
    height: int

    def __post_init__(self) -> None:
        for name in ("width", "height"):
            side = getattr(self, name)
            if not 1 <= side <= MAX_IMAGE_SIDE_PX:
                raise InputError(
                    f"camera {name} is {side}; it must be 1 to {MAX_IMAGE_SIDE_PX} pixels"
                )
        for name in ("fx", "fy"):
            focal = getattr(self, name)
            if not 0.0 < focal <= MAX_FOCAL_LENGTH_PX:
                raise InputError(
                    f"camera {name} is {focal}; "
                    f"it must be a focal length above 0, up to {MAX_FOCAL_LENGTH_PX:g} pixels"
                )
        for name, side in (("cx", self.width), ("cy", self.height)):
            centre = getattr(self, name)
            if not -side <= centre <= 2 * side:
                raise InputError(
                    f"camera {name} is {centre}; it must be a principal point near the image, "
                    f"0 to {side - 1} pixels"
                )


@dataclass(frozen=True, slots=True, eq=False)
class Frame:
    """One registered depth (and colour) image.

    Attributes:
        index: number of the frame in its recording.
        timestamp_s: seconds since the recording's start.
        depth_m: [H, W] float32 metres along the optical axis, 0 where there is no reading.
        camera: intrinsics of both images.
        color: [H, W, 3] uint8 RGB registered to the depth image, or None.
    """

    index: int
    timestamp_s: float
    depth_m: NDArray[np.float32]
    camera: Camera
    color: NDArray[np.uint8] | None = None

    def __post_init__(self) -> None:
        shape = (self.camera.height, self.camera.width)
        if self.depth_m.shape != shape or self.depth_m.dtype != np.float32:
            raise InputError(
                f"frame {self.index}: depth is {self.depth_m.dtype} {self.depth_m.shape}; "
                f"it must be float32 {shape}, as the camera says"
            )
        if self.color is not None and (
            self.color.shape != (*shape, 3) or self.color.dtype != np.uint8
        ):
            raise InputError(
                f"frame {self.index}: colour is {self.color.dtype} {self.color.shape}; "
                f"it must be uint8 {(*shape, 3)}, registered to the depth image"
            )
        read_only(self.depth_m)
        if self.color is not None:
            read_only(self.color)


class JointState(IntEnum):
    """Why a joint is, or is not, seen. The names, in this order, are the `joint_state_names`."""

    ABSENT = 0
    VISIBLE = 1
    SELF_OCCLUDED = 2
    OCCLUDED_BY_PERSON = 3
    OCCLUDED_BY_OBJECT = 4
    OUT_OF_VIEW = 5


JOINT_STATE_NAMES: tuple[str, ...] = tuple(state.name.lower() for state in JointState)


@dataclass(frozen=True, slots=True, eq=False)
class Person:
    """One person in one frame: J joints and P body parts, ordered as in `topview.body`.

    Attributes:
        id: identity that lasts while the person is in view, counted from 1.
        height_m: stature.
        joints_camera: [J, 3] metres.
        joint_state: [J] uint8, a `JointState` each.
        joint_confidence: [J] float32 in 0..1.
        Ts_camera_part: [P, 4, 4] part poses; a part's frame has its origin at the joint nearer the
            head (the head's own at the crown), +y along its axis to the far end, +x to the
            person's right and +z to the front, when standing with the arms down.
    """

    id: int
    height_m: float
    joints_camera: NDArray[np.float64]
    joint_state: NDArray[np.uint8]
    joint_confidence: NDArray[np.float32]
    Ts_camera_part: NDArray[np.float64]

    def __post_init__(self) -> None:
        for array in (
            self.joints_camera,
            self.joint_state,
            self.joint_confidence,
            self.Ts_camera_part,
        ):
            read_only(array)


@dataclass(frozen=True, slots=True, eq=False)
class SkeletonSequence:
    """People over time: F frames, P people, J joints, B body parts; what `skeletons.npz` holds.

    Attributes:
        frame_index: [F] int64.
        timestamps_s: [F] float64.
        person_ids: [P] int64.
        joint_names: J names.
        joints_camera: [F, P, J, 3] float64 metres, NaN where absent.
        joint_state: [F, P, J] uint8, an index into `JOINT_STATE_NAMES`.
        joint_confidence: [F, P, J] float32 in 0..1, 0 where absent.
        part_names: B names.
        Ts_camera_part: [F, P, B, 4, 4] float64, NaN where absent.
        heights_m: [P] float64.
        settings: what made it (method, settings, seed), plain JSON types.
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
    heights_m: NDArray[np.float64]
    settings: dict[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        F, P = len(self.frame_index), len(self.person_ids)
        J, B = len(self.joint_names), len(self.part_names)
        expected = {
            "timestamps_s": (F,),
            "joints_camera": (F, P, J, 3),
            "joint_state": (F, P, J),
            "joint_confidence": (F, P, J),
            "Ts_camera_part": (F, P, B, 4, 4),
            "heights_m": (P,),
        }
        for name, shape in expected.items():
            array = getattr(self, name)
            if array.shape != shape:
                raise InputError(f"{name} has shape {array.shape}; it must be {shape}")
            read_only(array)

    @property
    def present(self) -> NDArray[np.bool_]:
        """[F, P] True where a person is given at all."""
        return np.asarray(np.isfinite(self.joints_camera).all(-1).any(-1))

    @classmethod
    def from_people(
        cls,
        frames: Sequence[tuple[int, float, Sequence[Person]]],
        joint_names: tuple[str, ...],
        part_names: tuple[str, ...],
        settings: dict[str, Any] | None = None,
    ) -> SkeletonSequence:
        """Stack tracked frames, each (frame index, timestamp in s, its people)."""
        ids = sorted({person.id for _, _, people in frames for person in people})
        column = {person_id: p for p, person_id in enumerate(ids)}
        F, P, J, B = len(frames), len(ids), len(joint_names), len(part_names)
        joints = np.full((F, P, J, 3), np.nan)
        states = np.zeros((F, P, J), np.uint8)
        confidence = np.zeros((F, P, J), np.float32)
        poses = np.full((F, P, B, 4, 4), np.nan)
        heights = np.zeros(P)
        for f, (_, _, people) in enumerate(frames):
            for person in people:
                p = column[person.id]
                joints[f, p] = person.joints_camera
                states[f, p] = person.joint_state
                confidence[f, p] = person.joint_confidence
                poses[f, p] = person.Ts_camera_part
                heights[p] = person.height_m
        return cls(
            frame_index=np.array([index for index, _, _ in frames], np.int64),
            timestamps_s=np.array([time_s for _, time_s, _ in frames], np.float64),
            person_ids=np.array(ids, np.int64),
            joint_names=joint_names,
            joints_camera=joints,
            joint_state=states,
            joint_confidence=confidence,
            part_names=part_names,
            Ts_camera_part=poses,
            heights_m=heights,
            settings=settings or {},
        )


@runtime_checkable
class Recording(Protocol):
    """A depth recording: iterate to get its frames in order; may be iterated again.

    Frames that cannot be read are left out of the iteration and named in `problems`, one clear
    line each (file, value, what would be right), so that one bad file loses nothing else.
    """

    name: str
    camera: Camera
    problems: list[str]

    def __len__(self) -> int:
        """How many frames the recording should have, the unreadable ones included."""
        ...

    def __iter__(self) -> Iterator[Frame]: ...
