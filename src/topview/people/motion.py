"""How a head moves: a Kalman filter of a point with a velocity that fades."""

from __future__ import annotations

from functools import lru_cache
from math import dist, exp, log, pi
from typing import Final

import msgspec
import numpy as np
from numpy.typing import NDArray

from topview.filter.over_time import share_after

Vector = NDArray[np.float64]

# All ours. A velocity that nothing renews fades over so many seconds.
VELOCITY_MEMORY_S: Final = 0.8
# Spectral density of the acceleration, m^2/s^3: of heads that nod, jump and sit down.
ACCELERATION: Final = 6.0
# Standard deviations of a measured head's centre, and of the velocity of one just found.
MEASURED_M: Final = 0.04
FIRST_SPEED_M_PER_S: Final = 1.0
# Over which the velocity of a walk is averaged: a head that comes to be covered seems to move.
WALK_S: Final = 0.4
# A longer time between two frames is a pause, in which anything may have happened.
PAUSE_S: Final = 0.5


class Motion(msgspec.Struct, frozen=True, eq=False):
    """Where a point is and where it goes; the covariance is the same along each axis.

    Attributes:
        position_camera: [3] metres.
        velocity: [3] metres per second.
        covariance: variance of the position, covariance, variance of the velocity.
        walk: [3] metres per second, of late.
    """

    position_camera: Vector
    velocity: Vector
    covariance: tuple[float, float, float]
    walk: Vector

    @classmethod
    def starting_at(cls, position_camera: Vector) -> Motion:
        """Of a point that has just been measured."""
        covariance = (MEASURED_M**2, 0.0, FIRST_SPEED_M_PER_S**2)
        return cls(position_camera, np.zeros(3), covariance, np.zeros(3))

    def restarted(self, position_camera: Vector) -> Motion:
        """At another place, where it goes on with the same walk."""
        covariance = (MEASURED_M**2, 0.0, FIRST_SPEED_M_PER_S**2)
        return Motion(position_camera, self.walk, covariance, self.walk)

    @property
    def sigma_m(self) -> float:
        """Standard deviation of the position along each axis."""
        return self.covariance[0] ** 0.5

    def predicted(self, elapsed_s: float) -> Motion:
        """After so many seconds; of a pause only the beginning counts."""
        step_s = min(max(elapsed_s, 0.0), PAUSE_S)
        kept = exp(-step_s / VELOCITY_MEMORY_S)
        ahead_s = VELOCITY_MEMORY_S * (1.0 - kept)
        pp, pv, vv = self.covariance
        covariance = (
            pp + 2.0 * ahead_s * pv + ahead_s**2 * vv + ACCELERATION * step_s**3 / 3.0,
            kept * (pv + ahead_s * vv) + ACCELERATION * step_s**2 / 2.0,
            kept**2 * vv + ACCELERATION * step_s,
        )
        walk = self.walk + share_after(step_s, WALK_S) * (self.velocity - self.walk)
        position_camera = self.position_camera + ahead_s * self.velocity
        return Motion(position_camera, kept * self.velocity, covariance, walk)

    def updated(self, measured_camera: Vector, sigma_m: float = MEASURED_M) -> Motion:
        """With a measurement [3] of the position."""
        pp, pv, vv = self.covariance
        total = pp + sigma_m**2
        gain, gain_per_s = pp / total, pv / total
        innovation = measured_camera - self.position_camera
        return Motion(
            self.position_camera + gain * innovation,
            self.velocity + gain_per_s * innovation,
            (pp * (1.0 - gain), pv * (1.0 - gain), vv - gain_per_s * pv),
            self.walk,
        )

    def log_density(self, measured_camera: Vector, sigma_m: float = MEASURED_M) -> float:
        """Of a measurement [3], per cubic metre."""
        variance = self.covariance[0] + sigma_m**2
        square_m2 = dist(measured_camera.tolist(), self.position_camera.tolist()) ** 2
        return -0.5 * (square_m2 / variance + 3.0 * log(2.0 * pi * variance))


@lru_cache(maxsize=64)
def predicted(motion: Motion, elapsed_s: float) -> Motion:
    """`Motion.predicted`, which several ask for in one frame."""
    return motion.predicted(elapsed_s)
