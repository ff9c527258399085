"""The torso as one elliptic cylinder, by basic top view re-projection (Sec. 5.1.1 - 5.1.3).

A hypothesis is a virtual view on the half sphere around the user: the direction in which the
cylinder's axis points. The points of the best view, seen along that axis, are where an ellipse of
the cylinder's size is fitted: it tells where the cylinder is, and its yaw.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from topview.body.model import HEAD_CENTRE, BodyModel
from topview.body.parts import HEAD, LEFT_UPPER_ARM, PARTS, RIGHT_UPPER_ARM, UPPER_TORSO
from topview.filter.particles import importance_weights, n_best, systematic_resample
from topview.geometry.rotations import (
    rotations_from_angles,
    rotations_from_vectors,
    unit,
    vectors_from_rotations,
)
from topview.score.utvr import UtvrTerms, score_hypotheses
from topview.track.evidence import Evidence, columns
from topview.track.stances import facing
from topview.track.upper_body.cylinder_fit import FitSettings, FittedCylinder, fit_cylinder

Array = NDArray[np.float64]

MAX_FIT_POINTS = 600  # ours: more did not make the fit better
NO_PARTS = np.empty((0, 15), np.float32)


@dataclass(frozen=True, slots=True)
class TorsoSettings:
    """Ours where not said otherwise; metres, radians.

    Attributes:
        hypotheses: virtual views in each round.
        rounds: of sampling and evaluation, every one half as wide as the last.
        sigma_rad: pitch and roll of the first round's views around the kept ones.
        kept: views that go on to the next round and frame (Sec. 6.1.3: 5 for the torso).
        averaged, sharpness: so many of the best views make the torso's axis, each weighted by its
            score to this power.
        grid_step_rad, grid_pitch_rad, grid_roll_rad: the grid over the half sphere, searched when
            somebody is new or lost.
        clothing_m: added to the radii, so that the points on the surface lie inside.
        tolerance_m: the T of Sec. 5.2.1.
        turn_weight: of a squared turn away from the axis that is held to, in log f_bTVR.
        hidden_turn_weight: the same per share of the user's area that is hidden.
        hidden_hold: how much more firmly the fit is held, per share of that area.
        forgetting: what is held to follows the torso, in each frame, by the share of the area that
            is not hidden, to this power.
        lost_score: a best view with a higher f_bTVR has lost the torso.
        no_evidence: with no better view than this the torso stays as it is held to be.
        least_share: with fewer of the points that a torso shows, it keeps its pose.
        fit_margin: points within so many times the cylinder's radii take part in the fit.
        turns_rad: turns from the last yaw at which the fit starts.
        start_turns_rad: the same for somebody new, from facing the camera.
        fit: of the cylinder.
    """

    hypotheses: int = 150
    rounds: int = 2
    sigma_rad: float = 0.15
    kept: int = PARTS[UPPER_TORSO].n_best
    averaged: int = 20
    sharpness: float = 8.0
    grid_step_rad: float = 0.2
    grid_pitch_rad: tuple[float, float] = (-1.6, 0.6)
    grid_roll_rad: tuple[float, float] = (-1.2, 1.2)
    clothing_m: float = 0.015
    tolerance_m: float = 0.05
    turn_weight: float = 2.0
    hidden_turn_weight: float = 200.0
    hidden_hold: float = 8.0
    forgetting: float = 4.0
    lost_score: float = 4.0
    no_evidence: float = 6.0
    least_share: float = 0.08
    fit_margin: float = 1.25
    turns_rad: tuple[float, ...] = (0.0,)
    start_turns_rad: tuple[float, ...] = (0.0, -0.7, 0.7, -1.4, 1.4)
    fit: FitSettings = field(default_factory=FitSettings)


@dataclass(frozen=True, slots=True, eq=False)
class Torso:
    """The torso in one frame.

    Attributes:
        neck_camera: [3] metres, the cylinder's upper end.
        R_camera_torso: [3, 3] y along the axis, x to the right shoulder, z to the front.
        score: f_bTVR of its view, infinite without evidence.
    """

    neck_camera: Array
    R_camera_torso: Array
    score: float


@dataclass(frozen=True, slots=True, eq=False)
class Size:
    """The cylinder of somebody's torso: its semi-axes end at the shoulder joints and at the chest.

    Attributes:
        length_m: neck joint to hips.
        radii_m: [2] along x and z.
        to_neck_m: from the head's centre to the neck joint.
        shoulder_drop_m: from the neck joint down to the height of the shoulder joints.
    """

    length_m: float
    radii_m: Array
    to_neck_m: float
    shoulder_drop_m: float

    @classmethod
    def of(cls, model: BodyModel) -> Size:
        left, right = model.joints_parent[LEFT_UPPER_ARM], model.joints_parent[RIGHT_UPPER_ARM]
        return cls(
            float(model.lengths_m[1:3].sum()),
            np.array([(right[0] - left[0]) / 2, model.radii_m[UPPER_TORSO, 1]]),
            float((1.0 - HEAD_CENTRE) * model.lengths_m[HEAD]),
            float(right[1]),
        )


class TorsoFilter:
    """One person's torso over time: a particle filter over virtual views."""

    def __init__(self, settings: TorsoSettings, threads: int) -> None:
        self.settings = settings
        self.threads = threads
        self.torso: Torso | None = None
        self._Rs = np.empty((0, 3, 3))
        self._aside = np.zeros(2)
        self._held = np.eye(3)

    def update(self, model: BodyModel, evidence: Evidence, rng: np.random.Generator) -> Torso:
        """The torso in the next frame."""
        size = Size.of(model)
        if self.torso is None:
            upright = facing(0.0, evidence.up_camera)
            self.torso = Torso(_necks(upright[None], size, evidence)[0], upright, np.inf)
            self._held = upright
            self.torso = self._found(self.torso, size, evidence, rng, is_new=True)
        else:
            found = self._found(self.torso, size, evidence, rng)
            if found.score > self.settings.lost_score and evidence.hidden_share < 0.3:
                again = self._found(self.torso, size, evidence, rng, is_new=True)
                found = again if again.score < found.score else found
            self.torso = found
        share = (1.0 - evidence.hidden_share) ** self.settings.forgetting
        turn = vectors_from_rotations(self._held.T @ self.torso.R_camera_torso)
        self._held = self._held @ rotations_from_vectors(share * turn)
        return self.torso

    def turn_round(self) -> None:
        """Front and back look alike from above: swap them."""
        assert self.torso is not None
        turn = np.diag([-1.0, 1.0, -1.0])
        torso = self.torso
        self.torso = Torso(torso.neck_camera, torso.R_camera_torso @ turn, torso.score)
        self._Rs, self._aside, self._held = self._Rs @ turn, -self._aside, self._held @ turn

    def _found(
        self,
        last: Torso,
        size: Size,
        evidence: Evidence,
        rng: np.random.Generator,
        is_new: bool = False,
    ) -> Torso:
        """Sample and score views, take the mean of the best, and fit the ellipse in it."""
        s = self.settings
        if is_new:
            Rs = self._grid(evidence)
            self._aside = np.zeros(2)
        else:
            Rs = np.concatenate([last.R_camera_torso[None], self._Rs])
        scores = self._scores(Rs, size, evidence, None if is_new else last)
        for halvings in range(s.rounds):
            drawn = self._drawn(Rs, scores, s.sigma_rad / 2**halvings, rng)
            Rs = np.concatenate([Rs, drawn])
            scores = np.concatenate(
                [scores, self._scores(drawn, size, evidence, None if is_new else last)]
            )
            best = n_best(scores, s.averaged)
            Rs, scores = Rs[best], scores[best]
        if scores[0] > s.no_evidence:
            held = self._held[None]
            return Torso(self._origins(held, size, evidence)[0], held[0], np.inf)
        self._Rs = Rs[: s.kept]
        R = _mean(Rs, scores, s.sharpness)
        return self._fitted(R, float(scores[0]), size, evidence, is_new)

    def _grid(self, evidence: Evidence) -> Array:
        """[M, 3, 3] views all over the half sphere, of somebody who faces the camera."""
        s = self.settings
        pitch = np.arange(*s.grid_pitch_rad, s.grid_step_rad)
        roll = np.arange(*s.grid_roll_rad, s.grid_step_rad)
        angles = np.stack([a.ravel() for a in np.meshgrid(pitch, [0.0], roll)], axis=1)
        return facing(0.0, evidence.up_camera) @ rotations_from_angles(angles)

    def _drawn(self, Rs: Array, scores: Array, sigma_rad: float, rng: np.random.Generator) -> Array:
        """[M, 3, 3] views around the best ones."""
        s = self.settings
        best = n_best(scores, s.kept)
        parents = systematic_resample(importance_weights(scores[best]), s.hypotheses, rng)
        turns = np.zeros((s.hypotheses, 3))
        turns[:, [0, 2]] = sigma_rad * rng.standard_normal((s.hypotheses, 2))
        return Rs[best][parents] @ rotations_from_angles(turns)

    def _origins(self, Rs: Array, size: Size, evidence: Evidence) -> Array:
        """[M, 3] upper ends of cylinders turned like `Rs`: below the head, and aside of it by as
        much as the last fit said."""
        if not evidence.head_is_seen and self.torso is not None:
            return np.broadcast_to(self.torso.neck_camera, (len(Rs), 3))
        return _necks(Rs, size, evidence) + Rs[:, :, [0, 2]] @ self._aside

    def _scores(self, Rs: Array, size: Size, evidence: Evidence, last: Torso | None) -> Array:
        """[M] f_bTVR (Eq. 5.1), times what makes a sudden turn less likely.

        N_cyl of Eq. 5.2 counts what the camera could see of a hypothesis, so without the pixels
        that something hides.
        """
        s = self.settings
        terms = score_hypotheses(
            Rs,
            self._origins(Rs, size, evidence),
            size.length_m,
            size.radii_m + s.clothing_m,
            columns(evidence.all_points_camera),
            evidence.view,
            NO_PARTS,
            s.tolerance_m,
            self.threads,
        )
        visible_share = 1.0 - terms.n_occluded / np.maximum(terms.n_pixels, 1)
        with np.errstate(invalid="ignore"):
            scores = terms.btvr(evidence.hidden_share) * visible_share
        scores = np.where(self._has_evidence(terms), scores, np.inf)
        if last is None:
            return scores
        cosine = np.clip(Rs[:, :, 1] @ self._held[:, 1], -1.0, 1.0)
        weight = s.turn_weight + s.hidden_turn_weight * evidence.hidden_share
        return scores * np.exp(weight * np.arccos(cosine) ** 2)

    def _has_evidence(self, terms: UtvrTerms) -> NDArray[np.bool_]:
        return terms.has_evidence & (
            terms.n_points > self.settings.least_share * np.maximum(terms.n_pixels, 1)
        )

    def _fitted(
        self, R: Array, score: float, size: Size, evidence: Evidence, is_new: bool
    ) -> Torso:
        """Yaw and place from the ellipse fitted to the re-projected points (Fig. 5.3 a)."""
        s = self.settings
        neck = self._origins(R[None], size, evidence)[0]
        x, y, z = ((evidence.all_points_camera - neck) @ R).T
        rx, rz = s.fit_margin * (size.radii_m + s.clothing_m)
        reach = max(rx, rz) if is_new else 0.0
        rx, rz = max(rx, reach), max(rz, reach)
        inside = (y > 0.0) & (y < size.length_m) & ((x / rx) ** 2 + (z / rz) ** 2 < 1.0)
        points = np.stack([x[inside], y[inside], z[inside]], axis=1)
        full = 2 * size.radii_m[0] * size.length_m
        seen_share = float(inside.sum() * _pixel_area_m2(evidence) / full)
        if seen_share < s.least_share:
            return Torso(neck, R, np.inf)
        step = max(1, len(points) // MAX_FIT_POINTS)
        held = R.T @ self._held[:, 0]
        expected = None if is_new else float(np.arctan2(-held[2], held[0]))
        hold = 1.0 if is_new else 1.0 + s.hidden_hold * evidence.hidden_share
        fits = [
            fit_cylinder(points[::step], size.radii_m, t, seen_share, s.fit, expected, hold)
            for t in (s.start_turns_rad if is_new else s.turns_rad)
        ]
        return self._placed(min(fits, key=lambda fit: fit.cost), R, neck, score, size, evidence)

    def _placed(
        self,
        fit: FittedCylinder,
        R: Array,
        neck: Array,
        score: float,
        size: Size,
        evidence: Evidence,
    ) -> Torso:
        """The torso where the cylinder was fitted; the kept views lean and turn with it."""
        lean = rotations_from_vectors(np.array([fit.lean[1], 0.0, -fit.lean[0]]))
        turn = lean @ rotations_from_angles(np.array([0.0, fit.turn_rad, 0.0]))
        neck = neck + R[:, [0, 2]] @ fit.centre
        R_fitted = R @ turn
        self._Rs = self._Rs @ turn
        if evidence.head_is_seen:
            off = neck - _necks(R_fitted[None], size, evidence)[0]
            self._aside = (off @ R_fitted)[[0, 2]]
        return Torso(neck, R_fitted, score)


def _necks(Rs: Array, size: Size, evidence: Evidence) -> Array:
    """[M, 3] neck joints below the head of torsos turned like `Rs`: a neck bends half as far."""
    return evidence.head_camera + size.to_neck_m * unit(Rs[:, :, 1] - evidence.up_camera)


def _mean(Rs: Array, scores: Array, sharpness: float) -> Array:
    """[3, 3] the best rotation, turned until its axis is the weighted mean of all."""
    weights = (scores[0] / scores) ** sharpness
    axis, mean = Rs[0, :, 1], unit(weights @ Rs[:, :, 1])
    cross = np.cross(axis, mean)
    sine, cosine = np.linalg.norm(cross), axis @ mean
    return rotations_from_vectors(unit(cross) * np.arctan2(sine, cosine)) @ Rs[0]


def _pixel_area_m2(evidence: Evidence) -> float:
    """The surface that a pixel stands for, seen face on."""
    share = len(evidence.points_camera) / max(len(evidence.all_points_camera), 1)
    return evidence.point_area_m2 * share
