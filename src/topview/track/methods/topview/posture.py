"""What a pose looks like, as traits that laws of poses are of, and the same in a mirror (ours)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.body.model import HEAD_CENTRE, BodyModel
from topview.body.parts import HEAD, LEFT_LOWER_LEG, PARTS, RIGHT_LOWER_LEG, UPPER_TORSO
from topview.geometry.rotations import unit
from topview.track.bone_lengths import BoneLengths
from topview.track.evidence import Evidence
from topview.track.methods.topview.whole_body import parts_out_of_sight
from topview.track.pose import OTHER_SIDE, Pose

Array = NDArray[np.float64]

_NOT_TORSO: Final = [part for part in range(len(PARTS)) if part != UPPER_TORSO]
_OTHERS: Final = [_NOT_TORSO.index(OTHER_SIDE[part]) for part in _NOT_TORSO]


def posture_traits(pose: Pose, model: BodyModel, up_camera: Array) -> Array:
    """[38] traits: 1; in the frame of the upper torso the line of sight, the way up, and the axis
    of each other part; and the sum of all lengths."""
    directions = [unit(pose.neck_camera), up_camera, *pose.Rs[_NOT_TORSO][..., 1]]
    in_torso = np.array(directions) @ pose.Rs[UPPER_TORSO]
    return np.concatenate([[1.0], in_torso.ravel(), [model.lengths_m.sum()]])


def mirrored_traits(blocks: Sequence[tuple[Sequence[int], int]]) -> tuple[Array, NDArray[np.int64]]:
    """[T] signs and [T] places of traits that make those of what a mirror shows.

    Args:
        blocks: of the traits, which row of each is which in the mirror, and how wide its rows are;
            those of 3 are vectors.
    """
    signs, order = [], []
    for rows, width in blocks:
        start = sum(map(len, order))
        signs.append(np.tile([-1.0, 1.0, 1.0] if width == 3 else np.ones(1), len(rows)))
        order.append(start + (np.array(rows)[:, None] * width + np.arange(width)).ravel())
    return np.concatenate(signs), np.concatenate(order)


# As `mirrored_traits` takes them.
POSTURE_BLOCKS: Final = ([0], 1), ([0, 1, *(2 + other for other in _OTHERS)], 3), ([0], 1)

# Where these are in `upright_traits`, behind the axes.
UP_TRAITS: Final = slice(3 * len(PARTS), 3 * len(PARTS) + 3)
HEIGHT_TRAIT: Final = UP_TRAITS.stop
N_UPRIGHT: Final = HEIGHT_TRAIT + 1


def upright_traits(Rs: Array, up: Array, heights: Array | float) -> Array:
    """[P, 37] traits: the parts' own axes and the way up, in the frame of the upper torso, and how
    high the head's centre is above the lower foot, in statures.

    Args:
        Rs: [11, P, 3, 3] rotations in a frame in which [3] is up.
        up: that.
        heights: [P] of heads, or one of all.
    """
    traits = np.empty((Rs.shape[1], N_UPRIGHT))
    axes = np.einsum("pji,kpj->pki", Rs[UPPER_TORSO], Rs[..., 1])
    traits[:, : UP_TRAITS.start] = axes.reshape(len(axes), -1)
    traits[:, UP_TRAITS] = np.swapaxes(Rs[UPPER_TORSO], 1, 2) @ up
    traits[:, HEIGHT_TRAIT] = heights
    return traits


def head_heights(Rs: Array) -> Array:
    """[P] of the head's centre above the lower foot, in statures, of [11, P, 3, 3] rotations in an
    upright frame, y down."""
    body, poses = BoneLengths().model(1.0), Pose(np.zeros((Rs.shape[1], 3)), Rs)
    feet = poses.ends(body)[[LEFT_LOWER_LEG, RIGHT_LOWER_LEG]]
    heads = poses.origins(body)[HEAD] + HEAD_CENTRE * body.lengths_m[HEAD] * Rs[HEAD, ..., 1]
    return feet[..., 1].max(0) - heads[:, 1]


@dataclass(frozen=True, slots=True, eq=False)
class Known:
    """What is known of a pose besides its parts.

    Attributes:
        seen: [11] share of each part that is in sight.
        up_camera: [3] unit vector.
        head_height: of the head's centre above the floor, in statures; None if it is not known.
    """

    seen: Array
    up_camera: Array
    head_height: float | None


def known_of(pose: Pose, model: BodyModel, evidence: Evidence) -> Known:
    """What is known of a pose besides its parts."""
    seen = 1.0 - parts_out_of_sight(pose, model, evidence)
    return Known(seen, evidence.up_camera, head_height(evidence, model))


def head_height(evidence: Evidence, model: BodyModel) -> float | None:
    """Of the head's centre above the floor, in statures, where the stature has been measured, not
    guessed from that."""
    if evidence.stature_m is None or not evidence.floor.any():
        return None
    return float(evidence.above_floor_m(evidence.head_camera)) / model.stature_m
