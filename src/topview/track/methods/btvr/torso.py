"""The torso as one elliptic cylinder, by basic top view re-projection (Sec. 5.1.1 - 5.1.4).

A hypothesis is a virtual view on the half sphere around the user: the direction in which the
cylinder's axis points, from the neck joint below the head. All views are scored, and their mean,
weighted by the score, is the axis. Seen along it, ellipses tell the yaw.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.body.model import BodyModel
from topview.geometry.rotations import rotations_from_angles, rotations_from_vectors, unit
from topview.records import check_range
from topview.score.utvr import Observed, UtvrTerms, score_hypotheses
from topview.track.evidence import Evidence
from topview.track.methods.btvr.torso_shape import NARROW, TorsoShape
from topview.track.methods.btvr.yaw import EllipseYaw, YawFilter
from topview.track.stances import facing

Array = NDArray[np.float64]

NO_PARTS: Final = np.empty((0, 15), np.float32)
GOLDEN_RAD: Final = np.pi * (3.0 - np.sqrt(5.0))

# All ours. Lengths are shares of the stature.
VIEW_REACH_RAD: Final = 0.8  # from the last axis to the farthest view
# Of a squared angle from upright in radians, in log f_bTVR: people stand more often than they bend.
# The second is added per share of the user's area that is hidden.
UPRIGHT_WEIGHT: Final = 1.0
OCCLUDED_UPRIGHT_WEIGHT: Final = 20.0
VIEW_SHARPNESS: Final = 8.0  # views are weighted by their f_bTVR to this negative power
LEAST_POINT_SHARE: Final = 0.08  # of the points that a torso shows, which a view must have
AXIS_SMOOTHING: Final = 0.5  # share of the last axis in the next one; it grows with occlusion


@dataclass(frozen=True, slots=True)
class TorsoSettings:
    """How the torso is searched.

    Attributes:
        views: that are scored in each frame, 1 to 10000; the time grows with them.
        tolerance_m: the T of Sec. 5.2.1, 0 to 1 metre.
        clothing_m: added to the radii, so that points on the clothes lie inside; 0 to 0.2 metres.
        shape: of the cylinder.
        best_view: whether the axis is the best view of the whole half sphere, by Eq. 5.1 alone, as
            printed. Else it is a mean of the views near the last axis, weighted by Eq. 5.1 without
            hidden pixels and by how upright they are, and smoothed over time.
        ellipse_alone: whether the yaw is that of the best ellipse in this frame, as printed; else a
            belief over all yaws tells it.
        is_coarse: whether views are scored at half the resolution.
        any_first_yaw: whether somebody new may face any way, and not the camera.

    Raises:
        InputError: a value out of range.
    """

    views: int = 180
    tolerance_m: float = 0.05
    clothing_m: float = 0.015
    shape: TorsoShape = NARROW
    best_view: bool = False
    ellipse_alone: bool = False
    is_coarse: bool = False
    any_first_yaw: bool = False

    def __post_init__(self) -> None:
        check_range(self, 1, 10_000, "views")
        check_range(self, 0.0, 1.0, "tolerance_m")
        check_range(self, 0.0, 0.2, "clothing_m")


@dataclass(frozen=True, slots=True, eq=False)
class Torso:
    """The torso in one frame.

    Attributes:
        neck_camera: [3] metres, the cylinder's upper end.
        R_camera_torso: [3, 3] y along the axis, x to the right shoulder, z to the front.
    """

    neck_camera: Array
    R_camera_torso: Array


class TorsoFilter:
    """One person's torso over time."""

    def __init__(self, settings: TorsoSettings, threads: int) -> None:
        self.settings = settings
        self.threads = threads
        self.torso: Torso | None = None
        self.yaw = (
            EllipseYaw(settings.shape)
            if settings.ellipse_alone
            else YawFilter(settings.any_first_yaw)
        )

    def update(self, model: BodyModel, evidence: Evidence, frames: float = 1.0) -> Torso:
        """The torso in the next frame, `frames` of `FRAME_S` later."""
        stature_m, shape = model.stature_m, self.settings.shape
        R_yaw = _about_y(self.yaw.yaw_rad)
        if self.settings.best_view:
            axis = self._best_axis(R_yaw, stature_m, evidence)
        else:
            axis = self._smoothed_axis(R_yaw, stature_m, evidence, frames)
        R = turned_to(axis, facing(0.0, evidence.up_camera))
        neck = self._necks((R @ R_yaw)[None], stature_m, evidence)[0]
        below_head = neck + shape.neck_behind * stature_m * (R @ R_yaw)[:, 2]
        points = (evidence.all_points_camera - below_head) @ R
        R = R @ _about_y(self.yaw.update(points, stature_m, shape.neck_behind, frames))
        self.torso = Torso(self._necks(R[None], stature_m, evidence)[0], R)
        return self.torso

    def _smoothed_axis(
        self, R_yaw: Array, stature_m: float, evidence: Evidence, frames: float
    ) -> Array:
        """[3] the mean of the views near the last axis, and what is left of the last one."""
        if self.torso is None:
            down = -evidence.up_camera
            middle = self._mean_axis(down, np.pi / 2, R_yaw, stature_m, evidence)
            return self._mean_axis(middle, VIEW_REACH_RAD, R_yaw, stature_m, evidence)
        last = self.torso.R_camera_torso[:, 1]
        axis = self._mean_axis(last, VIEW_REACH_RAD, R_yaw, stature_m, evidence)
        smoothing = AXIS_SMOOTHING**frames
        smoothing += (1.0 - smoothing) * evidence.hidden_share
        return unit(smoothing * last + (1.0 - smoothing) * axis)

    def _mean_axis(
        self, middle: Array, reach_rad: float, R_yaw: Array, stature_m: float, evidence: Evidence
    ) -> Array:
        """[3] the mean of the views around `middle`, weighted by their scores; `middle` itself
        without evidence."""
        axes = views_around(middle, self.settings.views, reach_rad)
        scores = self._scores(axes, R_yaw, stature_m, evidence)
        if not np.isfinite(scores).any():
            return middle
        logs = np.log(scores) + upright_costs(axes, evidence.up_camera, evidence.hidden_share)
        weights = np.exp(-VIEW_SHARPNESS * (logs - logs.min()))
        return unit(weights @ axes)

    def _best_axis(self, R_yaw: Array, stature_m: float, evidence: Evidence) -> Array:
        """[3] the best view of the half sphere; the last axis without evidence."""
        axes = views_around(-evidence.up_camera, self.settings.views, np.pi / 2)
        scores = self._scores(axes, R_yaw, stature_m, evidence)
        if np.isfinite(scores).any():
            return axes[scores.argmin()]
        return -evidence.up_camera if self.torso is None else self.torso.R_camera_torso[:, 1]

    def _scores(self, axes: Array, R_yaw: Array, stature_m: float, evidence: Evidence) -> Array:
        """[M] as `view_scores`, of cylinders along the axes."""
        Rs = turned_to(axes, facing(0.0, evidence.up_camera)) @ R_yaw
        return view_scores(
            Rs,
            self._necks(Rs, stature_m, evidence),
            stature_m,
            evidence.observed(self.settings.is_coarse),
            evidence.hidden_share,
            self.settings,
            self.threads,
        )

    def _necks(self, Rs: Array, stature_m: float, evidence: Evidence) -> Array:
        """[M, 3] neck joints below the head of torsos turned like `Rs`."""
        if not evidence.head_is_seen and self.torso is not None:
            return np.broadcast_to(self.torso.neck_camera, (len(Rs), 3))
        return necks_below(evidence.head_camera, Rs, stature_m, self.settings.shape)


