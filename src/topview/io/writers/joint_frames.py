"""How the joints of skeletons turn and how long their bones are, told by joints and parts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from topview.body import joint_frames as of_bodies
from topview.body.parts import OUTPUT_JOINT_NAMES, PART_NAMES
from topview.io.writers.levelled import joints_and_parts
from topview.skeletons import Skeletons, SkeletonSequence

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class JointFrames:
    """Joints in their parents' frames: F frames, S slots, J joints as in a `SkeletonSequence`.

    Attributes:
        parents: [J] int64, which joint each hangs from; -1 for the pelvis, the root, and for joints
            that are not topview's.
        Rs_parent_joint: [F, S, J, 3, 3] how each joint's frame is turned in its parent's, the
            root's in the camera's; all are the identity while the person stands upright with the
            arms hanging and looks along z. NaN where it is not known.
        offsets_parent_joint_m: [F, S, J, 3] from its parent to each joint, in the parent's frame;
            the root's in the camera's, metres. NaN where it is not known.
    """

    parents: NDArray[np.int64]
    Rs_parent_joint: Array
    offsets_parent_joint_m: Array


def joint_frames(sequence: SkeletonSequence) -> JointFrames:
    """Of everybody in all frames. A joint's place is its parent's, plus the rotation of the
    parent's frame in the camera's times the offset."""
    F, S, J = sequence.joint_state.shape
    Rs, offsets_m = np.full((F, S, J, 3, 3), np.nan), np.full((F, S, J, 3), np.nan)
    if are_ours(sequence):
        rows, slots = np.nonzero(sequence.present)
        with np.errstate(over="ignore", invalid="ignore"):  # of files that hold nonsense
            own_Rs, own_m = of_bodies.joint_frames(*joints_and_parts(sequence, rows, slots))
        at = rows[:, None], slots[:, None], _columns(sequence)
        Rs[at], offsets_m[at] = own_Rs, own_m
    return JointFrames(parents_of(sequence), Rs, offsets_m)


def parents_of(sequence: SkeletonSequence) -> NDArray[np.int64]:
    """[J] `JointFrames.parents`."""
    parents = np.full(len(sequence.joint_names), -1, np.int64)
    if are_ours(sequence):
        columns = _columns(sequence)
        parents[columns] = [columns[p] if p >= 0 else -1 for p in of_bodies.JOINT_PARENTS]
    return parents


def bone_lengths_m(skeletons: Skeletons) -> Array:
    """[P, J] metres from its parent to each joint while the person stands in the reference pose, as
    told in the last frame that knows it: the tracker learns them. 0 for the root, NaN where no
    frame does."""
    lengths_m = np.empty((0, 0))
    for block in skeletons.blocks():
        if not lengths_m.size:
            lengths_m = np.full((len(block.people_ids), len(block.joint_names)), np.nan)
        if not are_ours(block):
            continue
        joints = np.arange(len(OUTPUT_JOINT_NAMES))
        for person_id in np.unique(block.person_ids[block.present]).tolist():
            of_person = joints_and_parts(block, *block.slots_of(person_id))
            with np.errstate(over="ignore", invalid="ignore"):  # of files that hold nonsense
                told_m = of_bodies.bone_lengths(*of_person)
            is_known = np.isfinite(told_m)
            last = len(told_m) - 1 - is_known[::-1].argmax(0)
            own = np.flatnonzero(block.people_ids == person_id), _columns(block)
            lengths_m[own] = np.where(is_known.any(0), told_m[last, joints], lengths_m[own])
    return lengths_m


def are_ours(sequence: SkeletonSequence) -> bool:
    """Whether all of topview's joints and parts are among the sequence's."""
    joints, parts = set(sequence.joint_names), set(sequence.part_names)
    return set(OUTPUT_JOINT_NAMES) <= joints and set(PART_NAMES) <= parts


def _columns(sequence: SkeletonSequence) -> list[int]:
    return [sequence.joint_names.index(name) for name in OUTPUT_JOINT_NAMES]
