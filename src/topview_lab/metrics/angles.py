"""Angular errors in degrees: relative angles, directions of bones, axes and orientations of parts.

Sec. 6.1.2 measures "the relative angles of consecutive joints" and groups them into torso, arm and
leg joints, but does not write the angles down. We report two readings of it, both from joints
alone:

- relative angles: between the bone before a joint and the one after it, whatever the camera sees.
  A shoulder or hip, being a ball joint, has two: to the spine and to the line of both shoulders or
  hips. A torso that leans wrongly as a whole has no such error.
- directions: of the bone between two consecutive joints, in the camera frame. This is the stricter
  one, and the one that "the torso configuration" of Table 6.3 can be judged by.

Besides: the axis of each predicted part against the reference's bone, and, where the reference
tells orientations, the whole rotation between both, twist included.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.body import JOINT_NAMES, PART_NAMES
from topview_lab.metrics.errors import Errors, Pool, group_means, hidden_of

LEFT_RIGHT: Final = ("left", "right")


@dataclass(frozen=True, slots=True)
class Bone:
    """The line between two joints, named after the part whose axis it is."""

    part: str
    start: str
    end: str


BONES: Final[tuple[Bone, ...]] = (
    Bone("head", "head", "neck"),
    Bone("upper_torso", "neck", "torso"),
    Bone("lower_torso", "torso", "pelvis"),
    *(
        Bone(f"{side}_{part}", f"{side}_{start}", f"{side}_{end}")
        for side in LEFT_RIGHT
        for part, start, end in (
            ("upper_arm", "shoulder", "elbow"),
            ("forearm", "elbow", "hand"),
            ("upper_leg", "hip", "knee"),
            ("lower_leg", "knee", "ankle"),
        )
    ),
)

DIRECTIONS: Final = (*BONES[1:], Bone("shoulder_line", "left_shoulder", "right_shoulder"))


@dataclass(frozen=True, slots=True)
class RelativeAngle:
    """The angle between two bones, each from the joint nearer the root to the other."""

    name: str
    before: tuple[str, str]
    after: tuple[str, str]

    @property
    def joints(self) -> tuple[str, ...]:
        return tuple(dict.fromkeys(self.before + self.after))


_CHEST: Final = ("neck", "torso")
_LOINS: Final = ("torso", "pelvis")

RELATIVE_ANGLES: Final[tuple[RelativeAngle, ...]] = (
    RelativeAngle("neck", ("head", "neck"), _CHEST),
    RelativeAngle("torso", _CHEST, _LOINS),
    *(
        RelativeAngle(f"{side}_{name}", *bones)
        for side in LEFT_RIGHT
        for shoulder, elbow, hand, hip, knee, ankle in [
            [f"{side}_{j}" for j in ("shoulder", "elbow", "hand", "hip", "knee", "ankle")]
        ]
        for name, bones in {
            "shoulder": (_CHEST, ("neck", shoulder)),
            "arm_to_spine": (_CHEST, (shoulder, elbow)),
            "arm_to_shoulders": (("neck", shoulder), (shoulder, elbow)),
            "elbow": ((shoulder, elbow), (elbow, hand)),
            "leg_to_spine": (_LOINS, (hip, knee)),
            "leg_to_hips": (("pelvis", hip), (hip, knee)),
            "knee": ((hip, knee), (knee, ankle)),
        }.items()
    ),
)


def _both(*names: str) -> tuple[str, ...]:
    return tuple(f"{side}_{name}" for side in LEFT_RIGHT for name in names)


RELATIVE_ANGLE_GROUPS: Final[dict[str, tuple[str, ...]]] = {
    "torso joints": ("neck", "torso", *_both("shoulder")),
    "arm joints": _both("arm_to_spine", "arm_to_shoulders", "elbow"),
    "leg joints": _both("leg_to_spine", "leg_to_hips", "knee"),
}
"""The rows of Table 6.4."""

DIRECTION_GROUPS: Final[dict[str, tuple[str, ...]]] = {
    "torso joints": ("upper_torso", "lower_torso", "shoulder_line"),
    "arm joints": _both("upper_arm", "forearm"),
    "leg joints": _both("upper_leg", "lower_leg"),
}
"""The rows of Table 6.4; the first is the torso of Table 6.3."""

PART_GROUPS: Final[dict[str, tuple[str, ...]]] = {
    "upper torso": ("upper_torso", "shoulder_line"),  # the line tells its twist
    "lower torso": ("lower_torso",),
    "upper arms": _both("upper_arm"),
    "forearms": _both("forearm"),
    "upper legs": _both("upper_leg"),
    "lower legs": _both("lower_leg"),
}
"""The graphs of Fig. 6.3, as groups of `DIRECTIONS`."""


def relative_angle_errors(pool: Pool) -> Errors:
    """|predicted - true| of each of `RELATIVE_ANGLES`."""
    true = _relative_angles_deg(pool.samples.reference_camera)
    return Errors(
        names=tuple(angle.name for angle in RELATIVE_ANGLES),
        raw=np.abs(_relative_angles_deg(pool.samples.predicted_camera) - true),
        offset_out=np.abs(_relative_angles_deg(pool.corrected_camera) - true),
        hidden=hidden_of(pool, [angle.joints for angle in RELATIVE_ANGLES]),
    )


def direction_errors(pool: Pool) -> Errors:
    """Angle between the predicted and the true direction of each of `DIRECTIONS`."""
    bones = [(bone.start, bone.end) for bone in DIRECTIONS]
    true = _directions(pool.samples.reference_camera, bones)
    return Errors(
        names=tuple(bone.part for bone in DIRECTIONS),
        raw=_angles_deg(_directions(pool.samples.predicted_camera, bones), true),
        offset_out=_angles_deg(_directions(pool.corrected_camera, bones), true),
        hidden=hidden_of(pool, bones),
    )


def axis_errors(pool: Pool) -> Errors:
    """Angle between each predicted part's +y axis and the reference's bone.

    The constant offset of an axis is the mean direction of the bone in the frame of the part.
    """
    bones = [(bone.start, bone.end) for bone in BONES]
    parts = [PART_NAMES.index(bone.part) for bone in BONES]
    Rs_camera_part = pool.samples.Rs_camera_part[:, parts]
    true_camera = _directions(pool.samples.reference_camera, bones)
    length = np.linalg.norm(true_camera, axis=-1, keepdims=True)
    unit_camera = true_camera / np.where(length > 0.0, length, np.nan)
    true_part = np.einsum("nbji,nbj->nbi", Rs_camera_part, unit_camera)
    return Errors(
        names=tuple(bone.part for bone in BONES),
        raw=_angles_deg(true_part, np.array([0.0, 1.0, 0.0])),
        offset_out=_angles_deg(true_part, group_means(true_part, pool.group)[pool.group]),
        hidden=hidden_of(pool, bones),
    )


def orientation_errors(pool: Pool) -> Errors:
    """Angle of the rotation between each part's predicted and true orientation.

    The constant offset of a part is the mean rotation from predicted to true.
    """
    predicted = pool.samples.Rs_camera_part
    between = np.einsum("nbji,nbjk->nbik", predicted, pool.samples.Rs_camera_true_part)
    mean = _nearest_rotations(group_means(between, pool.group))[pool.group]
    joints = {bone.part: (bone.start, bone.end) for bone in BONES}
    return Errors(
        names=PART_NAMES,
        raw=_rotations_deg(between, np.eye(3)),
        offset_out=_rotations_deg(between, mean),
        hidden=hidden_of(pool, [joints[part] for part in PART_NAMES]),
    )


def _relative_angles_deg(joints_camera: NDArray[np.float64]) -> NDArray[np.float64]:
    """[N, C] of [N, J, 3] joints."""
    return _angles_deg(
        _directions(joints_camera, [angle.before for angle in RELATIVE_ANGLES]),
        _directions(joints_camera, [angle.after for angle in RELATIVE_ANGLES]),
    )


def _directions(
    joints_camera: NDArray[np.float64], bones: Sequence[tuple[str, str]]
) -> NDArray[np.float64]:
    """[N, C, 3] from the first to the second joint of each bone, of any length."""
    starts = [JOINT_NAMES.index(start) for start, _ in bones]
    ends = [JOINT_NAMES.index(end) for _, end in bones]
    return joints_camera[:, ends] - joints_camera[:, starts]


def _angles_deg(
    directions: NDArray[np.float64], others: NDArray[np.float64]
) -> NDArray[np.float64]:
    """[...] angle between two [..., 3] directions of any length, exact near 0 and 180 degrees.

    NaN where either has no length.
    """
    across = np.linalg.norm(np.cross(directions, others), axis=-1)
    along = (directions * others).sum(-1)
    angles = np.degrees(np.arctan2(across, along))
    return np.where((across > 0.0) | (along != 0.0), angles, np.nan)


def _rotations_deg(Rs: NDArray[np.float64], others: NDArray[np.float64]) -> NDArray[np.float64]:
    """[...] angle of the rotation between two [..., 3, 3] rotations: |R - S| = 2 sqrt(2) sin."""
    half_sine = np.linalg.norm(Rs - others, axis=(-2, -1)) / np.sqrt(8.0)
    return np.degrees(2.0 * np.arcsin(np.minimum(half_sine, 1.0)))


def _nearest_rotations(matrices: NDArray[np.float64]) -> NDArray[np.float64]:
    """The rotation nearest to each [..., 3, 3] matrix, NaN where it is unknown."""
    known = np.all(np.isfinite(matrices), axis=(-2, -1), keepdims=True)
    U, _, Vt = np.linalg.svd(np.where(known, matrices, np.eye(3)))
    U[..., :, 2] *= np.sign(np.linalg.det(U @ Vt))[..., None]
    return np.where(known, U @ Vt, np.nan)
