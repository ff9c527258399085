"""Front or back: an elliptic torso looks alike from both, so other things must tell (ours)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from topview.geometry.rotations import unit
from topview.track.upper_body.arms import Arm
from topview.track.upper_body.torso import Torso

Array = NDArray[np.float64]

# Ours.
STEP_M = 0.25  # a way this long, across the floor, tells where somebody walks to
SIDEWAYS = 0.6  # cosine between that way and the front; below it he steps aside
REACH_M = 0.2  # a palm this far before the torso, or behind it, tells where the front is
PALM_WEIGHT = 0.02  # of such a palm in each frame, against that of a step
SURE = 0.9  # votes that turn somebody round, and, the other way, the most that are remembered


class Facing:
    """Gathers votes on whether somebody faces where the torso's front is thought to be."""

    def __init__(self) -> None:
        self._votes = 0.0
        self._left_camera: Array | None = None

    def is_reversed(self, torso: Torso, arms: Sequence[Arm], up_camera: Array) -> bool:
        """True once the votes say that front and back are mixed up; they then start anew."""
        self._votes += self._step(torso, up_camera)
        for arm in arms:
            forward_m = float(arm.palm_torso[2])
            if abs(forward_m) > REACH_M and arm.is_found:
                self._votes += PALM_WEIGHT * np.sign(forward_m)
        self._votes = min(self._votes, 2.0 * SURE)
        if self._votes > -SURE:
            return False
        self._votes = 0.0
        return True

    def _step(self, torso: Torso, up_camera: Array) -> float:
        """The vote of a step: people walk to their front."""
        if self._left_camera is None:
            self._left_camera = torso.neck_camera
        way = torso.neck_camera - self._left_camera
        way = way - up_camera * (way @ up_camera)
        if np.linalg.norm(way) < STEP_M:
            return 0.0
        self._left_camera = torso.neck_camera
        cosine = float(unit(way) @ torso.R_camera_torso[:, 2])
        return cosine if abs(cosine) > SIDEWAYS else 0.0
