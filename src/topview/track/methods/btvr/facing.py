"""What else than its points tells where a torso faces: walking, and a face in view (ours)."""

from __future__ import annotations

from collections import deque

import numpy as np
from numpy.typing import NDArray

from topview.geometry.rotations import unit
from topview.track.evidence import Evidence
from topview.track.methods.btvr.turning import TURNS_RAD
from topview.track.stances import facing

Array = NDArray[np.float64]

# Ours. Logarithms, from one frame, times the cosine between a direction and the front.
FACE_WEIGHT = 0.05  # of the direction to the camera, for a face that is seen to look there
WALK_WEIGHT = 0.1  # of the way of somebody who walks
WALK_FRAMES, WALK_M = 15, 0.35  # somebody whose head gets so far in so many frames walks


class Facing:
    """Where somebody is likely to face: people walk to their front."""

    def __init__(self) -> None:
        self._heads_camera: deque[Array] = deque(maxlen=WALK_FRAMES)

    def log_likelihood(self, evidence: Evidence) -> Array:
        """[N_TURNS] for `TURNS_RAD`, 0 where nothing tells."""
        front_camera = WALK_WEIGHT * self._way(evidence)
        if evidence.face_share is not None:
            to_camera = -unit(evidence.head_camera)
            front_camera += FACE_WEIGHT * (2.0 * evidence.face_share - 1.0) * to_camera
        x, _, z = facing(0.0, evidence.up_camera).T @ front_camera
        return x * np.sin(TURNS_RAD) + z * np.cos(TURNS_RAD)

    def _way(self, evidence: Evidence) -> Array:
        """[3] where somebody walks to; zeros for those who stand, or are not seen."""
        if not evidence.head_is_seen:
            self._heads_camera.clear()
            return np.zeros(3)
        self._heads_camera.append(evidence.head_camera)
        way = evidence.head_camera - self._heads_camera[0]
        way = way - evidence.up_camera * (way @ evidence.up_camera)
        return unit(way) if np.linalg.norm(way) > WALK_M else np.zeros(3)
