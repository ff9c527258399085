"""The body as one table: 11 parts, 10 articulations, 22 degrees of freedom (Sec. 3.2).

A body is fitted by the 16 `JOINTS`, and errors are told of them. Outputs have the `OUTPUT_JOINTS`:
these and the four ends of `topview.body.ends`, which follow from the fitted parts.

Which part hangs from which, how far it may turn (Table 3.2) and how many of its hypotheses go on
from frame to frame (Sec. 6.1.3). Sizes are in `topview.body.proportions`; a part's frame is
described in `topview.records.Person`: origin at the joint nearer the head, +y along the part to
its far end, +x to the person's right, +z to the front. With every rotation at zero the person
stands upright with the arms down; a positive rotation about x swings a part's far end to the
front, one about z swings it to the person's left, as the signs of Table 3.2 want it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import radians
from typing import Final

Interval = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Part:
    """One cylinder of the body.

    Attributes:
        name: its name in every output.
        parent: index of the part that it hangs from, -1 for the head, which is the root.
        limits_rad: rotation about x (flexion), y (about its own axis) and z (abduction), relative
            to the parent, signed as in Table 3.2.
        is_hinge: True for elbows and knees, which turn about x alone.
        n_best: hypotheses that are propagated to the next frame.
    """

    name: str
    parent: int
    limits_rad: tuple[Interval, Interval, Interval]
    is_hinge: bool
    n_best: int


def _limits(x: Interval, y: Interval = (0, 0), z: Interval = (0, 0)) -> tuple[Interval, ...]:
    return tuple((radians(low), radians(high)) for low, high in (x, y, z))


def _part(
    name: str, parent: int, limits: tuple[Interval, ...], n_best: int, *, is_hinge: bool = False
) -> Part:
    x, y, z = limits
    return Part(name, parent, (x, y, z), is_hinge, n_best)


(
    HEAD,
    UPPER_TORSO,
    LOWER_TORSO,
    LEFT_UPPER_ARM,
    LEFT_FOREARM,
    RIGHT_UPPER_ARM,
    RIGHT_FOREARM,
    LEFT_UPPER_LEG,
    LEFT_LOWER_LEG,
    RIGHT_UPPER_LEG,
    RIGHT_LOWER_LEG,
) = range(11)

UNLIMITED: Final = (-180, 180)

PARTS: Final[tuple[Part, ...]] = (
    _part("head", -1, _limits(UNLIMITED, UNLIMITED, UNLIMITED), 10),
    _part("upper_torso", HEAD, _limits((-30, 60), UNLIMITED, (-45, 45)), 5),
    _part("lower_torso", UPPER_TORSO, _limits((-30, 45), (-30, 30), (-30, 30)), 5),
    _part("left_upper_arm", UPPER_TORSO, _limits((-60, 180), (-90, 90), (-10, 180)), 10),
    _part("left_forearm", LEFT_UPPER_ARM, _limits((-10, 160)), 10, is_hinge=True),
    _part("right_upper_arm", UPPER_TORSO, _limits((-60, 180), (-90, 90), (-180, 10)), 10),
    _part("right_forearm", RIGHT_UPPER_ARM, _limits((-10, 160)), 10, is_hinge=True),
    _part("left_upper_leg", LOWER_TORSO, _limits((-45, 100), (-90, 90), (-10, 90)), 5),
    _part("left_lower_leg", LEFT_UPPER_LEG, _limits((-100, 10)), 10, is_hinge=True),
    _part("right_upper_leg", LOWER_TORSO, _limits((-45, 100), (-90, 90), (-90, 10)), 5),
    _part("right_lower_leg", RIGHT_UPPER_LEG, _limits((-100, 10)), 10, is_hinge=True),
)

PART_NAMES: Final[tuple[str, ...]] = tuple(part.name for part in PARTS)


@dataclass(frozen=True, slots=True)
class Joint:
    """A landmark of the skeleton.

    Attributes:
        name: its name in every output.
        part: index of the part that carries it; its constant offsets are told in that frame.
        bone_to: index of the joint towards the root that a drawing connects it with, -1 for none.
    """

    name: str
    part: int
    bone_to: int


# Where each lies on its part: `topview.body.model.BodyModel.joints_part`.
JOINTS: Final[tuple[Joint, ...]] = (
    Joint("head", HEAD, -1),
    Joint("neck", UPPER_TORSO, 0),
    Joint("torso", LOWER_TORSO, 1),
    Joint("pelvis", LOWER_TORSO, 2),
    Joint("left_shoulder", LEFT_UPPER_ARM, 1),
    Joint("left_elbow", LEFT_UPPER_ARM, 4),
    Joint("left_hand", LEFT_FOREARM, 5),
    Joint("right_shoulder", RIGHT_UPPER_ARM, 1),
    Joint("right_elbow", RIGHT_UPPER_ARM, 7),
    Joint("right_hand", RIGHT_FOREARM, 8),
    Joint("left_hip", LEFT_UPPER_LEG, 3),
    Joint("left_knee", LEFT_UPPER_LEG, 10),
    Joint("left_ankle", LEFT_LOWER_LEG, 11),
    Joint("right_hip", RIGHT_UPPER_LEG, 3),
    Joint("right_knee", RIGHT_UPPER_LEG, 13),
    Joint("right_ankle", RIGHT_LOWER_LEG, 14),
)

JOINT_NAMES: Final[tuple[str, ...]] = tuple(joint.name for joint in JOINTS)
HEAD_CENTRE_JOINT: Final = JOINT_NAMES.index("head")

END_JOINTS: Final[tuple[Joint, ...]] = (
    Joint("left_wrist", LEFT_FOREARM, JOINT_NAMES.index("left_elbow")),
    Joint("right_wrist", RIGHT_FOREARM, JOINT_NAMES.index("right_elbow")),
    Joint("left_foot", LEFT_LOWER_LEG, JOINT_NAMES.index("left_ankle")),
    Joint("right_foot", RIGHT_LOWER_LEG, JOINT_NAMES.index("right_ankle")),
)
END_NAMES: Final[tuple[str, ...]] = tuple(joint.name for joint in END_JOINTS)
OUTPUT_JOINT_NAMES: Final[tuple[str, ...]] = JOINT_NAMES + END_NAMES


def _in_outputs(joint: Joint) -> Joint:
    """A hand's bone goes to the wrist, where there is one."""
    wrist = joint.name.replace("hand", "wrist")
    is_hand = joint.name != wrist
    return replace(joint, bone_to=OUTPUT_JOINT_NAMES.index(wrist)) if is_hand else joint


OUTPUT_JOINTS: Final[tuple[Joint, ...]] = (*map(_in_outputs, JOINTS), *END_JOINTS)


def other_side(name: str) -> str:
    """The name of the same joint or part on the other side of the body; its own in the middle."""
    return "_".join(_OTHER_SIDE.get(word, word) for word in name.split("_"))


_OTHER_SIDE: Final = {"left": "right", "right": "left"}
