"""Whole-body particle swarm optimisation: the thesis's strongest rivals (Tables 6.1, 6.2).

Baseline (bPSO) and perturbed (pPSO), after Oikonomidis, Kyriazis and Argyros, "Efficient
model-based 3D tracking of hand articulations using Kinect" (BMVC 2011), and Michel, Panagiotakis
and Argyros, "Tracking the articulated motion of the human body with two RGBD cameras" (MVA 2015).
Body, people and the pose of a person's first frame are those of the default tracker, so that what
happens from frame to frame is compared. Those papers see nobody else in the scene; here (ours) what
another person or an object hides costs a pose nothing.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from topview.body.model import BodyModel
from topview.body.parts import PARTS, UPPER_TORSO
from topview.camera.pyramid import DepthView
from topview.records import InputError
from topview.track.body_tracker import Needs, Subject
from topview.track.evidence import Evidence
from topview.track.methods.topview.tracker import LEAST_BODY_POINTS, TopviewSettings
from topview.track.pose import Pose
from topview_lab.kernels import swarm as kernel
from topview_lab.rivals.pose_space import HIGH, LOW, N_DIMENSIONS, N_GLOBAL, PLACE, TURN, PoseSpace

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class SwarmSettings:
    """Metres, radians.

    Attributes:
        particles, generations: the budget of a frame; 64 and 25 in the authors' released hand
            tracker. 40 leave them more than the default tracker's time, see `EQUAL_TIME`.
        own_weight, best_weight: c1 and c2, the pull of a particle's own best and of the swarm's
            (BMVC 2011: 2.8, 1.3); with them the constriction w of Clerc and Kennedy (2002).
        place_sigma_m, turn_sigma_rad, joint_sigma_rad: how far the particles start from the pose
            of the frame before (1 cm and 0.1 in the authors' released hand tracker; half as far
            for the turn, which moves all of the body: ours).
        perturbed: whether angles are drawn anew (pPSO), against premature convergence.
        perturbed_every: generations after which pPSO draws anew, within its limits, one angle of
            each of half the particles (BMVC 2011: 3).
        clamp_m, match_m: d_M and d_m of the objective, the largest difference that counts and the
            one below which a pixel is matched (BMVC 2011: 4 cm and 1 cm, for hands; ours).
        overlap_weight_m: lambda, of the overlap (BMVC 2011: 20, with differences in mm).
        padding_m: of the window that poses are rendered in, around the user's pixels and the last
            pose.
        body: of the default tracker, which gives the pose of a person's first frame.
    """

    particles: int = 64
    generations: int = 40
    own_weight: float = 2.8
    best_weight: float = 1.3
    place_sigma_m: float = 0.01
    turn_sigma_rad: float = 0.05
    joint_sigma_rad: float = 0.1
    perturbed: bool = False
    perturbed_every: int = 3
    clamp_m: float = 0.1
    match_m: float = 0.05
    overlap_weight_m: float = 0.05
    padding_m: float = 0.25
    body: TopviewSettings = field(default_factory=TopviewSettings)

    needs: ClassVar[Needs] = Needs()

    def __post_init__(self) -> None:
        for name in ("particles", "generations", "perturbed_every"):
            if getattr(self, name) < 1:
                raise InputError(f"{name} is {getattr(self, name)}; it must be 1 or more")
        if self.own_weight + self.best_weight <= 4.0:
            raise InputError(
                f"own_weight + best_weight is {self.own_weight + self.best_weight:g}; "
                "it must be above 4, or the swarm does not converge"
            )

    @property
    def name(self) -> str:
        return "ppso" if self.perturbed else "bpso"

    def tracker(self, subject: Subject) -> SwarmTracker:
        return SwarmTracker(subject, self)

    @property
    def sigmas(self) -> Array:
        """[27] of the dimensions of the pose space."""
        sigmas = np.full(N_DIMENSIONS, self.joint_sigma_rad)
        sigmas[PLACE], sigmas[TURN] = self.place_sigma_m, self.turn_sigma_rad
        return sigmas


def perturbed_swarm() -> SwarmSettings:
    """pPSO."""
    return SwarmSettings(perturbed=True)


EQUAL_TIME = SwarmSettings(generations=16)
"""With as much time for a person and frame as the default tracker takes on the same core."""


def minimise(
    cost: Callable[[Array], Array],
    start: Array,
    settings: SwarmSettings,
    rng: np.random.Generator,
) -> Array:
    """[D] the best place that the swarm finds around `start` [D].

    Args:
        cost: [M, D] places to [M] costs.
    """
    s = settings
    psi = s.own_weight + s.best_weight
    constriction = 2.0 / abs(2.0 - psi - np.sqrt(psi * psi - 4.0 * psi))
    shape = (s.particles, len(start))
    places = start + s.sigmas * rng.standard_normal(shape)
    places[0] = start
    places = np.clip(places, LOW, HIGH)
    velocities = np.zeros(shape)
    bests, best_costs = places.copy(), np.full(s.particles, np.inf)
    for generation in range(s.generations):
        costs = cost(places)
        is_better = costs < best_costs
        bests[is_better], best_costs[is_better] = places[is_better], costs[is_better]
        own, towards_best = rng.random((2, *shape))
        velocities = constriction * (
            velocities
            + s.own_weight * own * (bests - places)
            + s.best_weight * towards_best * (bests[np.argmin(best_costs)] - places)
        )
        places = np.clip(places + velocities, LOW, HIGH)
        if s.perturbed and generation % s.perturbed_every == s.perturbed_every - 1:
            chosen = rng.permutation(s.particles)[: s.particles // 2]
            angle = rng.integers(N_GLOBAL, len(start), len(chosen))
            places[chosen, angle] = rng.uniform(LOW[angle], HIGH[angle])
    return bests[np.argmin(best_costs)]


@dataclass(frozen=True, slots=True, eq=False)
class Observation:
    """The window of the depth image that poses are compared with.

    Attributes:
        view: its depth.
        mine: [h, w] bool, pixels of the user.
    """

    view: DepthView
    mine: NDArray[np.bool_]

    @classmethod
    def around(cls, evidence: Evidence, joints_camera: Array, padding_m: float) -> Observation:
        """The window around the user's pixels and a pose's joints [J, 3], at half the working
        resolution: about as many pixels as the 64 x 64 of BMVC 2011."""
        view, mine = evidence.coarse_view, evidence.user_mask[::2, ::2]
        v, u = np.nonzero(mine)
        x, y, z = joints_camera[joints_camera[:, 2] > 0.1].T
        u = np.append(u, view.fx * x / z + view.cx)
        v = np.append(v, view.fy * y / z + view.cy)
        padding = padding_m * max(view.fx, view.fy) / max(np.median(z), 0.3)
        height, width = mine.shape
        u0, u1 = np.clip([u.min() - padding, u.max() + padding + 1], 0, width).astype(int)
        v0, v1 = np.clip([v.min() - padding, v.max() + padding + 1], 0, height).astype(int)
        window = np.s_[v0:v1, u0:u1]
        return cls(
            DepthView(
                np.ascontiguousarray(view.depth_m[window]),
                view.fx,
                view.fy,
                view.cx - u0,
                view.cy - v0,
            ),
            np.ascontiguousarray(mine[window]),
        )


def discrepancy_m(
    poses: Pose, model: BodyModel, seen: Observation, settings: SwarmSettings, threads: int
) -> Array:
    """[M] the objective D(O, h) of BMVC 2011: mean clamped depth difference, plus what the maps of
    matched and of the user's pixels fail to overlap, weighted."""
    f4 = np.float32
    view = seen.view
    terms = np.empty((poses.Rs.shape[1], kernel.N_TERMS), np.int32)
    kernel.compare_bodies(
        np.ascontiguousarray(poses.Rs, f4),
        np.ascontiguousarray(poses.origins(model), f4),
        model.lengths_m.astype(f4),
        model.radii_m.astype(f4),
        view.depth_m,
        seen.mine,
        f4(view.fx),
        f4(view.fy),
        f4(view.cx),
        f4(view.cy),
        f4(settings.clamp_m),
        f4(settings.match_m),
        max(1, min(threads, len(terms))),
        terms,
    )
    difference, both, either = terms.T
    depth_m = difference / kernel.UNITS_PER_M / np.maximum(either, 1)
    overlap = 2.0 * both / np.maximum(both + either, 1)
    return depth_m + settings.overlap_weight_m * (1.0 - overlap)


