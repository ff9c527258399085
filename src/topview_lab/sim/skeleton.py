"""The simulated skeleton: 19 segments with joints at anatomical centres, and its kinematics.

The segment frames share the body's axes while the person stands with hanging arms: x to the
person's left, y up, z to the front. The room frame is x to the camera's right, y away from it,
z up, with its origin on the floor below the camera.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.geometry.rotations import rotations_from_vectors
from topview.records import read_only

Limits = tuple[tuple[float, float], tuple[float, float], tuple[float, float]]
"""Least and greatest flexion, abduction and twist, in degrees."""


@dataclass(frozen=True, slots=True)
class Segment:
    """One rigid piece of the skeleton.

    Attributes:
        name: with _l or _r for the person's left or right.
        hangs_from: the segment that carries this one's origin, "" for the root.
        turns_with: the segment that this one's angles are relative to, "" for the room.
        signs: of the rotations about the segment's x (flexion), y (twist) and z (abduction).
        limits_deg: after the normal ranges of the American Academy of Orthopaedic Surgeons (1965),
            slightly widened; the foot's under the body's weight, K. Bennell et al., Australian J.
            Physiotherapy 44 (1998). The pelvis turns about the hips as far as they let it.
    """

    name: str
    hangs_from: str
    turns_with: str
    signs: tuple[int, int, int]
    limits_deg: Limits


def _upright(name: str, parent: str, limits: Limits) -> Segment:
    """Trunk and head: flexion bends forward, abduction and twist go to the person's left."""
    return Segment(name, parent, parent, (1, 1, -1), limits)


def _hanging(
    name: str, parent: str, limits: Limits, *, bends_back: bool = False, turns_with: str = ""
) -> list[Segment]:
    """A limb on both sides: flexion swings it forward (knees: back), abduction outwards, and
    twist turns its front inwards."""
    bend = 1 if bends_back else -1
    middle = {"chest", "pelvis"}
    return [
        Segment(
            name=f"{name}_{side}",
            hangs_from=parent if parent in middle else f"{parent}_{side}",
            turns_with=turns_with or (parent if parent in middle else f"{parent}_{side}"),
            signs=(bend, -outwards, outwards),
            limits_deg=limits,
        )
        for side, outwards in (("l", 1), ("r", -1))
    ]


SEGMENTS: Final[tuple[Segment, ...]] = (
    _upright("pelvis", "", ((-30, 100), (-30, 30), (-35, 35))),
    _upright("abdomen", "pelvis", ((-20, 50), (-25, 25), (-25, 25))),
    _upright("chest", "abdomen", ((-20, 40), (-25, 25), (-35, 35))),
    _upright("neck", "chest", ((-30, 35), (-25, 25), (-40, 40))),
    _upright("head", "neck", ((-30, 30), (-25, 25), (-45, 45))),
    *_hanging("clavicle", "chest", ((-15, 15), (-5, 35), (-15, 15))),
    *_hanging("upper_arm", "clavicle", ((-60, 180), (-60, 180), (-100, 90)), turns_with="chest"),
    *_hanging("forearm", "upper_arm", ((-5, 155), (0, 0), (-90, 90))),
    *_hanging("hand", "forearm", ((-35, 30), (-70, 70), (0, 0))),
    *_hanging("thigh", "pelvis", ((-30, 125), (-30, 50), (-45, 45))),
    *_hanging("calf", "thigh", ((-5, 150), (0, 0), (-20, 20)), bends_back=True),
    *_hanging("foot", "calf", ((-50, 35), (-20, 20), (-20, 20))),
)

SEGMENT_NAMES: Final[tuple[str, ...]] = tuple(segment.name for segment in SEGMENTS)
SEGMENT_INDEX: Final[dict[str, int]] = {name: s for s, name in enumerate(SEGMENT_NAMES)}
SEGMENT_LIMITS_RAD: Final = read_only(np.radians([segment.limits_deg for segment in SEGMENTS]))
"""[S, 3, 2] least and greatest flexion, abduction, twist."""

_SIGNS = np.array([segment.signs for segment in SEGMENTS], np.float64)
_TURNS_WITH = np.array([SEGMENT_INDEX.get(segment.turns_with, -1) for segment in SEGMENTS])
_HANGS_FROM = np.array([SEGMENT_INDEX.get(segment.hangs_from, -1) for segment in SEGMENTS])


