"""Tracks the body of one person from frame to frame."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from topview.body.kinematics import R_CAMERA_FACING
from topview.body.model import BodyModel
from topview.body.parts import (
    HEAD,
    LEFT_LOWER_LEG,
    LEFT_UPPER_LEG,
    LOWER_TORSO,
    PARTS,
    RIGHT_LOWER_LEG,
    RIGHT_UPPER_LEG,
    UPPER_TORSO,
)
from topview.filter.particles import generator
from topview.geometry.rotations import (
    rotations_from_angles,
    rotations_from_vectors,
    vectors_from_rotations,
)
from topview.track.evidence import Evidence
from topview.track.girth import GirthEstimate
from topview.track.limbs import LIMBS, LimbSearch, LimbSettings
from topview.track.pose import Pose
from topview.track.refinement import Refined, RefinementSettings, refine
from topview.track.timing import StageClock

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class BodySettings:
    """Ours.

    Attributes:
        start_yaws_rad: directions that a person may face at first.
        start_iterations: of refinement for each way to start.
        turned: candidates drawn around the prediction, each frame.
        turn_sigma_rad: how widely they turn about the torso's x, y and z axes.
        free_space_weight, departure_weight: of the costs, against a share of unexplained points.
    """

    limbs: LimbSettings = field(default_factory=LimbSettings)
    refinement: RefinementSettings = field(default_factory=RefinementSettings)
    start_yaws_rad: tuple[float, ...] = (0.0, -0.6, 0.6, -1.2, 1.2)
    start_iterations: int = 15
    start_searched: int = 3
    turned: int = 0
    turn_sigma_rad: tuple[float, float, float] = (0.25, 0.35, 0.15)
    turned_margin: float = 0.03
    velocity_share: float = 0.6
    free_space_weight: float = 1.0
    departure_weight: float = 0.3
    least_points: int = 30


class BodyTracker:
    """One person's pose over time."""

    def __init__(self, person: int, seed: int, settings: BodySettings, threads: int) -> None:
        self.person = person
        self.seed = seed
        self.settings = settings
        self.threads = threads
        self.pose: Pose | None = None
        self._limbs = LimbSearch(settings.limbs, threads)
        self._before: Pose | None = None
        self._girths = GirthEstimate()

    def update(self, model: BodyModel, evidence: Evidence, frame: int, clock: StageClock) -> Pose:
        """The pose in the next frame."""
        model = self._girths.applied_to(model)
        if len(evidence.points_camera) < self.settings.least_points:
            pose = self._hidden(model, evidence)
        elif self.pose is None:
            with clock.stage("start"):
                pose = self._start(model, evidence, frame)
        else:
            pose = self._follow(self.pose, model, evidence, frame, clock)
            self._girths.learn(pose, model, evidence)
        self._before, self.pose = self.pose, pose
        return pose

    def _hidden(self, model: BodyModel, evidence: Evidence) -> Pose:
        """Nothing is seen: the pose is kept, below where the head is thought to be."""
        if self.pose is None:
            return _standing(model, evidence.head_camera, 0.0, seated=False)
        half_head = 0.5 * model.lengths_m[HEAD] * self.pose.Rs[HEAD][:, 1]
        return Pose(evidence.head_camera + half_head, self.pose.Rs)

    def _follow(
        self, last: Pose, model: BodyModel, evidence: Evidence, frame: int, clock: StageClock
    ) -> Pose:
        s = self.settings
        moving = self._extrapolated(last)
        with clock.stage("body"):
            candidates = [last, moving, *self._turned(moving, model, frame)]
            refined = refine(candidates, last, model, evidence, s.refinement)
            costs = self._costs(refined)
            costs[2:] += s.turned_margin
            pose = refined.poses[int(np.argmin(costs))]
        with clock.stage("limbs"):
            pose = self._limbs.search(pose, moving, model, evidence, self._generators(frame))
        with clock.stage("refinement"):
            return refine([pose], pose, model, evidence, s.refinement).poses[0]

    def _start(self, model: BodyModel, evidence: Evidence, frame: int) -> Pose:
        """Try ways to stand or sit, in several directions; search the limbs of the best ones."""
        s = self.settings
        candidates = [
            _standing(model, evidence.head_camera, yaw, seated)
            for seated in (False, True)
            for yaw in s.start_yaws_rad
        ]
        tried = refine(candidates, candidates[0], model, evidence, s.refinement, s.start_iterations)
        order = np.argsort(self._costs(tried), kind="stable")[: s.start_searched]
        searched = []
        for index in order:
            self._limbs.forget()
            pose = tried.poses[index]
            for _ in range(2):
                pose = self._limbs.search(pose, pose, model, evidence, self._generators(frame))
                pose = refine([pose], pose, model, evidence, s.refinement).poses[0]
            searched.append(pose)
        self._limbs.forget()
        measured = refine(searched, searched[0], model, evidence, s.refinement, 0)
        return searched[int(np.argmin(self._costs(measured)))]

    def _costs(self, refined: Refined) -> Array:
        s = self.settings
        return (
            refined.unexplained
            + s.free_space_weight * refined.in_free_space
            + s.departure_weight * refined.departure
        )

    def _extrapolated(self, last: Pose) -> Pose:
        """Constant velocity, damped."""
        if self._before is None:
            return last
        share = self.settings.velocity_share
        before, now = self._before.relative(), last.relative()
        turn = vectors_from_rotations(np.swapaxes(before, 1, 2) @ now)
        return Pose.from_relative(
            last.neck_camera + share * (last.neck_camera - self._before.neck_camera),
            now @ rotations_from_vectors(share * turn),
        )

    def _turned(self, pose: Pose, model: BodyModel, frame: int) -> Sequence[Pose]:
        """Candidates whose torso is turned about the neck, or about the pelvis, by turns; the
        limbs keep their directions in the room."""
        rng = generator(self.seed, self.person, UPPER_TORSO, frame)
        vectors = rng.standard_normal((self.settings.turned, 3)) * self.settings.turn_sigma_rad
        to_pelvis = pose.Rs[UPPER_TORSO][:, 1] * model.lengths_m[UPPER_TORSO]
        to_pelvis += pose.Rs[LOWER_TORSO][:, 1] * model.lengths_m[LOWER_TORSO]
        poses = []
        for index, turn in enumerate(rotations_from_vectors(vectors)):
            Rs = pose.Rs.copy()
            turn_camera = Rs[UPPER_TORSO] @ turn @ Rs[UPPER_TORSO].T
            for part in (UPPER_TORSO, LOWER_TORSO):
                Rs[part] = turn_camera @ Rs[part]
            shift = to_pelvis - turn_camera @ to_pelvis if index % 2 else np.zeros(3)
            poses.append(Pose(pose.neck_camera + shift, Rs))
        return poses

    def _generators(self, frame: int) -> dict[int, np.random.Generator]:
        return {upper: generator(self.seed, self.person, upper, frame) for upper in LIMBS}


def _standing(model: BodyModel, head_camera: Array, yaw_rad: float, seated: bool) -> Pose:
    """Upright below the head, turned by `yaw_rad` from facing the camera; arms down."""
    R_facing = R_CAMERA_FACING @ rotations_from_angles(np.array([0.0, yaw_rad, 0.0]))
    Rs = np.repeat(R_facing[None], len(PARTS), axis=0)
    if seated:
        thigh = R_facing @ rotations_from_angles(np.array([1.4, 0.0, 0.0]))
        Rs[[LEFT_UPPER_LEG, RIGHT_UPPER_LEG]] = thigh
        Rs[[LEFT_LOWER_LEG, RIGHT_LOWER_LEG]] = R_facing
    neck = head_camera + R_facing[:, 1] * 0.5 * model.lengths_m[HEAD]
    return Pose(neck, Rs)
