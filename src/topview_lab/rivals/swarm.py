"""Whole-body particle swarm optimisation: the thesis's strongest rivals (Tables 6.1, 6.2).

Baseline (bPSO) and perturbed (pPSO), after Oikonomidis, Kyriazis and Argyros, "Efficient
model-based 3D tracking of hand articulations using Kinect" (BMVC 2011), and Michel, Panagiotakis
and Argyros, "Tracking the articulated motion of the human body with two RGBD cameras" (MVA 2015).
Body model, people and the pose of a person's first frame are those of the default tracker, so that
the tracking from frame to frame is compared. Those papers track one person; here (ours) pixels that
another person or an object hides cost a pose nothing.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import ClassVar, Final

import numpy as np
from numpy.typing import NDArray

from topview.body.model import BodyModel
from topview.body.parts import PARTS, UPPER_TORSO
from topview.body.proportions import ANATOMICAL
from topview.camera.pyramid import DepthView
from topview.records import InputError
from topview.track.body_tracker import Needs, Subject
from topview.track.evidence import Evidence
from topview.track.methods.topview.tracker import LEAST_BODY_POINTS, TopviewSettings
from topview.track.pose import Pose
from topview_lab.kernels import swarm as kernel
from topview_lab.rivals.pose_space import HIGH, LOW, N_DIMENSIONS, N_GLOBAL, PLACE, TURN, PoseSpace

Array = NDArray[np.float64]


OWN_WEIGHT, BEST_WEIGHT = 2.8, 1.3
"""c1 and c2, the pull of a particle's own best and of the swarm's (BMVC 2011); their sum must be
above 4, or the swarm does not converge (Clerc and Kennedy 2002)."""
_PSI: Final = OWN_WEIGHT + BEST_WEIGHT
CONSTRICTION: Final = 2.0 / abs(2.0 - _PSI - np.sqrt(_PSI * _PSI - 4.0 * _PSI))
"""w of Clerc and Kennedy (2002)."""
START_SIGMA_M, START_SIGMA_RAD = 0.01, 0.1
"""How far the particles start from the pose of the frame before, in place and in each joint's
angles (the authors' released hand tracker)."""
START_TURN_SIGMA_RAD: Final = 0.05
"""The same for the turn of the whole body: half the joints', as it moves everything (ours)."""
PERTURBED_EVERY: Final = 3
"""Generations after which pPSO draws anew, within its limits, one angle of each of half the
particles (BMVC 2011)."""
CLAMP_M, MATCH_M = 0.1, 0.05
"""d_M and d_m of the objective: the largest depth difference that counts, and the one below which a
pixel is matched (ours; BMVC 2011 has 4 cm and 1 cm, for hands)."""
OVERLAP_WEIGHT_M: Final = 0.05
"""lambda, the weight of the overlap (ours; BMVC 2011 has 20, with differences in mm)."""
WINDOW_PADDING_M: Final = 0.25
"""Of the window that poses are rendered in, around the user's pixels and the last pose (ours)."""


@dataclass(frozen=True, slots=True)
class SwarmSettings:
    """The budget of a frame.

    Attributes:
        particles: 1 or more; 64 in the authors' released hand tracker.
        generations: 1 or more; 25 in the authors' released hand tracker. 40 leave them more than
            the default tracker's time, see `EQUAL_TIME`.
        perturbed: whether angles are redrawn (pPSO), against premature convergence.
        body: of the default tracker, which gives the pose of a person's first frame.
    """

    particles: int = 64
    generations: int = 40
    perturbed: bool = False
    body: TopviewSettings = field(default_factory=TopviewSettings)

    needs: ClassVar[Needs] = Needs()

    def __post_init__(self) -> None:
        for name in ("particles", "generations"):
            if getattr(self, name) < 1:
                raise InputError(f"{name} is {getattr(self, name)}; it must be 1 or more")

    @property
    def name(self) -> str:
        return "ppso" if self.perturbed else "bpso"

    def tracker(self, subject: Subject) -> SwarmTracker:
        return SwarmTracker(subject, self)


def start_sigmas() -> Array:
    """[27] how far particles start from the last pose, in each dimension of the pose space."""
    sigmas = np.full(N_DIMENSIONS, START_SIGMA_RAD)
    sigmas[PLACE], sigmas[TURN] = START_SIGMA_M, START_TURN_SIGMA_RAD
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
    """Minimise a cost with a swarm around `start` [D]; returns the best position [D].

    Args:
        cost: maps positions [M, D] to costs [M].
    """
    s = settings
    shape = (s.particles, len(start))
    places = start + start_sigmas() * rng.standard_normal(shape)
    places[0] = start
    places = np.clip(places, LOW, HIGH)
    velocities = np.zeros(shape)
    bests, best_costs = places.copy(), np.full(s.particles, np.inf)
    for generation in range(s.generations):
        costs = cost(places)
        is_better = costs < best_costs
        bests[is_better], best_costs[is_better] = places[is_better], costs[is_better]
        own, towards_best = rng.random((2, *shape))
        velocities = CONSTRICTION * (
            velocities
            + OWN_WEIGHT * own * (bests - places)
            + BEST_WEIGHT * towards_best * (bests[np.argmin(best_costs)] - places)
        )
        places = np.clip(places + velocities, LOW, HIGH)
        if s.perturbed and generation % PERTURBED_EVERY == PERTURBED_EVERY - 1:
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
    def around(cls, evidence: Evidence, joints_camera: Array) -> Observation:
        """The window around the user's pixels and a pose's joints [J, 3], at half the working
        resolution: about as many pixels as the 64 x 64 of BMVC 2011."""
        view, mine = evidence.coarse_view, evidence.user_mask[::2, ::2]
        v, u = np.nonzero(mine)
        x, y, z = joints_camera[joints_camera[:, 2] > 0.1].T
        u = np.append(u, view.fx * x / z + view.cx)
        v = np.append(v, view.fy * y / z + view.cy)
        padding = WINDOW_PADDING_M * max(view.fx, view.fy) / max(np.median(z), 0.3)
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


def discrepancy_m(poses: Pose, model: BodyModel, seen: Observation, threads: int) -> Array:
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
        f4(CLAMP_M),
        f4(MATCH_M),
        max(1, min(threads, len(terms))),
        terms,
    )
    difference, both, either = terms.T
    depth_m = difference / kernel.UNITS_PER_M / np.maximum(either, 1)
    overlap = 2.0 * both / np.maximum(both + either, 1)
    return depth_m + OVERLAP_WEIGHT_M * (1.0 - overlap)


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
            self.model = BodyModel.of(evidence.stature_m, ANATOMICAL)
        if is_seen:
            with self.subject.clock.stage("swarm"):
                self._pose = self._optimise(self._pose, evidence)
        return self._pose

    def _optimise(self, last: Pose, evidence: Evidence) -> Pose:
        space = PoseSpace(last.Rs[UPPER_TORSO])
        seen = Observation.around(evidence, last.origins(self.model))

        def cost(vectors: Array) -> Array:
            return discrepancy_m(space.poses(vectors), self.model, seen, self.subject.threads)

        # Beside the parts' own counters, which the first frame's tracker draws from.
        rng = self.subject.rng(len(PARTS), evidence)
        return space.pose(minimise(cost, space.vector(last), self.settings, rng))
