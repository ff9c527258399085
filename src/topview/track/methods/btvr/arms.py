"""The arms: hypotheses between shoulder and palm, scored by their rendered depth (Sec. 5.1.4)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.body.model import BodyModel
from topview.body.parts import PARTS
from topview.filter.particles import n_best
from topview.geometry.rotations import unit
from topview.kernels import arms as kernel
from topview.people.users import HandCandidate
from topview.records import check_range
from topview.track.elbows import elbows_on_circle, spread_points
from topview.track.evidence import Evidence
from topview.track.methods.btvr.arm_angles import arm_angles, beyond_ranges_rad
from topview.track.methods.btvr.pixels import UserPixels
from topview.track.methods.btvr.torso import Torso

Array = NDArray[np.float64]

# All ours but where a table or an equation is named.
# Where the palm may be. Extremities are points that nothing else explains, far from each other.
LIKELY_WEIGHT: Final = 0.5  # of a point, from which on it may be an extremity
EXTREMITIES: Final = 8  # points that may be palms where no colour tells
EXTREMITY_CONFIDENCE: Final = 0.5  # of these, as of a hand candidate
LEAST_HAND_CONFIDENCE: Final = 0.1  # of a hand candidate on this side of the body
PALM_SIGMA_M: Final = 0.015  # of a palm whose confidence is 1; it is inverse to the confidence
ARM_REACH: Final = 1.1  # a palm is no farther from the shoulder, in lengths of the arm
# Sampling; every round is half as wide as the one before.
JITTER_RAD: Final = 0.4  # around the kept hypotheses
SHOULDER_JITTER: Final = 0.5  # of their shoulders, in radii of the upper arm
PAIRS: Final = 20  # of shoulder and palm in each round
ELBOWS_PER_PAIR: Final = 6  # on the circle of Eq. 5.4 - 5.6
# The discrepancy between an arm's rendered depth and the image; 1 for an arm in free space.
DIFFERENCE_CAP_M: Final = 0.1  # the largest difference of a pixel, and that of free space
OCCLUDED_DIFFERENCE_M: Final = 0.03  # of a pixel that something else hides
SELF_OCCLUDED_CAP_M: Final = 0.07  # of a pixel that the body hides: arms are seldom behind the back
LEAST_AREA: Final = 0.3  # share of the whole arm's pixels: an arm that points at the camera has few
NEAREST_SHOULDER_M: Final = 0.3  # for that area, a shoulder counts as no nearer to the camera
# What is added to the discrepancy.
UNEXPLAINED_WEIGHT: Final = 1.5  # of as many unexplained pixels as a whole arm has
MOTION_WEIGHT: Final = 0.03  # of log(1 + (turn / MOTION_RAD)^2) since the last frame, each part
MOTION_RAD: Final = 0.5
SHOULDER_WEIGHT: Final = 0.02  # of a shoulder's squared distance from its joint, in arm radii
RANGE_WEIGHT: Final = 1.0  # per radian beyond Table 5.1
RANGE_SLACK_RAD: Final = 0.35  # beyond Table 5.1 that costs nothing
# The arm is the mean of the best hypothesis and those like it.
AVERAGED: Final = 8  # hypotheses at the most
ALIKE_RAD: Final = 0.35  # which differ by less from the best one
MEAN_SHARPNESS: Final = 20.0  # weights are exp(-MEAN_SHARPNESS * score)


@dataclass(frozen=True, slots=True)
class ArmSettings:
    """How each arm is searched; the time grows with both.

    Attributes:
        samples: hypotheses drawn in each round around those kept, 1 to 10000.
        rounds: of sampling and evaluation in each frame, 1 to 10.

    Raises:
        InputError: a value out of range.
    """

    samples: int = 100
    rounds: int = 3

    def __post_init__(self) -> None:
        check_range(self, 1, 10_000, "samples")
        check_range(self, 1, 10, "rounds")


@dataclass(frozen=True, slots=True, eq=False)
class Arm:
    """An arm in the frame of the torso.

    Attributes:
        shoulder_torso: [3] metres.
        axes_torso: [2, 3] directions of upper arm and forearm.
        discrepancy: 0 for an arm that looks as the image does, about 1 for one in free space.
    """

    shoulder_torso: Array
    axes_torso: Array
    discrepancy: float


@dataclass(frozen=True, slots=True, eq=False)
class _Hypotheses:
    """[M, 3] offsets of the shoulder and [M, 2, 3] directions, in the torso's frame."""

    offsets: Array
    axes: Array

    def __getitem__(self, chosen: NDArray[np.intp]) -> _Hypotheses:
        return _Hypotheses(self.offsets[chosen], self.axes[chosen])

    def turned_round(self) -> _Hypotheses:
        """The same arms in the frame of a torso that is turned half round."""
        half_turn = np.array([-1.0, 1.0, -1.0])
        return _Hypotheses(self.offsets * half_turn, self.axes * half_turn)

    def and_more(self, other: _Hypotheses) -> _Hypotheses:
        return _Hypotheses(
            np.concatenate([self.offsets, other.offsets]), np.concatenate([self.axes, other.axes])
        )


