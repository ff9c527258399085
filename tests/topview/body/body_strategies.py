"""Random poses of the body."""

from __future__ import annotations

import numpy as np
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from topview.body.parts import PARTS


def rotations(count: int) -> st.SearchStrategy[np.ndarray]:
    """[count, 3, 3], any rotations."""
    return st.integers(0, 2**32 - 1).map(
        lambda seed: Rotation.from_quat(
            np.random.default_rng(seed).normal(size=(count, 4))
        ).as_matrix()
    )


body_rotations = rotations(len(PARTS))
