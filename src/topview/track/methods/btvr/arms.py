"""The arms: hypotheses between shoulder and palm, scored by their rendered depth (Sec. 5.1.4)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from topview.body.model import BodyModel
from topview.filter.particles import n_best
from topview.geometry.rotations import unit
from topview.kernels import arms as kernel
from topview.people.users import HandCandidate
from topview.track.evidence import Evidence
from topview.track.methods.btvr.arm_angles import arm_angles, beyond_ranges_rad
from topview.track.methods.btvr.pixels import UserPixels
from topview.track.methods.btvr.torso import Torso
from topview.track.methods.topview.limbs import elbows_on_circle, spread_points

Array = NDArray[np.float64]

LIKELY = 0.5  # worth from which on a point may be a palm; ours


@dataclass(frozen=True, slots=True)
class ArmSettings:
    """Ours where not said otherwise; metres, radians.

    Attributes:
        kept: hypotheses that go on to the next frame (Sec. 6.1.3: 10 for mobile parts).
        rounds: of sampling and evaluation, every one half as wide as the last.
        jittered, jitter_rad: hypotheses around the kept ones in each round, and how widely.
        pairs, turns: of shoulder and palm, drawn in each round, and elbows on each one's circle.
        extremities: points that may be palms where no colour tells.
        extremity_confidence: as of a hand candidate.
        least_confidence: of a hand on this side.
        palm_sigma_m: standard deviation of a palm whose confidence is 1; it is inverse to that.
        shoulder_weight: of a shoulder's squared distance from where the torso has it, in its
            standard deviations, which are the radius of the upper arm.
        cap_m: the largest difference of depth that counts, and what free space costs.
        hidden_m, buried_m: difference that a pixel counts for which something else hides, and the
            largest for one that the own body hides: arms are seldom behind the back.
        unexplained_weight: of an arm's worth of pixels that nothing explains.
        motion_weight, motion_rad: of a part's turn away from where it was, and the turn that
            begins to count.
        range_weight, range_slack_rad: per radian beyond Table 5.1, and what is still let pass.
        averaged, alike_rad, sharpness: so many of the best hypotheses, that differ by no more from
            the best one, make the arm's pose; how much more the better ones count.
        found_discrepancy: an arm that costs no more has been found.
    """

    kept: int = 10
    rounds: int = 3
    jittered: int = 100
    jitter_rad: float = 0.4
    pairs: int = 20
    turns: int = 6
    extremities: int = 8
    extremity_confidence: float = 0.5
    least_confidence: float = 0.1
    palm_sigma_m: float = 0.015
    shoulder_weight: float = 0.02
    cap_m: float = 0.1
    hidden_m: float = 0.03
    buried_m: float = 0.07
    unexplained_weight: float = 1.5
    motion_weight: float = 0.03
    motion_rad: float = 0.5
    range_weight: float = 1.0
    range_slack_rad: float = 0.35
    averaged: int = 8
    alike_rad: float = 0.35
    sharpness: float = 20.0
    found_discrepancy: float = 0.35


@dataclass(frozen=True, slots=True, eq=False)
class Arm:
    """An arm in the frame of the torso; shoulder in metres, [2, 3] directions of its parts.

    `discrepancy` is 0 for an arm that looks as the image does, and about 1 for one in free space;
    `is_found` tells whether it is low enough to say anything.
    """

    shoulder_torso: Array
    axes_torso: Array
    discrepancy: float
    is_found: bool


@dataclass(frozen=True, slots=True, eq=False)
class _Hypotheses:
    """[M, 3] offsets of the shoulder and [M, 2, 3] directions, in the torso's frame."""

    offsets: Array
    axes: Array

    def __getitem__(self, chosen: NDArray[np.intp]) -> _Hypotheses:
        return _Hypotheses(self.offsets[chosen], self.axes[chosen])

    def and_more(self, other: _Hypotheses) -> _Hypotheses:
        return _Hypotheses(
            np.concatenate([self.offsets, other.offsets]), np.concatenate([self.axes, other.axes])
        )


