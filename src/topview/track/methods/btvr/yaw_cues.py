"""Cues to a torso's yaw beside its points: the way of walking, and a face in view (ours)."""

from __future__ import annotations

from collections import deque
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.filter.over_time import FRAME_S
from topview.geometry.rotations import horizontal, unit
from topview.track.evidence import Evidence
from topview.track.methods.btvr.yaw import YAWS_RAD
from topview.track.stances import facing

Array = NDArray[np.float64]

# All ours. The weights are log likelihoods of `FRAME_S`, for a direction that is the front itself;
# for any other yaw they are multiplied by the cosine between the direction and the front.
FACE_LOG_WEIGHT: Final = 0.05  # of the direction to the camera, while a face is seen
WALK_LOG_WEIGHT: Final = 0.1  # of the direction of walking
# Somebody walks whose head moves this far, in metres, within so many seconds.
WALK_M: Final = 0.35
WALK_WINDOW_S: Final = 14 / 30


class YawCues:
    """How likely each yaw is: people walk to their front, and a face looks at the camera."""

    def __init__(self) -> None:
        self._heads: deque[tuple[float, Array]] = deque()  # when, and [3] where

    def log_likelihood(self, evidence: Evidence, frames: float = 1.0) -> Array:
        """[N_YAWS] for `YAWS_RAD`, of what `frames` of `FRAME_S` tell; zeros without a cue."""
        front_camera = WALK_LOG_WEIGHT * self._walk(evidence)
        if evidence.face_share is not None:
            to_camera = -unit(evidence.head_camera)
            front_camera += FACE_LOG_WEIGHT * (2.0 * evidence.face_share - 1.0) * to_camera
        x, _, z = frames * facing(0.0, evidence.up_camera).T @ front_camera
        return x * np.sin(YAWS_RAD) + z * np.cos(YAWS_RAD)

    def _walk(self, evidence: Evidence) -> Array:
        """[3] unit vector along the way walked; zeros for who stands or is not seen."""
        if not evidence.head_is_seen:
            self._heads.clear()
            return np.zeros(3)
        self._heads.append((evidence.timestamp_s, evidence.head_camera))
        while evidence.timestamp_s - self._heads[0][0] > WALK_WINDOW_S + 0.1 * FRAME_S:
            self._heads.popleft()
        way = horizontal(evidence.head_camera - self._heads[0][1], evidence.up_camera)
        return unit(way) if np.linalg.norm(way) > WALK_M else np.zeros(3)