def necks_below(head_camera: Array, Rs: Array, stature_m: float, shape: TorsoShape) -> Array:
    """[M, 3] neck joints below a head's centre [3] of torsos turned like `Rs` [M, 3, 3], metres."""
    offsets = shape.neck_below * Rs[:, :, 1] - shape.neck_behind * Rs[:, :, 2]
    return head_camera + stature_m * offsets


def view_scores(
    Rs: Array,
    necks_camera: Array,
    stature_m: float,
    observed: Observed,
    hidden_share: float,
    settings: TorsoSettings,
    threads: int,
) -> Array:
    """[M] f_bTVR (Eq. 5.1) of torsos, infinite without evidence.

    N_cyl of Eq. 5.2 counts all pixels of a hypothesis; where the views are averaged, all but the
    occluded ones, and views with few points have no evidence.

    Args:
        Rs, necks_camera: [M, 3, 3] `Rs_camera_torso` and [M, 3] metres.
        stature_m: of the person.
        observed: the scene, and the person's points.
        hidden_share: P_occl of Eq. 5.3.
        settings: of the search.
        threads: of the kernel.
    """
    shape = settings.shape
    terms = score_hypotheses(
        Rs,
        necks_camera + shape.ahead * stature_m * Rs[:, :, 2],
        shape.length * stature_m,
        stature_m * np.array(shape.semi_axes) + settings.clothing_m,
        observed,
        NO_PARTS,
        settings.tolerance_m,
        threads,
    )
    if settings.best_view:
        return np.where(terms.has_evidence, terms.btvr(hidden_share), np.inf)
    visible_share = 1.0 - terms.n_occluded / np.maximum(terms.n_pixels, 1)
    with np.errstate(invalid="ignore"):
        scores = terms.btvr(hidden_share) * visible_share
    return np.where(_has_enough(terms), scores, np.inf)


def upright_costs(axes: Array, up_camera: Array, hidden_share: float) -> Array:
    """[M] what is added to log f_bTVR of axes that are not upright."""
    weight = UPRIGHT_WEIGHT + OCCLUDED_UPRIGHT_WEIGHT * hidden_share
    return weight * np.arccos(np.clip(axes @ -up_camera, -1.0, 1.0)) ** 2


def _has_enough(terms: UtvrTerms) -> NDArray[np.bool_]:
    """[M] whether a view has enough of the points that a torso shows."""
    least = LEAST_POINT_SHARE * np.maximum(terms.n_pixels, 1)
    return terms.has_evidence & (terms.n_points > least)


def views_around(middle: Array, count: int, reach_rad: float) -> Array:
    """[count, 3] directions, evenly over a cap of the sphere around a direction."""
    k = np.arange(count) + 0.5
    along = 1.0 - k / count * (1.0 - np.cos(reach_rad))
    across = np.sqrt(1.0 - along**2)
    turns = GOLDEN_RAD * k
    local = np.stack([across * np.cos(turns), along, across * np.sin(turns)], axis=1)
    return local @ turned_to(middle, np.eye(3)).T


def turned_to(axes: Array, R: Array) -> Array:
    """[..., 3, 3] the [3, 3] rotation `R`, turned by the least angle until its y points along
    `axes` [..., 3]."""
    y = R[:, 1]
    cross = np.cross(y, axes)
    sine, cosine = np.linalg.norm(cross, axis=-1, keepdims=True), axes @ y
    return rotations_from_vectors(unit(cross) * np.arctan2(sine, cosine[..., None])) @ R


def _about_y(turn_rad: float) -> Array:
    return rotations_from_angles(np.array([0.0, turn_rad, 0.0]))
