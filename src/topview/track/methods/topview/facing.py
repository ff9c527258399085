"""Which way somebody faces of whom no joints are proposed, over time (ours).

The cylinders of a body look alike from front and back, and whoever is taken to face the wrong way
stays a good fit. A single pose tells little, so what is believed is the yaw: as likely as those
captured bodies face so that look like what is seen (`lookup.Likeness`), in this frame and, turned
on, in those before. What a pose is less likely than another by its yaw, it costs.
"""

from __future__ import annotations

from math import pi
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.body.parts import UPPER_TORSO
from topview.filter.over_time import frames_in
from topview.filter.turning import (
    N_YAWS,
    RATES_RAD,
    YAWS_RAD,
    normalised,
    of_somebody_new,
    turned_on,
    wrapped,
)
from topview.track.methods.topview.lookup import Likeness
from topview.track.pose import Pose
from topview.track.stances import heading, headings

Array = NDArray[np.float64]

# All ours.
NEW_SHARE: Final = 0.1  # of a frame's log likelihood, but the first's: frames in a row err alike
KNOWN_SIGMA_RAD: Final = 0.5  # of a yaw that was known a moment ago
YAW_COST: Final = 0.01  # of a yaw that is less likely by a factor of e, as a share of points
LEAST_YAW_BELIEF: Final = 1e-6  # in any yaw, before it is compared


class FacingBelief:
    """One person's yaw over time, 0 for facing the camera."""

    def __init__(self) -> None:
        self._believe(of_somebody_new())
        self._has_begun = False

    @property
    def likeliest_rad(self) -> float:
        """The yaw that is believed in most."""
        return float(YAWS_RAD[np.argmax(self._belief.sum(0))])

    def begin(self, pose: Pose, up_camera: Array) -> None:
        """From the yaw of a pose that is known."""
        yaw_rad = heading(pose.Rs[UPPER_TORSO], up_camera)
        near = np.exp(-0.5 * (wrapped(YAWS_RAD - yaw_rad) / KNOWN_SIGMA_RAD) ** 2)
        self._believe(normalised(np.tile(near, (len(RATES_RAD), 1))))
        self._has_begun = True

    def update(self, alike: Likeness, elapsed_s: float) -> None:
        """By what looks like what is seen, so long after the last frame."""
        frames = frames_in(elapsed_s)
        share = min(NEW_SHARE * frames, 1.0) if self._has_begun else 1.0
        told, self._has_begun = share * alike.yaw_log_likelihood(), True
        self._believe(normalised(turned_on(self._belief, frames) * np.exp(told)))

    def costs(self, Rs_camera_torso: Array, up_camera: Array) -> Array:
        """[M] what speaks against the yaws of torsos [M, 3, 3]."""
        yaws_rad = headings(Rs_camera_torso, up_camera)
        steps = (yaws_rad - YAWS_RAD[0]) * (N_YAWS / (2.0 * pi)) % N_YAWS
        whole = steps.astype(np.int64)
        before, share = whole % N_YAWS, steps - whole
        after = (before + 1) % N_YAWS
        return (1.0 - share) * self._costs[before] + share * self._costs[after]

    def _believe(self, belief: Array) -> None:
        log_belief = np.log(belief.sum(0) + LEAST_YAW_BELIEF)
        self._belief, self._costs = belief, YAW_COST * (log_belief.max() - log_belief)