class ArmFilter:
    """One arm over time: a particle filter.

    Args:
        upper: index of the upper arm; the forearm comes next in the table of parts.
        side: +1 for the right arm, -1 for the left.
    """

    def __init__(self, upper: int, side: float, settings: ArmSettings) -> None:
        self.upper = upper
        self.side = side
        self.settings = settings
        self.arm: Arm | None = None
        hanging = np.array([[[0.1 * side, 1.0, 0.0], [0.0, 1.0, 0.1]]])
        self._kept = _Hypotheses(np.zeros((1, 3)), unit(hanging))

    def swap(self, other: ArmFilter) -> None:
        """Left and right change places, as front and back do."""
        turn = np.array([-1.0, 1.0, -1.0])
        mine, theirs = self._kept, other._kept
        self._kept = _Hypotheses(theirs.offsets * turn, theirs.axes * turn)
        other._kept = _Hypotheses(mine.offsets * turn, mine.axes * turn)
        self.arm = other.arm = None

    def update(
        self,
        torso: Torso,
        model: BodyModel,
        pixels: UserPixels,
        evidence: Evidence,
        rng: np.random.Generator,
    ) -> Arm:
        """The arm in the next frame, given the torso and what nothing else explains."""
        s = self.settings
        look = _Look(torso, model, pixels, evidence, self.upper)
        last = self._kept.axes[0]
        palms, sigmas_m = self._palms(look)
        hypotheses = self._kept
        scores = self._scores(hypotheses, last, look, coarsely=True)
        for halvings in range(s.rounds):
            width = 0.5**halvings
            is_last = halvings == s.rounds - 1
            if is_last:
                scores = self._scores(hypotheses, last, look)
            drawn = self._jittered(hypotheses, width, look, rng)
            if len(palms):
                drawn = drawn.and_more(self._between(palms, sigmas_m, width, look, rng))
            hypotheses = hypotheses.and_more(drawn)
            scores = np.concatenate([scores, self._scores(drawn, last, look, coarsely=not is_last)])
            best = n_best(scores, s.kept)
            hypotheses, scores = hypotheses[best], scores[best]
        self._kept = hypotheses
        self.arm = self._mean(hypotheses, scores, look)
        return self.arm

    def _palms(self, look: _Look) -> tuple[Array, Array]:
        """[P, 3] places where the palm may be, on the arm's axis, and [P] their deviations."""
        s = self.settings
        ends = spread_points(look.likely_points, look.shoulder_camera, s.extremities)
        hands = [
            (hand.palm_camera, self._confidence(hand))
            for hand in look.evidence.hands
            if look.is_in_reach(hand.palm_camera) and self._confidence(hand) > s.least_confidence
        ]
        places = np.concatenate([ends, *(palm_camera[None] for palm_camera, _ in hands)])
        confidence = np.array([s.extremity_confidence] * len(ends) + [c for _, c in hands])
        return places + unit(places) * look.radii_m[1], s.palm_sigma_m / confidence

    def _confidence(self, hand: HandCandidate) -> float:
        """That it is a hand, and on this side."""
        share = hand.left_share if self.side < 0.0 else 1.0 - hand.left_share
        return hand.confidence * share

    def _jittered(
        self, around: _Hypotheses, width: float, look: _Look, rng: np.random.Generator
    ) -> _Hypotheses:
        s = self.settings
        parents = around[rng.integers(0, len(around.axes), s.jittered)]
        axes = parents.axes + width * s.jitter_rad * rng.standard_normal((s.jittered, 2, 3))
        off = 0.5 * width * look.radii_m[0] * rng.standard_normal((s.jittered, 3))
        return _Hypotheses(parents.offsets + off, unit(axes))

    def _between(
        self, palms: Array, sigmas_m: Array, width: float, look: _Look, rng: np.random.Generator
    ) -> _Hypotheses:
        """Elbows on circles between shoulders and palms, both drawn from Gaussians."""
        s = self.settings
        which = rng.integers(0, len(palms), s.pairs)
        noise = width * rng.standard_normal((2, s.pairs, 3))
        offsets = look.radii_m[0] * noise[0]
        shoulders = look.shoulder_camera + offsets @ look.R.T
        ends = palms[which] + sigmas_m[which, None] * noise[1]
        lu, lf = look.lengths_m
        axes = elbows_on_circle(shoulders, ends, lu, lf, s.turns)
        return _Hypotheses(np.repeat(offsets, s.turns, axis=0), axes @ look.R)

    def _scores(
        self, hypotheses: _Hypotheses, last: Array, look: _Look, *, coarsely: bool = False
    ) -> Array:
        """[M] discrepancy of the rendered arms, with what else speaks against them."""
        s = self.settings
        axes = hypotheses.axes
        sums = look.compared(hypotheses, s, coarsely=coarsely)
        difference, pixels, explained = sums.T
        # An arm that points at the camera shows little; it still must be worth a hand.
        full = look.full_pixels
        score = difference / (s.cap_m * np.maximum(pixels, 0.3 * full))
        score += s.unexplained_weight * (look.open_worth - explained) / full
        turn = np.arccos(np.clip((axes * last).sum(-1), -1.0, 1.0))
        score += s.motion_weight * np.log1p((turn / s.motion_rad) ** 2).sum(1)
        score += s.shoulder_weight * ((hypotheses.offsets / look.radii_m[0]) ** 2).sum(1)
        beyond = beyond_ranges_rad(arm_angles(axes, self.side))
        return score + s.range_weight * np.maximum(beyond - s.range_slack_rad, 0.0)

    def _mean(self, hypotheses: _Hypotheses, scores: Array, look: _Look) -> Arm:
        """The best hypothesis, averaged with those that are much like it."""
        s = self.settings
        axes = hypotheses.axes
        alike = ((axes * axes[0]).sum(-1) > np.cos(s.alike_rad)).all(1)
        alike &= np.arange(len(axes)) < s.averaged
        weights = np.where(alike, np.exp(s.sharpness * (scores[0] - scores)), 0.0)
        weights /= weights.sum()
        mean = _Hypotheses(
            (weights @ hypotheses.offsets)[None],
            unit(np.einsum("m,mki->ki", weights, axes))[None],
        )
        difference, pixels, _ = look.compared(mean, s)[0]
        discrepancy = float(difference / (s.cap_m * max(pixels, 1.0)))
        shoulder = look.nominal_shoulder + mean.offsets[0]
        return Arm(shoulder, mean.axes[0], discrepancy, discrepancy < s.found_discrepancy)


