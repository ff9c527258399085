"""Inverse kinematics of two bones: legs reach for the floor, arms for objects."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.geometry.rotations import rotations_from_vectors, vectors_from_rotations
from topview_lab.sim.actions import Side
from topview_lab.sim.bodies import Body
from topview_lab.sim.skeleton import SEGMENT_INDEX, SEGMENTS

Array = NDArray[np.float64]
PALM: Final = 0.030
"""The palm's middle beyond the wrist, share of the stature, as in `anthropometry.joint_places`."""
STRETCH: Final = 0.999
"""A limb reaches no further than this share of its length, so that its bending plane is defined."""


def unit(vector: Array) -> Array:
    """The vector at length 1."""
    return vector / np.linalg.norm(vector)


def two_bones(start: Array, end: Array, lengths: tuple[float, float], bend: Array) -> Array:
    """[2, 3] directions of two bones from start towards end, with their joint on bend's side."""
    upper, lower = lengths
    reach = np.linalg.norm(end - start)
    along = (end - start) / reach
    distance = float(np.clip(reach, abs(upper - lower) + 1e-3, STRETCH * (upper + lower)))
    out = unit(bend - (bend @ along) * along)
    shadow = (distance**2 + upper**2 - lower**2) / (2.0 * distance)
    joint = shadow * along + np.sqrt(max(upper**2 - shadow**2, 0.0)) * out
    return np.stack([joint / upper, (distance * along - joint) / lower])


def limb_angles(name: str, R_a_carrier: Array, bones_a: Array) -> tuple[Array, float]:
    """[3] angles of the upper segment `name` and the flexion of the lower one, radians."""
    upper, lower = bones_a @ R_a_carrier
    axis = np.cross((0.0, -1.0, 0.0), upper)
    sine = np.linalg.norm(axis)
    angle = np.arctan2(sine, -upper[1])
    swing = axis * (angle / sine if sine > 1e-9 else 1.0)
    x, y, z = rotations_from_vectors(swing).T @ lower
    forwards = -1.0 if name.startswith("thigh") else 1.0
    twist = np.arctan2(forwards * x, forwards * z)
    flexion = np.arctan2(np.hypot(x, z), -y)
    return _signed(name, swing[0], twist, swing[2]), float(flexion)


def _signed(name: str, about_x: float, about_y: float, about_z: float) -> Array:
    """[3] flexion, abduction, twist of a segment from its rotations."""
    for_flexion, for_twist, for_abduction = SEGMENTS[SEGMENT_INDEX[name]].signs
    return np.array([for_flexion * about_x, for_abduction * about_z, for_twist * about_y])


def end_angles(name: str, R_carrier_segment: Array) -> Array:
    """[3] angles of a segment that has this rotation: a twist about y, then a swing."""
    R = R_carrier_segment
    twist = float(2.0 * np.arctan2(R[0, 2] - R[2, 0], 1.0 + np.trace(R)))
    about = vectors_from_rotations(R @ rotations_from_vectors(np.array([0.0, -twist, 0.0])))
    return _signed(name, about[0], twist, about[2])


def reaching_angles(
    body: Body, Ts_a_segment: Array, side: Side, palm_a: Array, elbow_chest: Array
) -> tuple[Array, float]:
    """[3] angles of an upper arm and the flexion of its forearm that bring the palm to a point.

    Args:
        body: the person's body.
        Ts_a_segment: [S, 4, 4] poses of the segments; those of the trunk are used.
        side: of the arm.
        palm_a: [3] target in metres; the arm points at it where it is out of reach.
        elbow_chest: [3] direction of the elbow, in the chest's axes.
    """
    R_a_chest = Ts_a_segment[SEGMENT_INDEX["chest"], :3, :3]
    shoulder = Ts_a_segment[SEGMENT_INDEX[f"upper_arm_{side}"], :3, 3]
    elbow, wrist = (body.offsets_m[SEGMENT_INDEX[f"{name}_{side}"]] for name in ("forearm", "hand"))
    lengths = (
        float(np.linalg.norm(elbow)),
        float(np.linalg.norm(wrist)) + PALM * body.appearance.stature_m,
    )
    bones = two_bones(shoulder, palm_a, lengths, R_a_chest @ elbow_chest)
    return limb_angles(f"upper_arm_{side}", R_a_chest, bones)
