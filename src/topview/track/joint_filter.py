"""Proposed joints over time: a Kalman filter for each joint of each mode (ours).

Joints go on at a constant velocity that changes at random, and each frame's proposal is a
measurement as sure as its scales say. It averages what differs from frame to frame, such as noise
and which way the window was looked at; what a proposer gets wrong all the time stays wrong. So the
scales that go on are those of the proposals.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from topview.detect.joints import JointProposals
from topview.records import check_range

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class JointFilterSettings:
    """Ours, fitted on rendered people.

    Attributes:
        unrest_m2_s3: how fast the variance of a joint's velocity grows, 0.001 to 1e6.
        jump: a joint starts anew whose proposal is so many standard deviations off, 1 to 1000.

    Raises:
        InputError: a value out of range.
    """

    unrest_m2_s3: float = 20.0
    jump: float = 5.0

    def __post_init__(self) -> None:
        check_range(self, 0.001, 1e6, "unrest_m2_s3")
        check_range(self, 1.0, 1000.0, "jump")


class JointFilter:
    """The joints of one person's proposals over time.

    Places are filtered as what they are measured as: across, as shares of the depth, and in depth.
    All arrays are [M, J, 3].
    """

    def __init__(self, settings: JointFilterSettings) -> None:
        self.settings = settings
        self._place = self._velocity = self._variance = np.zeros(0)
        self._covariance = self._of_velocity = np.zeros(0)

    def update(self, proposals: JointProposals, elapsed_s: float) -> JointProposals:
        """The first person's proposals with their places filtered.

        Args:
            proposals: P = 1; always of as many modes and joints.
            elapsed_s: since the ones before.
        """
        places_camera, scales_m = proposals.positions_camera[0], proposals.scales_m[0]
        to_metres = metres_of_measured(places_camera)
        measured = places_camera / to_metres
        noise = 2.0 * (scales_m / to_metres) ** 2  # the variance of a Laplace law
        unrest = self.settings.unrest_m2_s3 / to_metres**2
        if self._place.shape != measured.shape:
            self._place, self._variance = measured, noise
            self._velocity = self._covariance = np.zeros_like(noise)
            self._of_velocity = unrest
            return proposals
        self._predict(elapsed_s, unrest)
        self._correct(measured, noise, unrest)
        rays = np.concatenate([self._place[..., :2], np.ones_like(self._place[..., 2:])], axis=-1)
        filtered = rays * self._place[..., 2:]
        return replace(proposals, positions_camera=filtered[None])

    def _predict(self, elapsed_s: float, unrest: Array) -> None:
        t = elapsed_s
        self._place = self._place + t * self._velocity
        self._variance = (
            self._variance
            + 2.0 * t * self._covariance
            + t**2 * self._of_velocity
            + unrest * t**3 / 3.0
        )
        self._covariance = self._covariance + t * self._of_velocity + unrest * t**2 / 2.0
        self._of_velocity = self._of_velocity + unrest * t

    def _correct(self, measured: Array, noise: Array, unrest: Array) -> None:
        off = measured - self._place
        total = self._variance + noise
        gain, velocity_gain = self._variance / total, self._covariance / total
        has_jumped = (off**2 / total).sum(-1, keepdims=True) > self.settings.jump**2
        self._place = np.where(has_jumped, measured, self._place + gain * off)
        self._velocity = np.where(has_jumped, 0.0, self._velocity + velocity_gain * off)
        self._of_velocity = np.where(
            has_jumped, unrest, self._of_velocity - velocity_gain * self._covariance
        )
        self._covariance = np.where(has_jumped, 0.0, (1.0 - gain) * self._covariance)
        self._variance = np.where(has_jumped, noise, (1.0 - gain) * self._variance)


def metres_of_measured(places_camera: Array) -> Array:
    """[..., 3] what places across and down, as shares of the depth, and in depth are to be
    multiplied by to be the metres of [..., 3] places."""
    depth_m = places_camera[..., 2:]
    return np.concatenate([depth_m, depth_m, np.ones_like(depth_m)], axis=-1)