class _Look:
    """One arm's surroundings in one frame."""

    def __init__(
        self, torso: Torso, model: BodyModel, pixels: UserPixels, evidence: Evidence, upper: int
    ) -> None:
        self.R = torso.R_camera_torso
        self.nominal_shoulder = model.joints_parent[upper]
        self.shoulder_camera = torso.neck_camera + self.R @ self.nominal_shoulder
        self.lengths_m = model.lengths_m[upper : upper + 2]
        self.radii_m = model.radii_m[upper : upper + 2, 0]
        self.evidence = evidence
        view = evidence.view
        side_m2 = 2.0 * float((self.lengths_m * self.radii_m).sum())
        distance_m = max(float(self.shoulder_camera[2]), 0.3)
        self.full_pixels = side_m2 * view.fx * view.fy / distance_m**2
        is_open = pixels.open_to(upper, self.shoulder_camera, self.reach_m)
        self.likely_points = pixels.points[is_open & (pixels.worth > LIKELY)]
        whose, worth = pixels.images(is_open)
        self.open_worth = float(worth.sum())
        self._images = (view.depth_m, whose, worth)
        self._coarse_images = tuple(np.ascontiguousarray(i[::2, ::2]) for i in self._images)

    @property
    def reach_m(self) -> float:
        return 1.1 * float(self.lengths_m.sum())

    def is_in_reach(self, place_camera: Array) -> bool:
        return bool(np.linalg.norm(place_camera - self.shoulder_camera) < self.reach_m)

    def compared(
        self, hypotheses: _Hypotheses, settings: ArmSettings, *, coarsely: bool = False
    ) -> Array:
        """[M, 3] sums of `compare_arms`; from an image of half the resolution, if `coarsely`."""
        f4 = np.float32
        view = self.evidence.coarse_view if coarsely else self.evidence.view
        images = self._coarse_images if coarsely else self._images
        shoulders = self.shoulder_camera + hypotheses.offsets @ self.R.T
        sums = np.empty((len(shoulders), kernel.N_SUMS))
        depth_m, whose, worth = images
        kernel.compare_arms(
            shoulders.astype(f4),
            (hypotheses.axes @ self.R.T).astype(f4),
            self.lengths_m.astype(f4),
            self.radii_m.astype(f4),
            depth_m,
            whose,
            worth,
            f4(view.fx),
            f4(view.fy),
            f4(view.cx),
            f4(view.cy),
            f4(settings.cap_m),
            f4(settings.hidden_m),
            f4(settings.buried_m),
            sums,
        )
        return 4.0 * sums if coarsely else sums
