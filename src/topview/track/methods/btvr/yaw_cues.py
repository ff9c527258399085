"""Cues to a torso's yaw beside its ellipses: the head, which is before the trunk, the way of
walking, and a face in view (ours)."""

from __future__ import annotations

from collections import deque
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

# How far a head is before the trunk (`head_before`), in shares of the stature: of who faces the
# camera `TOWARDS_CAMERA` less, of who turns the back to it so much more: the near side is what is
# seen. `scripts/fit_head_before.py` on 27 recordings of rendered people, one, sit and turn of even
# seeds 0 to 16, found 0.031, 0.023 and a deviation of 0.035, more among people than among frames.
HEAD_BEFORE: Final = 0.03
TOWARDS_CAMERA: Final = 0.02
HEAD_SIGMA: Final = 0.045
MOST_HEAD_SIGMAS: Final = 3.0  # an ellipse that is further off is wrong altogether
HEAD_SHARE: Final = 0.1  # of the log likelihood in `FRAME_S`: frames in a row err alike
BELOW_HEAD: Final = Section(0.17, 0.40, TRUNK_SECTION.semi_axes, 0.2)


class YawCues:
    """How likely each yaw is: the head is before the trunk, people walk to their front, and a face
    looks at the camera."""

    def __init__(self) -> None:
        self._heads: deque[tuple[float, Array]] = deque()  # when, and [3] where

    def log_likelihood(self, evidence: Evidence, stature_m: float, frames: float = 1.0) -> Array:
        """[N_YAWS] for `YAWS_RAD`, of what `frames` of `FRAME_S` tell; zeros without a cue."""
        front_camera = WALK_LOG_WEIGHT * self._walk(evidence)
        if evidence.face_share is not None:
            to_camera = -unit(evidence.head_camera)
            front_camera += FACE_LOG_WEIGHT * (2.0 * evidence.face_share - 1.0) * to_camera
        x, _, z = frames * facing(0.0, evidence.up_camera).T @ front_camera
        cues = x * np.sin(YAWS_RAD) + z * np.cos(YAWS_RAD)
        return cues + min(HEAD_SHARE * frames, 1.0) * _front_by_head(evidence, stature_m)

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


def _front_by_head(evidence: Evidence, stature_m: float) -> Array:
    """[N_YAWS] log likelihoods of where the head is; 0 for the likelier one of opposite yaws, as
    that is all that it tells."""
    before = head_before(evidence, stature_m)
    if before is None:
        return np.zeros(N_YAWS)
    off = (before - HEAD_BEFORE + TOWARDS_CAMERA * np.cos(YAWS_RAD)) / HEAD_SIGMA
    told = -0.5 * np.minimum(off**2, MOST_HEAD_SIGMAS**2)
    return told - np.maximum(told, np.roll(told, N_YAWS // 2))