class SwarmTracker:
    """One person's pose over time, by a swarm around the pose of the frame before."""

    def __init__(self, subject: Subject, settings: SwarmSettings) -> None:
        self.subject = subject
        self.settings = settings
        self._first = settings.body.tracker(subject)
        self._pose: Pose | None = None
        self.model = self._first.model

    def update(self, evidence: Evidence) -> Pose:
        """The pose in the next frame."""
        is_seen = len(evidence.points_camera) >= LEAST_BODY_POINTS
        if self._pose is None:
            pose = self._first.update(evidence)
            self.model = self._first.model
            self._pose = pose if is_seen else None
            return pose
        if evidence.stature_m is not None:
            self.model = BodyModel.of(evidence.stature_m, self.settings.body.proportions)
        if is_seen:
            with self.subject.clock.stage("swarm"):
                self._pose = self._moved(self._pose, evidence)
        return self._pose

    def _moved(self, last: Pose, evidence: Evidence) -> Pose:
        s = self.settings
        space = PoseSpace(last.Rs[UPPER_TORSO])
        seen = Observation.around(evidence, last.origins(self.model), s.padding_m)

        def cost(vectors: Array) -> Array:
            return discrepancy_m(space.poses(vectors), self.model, seen, s, self.subject.threads)

        # Beside the parts' own counters, which the first frame's tracker draws from.
        rng = self.subject.rng(len(PARTS), evidence)
        return space.pose(minimise(cost, space.vector(last), s, rng))
