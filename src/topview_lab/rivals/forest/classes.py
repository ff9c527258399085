"""The classes of body parts that the forest tells apart, and which of them vote for which joint.

Shotton et al. (2011) have 31 by hand; these 29 are ours: regions around the joints, and what lies
between them, with the person's own left and right.
"""

from __future__ import annotations

from typing import Final

from topview.body.parts import JOINT_NAMES

SIDED: Final = (
    "chest", "pelvis",
    "shoulder", "upper_arm", "elbow", "forearm", "hand",
    "hip", "upper_leg", "knee", "lower_leg", "ankle", "foot",
)  # fmt: skip

CLASSES: Final[tuple[str, ...]] = (
    "head",
    "neck",
    "waist",
    *(f"{side}_{name}" for name in SIDED for side in ("left", "right")),
)
CLASS_INDEX: Final[dict[str, int]] = {name: index for index, name in enumerate(CLASSES)}

_OF_SEVERAL: Final = {"torso": ("waist",), "pelvis": ("left_pelvis", "right_pelvis")}

VOTES: Final[tuple[tuple[int, ...], ...]] = tuple(
    tuple(CLASS_INDEX[name] for name in _OF_SEVERAL.get(joint, (joint,))) for joint in JOINT_NAMES
)
"""For each of our joints, the classes that vote for it."""
