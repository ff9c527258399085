"""What formats share that animate or analyse bodies: an upright world, even times, rigid bones."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from topview.body import OUTPUT_JOINT_NAMES, PART_NAMES
from topview.body.hierarchy import NODES, ROOT, Articulation, articulated
from topview.geometry.rotations import levelled
from topview.records import InputError
from topview.skeletons import SkeletonSequence

Array = NDArray[np.float64]

UP_OF_LEVEL_CAMERA: Final = np.array([0.0, -1.0, 0.0])
Y_UP_FROM_STAGE: Final = np.diag([1.0, -1.0, -1.0])  # x right, y up, z towards the camera
Z_UP_FROM_STAGE: Final = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
# x forward, y left, z up: ROS's REP 103.
ROS_FROM_STAGE: Final = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
FLOOR_IS_LEVEL: Final = 0.9  # ours; cosine of a floor's tilt, above which gravity agrees with it
# The frame of a body that animation programs take as unturned: x to its left, y up, z to its front.
ANIMATION_FROM_PART: Final = np.diag([-1.0, -1.0, 1.0])
DEFAULT_RATE_HZ: Final = 30.0  # ours; of a single frame, whose rate nobody knows
MOST_MOMENTS: Final = 1_000_000  # ours; nine hours at 30 a second
NEAREST: Final = 0.75  # ours; of an interval: so far from an even moment a frame may lie


def T_upright_camera(sequence: SkeletonSequence, R_upright_stage: Array) -> Array:
    """[4, 4] from the camera's frame into an upright one with its origin on the floor below the
    camera. Where neither gravity nor the floor is known the camera is taken to be level; without a
    floor the origin is its own."""
    down, floor = sequence.gravity_camera, sequence.floor_camera
    up = -down if is_direction(down) else UP_OF_LEVEL_CAMERA
    cosine = float(floor[:3] @ up) if is_direction(floor[:3]) else 0.0
    height_m = float(floor[3]) / cosine if cosine > FLOOR_IS_LEVEL else 0.0
    upright = np.eye(4)
    upright[:3, :3] = R_upright_stage
    return upright @ levelled(up, height_m)


def T_world_camera(sequence: SkeletonSequence) -> Array:
    """[4, 4] pose of the camera in the world, metres: the user's, where the camera has one; else in
    a world with its origin on the floor below the camera, x forward, y left and z up, as ROS wants
    it. NaN if neither gravity nor the floor is known; without a floor the origin is the camera's.
    """
    camera = sequence.camera
    if camera is not None and camera.T_world_camera is not None:
        return camera.T_world_camera
    if not is_direction(sequence.gravity_camera):
        return np.full((4, 4), np.nan)
    return T_upright_camera(sequence, ROS_FROM_STAGE)


def is_direction(vector: Array) -> bool:
    """Whether it may be a unit vector, not NaN or nonsense that a file holds."""
    return bool((np.abs(vector) < 1.0 + 1e-6).all())


def placed(points_camera: Array, T_upright_camera: Array) -> Array:
    """[..., 3] points in the upright frame."""
    return points_camera @ T_upright_camera[:3, :3].T + T_upright_camera[:3, 3]


def the_one(sequence: SkeletonSequence, format: str) -> int:
    """Whom a format of one person is about.

    Raises:
        InputError: there is not just one.
    """
    if len(sequence.people_ids) != 1:
        raise InputError(f"{format} holds one person; {len(sequence.people_ids)} were given")
    return int(sequence.people_ids[0])


@dataclass(frozen=True, slots=True, eq=False)
class BodyMotion:
    """One person in the N frames that have them, rigid and upright: K nodes of
    `topview.body.hierarchy`, in the frames of animation programs.

    Attributes:
        rows: [N] the frames, as rows of the sequence.
        timestamps_s: [N].
        names: K' known nodes; a parent comes before its children, the root first.
        parents: [K'] indices into these, -1 for the root.
        offsets_m: [K', 3] from its parent to each node; the root's is zero.
        root_m: [N, 3] where the root is: x right, y up, z towards the camera.
        Rs_parent_node: [N, K', 3, 3]; the identity with the person upright, arms hanging, facing z.
    """

    rows: NDArray[np.int64]
    timestamps_s: Array
    names: tuple[str, ...]
    parents: tuple[int, ...]
    offsets_m: Array
    root_m: Array
    Rs_parent_node: Array

    @classmethod
    def of(cls, sequence: SkeletonSequence, format: str) -> BodyMotion:
        """Of a sequence of one person.

        Raises:
            InputError: there are others, or no frame has a pelvis and its rotation.
        """
        person_id = the_one(sequence, format)
        rows, body = articulation_of(sequence, person_id)
        known = np.nonzero(body.known)[0].tolist()
        T = T_upright_camera(sequence, Y_UP_FROM_STAGE)
        C = ANIMATION_FROM_PART
        Rs = C @ body.Rs_parent_node[:, known] @ C.T
        Rs[:, ROOT] = T[:3, :3] @ body.Rs_parent_node[:, ROOT] @ C.T
        return cls(
            rows,
            sequence.timestamps_s[rows],
            tuple(NODES[n].name for n in known),
            tuple(known.index(NODES[n].parent) if n != ROOT else -1 for n in known),
            body.offsets_m[known] @ C.T,
            placed(body.root_camera, T),
            Rs,
        )


def articulation_of(
    sequence: SkeletonSequence, person_id: int
) -> tuple[NDArray[np.int64], Articulation]:
    """Somebody's rigid body, and [N] the rows of the frames in which all of it is known.

    Raises:
        InputError: the sequence has other joints or parts than topview's, or there is no frame.
    """
    rows, slots = sequence.slots_of(person_id)
    body = articulated(*joints_and_parts(sequence, rows, slots))
    is_whole = np.isfinite(body.Rs_parent_node[:, body.known]).all((1, 2, 3))
    is_whole &= np.isfinite(body.root_camera).all(-1)
    if not is_whole.any() or not body.known[ROOT]:
        raise InputError(f"person {person_id} has no frame with a pelvis; it must have one")
    whole = Articulation(body.offsets_m, body.root_camera[is_whole], body.Rs_parent_node[is_whole])
    return rows[is_whole], whole


def joints_and_parts(
    sequence: SkeletonSequence, rows: NDArray[np.int64], slots: NDArray[np.int64]
) -> tuple[Array, Array]:
    """[N, J, 3] joints and [N, B, 4, 4] parts of who is in these slots, in topview's order.

    Raises:
        InputError: the sequence has other joints or parts than topview's.
    """
    joints = _columns(sequence.joint_names, OUTPUT_JOINT_NAMES)
    parts = _columns(sequence.part_names, PART_NAMES)
    Ts = sequence.Ts_camera_part[rows, slots]
    return sequence.joints_camera[rows, slots][:, joints], Ts[:, parts]


def rigidity_m(sequence: SkeletonSequence, person_id: int) -> float:
    """How far somebody's joints lie from those of a body with rigid bones: the largest of all
    frames, metres. Errors as of `articulation_of`."""
    rows, body = articulation_of(sequence, person_id)
    slots = np.argmax(sequence.person_ids[rows] == person_id, axis=1)
    joints_camera, _ = joints_and_parts(sequence, rows, slots)
    far = np.linalg.norm(body.joints_camera() - joints_camera, axis=-1)
    return float(np.nanmax(far))


def _columns(names: tuple[str, ...], needed: tuple[str, ...]) -> list[int]:
    missing = [name for name in needed if name not in names]
    if missing:
        raise InputError(f"has no {missing[0]}; it must have the joints and parts of topview")
    return [names.index(name) for name in needed]


def check_times_grow(timestamps_s: Array) -> None:
    """Raises InputError where a frame is no later than the one before."""
    grows = np.diff(timestamps_s) > 0
    if not grows.all():
        at = int(np.argmin(grows))
        raise InputError(
            f"timestamps_s goes from {timestamps_s[at]:g} to {timestamps_s[at + 1]:g}; "
            f"times must grow"
        )


@dataclass(frozen=True, slots=True, eq=False)
class EvenTimes:
    """Moments at a constant rate, for formats that know no others.

    Attributes:
        rate_hz: moments a second.
        rows: [M] the frame of each moment, as an index into the given times; -1 where there is
            none near.
    """

    rate_hz: float
    rows: NDArray[np.int64]

    @classmethod
    def of(cls, timestamps_s: Array) -> EvenTimes:
        """From the first frame to the last, at the rate of the frames; each moment has the frame
        that is nearest in time.

        Raises:
            InputError: times do not grow.
        """
        check_times_grow(timestamps_s)
        steps = np.diff(timestamps_s)
        if not len(steps):
            return cls(DEFAULT_RATE_HZ, np.arange(len(timestamps_s)))
        step_s = float(steps[steps < 1.5 * np.median(steps)].mean())  # without what is missing
        count = round((timestamps_s[-1] - timestamps_s[0]) / step_s) + 1
        if count > MOST_MOMENTS:
            raise InputError(f"would have {count} frames; it must be at most {MOST_MOMENTS}")
        moments_s = timestamps_s[0] + step_s * np.arange(count)
        after = np.searchsorted(timestamps_s, moments_s).clip(1, len(timestamps_s) - 1)
        before_is_nearer = moments_s - timestamps_s[after - 1] < timestamps_s[after] - moments_s
        rows = np.where(before_is_nearer, after - 1, after)
        is_near = np.abs(timestamps_s[rows] - moments_s) <= NEAREST * step_s
        return cls(1.0 / step_s, np.where(is_near, rows, -1))

    def values(self, array: NDArray[Any]) -> NDArray[Any]:
        """[M, ...] those of [F, ...] at each moment, NaN where there is no frame near."""
        taken = array[self.rows].astype(np.float64)
        taken[self.rows < 0] = np.nan
        return taken
