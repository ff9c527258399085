"""The class (`topview_lab.rivals.forest.classes`) of each point of a simulated person."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview_lab.rivals.forest.classes import CLASS_INDEX
from topview_lab.sim.bodies import SIM_JOINT_NAMES, SIM_PART_NAMES

Array = NDArray[np.float64]

# All ours: where along a part one class ends and the next begins, as shares of its length.
_ALONG: Final[dict[str, tuple[tuple[float, str], ...]]] = {
    "head": ((np.inf, "head"),),
    "upper_torso": ((0.7, "chest"), (np.inf, "waist")),
    "lower_torso": ((0.4, "waist"), (np.inf, "pelvis")),
    "upper_arm": ((0.3, "shoulder"), (0.75, "upper_arm"), (np.inf, "elbow")),
    "forearm": ((0.25, "elbow"), (0.85, "forearm"), (np.inf, "hand")),
    "hand": ((np.inf, "hand"),),
    "upper_leg": ((0.3, "hip"), (0.78, "upper_leg"), (np.inf, "knee")),
    "lower_leg": ((0.22, "knee"), (0.8, "lower_leg"), (np.inf, "ankle")),
    "foot": ((0.3, "ankle"), (np.inf, "foot")),
}
_AROUND: Final = (
    ("shoulder_l", "left_shoulder", 0.11),
    ("shoulder_r", "right_shoulder", 0.11),
    ("neck", "neck", 0.09),
)
"""Points of the upper torso within these distances of a joint, in metres, have its class; the last
that holds."""

_FAR_ENDS: Final = {
    "head": "neck", "upper_torso": "torso", "lower_torso": "pelvis",
    "upper_arm": "elbow", "forearm": "wrist", "hand": "hand",
    "upper_leg": "knee", "lower_leg": "ankle", "foot": "foot",
}  # fmt: skip


def part_classes(
    points: Array, part: NDArray[np.uint8], joints_camera: Array, Ts_camera_part: Array
) -> NDArray[np.uint8]:
    """[S] index into `CLASSES` of points on a simulated person.

    Args:
        points: [S, 3] metres, camera frame.
        part: [S] index into `sim.bodies.PART_NAMES`.
        joints_camera: [21, 3] in the order of `sim.bodies.JOINT_NAMES`.
        Ts_camera_part: [15, 4, 4].
    """
    out = np.empty(len(points), np.uint8)
    for index, name in enumerate(SIM_PART_NAMES):
        own = np.flatnonzero(part == index)
        stem, side = (name[:-2], name[-2:]) if name[-2:] in ("_l", "_r") else (name, "")
        origin = Ts_camera_part[index, :3, 3]
        local = (points[own] - origin) @ Ts_camera_part[index, :3, :3]
        length_m = np.linalg.norm(
            joints_camera[SIM_JOINT_NAMES.index(_FAR_ENDS[stem] + side)] - origin
        )
        is_left = np.full(len(own), side == "_l") if side else local[:, 0] < 0.0
        ends, kinds = zip(*_ALONG[stem], strict=True)
        which = np.searchsorted(ends, local[:, 1] / length_m)
        codes = np.array([[_code(kind, prefix) for kind in kinds] for prefix in ("right", "left")])
        out[own] = codes[is_left.astype(int), which]
    trunk = np.flatnonzero(part == SIM_PART_NAMES.index("upper_torso"))
    for joint, kind, radius_m in _AROUND:
        gaps = np.linalg.norm(points[trunk] - joints_camera[SIM_JOINT_NAMES.index(joint)], axis=1)
        out[trunk[gaps < radius_m]] = CLASS_INDEX[kind]
    return out


def _code(kind: str, side: str) -> int:
    return CLASS_INDEX[kind] if kind in CLASS_INDEX else CLASS_INDEX[f"{side}_{kind}"]
