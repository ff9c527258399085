"""What shape people have in their clothes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.body.parts import PART_NAMES
from topview.body.surface import Between, Surface

# Shares of the stature, of each part as in `Surface.shapes_m`; x points to the other side of the
# body. Fitted to the points of rendered people at their true poses (`one`, `turn` and `sit` of
# seeds 0 to 13), as `scripts/fit_surface.py` does, which goes on from here by some 0.2 % of the
# stature, with bodies that are tracked no better. The wide end of the lower leg is the foot.
DRESSED: Final[dict[str, tuple[float, ...]]] = {
    "head": (0.052, 0.054, 0.040, 0.074, 0.0, -0.008),
    "upper_torso": (0.135, 0.058, 0.093, 0.091, 0.0, 0.021),
    "lower_torso": (0.107, 0.075, 0.116, 0.088, 0.0, 0.021),
    "upper_arm": (0.045, 0.046, 0.028, 0.029, 0.005, -0.003),
    "forearm": (0.032, 0.032, 0.020, 0.022, 0.002, -0.002),
    "upper_leg": (0.067, 0.071, 0.039, 0.042, 0.009, 0.010),
    "lower_leg": (0.040, 0.036, 0.033, 0.053, -0.003, -0.006),
}
# The same, of what lies between the parts.
BETWEEN: Final = Between(girdle=(0.067, 0.044, 0.054), hips=(0.085, -0.009, 0.004))

_SIDES: Final = np.array([1.0, 1.0, 1.0, 1.0, -1.0, 1.0])


def of_both_sides(
    shares: Mapping[str, Sequence[float] | NDArray[np.float64]],
) -> NDArray[np.float64]:
    """[11, 6] of all parts, of those of one side as in `DRESSED`."""
    return np.array(
        [
            np.array(shares[name.removeprefix("left_").removeprefix("right_")])
            * (_SIDES if name.startswith("right_") else 1.0)
            for name in PART_NAMES
        ]
    )


_SHARES: Final = of_both_sides(DRESSED)


def dressed_shapes(stature_m: float) -> NDArray[np.float64]:
    """[11, 6] `Surface.shapes_m` of the parts."""
    return _SHARES * stature_m


def dressed_surface(
    stature_m: float, lengths_m: NDArray[np.float64], joints_parent: NDArray[np.float64]
) -> Surface:
    """Of a body of this stature, whose parts have [11] lengths, and joints where [11, 3] say."""
    parts = Surface.of_parts(lengths_m, dressed_shapes(stature_m))
    return parts.with_between(BETWEEN, stature_m, joints_parent)
