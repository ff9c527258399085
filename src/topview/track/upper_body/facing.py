"""What else than its points tells where a torso faces: a face that looks at the camera (ours)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from topview.geometry.rotations import unit
from topview.track.evidence import Evidence
from topview.track.stances import facing
from topview.track.upper_body.turning import TURNS_RAD

Array = NDArray[np.float64]

FACE_WEIGHT = 0.05  # ours, of one frame: in a logarithm, times the cosine from front to camera


def facing_log_likelihood(evidence: Evidence) -> Array:
    """[N_TURNS] for `TURNS_RAD`, 0 where no colours tell."""
    if evidence.face_share is None:
        return np.zeros(len(TURNS_RAD))
    to_camera = -unit(evidence.head_camera)
    x, _, z = facing(0.0, evidence.up_camera).T @ to_camera
    weight = FACE_WEIGHT * (2.0 * evidence.face_share - 1.0)
    return weight * (x * np.sin(TURNS_RAD) + z * np.cos(TURNS_RAD))
