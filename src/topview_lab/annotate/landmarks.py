"""The joints that carry markers, and their places in a standing person.

Heights are those of R. Drillis and R. Contini, Body Segment Parameters (1966), as printed in D.
Winter, Biomechanics and Motor Control of Human Movement (2009), Fig. 4.1; depths follow C. Gordon
et al., 1988 Anthropometric Survey of U.S. Army Personnel (1989), with 2 cm of clothes: all as
shares of the stature. They initialise the naming of markers; measurements replace them.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, radians, sin
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.records import read_only

FRONT, BACK = range(2)
SIDE_NAMES: Final = ("front", "back")
"""The two sides of the body that wear markers; a marker is joint * 2 + side."""


@dataclass(frozen=True, slots=True)
class Landmark:
    """A joint with a marker in front and one behind.

    Attributes:
        name: as in rendered recordings, _l is the person's left.
        parent: index of the joint towards the pelvis at the other end of its bone, -1 for none.
        follows: index of the joint at the other end of the bone that the markers turn with, -1 for
            the trunk.
        height: above the floor.
        aside: to the person's left.
        depth: from the front marker to the back marker.
        place: of the joint between the front marker (0) and the back one (1), the mean of the
            simulator's bodies: the spine lies behind the middle of the trunk.
    """

    name: str
    parent: int
    follows: int
    height: float
    aside: float
    depth: float
    place: float = 0.5


LANDMARKS: Final[tuple[Landmark, ...]] = (
    Landmark("pelvis", -1, -1, 0.530, 0.0, 0.147, 0.53),
    Landmark("torso", 0, -1, 0.630, 0.0, 0.142, 0.62),
    Landmark("neck", 1, -1, 0.850, 0.0, 0.085),
    Landmark("head", 2, -1, 0.935, 0.0, 0.120),
    Landmark("shoulder_l", 2, 5, 0.818, 0.105, 0.085),
    Landmark("elbow_l", 4, 6, 0.632, 0.105, 0.060),
    Landmark("hand_l", 5, 5, 0.456, 0.105, 0.050, 0.53),
    Landmark("shoulder_r", 2, 8, 0.818, -0.105, 0.085),
    Landmark("elbow_r", 7, 9, 0.632, -0.105, 0.060),
    Landmark("hand_r", 8, 8, 0.456, -0.105, 0.050, 0.53),
    Landmark("hip_l", 0, -1, 0.530, 0.051, 0.140, 0.52),
    Landmark("knee_l", 10, 12, 0.285, 0.051, 0.085, 0.53),
    Landmark("ankle_l", 11, 11, 0.039, 0.051, 0.066),
    Landmark("hip_r", 0, -1, 0.530, -0.051, 0.140, 0.52),
    Landmark("knee_r", 13, 15, 0.285, -0.051, 0.085, 0.53),
    Landmark("ankle_r", 14, 14, 0.039, -0.051, 0.066),
)

NAMES: Final[tuple[str, ...]] = tuple(landmark.name for landmark in LANDMARKS)
INDEX: Final[dict[str, int]] = {name: j for j, name in enumerate(NAMES)}
PARENTS: Final = read_only(np.array([landmark.parent for landmark in LANDMARKS]))
FOLLOWS: Final = read_only(np.array([landmark.follows for landmark in LANDMARKS]))
DEPTHS: Final = read_only(np.array([landmark.depth for landmark in LANDMARKS]))
PLACES: Final = read_only(np.array([landmark.place for landmark in LANDMARKS]))

ARMS_DEG: Final = (8.0, 35.0, 90.0)
"""Abduction of the arms that is tried when markers are named (ours)."""


def standing(arms_deg: float) -> NDArray[np.float64]:
    """[J, 2, 3] front and back markers of a person of stature 1, x to the person's left, y up,
    z to the front, from the floor below the pelvis."""
    joints = np.array([(mark.aside, mark.height, 0.0) for mark in LANDMARKS])
    angle = radians(arms_deg)
    for side, outwards in (("l", 1.0), ("r", -1.0)):
        shoulder = joints[INDEX[f"shoulder_{side}"]]
        for name in (f"elbow_{side}", f"hand_{side}"):
            length = shoulder[1] - joints[INDEX[name], 1]
            joints[INDEX[name]] = shoulder + length * np.array(
                (outwards * sin(angle), -cos(angle), 0.0)
            )
    to_front = np.array((0.0, 0.0, 1.0)) * (DEPTHS * PLACES)[:, None]
    to_back = np.array((0.0, 0.0, -1.0)) * (DEPTHS * (1.0 - PLACES))[:, None]
    return np.stack([joints + to_front, joints + to_back], 1)


ANGLE_JOINTS: Final[tuple[tuple[str, str, str], ...]] = (
    ("head", "neck", "torso"),
    ("neck", "torso", "pelvis"),
    *(
        triple
        for side in ("l", "r")
        for triple in (
            ("neck", f"shoulder_{side}", f"elbow_{side}"),
            (f"shoulder_{side}", f"elbow_{side}", f"hand_{side}"),
            ("pelvis", f"hip_{side}", f"knee_{side}"),
            (f"hip_{side}", f"knee_{side}", f"ankle_{side}"),
        )
    ),
)
"""Three joints each; the angle at the middle one is between its two bones (Sec. 6.1.2)."""


def relative_angles_deg(joints: NDArray[np.floating]) -> NDArray[np.float64]:
    """[..., A] degrees, 0 for a straight limb, of [..., J, 3] joints; NaN where one is missing."""
    a, b, c = (
        np.asarray(joints, np.float64)[..., [INDEX[triple[k]] for triple in ANGLE_JOINTS], :]
        for k in range(3)
    )
    first, second = b - a, c - b
    cross = np.linalg.norm(np.cross(first, second), axis=-1)
    return np.degrees(np.arctan2(cross, (first * second).sum(-1)))
