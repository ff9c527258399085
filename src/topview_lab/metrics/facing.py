"""Which way people face: the turn of the trunk about its own axis (ours).

Of somebody upright that turn is the yaw; of somebody who lies it tells the back from the side and
the front, too. It needs the joints alone, so any system can be measured.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.body import JOINT_NAMES
from topview_lab.metrics.errors import Pool
from topview_lab.metrics.statistics import share

FACING_DEG: Final = 45.0  # ours; a trunk that is turned by more faces another way
FACING_AFTER_S: Final = 1.0  # ours; after somebody has come, in which it may still be found out

_LEFT, _RIGHT = (
    [JOINT_NAMES.index(f"{side}_{joint}") for joint in ("shoulder", "hip")]
    for side in ("left", "right")
)


@dataclass(frozen=True, slots=True)
class Held:
    """How often something held: of how many, and the share 0..1, NaN of none."""

    count: int
    share: float

    @classmethod
    def of(cls, holds: NDArray[np.bool_]) -> Held:
        """Of [N] cases."""
        return cls(len(holds), share(int(holds.sum()), len(holds)))


def turns_deg(
    reference_camera: NDArray[np.float64], predicted_camera: NDArray[np.float64]
) -> NDArray[np.float64]:
    """[N] degrees, 0 to 180, by which predicted trunks are turned about the axes of the true ones;
    NaN where a shoulder or a hip of either is unknown.

    Args:
        reference_camera, predicted_camera: [N, J, 3] joints in the order of `JOINT_NAMES`.
    """
    true, found = _across(reference_camera), _across(predicted_camera)
    axis = _down(reference_camera)
    true, found = (way - _dot(way, axis) / _dot(axis, axis) * axis for way in (true, found))
    about = _dot(np.cross(true, found), axis) / np.sqrt(_dot(axis, axis))
    return np.degrees(np.abs(np.arctan2(about, _dot(true, found))))[:, 0]


def yaws_deg(joints_camera: NDArray[np.float64]) -> NDArray[np.float64]:
    """[N] degrees, -180 to 180, of where the front of trunks points in the plane of the camera's x
    and z axes: 0 to the camera, 90 to the image's right, 180 away; NaN where a shoulder or a hip is
    unknown.

    Args:
        joints_camera: [N, J, 3] in the order of `JOINT_NAMES`.
    """
    front = np.cross(_across(joints_camera), _down(joints_camera))
    return np.degrees(np.arctan2(front[:, 0], -front[:, 2]))


def facing(pool: Pool) -> Held:
    """Over all person-frames from `FACING_AFTER_S` after each person's first one on in which they
    were found: whether the trunk is turned by less than `FACING_DEG`."""
    samples = pool.samples
    turned_deg = turns_deg(samples.reference_camera, samples.predicted_camera)
    counts = np.isfinite(turned_deg) & (since_first_s(pool) >= FACING_AFTER_S)
    return Held.of(turned_deg[counts] <= FACING_DEG)


def since_first_s(pool: Pool) -> NDArray[np.float64]:
    """[N] seconds since each person's first frame in the recording."""
    samples = pool.samples
    _, who = np.unique(np.stack([pool.sequence, samples.person], 1), axis=0, return_inverse=True)
    first_s = np.full(int(who.max(initial=-1)) + 1, np.inf)
    np.minimum.at(first_s, who.reshape(-1), samples.time_s)
    return samples.time_s - first_s[who.reshape(-1)]


def _across(joints_camera: NDArray[np.float64]) -> NDArray[np.float64]:
    """[N, 3] from the left to the right: shoulders and hips together."""
    return (joints_camera[:, _RIGHT] - joints_camera[:, _LEFT]).sum(1)


def _down(joints_camera: NDArray[np.float64]) -> NDArray[np.float64]:
    """[N, 3] from the middle of the shoulders to that of the hips."""
    shoulders, hips = np.moveaxis(joints_camera[:, _LEFT] + joints_camera[:, _RIGHT], 1, 0)
    return 0.5 * (hips - shoulders)


def _dot(one: NDArray[np.float64], other: NDArray[np.float64]) -> NDArray[np.float64]:
    """[N, 1]"""
    return (one * other).sum(-1, keepdims=True)
