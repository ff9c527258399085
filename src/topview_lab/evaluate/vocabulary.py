"""Find our joints among the joints of other systems.

Known are the names of the Kinect SDK v1 and v2, Azure Kinect, COCO, OpenPose (BODY_25),
MediaPipe Pose, SMPL and ours, in any spelling: `LShoulder`, `left_shoulder`, `SHOULDER_LEFT` and
`ShoulderLeft` are one joint.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Final

from topview.body import OUTPUT_JOINT_NAMES
from topview.records import InputError

# For each of our joints the joints whose middle it is, the best choice first. Definitions differ:
# constant offsets are to be expected, and the metrics tell errors without them too.
_MIDDLE: Final[dict[str, tuple[tuple[str, ...], ...]]] = {
    "head": (("head",), ("left ear", "right ear"), ("nose",)),
    "neck": (
        ("neck",), ("shouldercenter",), ("spineshoulder",), ("left shoulder", "right shoulder"),
    ),
    "torso": (
        ("torso",), ("spine",), ("spinemid",), ("spinenavel",), ("spinenaval",), ("spine1",),
    ),
    "pelvis": (
        ("pelvis",), ("hipcenter",), ("midhip",), ("spinebase",), ("hips",),
        ("left hip", "right hip"),
    ),
}  # fmt: skip
_LIMBS: Final[dict[str, tuple[str, ...]]] = {
    "shoulder": ("shoulder",), "elbow": ("elbow",), "hand": ("hand", "wrist"),
    "hip": ("hip",), "knee": ("knee",), "ankle": ("ankle",),
    "wrist": ("wrist",), "foot": ("foot", "toebase"),
}  # fmt: skip
CHOICES: Final[dict[str, tuple[tuple[str, ...], ...]]] = _MIDDLE | {
    f"{side}_{joint}": tuple((f"{side} {theirs}",) for theirs in names)
    for side in ("left", "right")
    for joint, names in _LIMBS.items()
}

_WORDS: Final = frozenset(
    word.split()[-1] for choices in CHOICES.values() for choice in choices for word in choice
)
# Known joints that we have no use for.
_OTHERS: Final = frozenset({
    "eye", "ear", "nose", "mouth", "eyeinner", "eyeouter", "pinky", "index", "thumb", "handtip",
    "heel", "footindex", "bigtoe", "smalltoe", "toe", "clavicle", "collar",
    "spinechest", "spine2", "spine3", "headtop", "background", "jaw",
})  # fmt: skip
_SIDES: Final = {"l": "left", "left": "left", "r": "right", "right": "right"}


def canonical(name: str) -> str:
    """A joint's name without its spelling: `left shoulder`, `spinebase`."""
    words = re.findall(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|\d+", name)
    # "LShoulder" has its side in front of a capital, which the pattern above does not part.
    if match := re.fullmatch(r"([LR])([A-Z][a-zA-Z]*)", name):
        words = [match[1], *re.findall(r"[A-Z]?[a-z]+", match[2])]
    words = [word.lower() for word in words if word.lower() not in ("joint", "type")]
    sides = [_SIDES[word] for word in words if word in _SIDES]
    stem = "".join(word for word in words if word not in _SIDES)
    return " ".join([*sides[:1], stem])


def is_known(name: str) -> bool:
    stem = canonical(name).split(" ")[-1]
    return stem in _WORDS or stem in _OTHERS


def find_joints(
    names: Sequence[str], source: str, more: Mapping[str, str] | None = None
) -> dict[str, tuple[int, ...]]:
    """Find our joints in another system's: for each, the indices in `names` whose midpoint it is.

    Args:
        names: K names.
        source: where they come from, for errors.
        more: their names to ours; with it, other unknown names are left out.

    Raises:
        InputError: unknown names and no `more`, a wrong `more`, or names given twice.
    """
    more = more or {}
    columns = {canonical(name): k for k, name in enumerate(names)}
    ours = f"ours are {', '.join(OUTPUT_JOINT_NAMES)}"
    theirs = f"theirs are {', '.join(names)}"
    if wrong := [name for pair in more.items() for name in _wrong(pair, names)]:
        raise InputError(
            f"{source}: the map names {', '.join(wrong)}; give theirs=ours, where {theirs}; {ours}"
        )
    unknown = [name for name in names if not is_known(name) and name not in more]
    if unknown and not more:
        raise InputError(
            f"{source}: unknown joint names {', '.join(unknown)}; map them with "
            f"--map theirs=ours,...: {theirs}; {ours}"
        )
    if len(columns) < len(names):
        raise InputError(f"{source}: a joint is named twice; {theirs}, each must be given once")
    found = {
        joint: tuple(columns[name] for name in choice)
        for joint, choices in CHOICES.items()
        if (choice := next((c for c in choices if all(n in columns for n in c)), None))
    } | {joint: (names.index(name),) for name, joint in more.items()}
    if not found:
        raise InputError(f"{source}: none of its joints is one of ours: {theirs}; {ours}")
    return {joint: found[joint] for joint in OUTPUT_JOINT_NAMES if joint in found}


def _wrong(pair: tuple[str, str], names: Sequence[str]) -> list[str]:
    theirs, ours = pair
    return [theirs] * (theirs not in names) + [ours] * (ours not in OUTPUT_JOINT_NAMES)