class ArmFilter:
    """One arm over time: a particle filter."""

    def __init__(self, upper: int, side: float, settings: ArmSettings) -> None:
        """Start with an arm that hangs.

        Args:
            upper: index of the upper arm; the forearm comes next in the table of parts.
            side: +1 for the right arm, -1 for the left.
            settings: of the search.
        """
        self.upper = upper
        self.side = side
        self.settings = settings
        self.arm: Arm | None = None
        hanging = np.array([[[0.1 * side, 1.0, 0.0], [0.0, 1.0, 0.1]]])
        self._kept = _Hypotheses(np.zeros((1, 3)), unit(hanging))

    def exchange_sides(self, other: ArmFilter) -> None:
        """Exchange the hypotheses with those of the other arm, as the torso turned half round."""
        self._kept, other._kept = other._kept.turned_round(), self._kept.turned_round()
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
        scene = _ArmScene(torso, model, pixels, evidence, self.upper)
        last = self._kept.axes[0]
        palms, sigmas_m = self._palms(scene)
        hypotheses = self._kept
        scores = self._scores(hypotheses, last, scene, coarsely=True)
        rounds = self.settings.rounds
        for halvings in range(rounds):
            width = 0.5**halvings
            is_last = halvings == rounds - 1
            if is_last:
                scores = self._scores(hypotheses, last, scene)
            drawn = self._jittered(hypotheses, width, scene, rng)
            if len(palms):
                drawn = drawn.and_more(_from_palms(palms, sigmas_m, width, scene, rng))
            hypotheses = hypotheses.and_more(drawn)
            drawn_scores = self._scores(drawn, last, scene, coarsely=not is_last)
            scores = np.concatenate([scores, drawn_scores])
            best = n_best(scores, PARTS[self.upper].n_best)
            hypotheses, scores = hypotheses[best], scores[best]
        self._kept = hypotheses
        self.arm = _mean(hypotheses, scores, scene)
        return self.arm

    def _palms(self, scene: _ArmScene) -> tuple[Array, Array]:
        """[P, 3] where the palm may be, on the forearm's axis, and [P] standard deviations, both
        in metres."""
        ends = spread_points(scene.likely_points, scene.shoulder_camera, EXTREMITIES)
        hands = [
            (hand.palm_camera, self._confidence(hand))
            for hand in scene.evidence.hands
            if scene.is_in_reach(hand.palm_camera)
            and self._confidence(hand) > LEAST_HAND_CONFIDENCE
        ]
        places = np.concatenate([ends, *(palm_camera[None] for palm_camera, _ in hands)])
        confidence = np.array([EXTREMITY_CONFIDENCE] * len(ends) + [c for _, c in hands])
        return places + unit(places) * scene.radii_m[1], PALM_SIGMA_M / confidence

    def _confidence(self, hand: HandCandidate) -> float:
        """That a candidate is a hand, and on this side of the body."""
        share = hand.left_share if self.side < 0.0 else 1.0 - hand.left_share
        return hand.confidence * share

    def _jittered(
        self, around: _Hypotheses, width: float, scene: _ArmScene, rng: np.random.Generator
    ) -> _Hypotheses:
        count = self.settings.samples
        parents = around[rng.integers(0, len(around.axes), count)]
        axes = parents.axes + width * JITTER_RAD * rng.standard_normal((count, 2, 3))
        off_m = SHOULDER_JITTER * width * scene.radii_m[0] * rng.standard_normal((count, 3))
        return _Hypotheses(parents.offsets + off_m, unit(axes))

    def _scores(
        self, hypotheses: _Hypotheses, last: Array, scene: _ArmScene, *, coarsely: bool = False
    ) -> Array:
        """[M] discrepancy of the rendered arms, and what is added to it; lower is better."""
        axes = hypotheses.axes
        difference_m, pixels, explained = scene.compared(hypotheses, coarsely=coarsely).T
        whole = scene.whole_pixels
        score = difference_m / (DIFFERENCE_CAP_M * np.maximum(pixels, LEAST_AREA * whole))
        score += UNEXPLAINED_WEIGHT * (scene.open_weight - explained) / whole
        turn = np.arccos(np.clip((axes * last).sum(-1), -1.0, 1.0))
        score += MOTION_WEIGHT * np.log1p((turn / MOTION_RAD) ** 2).sum(1)
        score += SHOULDER_WEIGHT * ((hypotheses.offsets / scene.radii_m[0]) ** 2).sum(1)
        beyond = beyond_ranges_rad(arm_angles(axes, self.side))
        return score + RANGE_WEIGHT * np.maximum(beyond - RANGE_SLACK_RAD, 0.0)


