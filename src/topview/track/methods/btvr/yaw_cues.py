"""Cues to a torso's yaw beside its ellipses: the head, which is before the trunk, the feet, which
are before the shins, the way of walking, and a face in view (ours)."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.filter.over_time import FRAME_S
from topview.filter.turning import N_YAWS, YAWS_RAD
from topview.geometry.rotations import horizontal, unit
from topview.track.evidence import Evidence
from topview.track.methods.btvr.ellipses import fit_ellipses
from topview.track.methods.btvr.yaw import (
    FREE_CENTRE_SIGMA_M,
    LEAST_SECTION_POINTS,
    TRUNK_SECTION,
    Section,
    points_of,
)
from topview.track.stances import facing

Array = NDArray[np.float64]

# All ours. The weights are log likelihoods of `FRAME_S`, for a direction that is the front itself;
# for any other yaw they are multiplied by the cosine between the direction and the front.
FACE_LOG_WEIGHT: Final = 0.05  # of the direction to the camera, while a face is seen
WALK_LOG_WEIGHT: Final = 0.1  # of the direction of walking
# Somebody walks whose head moves this far, in metres, within so many seconds.
WALK_M: Final = 0.35
WALK_WINDOW_S: Final = 14 / 30

MOST_SIGMAS: Final = 3.0  # what is further off is wrong altogether
STILL_SHARE: Final = 0.1  # of the log likelihood in `FRAME_S`: frames in a row err alike

NO_WAY: Final = np.zeros(3)


@dataclass(frozen=True, slots=True)
class Before:
    """How far a part of the body is before another one, in shares of the stature.

    Attributes:
        mean: of who stands sideways to the camera.
        towards_camera: of who faces the camera so much less, of who turns the back to it so much
            more: the near side is what is seen.
        sigma: standard deviation.
    """

    mean: float
    towards_camera: float
    sigma: float


# The head before the trunk (`head_before`): `scripts/fit_head_before.py` on 27 recordings of
# rendered people, one, sit and turn of even seeds 0 to 16, found 0.031, 0.023 and a deviation of
# 0.035, more among people than among frames.
HEAD_FORWARD: Final = Before(0.03, 0.02, 0.045)
# The feet before the shins (`feet_before`): the same script on seeds 0 to 9 of one, sit and turn
# found 0.025, 0.001 and a deviation of 0.039.
FEET_FORWARD: Final = Before(0.025, 0.0, 0.04)
# Heights above the floor, in shares of the stature, below and between which feet and shins are.
FEET_BELOW: Final = 0.05
SHINS: Final = (0.07, 0.17)
BELOW_HEAD: Final = Section(0.17, 0.40, TRUNK_SECTION.semi_axes, 0.2)


class YawCues:
    """How likely each yaw is: the head is before the trunk, people walk to their front, a face
    looks at the camera and, where feet are looked at, they are before the shins."""

    def __init__(self, with_feet: bool = False) -> None:
        self._with_feet = with_feet
        self._heads: deque[tuple[float, Array]] = deque()  # when, and [3] where

    def log_likelihood(self, evidence: Evidence, stature_m: float, frames: float = 1.0) -> Array:
        """[N_YAWS] for `YAWS_RAD`, of what `frames` of `FRAME_S` tell; zeros without a cue."""
        front_camera = WALK_LOG_WEIGHT * self._walk(evidence)
        if evidence.face_share is not None:
            to_camera = -unit(evidence.head_camera)
            front_camera += FACE_LOG_WEIGHT * (2.0 * evidence.face_share - 1.0) * to_camera
        x, _, z = frames * facing(0.0, evidence.up_camera).T @ front_camera
        cues = x * np.sin(YAWS_RAD) + z * np.cos(YAWS_RAD)
        share = min(STILL_SHARE * frames, 1.0)
        cues = cues + share * _front_by(head_before(evidence, stature_m), HEAD_FORWARD)
        if not self._with_feet:
            return cues
        return cues + share * _front_by(feet_before(evidence, stature_m), FEET_FORWARD)

    def _walk(self, evidence: Evidence) -> Array:
        """[3] unit vector along the way walked; zeros for who stands or is not seen."""
        if not evidence.head_is_seen:
            self._heads.clear()
            return NO_WAY
        self._heads.append((evidence.timestamp_s, evidence.head_camera))
        while evidence.timestamp_s - self._heads[0][0] > WALK_WINDOW_S + 0.1 * FRAME_S:
            self._heads.popleft()
        way = horizontal(evidence.head_camera - self._heads[0][1], evidence.up_camera)
        return unit(way) if np.linalg.norm(way) > WALK_M else NO_WAY


def head_before(evidence: Evidence, stature_m: float) -> Array | None:
    """[N_YAWS] how far the head's centre is before the trunk, if the front is that way; None where
    the head, or the trunk, is not seen.

    The trunk is an ellipse of the yaw, moved onto the points of a section below the head, seen from
    above. A share of the stature.
    """
    if not evidence.head_is_seen:
        return None
    points = (evidence.all_points_camera - evidence.head_camera) @ facing(0.0, evidence.up_camera)
    chosen = points_of(points, stature_m, BELOW_HEAD)
    if len(chosen) < LEAST_SECTION_POINTS:
        return None
    half = N_YAWS // 2  # opposite yaws have the same ellipse
    semi_axes_m, anywhere = stature_m * np.array(BELOW_HEAD.semi_axes), np.zeros((half, 2))
    _, centres = fit_ellipses(
        chosen, semi_axes_m, YAWS_RAD[:half], anywhere, centre_sigma_m=FREE_CENTRE_SIGMA_M
    )
    fronts = np.stack([np.sin(YAWS_RAD), np.cos(YAWS_RAD)], axis=1)
    return -(np.tile(centres, (2, 1)) * fronts).sum(1) / stature_m


def feet_before(evidence: Evidence, stature_m: float) -> Array | None:
    """[N_YAWS] how far the points of the feet are before those of the shins, if the front is that
    way; None where either, or the floor, is not seen. A share of the stature."""
    if not evidence.floor.any():
        return None
    points = evidence.all_points_camera
    heights = evidence.above_floor_m(points) / stature_m
    feet = points[heights < FEET_BELOW]
    shins = points[(heights > SHINS[0]) & (heights < SHINS[1])]
    if min(len(feet), len(shins)) < LEAST_SECTION_POINTS:
        return None
    x, _, z = (feet.mean(0) - shins.mean(0)) @ facing(0.0, evidence.up_camera) / stature_m
    return x * np.sin(YAWS_RAD) + z * np.cos(YAWS_RAD)


def _front_by(before: Array | None, law: Before) -> Array:
    """[N_YAWS] log likelihoods of how far something is before something else; 0 for the likelier
    one of opposite yaws, as that is all that it tells."""
    if before is None:
        return np.zeros(N_YAWS)
    off = (before - law.mean + law.towards_camera * np.cos(YAWS_RAD)) / law.sigma
    told = -0.5 * np.minimum(off**2, MOST_SIGMAS**2)
    return told - np.maximum(told, np.roll(told, N_YAWS // 2))
