"""Tracked frames with made people."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from topview import JOINT_NAMES, PART_NAMES
from topview.skeletons import About, TrackedFrame

ABOUT = About(JOINT_NAMES, PART_NAMES, {"recording": "made", "seed": 3})


def frames_with(who: Sequence[Sequence[int]], about: About = ABOUT) -> list[TrackedFrame]:
    """A frame for each list of ids, with random numbers in all else."""
    rng = np.random.default_rng(0)
    heights_m = {i: rng.uniform(1.5, 1.9) for i in range(100)}
    frames = []
    for f, ids in enumerate(who):
        people = np.zeros(len(ids), about.person_type)
        people["id"] = ids
        people["height_m"] = [heights_m[i] for i in ids]
        for name in ("joints_camera", "joint_confidence", "Ts_camera_part", "joint_covariance_m2"):
            people[name] = rng.random(people[name].shape)
        people["joint_state"] = rng.integers(1, 6, people["joint_state"].shape)
        floor = (0.0, -1.0, 0.0, 1.0 + f) if f % 3 == 1 else None
        frames.append(TrackedFrame(f, f / 30.0, f"{f:06d}.png", people, floor))
    return frames
