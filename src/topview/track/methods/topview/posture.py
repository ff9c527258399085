"""What a pose looks like, as traits that laws of poses are of, and the same in a mirror (ours)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.body.model import BodyModel
from topview.body.parts import PARTS, UPPER_TORSO
from topview.geometry.rotations import unit
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
