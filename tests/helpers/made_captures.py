"""Made-up captures, as `read_captures` takes them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

BONES = [
    "pelvis", "spine", "chest", "neck", "head", "upperarm_l", "forearm_l", "thigh_l", "shank_l",
    "upperarm_r", "forearm_r", "thigh_r", "shank_r",
]  # fmt: skip


def write_captures(path: Path, lengths: Sequence[int] = (40, 20), sway_rad: float = 0.3) -> Path:
    """An archive of captures of so many frames, 01_01, 01_02 and so on: people who hang their arms,
    and turn and sway at random, each axis by `sway_rad`."""
    rng, frames = np.random.default_rng(4), sum(lengths)
    down, up = [0.0, -1.0, 0.0], [0.0, 1.0, 0.0]
    directions = np.array([up if bone in BONES[:5] else down for bone in BONES])
    vectors = rng.normal(0.0, sway_rad, (frames * len(BONES), 3))
    quaternions = Rotation.from_rotvec(vectors).as_quat()
    np.savez(
        path,
        captures=np.array([f"01_{n:02d}" for n in range(1, len(lengths) + 1)]),
        lengths=np.array(lengths),
        bones=np.array(BONES),
        rotations_xyzw=quaternions.reshape(frames, len(BONES), 4).astype(np.float16),
        directions=np.repeat(directions[None], len(lengths), axis=0).astype(np.float32),
    )
    return path
