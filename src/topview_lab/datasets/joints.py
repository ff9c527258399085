"""Map the references' joint names to ours (`topview.body.OUTPUT_JOINT_NAMES`)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.body import OUTPUT_JOINT_NAMES, PART_NAMES
from topview.records import InputError

# Each reference name and the joint of ours that it is, or None for one that we do not have.
KINECT_V1_JOINTS: Final[dict[str, str | None]] = {
    "head": "head",
    "shoulder_center": "neck",
    "spine": "torso",
    "hip_center": "pelvis",
    **{
        f"{side}_{joint}": f"{side}_{joint}"
        for limb in (("shoulder", "elbow", "wrist", "hand"), ("hip", "knee", "ankle", "foot"))
        for side in ("left", "right")
        for joint in limb
    },
}
"""The 20 joints of the Kinect SDK v1, in its order."""

RENDERED_JOINTS: Final[dict[str, str | None]] = {
    "head_top": None,
    **{joint: joint for joint in ("head", "neck", "torso", "pelvis")},
    **{
        f"{name.removeprefix(side + '_')}_{side[0]}": ours
        for side in ("left", "right")
        for name, ours in KINECT_V1_JOINTS.items()
        if name.startswith(side)
    },
}
"""The 21 joints of the rendered recordings, sides as `_l` and `_r`."""

_KNOWN: Final[Mapping[str, str | None]] = (
    KINECT_V1_JOINTS | RENDERED_JOINTS | {name: name for name in OUTPUT_JOINT_NAMES}
)


def select_joints(names: Sequence[str], source: str) -> tuple[tuple[str, ...], NDArray[np.int64]]:
    """Select the joints that we have too: our names, and their indices in `names`.

    Args:
        names: joint names of a reference.
        source: file they come from, for the error.

    Raises:
        InputError: a name is unknown, two mean the same joint, or none is ours.
    """
    unknown = [name for name in names if name not in _KNOWN]
    if unknown:
        raise InputError(
            f"{source}: unknown joint names {', '.join(unknown)}; they must be among "
            f"{', '.join(sorted(_KNOWN))} (ours: {', '.join(OUTPUT_JOINT_NAMES)})"
        )
    ours = {i: joint for i, name in enumerate(names) if (joint := _KNOWN[name]) is not None}
    joints = tuple(ours.values())
    if not joints or len(set(joints)) < len(joints):
        raise InputError(
            f"{source}: joint names {', '.join(names)} give {', '.join(joints) or 'no joint'}; "
            f"each joint must be named once, at least one of {', '.join(OUTPUT_JOINT_NAMES)}"
        )
    return joints, np.array(list(ours), np.int64)


def our_part_name(name: str) -> str | None:
    """Our name of a part with the suffix `_l` or `_r`; None for hands and feet."""
    sides = {"_l": "left_", "_r": "right_"}
    ours = sides[name[-2:]] + name[:-2] if name[-2:] in sides else name
    return ours if ours in PART_NAMES else None


def facing_sides(names: Sequence[str], joints_camera: NDArray[np.float64]) -> tuple[str, ...]:
    """Our names with left and right corrected, for data sets with mirrored images or unknown sides.

    People mostly face the camera (ours), and then have their left at the image's right: arms by the
    shoulders, legs by the hips, by the majority of frames.

    Args:
        names: K of our joint names.
        joints_camera: [F, K, 3] of a whole recording, NaN where unknown.
    """
    exchanged = list(names)
    for root, limb in (
        ("shoulder", ("elbow", "wrist", "hand")),
        ("hip", ("knee", "ankle", "foot")),
    ):
        left, right = (
            joints_camera[:, names.index(f"{side}_{root}"), 0] for side in ("left", "right")
        )
        if (left < right).sum() > (left > right).sum():
            swap = {
                f"{side}_{joint}": f"{other}_{joint}"
                for joint in (root, *limb)
                for side, other in (("left", "right"), ("right", "left"))
            }
            exchanged = [swap.get(name, name) for name in exchanged]
    return tuple(exchanged)
