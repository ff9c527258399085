"""The body model: parts and joints in one table, proportions, limits, kinematics."""

from topview.body.parts import (
    JOINT_NAMES,
    JOINTS,
    OUTPUT_JOINT_NAMES,
    OUTPUT_JOINTS,
    PART_NAMES,
    PARTS,
    Joint,
    Part,
)

__all__ = [
    "JOINTS",
    "JOINT_NAMES",
    "OUTPUT_JOINTS",
    "OUTPUT_JOINT_NAMES",
    "PARTS",
    "PART_NAMES",
    "Joint",
    "Part",
]
