"""Random rotations and poses for the laws of geometry."""

from __future__ import annotations

import numpy as np
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial.transform import Rotation

from topview.geometry.rotations import transform


def vectors(limit: float) -> st.SearchStrategy[np.ndarray]:
    """[3] with coordinates within +-limit."""
    return arrays(np.float64, 3, elements=st.floats(-limit, limit))


def rotations() -> st.SearchStrategy[np.ndarray]:
    """[3, 3], any rotation."""
    return vectors(np.pi).map(lambda v: Rotation.from_rotvec(v).as_matrix())


def rigid_motions(limit_m: float) -> st.SearchStrategy[np.ndarray]:
    """[4, 4], any rotation and a shift within +-limit_m."""
    return st.builds(transform, rotations(), vectors(limit_m))
