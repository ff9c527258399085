"""How far two trackings of one recording lie apart, and what a skeleton is in a mirror."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.body import JOINT_NAMES
from topview.body.parts import other_side
from topview_lab.metrics.matching import NOBODY, match_people, people_distances
from topview_lab.metrics.statistics import CM_PER_M, share

MIRRORED_WITHIN_CM: Final = 3.0  # ours; left and right are alike to the eye
_MIRRORED: Final = [JOINT_NAMES.index(other_side(name)) for name in JOINT_NAMES]


def mirrored_joints(joints_camera: NDArray[np.float64]) -> NDArray[np.float64]:
    """[..., 16, 3] joints in the order of `JOINT_NAMES`, as they are in an image that is flipped
    left-right: x changes its sign, the left hand is the right hand."""
    return joints_camera[..., _MIRRORED, :] * np.array([-1.0, 1.0, 1.0])


@dataclass(frozen=True, slots=True, eq=False)
class Apart:
    """How far two trackings of the same frames lie apart.

    Attributes:
        distances_cm: [N, J] between the joints of everybody whom both have, NaN where one has none.
        alone: person-frames that only one of the two has.
    """

    distances_cm: NDArray[np.float64]
    alone: int

    def of_joint(self, joint: int) -> Apart:
        """One joint alone."""
        return replace(self, distances_cm=self.distances_cm[:, joint, None])

    def quantile_cm(self, of: float) -> float:
        """Of all joints' distances; NaN if there is none."""
        known = self._known_cm
        return float(np.quantile(known, of)) if known.size else float("nan")

    def share_within(self, limit_cm: float) -> float:
        """Of all joints' distances; NaN if there is none."""
        known = self._known_cm
        return share(int((known <= limit_cm).sum()), known.size)

    @property
    def _known_cm(self) -> NDArray[np.float64]:
        return self.distances_cm[np.isfinite(self.distances_cm)]


def pooled_apart(aparts: Sequence[Apart]) -> Apart:
    """Of at least one recording."""
    distances_cm = np.concatenate([apart.distances_cm for apart in aparts])
    return Apart(distances_cm, sum(apart.alone for apart in aparts))


def measure_apart(first_camera: NDArray[np.float64], second_camera: NDArray[np.float64]) -> Apart:
    """Match people frame by frame and compare their joints.

    Args:
        first_camera, second_camera: [F, P, J, 3] and [F, Q, J, 3] metres, NaN where absent; people
            may come in any order.
    """
    matches = match_people(people_distances(first_camera, second_camera))
    f, p = np.nonzero(matches != NOBODY)
    gaps_m = first_camera[f, p] - second_camera[f, matches[f, p]]
    given = sum(
        int(np.isfinite(joints).all(-1).any(-1).sum()) for joints in (first_camera, second_camera)
    )
    return Apart(CM_PER_M * np.linalg.norm(gaps_m, axis=-1), given - 2 * len(f))
