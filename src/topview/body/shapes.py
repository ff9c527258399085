"""What shape people have in their clothes, part by part: tapered elliptic cylinders."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.body.parts import PART_NAMES

# Shares of the stature, as in `BodyModel.shapes_m`: semi-axes along x and z at the part's origin,
# those at its far end, and how far its axis lies aside along x and z; x points to the other side of
# the body. Fitted to the points of rendered people (300 frames of seeds 0 to 99, true poses); the
# wide end of the lower leg is the foot.
DRESSED: Final[dict[str, tuple[float, ...]]] = {
    "head": (0.043, 0.051, 0.049, 0.073, 0.0, -0.006),
    "upper_torso": (0.110, 0.044, 0.091, 0.121, 0.0, 0.011),
    "lower_torso": (0.109, 0.080, 0.109, 0.093, 0.0, 0.014),
    "upper_arm": (0.042, 0.051, 0.028, 0.026, 0.007, -0.002),
    "forearm": (0.026, 0.028, 0.027, 0.022, 0.002, 0.0),
    "upper_leg": (0.066, 0.076, 0.036, 0.041, 0.008, 0.009),
    "lower_leg": (0.032, 0.030, 0.030, 0.075, -0.004, 0.009),
}


_SIDES: Final = np.array([1.0, 1.0, 1.0, 1.0, -1.0, 1.0])
_SHARES: Final = np.array(
    [
        np.array(DRESSED[name.removeprefix("left_").removeprefix("right_")])
        * (_SIDES if name.startswith("right_") else 1.0)
        for name in PART_NAMES
    ]
)


def dressed_shapes(stature_m: float) -> NDArray[np.float64]:
    """[11, 6] `BodyModel.shapes_m` in metres."""
    return _SHARES * stature_m
