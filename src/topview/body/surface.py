"""The surface of a body: pieces that move with its parts (ours).

The thesis's body is a cylinder for each part. What a camera sees of people in clothes is nearer to
a tapered elliptic cylinder for each part, a girdle from below the neck to each shoulder, and what
lies between the hips, which no part holds.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from topview.body.parts import (
    LEFT_UPPER_ARM,
    LEFT_UPPER_LEG,
    LOWER_TORSO,
    RIGHT_UPPER_ARM,
    RIGHT_UPPER_LEG,
    UPPER_TORSO,
)
from topview.geometry.rotations import cross, unit
from topview.records import read_only

Array = NDArray[np.float64]

THINNEST_M: Final = 0.015  # no semi-axis is less; ours


class Between(NamedTuple):
    """What lies between parts, in shares of the stature.

    Attributes:
        girdle: its radius below the neck and at the shoulders, and how far below the neck joint it
            begins.
        hips: their radius, and how far they lie below and before the hip joints.
    """

    girdle: tuple[float, float, float]
    hips: tuple[float, float, float]


@dataclass(frozen=True, slots=True, eq=False)
class Surface:
    """S pieces, each of which moves with a part; the first ones are the parts' own.

    Attributes:
        owners: [S] the part that each moves with.
        Rs_part: [S, 3, 3] how each is turned in that part's frame.
        origins_part: [S, 3] metres, where it begins there.
        lengths_m: [S] along its +y.
        shapes_m: [S, 6] semi-axes along x and z where it begins, those at its far end, and how far
            its axis lies aside, along x and z.
    """

    owners: NDArray[np.int64]
    Rs_part: Array
    origins_part: Array
    lengths_m: Array
    shapes_m: Array

    @classmethod
    def of_parts(cls, lengths_m: Array, shapes_m: Array) -> Surface:
        """One piece for each of B parts, with their [B] lengths and [B, 6] shapes."""
        B = len(lengths_m)
        return cls(
            read_only(np.arange(B)),
            read_only(np.repeat(np.eye(3)[None], B, axis=0)),
            read_only(np.zeros((B, 3))),
            read_only(lengths_m),
            read_only(shapes_m),
        )

    def with_between(self, between: Between, stature_m: float, joints_parent: Array) -> Surface:
        """With a girdle and hips, where the joints are that [11, 3] say where they lie in the
        frames of the parts that they hang from."""
        *girdle_radii, drop = between.girdle
        radius, below, before = between.hips
        neck = np.array([0.0, drop * stature_m, 0.0])
        aside = np.array([0.0, below * stature_m, before * stature_m])
        starts = np.array([neck, neck, joints_parent[LEFT_UPPER_LEG] + aside])
        ends = np.array(
            [*joints_parent[[LEFT_UPPER_ARM, RIGHT_UPPER_ARM]], joints_parent[RIGHT_UPPER_LEG]]
        )
        ends[2] += aside
        radii = np.array([girdle_radii, girdle_radii, (radius, radius)])
        shapes = np.zeros((len(ends), 6))
        shapes[:, :4] = np.repeat(radii * stature_m, 2, axis=1)
        return Surface(
            read_only(np.append(self.owners, [UPPER_TORSO, UPPER_TORSO, LOWER_TORSO])),
            read_only(np.concatenate([self.Rs_part, _along(ends - starts)])),
            read_only(np.concatenate([self.origins_part, starts])),
            read_only(np.append(self.lengths_m, np.linalg.norm(ends - starts, axis=1))),
            read_only(np.concatenate([self.shapes_m, shapes])),
        )

    def thicker(self, by_m: Array) -> Surface:
        """Farther out, by [11] metres of each part."""
        shapes_m = self.shapes_m.copy()
        shapes_m[:, :4] = np.maximum(shapes_m[:, :4] + by_m[self.owners, None], THINNEST_M)
        return replace(self, shapes_m=read_only(shapes_m))

    def placed(self, Rs: Array, origins: Array) -> tuple[Array, Array]:
        """[S, 3, 3] rotations and [S, 3] origins of the pieces, of parts with these, [B, 3, 3] and
        [B, 3]."""
        Rs_owner = Rs[self.owners]
        places = (Rs_owner @ self.origins_part[..., None])[..., 0] + origins[self.owners]
        return Rs_owner @ self.Rs_part, places


def straight(radii: Array) -> Array:
    """[B, 6] `Surface.shapes_m` of cylinders of [B, 2] semi-axes."""
    return np.concatenate([radii, radii, np.zeros_like(radii)], axis=1)


def _along(axes: Array) -> Array:
    """[N, 3, 3] rotations whose y is along [N, 3] axes, and z as far to the front as it can be."""
    y = unit(axes)
    x = unit(cross(y, np.array([0.0, 0.0, 1.0])))
    return np.stack([x, y, cross(x, y)], axis=-1)