def _generations() -> list[NDArray[np.intp]]:
    """The segments after the root, each generation with those whose forebears are all before it."""
    known, generations = _HANGS_FROM < 0, []
    while not known.all():
        generations.append(np.flatnonzero(~known & known[_TURNS_WITH] & known[_HANGS_FROM]))
        known[generations[-1]] = True
    return generations


_GENERATIONS: Final = _generations()


@dataclass(frozen=True, slots=True, eq=False)
class Pose:
    """Where a body stands and how it is bent.

    Attributes:
        root_room: [3] metres, the middle of the hip centres.
        heading_rad: direction of the front in the room's x-y plane, from x towards y.
        angles_rad: [S, 3] flexion, abduction, twist of each segment, in the senses of its table.
    """

    root_room: NDArray[np.float64]
    heading_rad: float
    angles_rad: NDArray[np.float64]

    def __post_init__(self) -> None:
        read_only(self.root_room)
        read_only(self.angles_rad)

    def mirrored(self) -> Pose:
        """The pose seen in a mirror that stands in the plane x = 0 of the room."""
        swap = [SEGMENT_INDEX[_other_side(name)] for name in SEGMENT_NAMES]
        flip = [[1, -1, -1] if _other_side(name) == name else [1, 1, 1] for name in SEGMENT_NAMES]
        return Pose(
            root_room=self.root_room * (-1, 1, 1),
            heading_rad=np.pi - self.heading_rad,
            angles_rad=self.angles_rad[swap] * flip,
        )


def _other_side(name: str) -> str:
    return name[:-1] + {"l": "r", "r": "l"}[name[-1]] if name[-2:] in ("_l", "_r") else name


def heading_rotation(heading_rad: float) -> NDArray[np.float64]:
    """[3, 3] R_room_body of an upright body (columns: its left, up, front)."""
    c, s = np.cos(heading_rad), np.sin(heading_rad)
    return np.array([[-s, 0, c], [c, 0, s], [0, 1, 0]])


def angles_array(degrees: Mapping[str, tuple[float, float, float]]) -> NDArray[np.float64]:
    """[S, 3] radians from degrees by segment, 0 where none are given."""
    array = np.zeros((len(SEGMENTS), 3))
    for name, angles in degrees.items():
        array[SEGMENT_INDEX[name]] = np.radians(angles)
    return array


def _rotations(signs: NDArray[np.float64], angles_rad: NDArray[np.float64]) -> NDArray[np.float64]:
    """[..., 3, 3] a swing (flexion and abduction as one rotation vector) after a twist about the
    long axis."""
    vectors = np.zeros((2, *angles_rad.shape))
    vectors[0, ..., ::2] = signs[..., ::2] * angles_rad[..., :2]
    vectors[1, ..., 1] = signs[..., 1] * angles_rad[..., 2]
    swings, twists = rotations_from_vectors(vectors)
    return swings @ twists


def segment_rotation(name: str, angles_rad: NDArray[np.float64]) -> NDArray[np.float64]:
    """[3, 3] rotation of one segment in the frame that its angles are relative to."""
    return _rotations(_SIGNS[SEGMENT_INDEX[name]], angles_rad)


def segment_poses(offsets_m: NDArray[np.float64], pose: Pose) -> NDArray[np.float64]:
    """[S, 4, 4] Ts_room_segment.

    Args:
        offsets_m: [S, 3] origin of each segment in the frame that it hangs from.
        pose: the joint angles and the root.
    """
    turns = _rotations(_SIGNS, pose.angles_rad)
    poses = np.zeros((len(SEGMENTS), 4, 4))
    poses[:, 3, 3] = 1.0
    root = _HANGS_FROM < 0
    poses[root, :3, :3] = heading_rotation(pose.heading_rad) @ turns[root]
    poses[root, :3, 3] = pose.root_room
    for own in _GENERATIONS:
        carriers = poses[_HANGS_FROM[own]]
        poses[own, :3, :3] = poses[_TURNS_WITH[own], :3, :3] @ turns[own]
        poses[own, :3, 3] = (carriers[:, :3, :3] @ offsets_m[own, :, None])[..., 0]
        poses[own, :3, 3] += carriers[:, :3, 3]
    return poses
