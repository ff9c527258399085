"""The hypotheses of one part that are kept from frame to frame, and what is made of many."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import cos
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.geometry.rotations import unit
from topview.track.methods.btvr.torso import VIEW_SHARPNESS

Array = NDArray[np.float64]

# Of an upper limb that is judged together with the part below it: hypotheses that point elsewhere
# by this angle at least, and how many of them. Ours.
ELSEWHERE_RAD: Final = 0.4
MOST_ELSEWHERE: Final = 4


@dataclass(frozen=True, slots=True, eq=False)
class Particles:
    """The N best of one part, best first.

    Attributes:
        Rs: [N, 3, 3] `Rs_camera_part`.
        scores: [N] f_uTVR, lower is better.
        spread: how wide to search around them, 1 while there is evidence.
    """

    Rs: Array
    scores: Array
    spread: float

    def turned(self, R: Array) -> Particles:
        """All turned in their own frames."""
        return replace(self, Rs=self.Rs @ R)

    def headed_by(self, R: Array, most: int) -> Particles:
        """One before all others, `most` altogether; it becomes a parent as often as the best."""
        Rs = np.concatenate([R[None], self.Rs])[:most]
        return replace(self, Rs=Rs, scores=np.append(self.scores.min(), self.scores)[:most])

    def with_one(self, R: Array) -> Particles:
        """One more, which becomes a parent as often as the best."""
        Rs, scores = np.concatenate([self.Rs, R[None]]), np.append(self.scores, self.scores.min())
        return replace(self, Rs=Rs, scores=scores)


def turns_rad(R: Array, Rs: Array) -> Array:
    """[M] how far rotations [M, 3, 3] are turned from `R` about its y."""
    turns = R.T @ Rs
    return np.arctan2(turns[:, 0, 2] - turns[:, 2, 0], turns[:, 0, 0] + turns[:, 2, 2])


def elsewhere(R: Array, Rs: Array) -> Array:
    """[K, 3, 3] a rotation, and those of [M, 3, 3] that point elsewhere than it and each other."""
    chosen = [R]
    is_elsewhere = np.ones(len(Rs), np.bool_)
    while len(chosen) < MOST_ELSEWHERE:
        is_elsewhere &= Rs[:, :, 1] @ chosen[-1][:, 1] < cos(ELSEWHERE_RAD)
        if not is_elsewhere.any():
            break
        chosen.append(Rs[is_elsewhere.argmax()])
    return np.array(chosen)


def mean_rotation(Rs: Array, scores: Array) -> Array:
    """[3, 3] the mean of rotations [M, 3, 3] of one part, weighted by their scores."""
    weights = (scores.min() / scores) ** VIEW_SHARPNESS
    y = unit(weights @ Rs[:, :, 1])[None]
    return frames_of(across((weights @ Rs[:, :, 0])[None], y), y)[0]


def across(xs: Array, ys: Array) -> Array:
    """[M, 3] the components of `xs` perpendicular to the unit vectors `ys`, as unit vectors."""
    return unit(xs - ys * (xs * ys).sum(1, keepdims=True))


def frames_of(xs: Array, ys: Array) -> Array:
    """[M, 3] axes x and y to [M, 3, 3] rotations."""
    return np.stack([xs, ys, np.cross(xs, ys)], axis=2)