def _from_palms(
    palms: Array, sigmas_m: Array, width: float, scene: _ArmScene, rng: np.random.Generator
) -> _Hypotheses:
    """Arms whose elbows are on the circles between shoulders and palms, both drawn from
    Gaussians."""
    which = rng.integers(0, len(palms), PAIRS)
    noise = width * rng.standard_normal((2, PAIRS, 3))
    offsets = scene.radii_m[0] * noise[0]
    shoulders = scene.shoulder_camera + offsets @ scene.R.T
    ends = palms[which] + sigmas_m[which, None] * noise[1]
    upper_m, forearm_m = scene.lengths_m
    axes = elbows_on_circle(shoulders, ends, upper_m, forearm_m, ELBOWS_PER_PAIR)
    return _Hypotheses(np.repeat(offsets, ELBOWS_PER_PAIR, axis=0), axes @ scene.R)


def _mean(hypotheses: _Hypotheses, scores: Array, scene: _ArmScene) -> Arm:
    """The mean of the best hypothesis and those like it."""
    axes = hypotheses.axes
    is_alike = ((axes * axes[0]).sum(-1) > np.cos(ALIKE_RAD)).all(1)
    is_alike &= np.arange(len(axes)) < AVERAGED
    weights = np.where(is_alike, np.exp(MEAN_SHARPNESS * (scores[0] - scores)), 0.0)
    weights /= weights.sum()
    mean = _Hypotheses(
        (weights @ hypotheses.offsets)[None],
        unit(np.einsum("m,mki->ki", weights, axes))[None],
    )
    difference_m, pixels, _ = scene.compared(mean)[0]
    discrepancy = float(difference_m / (DIFFERENCE_CAP_M * max(pixels, 1.0)))
    return Arm(scene.shoulder_torso + mean.offsets[0], mean.axes[0], discrepancy)


class _ArmScene:
    """What one frame shows around one arm.

    Attributes:
        R: [3, 3] `R_camera_torso`.
        shoulder_torso, shoulder_camera: [3] the shoulder joint of the torso, metres.
        lengths_m, radii_m: [2] of upper arm and forearm.
        whole_pixels: of the whole arm, seen from the side at the shoulder's distance.
        likely_points: [N, 3] points that may be the palm, metres.
        open_weight: sum of the weights of the pixels that nothing else explains.
    """

    def __init__(
        self, torso: Torso, model: BodyModel, pixels: UserPixels, evidence: Evidence, upper: int
    ) -> None:
        self.R = torso.R_camera_torso
        self.shoulder_torso = model.joints_parent[upper]
        self.shoulder_camera = torso.neck_camera + self.R @ self.shoulder_torso
        self.lengths_m = model.lengths_m[upper : upper + 2]
        self.radii_m = model.radii_m[upper : upper + 2, 0]
        self.evidence = evidence
        view = evidence.view
        side_m2 = 2.0 * float((self.lengths_m * self.radii_m).sum())
        distance_m = max(float(self.shoulder_camera[2]), NEAREST_SHOULDER_M)
        self.whole_pixels = side_m2 * view.fx * view.fy / distance_m**2
        is_open = pixels.open_to(upper, self.shoulder_camera, self.reach_m)
        self.likely_points = pixels.points[is_open & (pixels.weights > LIKELY_WEIGHT)]
        owners, weights = pixels.images(is_open)
        self.open_weight = float(weights.sum())
        self._images = (view.depth_m, owners, weights)
        self._coarse_images = tuple(np.ascontiguousarray(i[::2, ::2]) for i in self._images)

    @property
    def reach_m(self) -> float:
        return ARM_REACH * float(self.lengths_m.sum())

    def is_in_reach(self, place_camera: Array) -> bool:
        return bool(np.linalg.norm(place_camera - self.shoulder_camera) < self.reach_m)

    def compared(self, hypotheses: _Hypotheses, *, coarsely: bool = False) -> Array:
        """[M, 3] the sums of `compare_arms`; those of an image of half the resolution, times 4,
        if `coarsely`."""
        f4 = np.float32
        view = self.evidence.coarse_view if coarsely else self.evidence.view
        images = self._coarse_images if coarsely else self._images
        shoulders = self.shoulder_camera + hypotheses.offsets @ self.R.T
        sums = np.empty((len(shoulders), kernel.N_SUMS))
        depth_m, owners, weights = images
        kernel.compare_arms(
            shoulders.astype(f4),
            (hypotheses.axes @ self.R.T).astype(f4),
            self.lengths_m.astype(f4),
            self.radii_m.astype(f4),
            depth_m,
            owners,
            weights,
            f4(view.fx),
            f4(view.fy),
            f4(view.cx),
            f4(view.cy),
            f4(DIFFERENCE_CAP_M),
            f4(OCCLUDED_DIFFERENCE_M),
            f4(SELF_OCCLUDED_CAP_M),
            sums,
        )
        return 4.0 * sums if coarsely else sums
