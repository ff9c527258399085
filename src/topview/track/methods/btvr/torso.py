"""The torso as one elliptic cylinder, by basic top view re-projection (Sec. 5.1.1 - 5.1.4).

A hypothesis is a virtual view on the half sphere around the user: the direction in which the
cylinder's axis points, from the neck joint below the head. All views are scored, and their mean,
weighted by the score, is the axis. Seen along it, ellipses tell the yaw.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from topview.body.model import BodyModel
from topview.geometry.rotations import rotations_from_angles, rotations_from_vectors, unit
from topview.score.utvr import UtvrTerms, score_hypotheses
from topview.track.evidence import Evidence, columns
from topview.track.methods.btvr.turning import TurnFilter, TurnSettings
from topview.track.stances import facing

Array = NDArray[np.float64]

NO_PARTS = np.empty((0, 15), np.float32)
GOLDEN_RAD = np.pi * (3.0 - np.sqrt(5.0))


@dataclass(frozen=True, slots=True)
class TorsoSettings:
    """Ours where not said otherwise; lengths as shares of the stature, radians.

    Attributes:
        views: how many are scored.
        reach_rad: they lie this near to the last axis; those of somebody new on the half sphere.
        radii: of the cylinder whose points are counted: without the shoulders, so that hanging arms
            stay outside.
        length: of that cylinder.
        ahead: by how much it stands before the neck joint, so that the chest lies inside.
        clothing_m: added to the radii for the same reason.
        tolerance_m: the T of Sec. 5.2.1.
        upright_weight: of a squared angle from upright, in log f_bTVR: people stand more often than
            they bend.
        hidden_weight: the same per share of the user's area that is hidden.
        sharpness: views are weighted by their f_bTVR to this negative power.
        least_share: a view needs so many of the points that a torso shows.
        smoothing: share of the last axis in the next one; it grows to all of it the more is hidden.
        neck_below, neck_behind: the neck joint from the head's centre, along the axis and to the
            back: means of the simulator's bodies, standing or leaning.
        turn: how yaw is told.
    """

    views: int = 180
    reach_rad: float = 0.8
    radii: tuple[float, float] = (0.072, 0.060)
    length: float = 0.33
    ahead: float = 0.06
    clothing_m: float = 0.015
    tolerance_m: float = 0.05
    upright_weight: float = 1.0
    hidden_weight: float = 20.0
    sharpness: float = 8.0
    least_share: float = 0.08
    smoothing: float = 0.5
    neck_below: float = 0.09
    neck_behind: float = 0.045
    turn: TurnSettings = field(default_factory=TurnSettings)


@dataclass(frozen=True, slots=True, eq=False)
class Torso:
    """The torso in one frame.

    Attributes:
        neck_camera: [3] metres, the cylinder's upper end.
        R_camera_torso: [3, 3] y along the axis, x to the right shoulder, z to the front.
        score: f_bTVR of the best view, infinite without evidence.
    """

    neck_camera: Array
    R_camera_torso: Array
    score: float


class TorsoFilter:
    """One person's torso over time."""

    def __init__(self, settings: TorsoSettings, threads: int) -> None:
        self.settings = settings
        self.threads = threads
        self.torso: Torso | None = None
        self.turning = TurnFilter(settings.turn)

    def update(self, model: BodyModel, evidence: Evidence) -> Torso:
        """The torso in the next frame."""
        s, stature_m = self.settings, model.stature_m
        turn = _about_y(self.turning.turn_rad)
        upright = facing(0.0, evidence.up_camera)
        if self.torso is None:
            down = -evidence.up_camera
            middle, _ = self._axis(down, np.pi / 2, turn, stature_m, evidence)
            axis, score = self._axis(middle, s.reach_rad, turn, stature_m, evidence)
        else:
            last = self.torso.R_camera_torso[:, 1]
            axis, score = self._axis(last, s.reach_rad, turn, stature_m, evidence)
            hold = s.smoothing + (1.0 - s.smoothing) * evidence.hidden_share
            axis = unit(hold * last + (1.0 - hold) * axis)
        R = _turned_to(axis, upright)
        neck = self._necks((R @ turn)[None], stature_m, evidence)[0]
        below_head = neck + s.neck_behind * stature_m * (R @ turn)[:, 2]
        points = (evidence.all_points_camera - below_head) @ R
        R = R @ _about_y(self.turning.update(points, stature_m, s.neck_behind))
        self.torso = Torso(self._necks(R[None], stature_m, evidence)[0], R, score)
        return self.torso

    def _axis(
        self, middle: Array, reach_rad: float, turn: Array, stature_m: float, evidence: Evidence
    ) -> tuple[Array, float]:
        """[3] the mean of the views around `middle`, each weighted by its score, and the least
        f_bTVR; `middle` without any evidence."""
        s = self.settings
        axes = views_around(middle, s.views, reach_rad)
        Rs = _turned_to(axes, facing(0.0, evidence.up_camera)) @ turn
        scores = self._scores(Rs, stature_m, evidence)
        if not np.isfinite(scores).any():
            return middle, np.inf
        upright_weight = s.upright_weight + s.hidden_weight * evidence.hidden_share
        off = np.arccos(np.clip(axes @ -evidence.up_camera, -1.0, 1.0))
        logs = np.log(scores) + upright_weight * off**2
        weights = np.exp(-s.sharpness * (logs - logs.min()))
        return unit(weights @ axes), float(scores.min())

    def _scores(self, Rs: Array, stature_m: float, evidence: Evidence) -> Array:
        """[M] f_bTVR (Eq. 5.1), infinite without evidence.

        N_cyl of Eq. 5.2 counts what the camera could see of a hypothesis, so without the pixels
        that something hides.
        """
        s = self.settings
        terms = score_hypotheses(
            Rs,
            self._necks(Rs, stature_m, evidence) + s.ahead * stature_m * Rs[:, :, 2],
            s.length * stature_m,
            stature_m * np.array(s.radii) + s.clothing_m,
            columns(evidence.all_points_camera),
            evidence.view,
            NO_PARTS,
            s.tolerance_m,
            self.threads,
        )
        visible_share = 1.0 - terms.n_occluded / np.maximum(terms.n_pixels, 1)
        with np.errstate(invalid="ignore"):
            scores = terms.btvr(evidence.hidden_share) * visible_share
        return np.where(self._has_evidence(terms), scores, np.inf)

    def _has_evidence(self, terms: UtvrTerms) -> NDArray[np.bool_]:
        least = self.settings.least_share * np.maximum(terms.n_pixels, 1)
        return terms.has_evidence & (terms.n_points > least)

    def _necks(self, Rs: Array, stature_m: float, evidence: Evidence) -> Array:
        """[M, 3] neck joints below the head of torsos turned like `Rs`."""
        s = self.settings
        if not evidence.head_is_seen and self.torso is not None:
            return np.broadcast_to(self.torso.neck_camera, (len(Rs), 3))
        offsets = s.neck_below * Rs[:, :, 1] - s.neck_behind * Rs[:, :, 2]
        return evidence.head_camera + stature_m * offsets


def views_around(middle: Array, count: int, reach_rad: float) -> Array:
    """[count, 3] directions, evenly over a cap of the sphere around a direction."""
    k = np.arange(count) + 0.5
    along = 1.0 - k / count * (1.0 - np.cos(reach_rad))
    across = np.sqrt(1.0 - along**2)
    turns = GOLDEN_RAD * k
    local = np.stack([across * np.cos(turns), along, across * np.sin(turns)], axis=1)
    return local @ _turned_to(middle, np.eye(3)).T


def _turned_to(axes: Array, R: Array) -> Array:
    """[..., 3, 3] the rotation `R`, turned by the least angle until its y points along `axes`."""
    y = R[:, 1]
    cross = np.cross(y, axes)
    sine, cosine = np.linalg.norm(cross, axis=-1, keepdims=True), axes @ y
    return rotations_from_vectors(unit(cross) * np.arctan2(sine, cosine[..., None])) @ R


def _about_y(turn_rad: float) -> Array:
    return rotations_from_angles(np.array([0.0, turn_rad, 0.0]))
