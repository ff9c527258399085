"""Tracks the body of one person from frame to frame."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from topview.body.model import HEAD_CENTRE, BodyModel
from topview.body.parts import HEAD, LEFT_LOWER_LEG, LOWER_TORSO, RIGHT_LOWER_LEG, UPPER_TORSO
from topview.body.proportions import ANATOMICAL, Proportions
from topview.geometry.rotations import rotations_from_vectors, vectors_from_rotations
from topview.timing import StageClock
from topview.track.body_tracker import Needs, Subject
from topview.track.evidence import Evidence
from topview.track.methods.topview.facing import Facing, FacingSettings
from topview.track.methods.topview.limbs import LIMBS, Kept, LimbSearch, LimbSettings
from topview.track.methods.topview.refinement import Refined, RefinementSettings, refine
from topview.track.pose import HALF_ROUND, OTHER_SIDE, Pose
from topview.track.stances import STANDING, heading, stand, stand_all

Array = NDArray[np.float64]

HEIGHT_STEP_M = 0.01  # a body is rebuilt when its height estimate moves by this; ours


@dataclass(frozen=True, slots=True)
class TopviewSettings:
    """Ours, all of it.

    A pose's cost is the share of the person's points that it leaves unexplained, and what is added
    to that; all costs, margins and weights are in that unit.

    Attributes:
        limbs, refinement, facing: of these steps.
        proportions: of the body.
        statures_m: tried while nobody could measure one; the first is assumed until then.
        stature_frames: for so many frames with the person in sight.
        stoop_weight: cost of a stature, per logarithm of how far it is from the head's height
            above the floor: people stand more often than they stoop.
        lift_weight, lift_m: cost of both feet off the floor, per metre, and from which height on.
        start_yaws_rad: directions that a person may face at first, 0 towards the camera.
        start_iterations: of refinement for each way to start.
        searched: the most promising of these, or of the ways to recover, whose limbs are searched.
        lost_cost, lost_cost_hidden: a pose of higher cost is lost; the second is added in
            proportion to the share of the body that is hidden.
        lost_turns_rad: directions tried to recover, from the one that the torso had.
        lost_iterations: of refinement for each way to recover.
        lost_margin: by which a way to recover must be better.
        turned: ways to recover that turn the predicted torso at random.
        turn_sigma_rad: how widely, about the torso's x, y and z axes.
        turned_hidden, turned_cost: share of head and torso out of sight, and cost of the pose, up
            to which it is asked whether the front is the back.
        hidden_at_ease: share of the body that may be hidden without any of this.
        hidden_hold: how much firmer the pose is held to the one before, per share hidden beyond.
        hidden_still: share hidden beyond, from which on no motion is carried on: what was estimated
            of it from the rest that was seen runs away.
        velocity_share: of the last motion that the prediction carries on.
        free_space_weight, departure_weight: cost of the share of the body in free space, and of
            the mean squared turn away from the prior, per square radian.
        least_points: with fewer the person counts as not seen, and keeps the pose.
    """

    limbs: LimbSettings = field(default_factory=LimbSettings)
    refinement: RefinementSettings = field(default_factory=RefinementSettings)
    facing: FacingSettings = field(default_factory=FacingSettings)
    proportions: Proportions = ANATOMICAL
    statures_m: tuple[float, ...] = (1.72, 1.25, 1.4, 1.55, 1.9)
    stature_frames: int = 15
    stoop_weight: float = 0.2
    lift_weight: float = 0.3
    lift_m: float = 0.15
    start_yaws_rad: tuple[float, ...] = (0.0, -0.7, 0.7, -1.4, 1.4)
    start_iterations: int = 10
    searched: int = 3
    lost_cost: float = 0.3
    lost_cost_hidden: float = 0.5
    lost_turns_rad: tuple[float, ...] = (0.0, -0.7, 0.7)
    lost_iterations: int = 8
    lost_margin: float = 0.02
    turned: int = 12
    turn_sigma_rad: tuple[float, float, float] = (0.5, 0.5, 0.25)
    turned_hidden: float = 0.3
    turned_cost: float = 0.28
    hidden_at_ease: float = 0.15
    hidden_hold: float = 30.0
    hidden_still: float = 0.1
    velocity_share: float = 0.6
    free_space_weight: float = 1.0
    departure_weight: float = 0.3
    least_points: int = 30

    needs: ClassVar[Needs] = Needs(hidden_share=True)

    @property
    def name(self) -> str:
        return "topview"

    def tracker(self, subject: Subject) -> TopviewTracker:
        return TopviewTracker(subject, self)


@dataclass(frozen=True, slots=True, eq=False)
class FrameContext:
    """One frame, as every step of a tracker needs it."""

    model: BodyModel
    evidence: Evidence
    clock: StageClock


@dataclass(frozen=True, slots=True, eq=False)
class _Found:
    """A pose and the limb hypotheses that go on with it, the body it was found for, its cost,
    and the share of it that is hidden, beyond what is at ease."""

    pose: Pose
    kept: Kept
    model: BodyModel
    cost: float
    hidden: float


class TopviewTracker:
    """One person's pose over time."""

    def __init__(self, subject: Subject, settings: TopviewSettings) -> None:
        self.subject = subject
        self.settings = settings
        self.pose: Pose | None = None
        self._limbs = LimbSearch(settings.limbs, subject.threads)
        self._facing = Facing(settings.facing)
        self._before: Pose | None = None
        self._kept: Kept = {}
        self._hidden_share = 0.0
        self._frames = 0
        self.model = BodyModel.of(settings.statures_m[0], settings.proportions)

    def update(self, evidence: Evidence) -> Pose:
        """The pose in the next frame."""
        stature_m = evidence.stature_m
        self._scale_to(stature_m)
        if len(evidence.points_camera) < self.settings.least_points:
            pose = self._hidden(evidence)
        else:
            look = FrameContext(self.model, evidence, self.subject.clock)
            is_open = stature_m is None and self._frames < self.settings.stature_frames
            statures_m = self.settings.statures_m if is_open else (self.model.stature_m,)
            self._frames += 1
            if self.pose is None:
                found = self._start(look, statures_m)
            else:
                found = self._follow(self.pose, look, statures_m)
            found = self._facing_front(found, look)
            pose, self._kept, self.model = found.pose, found.kept, found.model
            self._hidden_share = found.hidden
        self._before, self.pose = self.pose, pose
        return pose

    def _scale_to(self, stature_m: float | None) -> None:
        if stature_m is not None and abs(stature_m - self.model.stature_m) > HEIGHT_STEP_M:
            self.model = BodyModel.of(stature_m, self.settings.proportions)

    def _hidden(self, evidence: Evidence) -> Pose:
        """Nothing is seen: the pose is kept, below where the head is thought to be."""
        if self.pose is None:
            return stand(self.model, evidence.head_camera, STANDING, 0.0, evidence.up_camera)
        half_head = HEAD_CENTRE * self.model.lengths_m[HEAD] * self.pose.Rs[HEAD][:, 1]
        return Pose(evidence.head_camera + half_head, self.pose.Rs)

    def _follow(self, last: Pose, look: FrameContext, statures_m: Sequence[float]) -> _Found:
        """Predict, refine, search the limbs, refine; if that does not explain the person, look
        wider."""
        s = self.settings
        hidden = max(self._hidden_share, self._beyond_ease(look.evidence.hidden_share))
        moving = self._extrapolated(last) if hidden < s.hidden_still else last
        with look.clock.stage("body"):
            hold = 1.0 + s.hidden_hold * hidden
            refined = self._refined([last, moving], last, look, hold=hold)
            pose = refined.poses[int(np.argmin(self._costs(refined)))]
        found = self._with_limbs(pose, moving, self._kept, look, hold)
        if found.cost < s.lost_cost + s.lost_cost_hidden * found.hidden:
            return found
        with look.clock.stage("body"):
            up = look.evidence.up_camera
            yaw = heading(last.Rs[UPPER_TORSO], up)
            yaws = [yaw + turn for turn in s.lost_turns_rad]
            trials = [(look.model, self._turned(moving, look))]
            trials += self._stances(yaws, look, statures_m)
        others = self._best_with_limbs(trials, s.lost_iterations, look)
        gain = found.cost + self._lift_cost(found, look.evidence)
        gain -= others.cost + self._lift_cost(others, look.evidence)
        return others if gain > s.lost_margin else found

    def _start(self, look: FrameContext, statures_m: Sequence[float]) -> _Found:
        """Try every stance in several directions."""
        s = self.settings
        trials = self._stances(s.start_yaws_rad, look, statures_m)
        return self._best_with_limbs(trials, s.start_iterations, look)

    def _facing_front(self, found: _Found, look: FrameContext) -> _Found:
        """What was found, or that turned round where its back is the front."""
        self._facing.step(found.pose, look.evidence.up_camera)
        s = self.settings
        is_clear = found.cost < s.turned_cost and self._trunk_hidden(found, look) < s.turned_hidden
        if not is_clear or not self._facing.is_due(look.evidence.frame_index):
            return found
        look = replace(look, model=found.model)
        with look.clock.stage("facing"):
            refined = self._refined([found.pose.turned_round()], None, look)
            twin = refined.poses[0]
            self._facing.look(found.pose, twin, found.model, look.evidence)
        if not self._facing.is_reversed():
            return found
        kept = {upper: found.kept[OTHER_SIDE[upper]] @ HALF_ROUND for upper in found.kept}
        turned = self._with_limbs(twin, twin, kept, look)
        if turned.cost > found.cost + s.lost_margin:
            self._facing.forget()
            return found
        self._facing.turn_round()
        self.pose = None  # no motion leads from the one to the other
        return turned

    def _trunk_hidden(self, found: _Found, look: FrameContext) -> float:
        """Share of the axes of head and torso that is out of sight."""
        trunk = [HEAD, UPPER_TORSO, LOWER_TORSO]
        along = ((np.arange(4) + 0.5) / 4)[:, None, None] * found.model.lengths_m[trunk, None]
        places = found.pose.origins(found.model)[trunk] + along * found.pose.Rs[trunk, :, 1]
        radius_m = found.model.radii_m[trunk].min()
        return float(look.evidence.out_of_sight(places.reshape(-1, 3), radius_m).mean())

    def _stances(
        self, yaws_rad: Sequence[float], look: FrameContext, statures_m: Sequence[float]
    ) -> list[tuple[BodyModel, list[Pose]]]:
        """Every stance in these directions, for every stature that the person may have."""
        head, up = look.evidence.head_camera, look.evidence.up_camera
        models = [BodyModel.of(m, self.settings.proportions) for m in statures_m]
        return [(model, stand_all(model, head, yaws_rad, up)) for model in models]

    def _best_with_limbs(
        self, trials: list[tuple[BodyModel, list[Pose]]], iterations: int, look: FrameContext
    ) -> _Found:
        """Refine candidates that know nothing of the frames before, search the limbs of the most
        promising ones, and give the best."""
        with look.clock.stage("body"):
            looks = [replace(look, model=model) for model, _ in trials]
            tried: list[tuple[float, int, Pose]] = []
            for index, (_, poses) in enumerate(trials):
                refined = self._refined(poses, None, looks[index], iterations)
                costs = self._costs(refined) + self._stature_cost(looks[index].model, look.evidence)
                tried += [(float(c), index, p) for c, p in zip(costs, refined.poses, strict=True)]
            tried.sort(key=lambda trial: trial[0])
        founds = []
        for _, index, pose in tried[: self.settings.searched]:
            found = self._with_limbs(pose, pose, {}, looks[index])
            founds.append(self._with_limbs(found.pose, found.pose, found.kept, looks[index]))
        return min(
            founds,
            key=lambda found: (
                found.cost
                + self._stature_cost(found.model, look.evidence)
                + self._lift_cost(found, look.evidence)
            ),
        )

    def _stature_cost(self, model: BodyModel, evidence: Evidence) -> float:
        """What speaks against a stature before any pose: people stand more often than they sit,
        and nobody is shorter than the head is high above the floor."""
        floor, head = evidence.floor, evidence.head_camera
        if not floor.any():
            return 0.0
        top_m = floor[:3] @ head + floor[3] + HEAD_CENTRE * model.lengths_m[HEAD]
        stoop = np.log(model.stature_m / max(top_m, 0.3))
        return float(self.settings.stoop_weight * abs(stoop))

    def _lift_cost(self, found: _Found, evidence: Evidence) -> float:
        """What speaks against a pose whose feet are both off the floor."""
        if not evidence.floor.any():
            return 0.0
        legs = [LEFT_LOWER_LEG, RIGHT_LOWER_LEG]
        soles = found.pose.origins(found.model)[legs]
        soles = soles + found.pose.Rs[legs, :, 1] * found.model.lengths_m[legs, None]
        lowest_m = float((soles @ evidence.floor[:3]).min() + evidence.floor[3])
        return self.settings.lift_weight * max(0.0, lowest_m - self.settings.lift_m)

    def _with_limbs(
        self, pose: Pose, predicted: Pose, kept: Kept, look: FrameContext, hold: float = 1.0
    ) -> _Found:
        """The pose with its limbs searched and all of it refined."""
        with look.clock.stage("limbs"):
            rngs = {upper: self.subject.rng(upper, look.evidence) for upper in LIMBS}
            pose, kept = self._limbs.search(pose, predicted, look.model, look.evidence, rngs, kept)
        with look.clock.stage("refinement"):
            prior = _with_torso_of(predicted, pose) if hold > 1.0 else None
            refined = self._refined([pose], prior, look, hold=hold)
        cost = float(self._costs(refined)[0])
        found = _Found(refined.poses[0], kept, look.model, cost, 0.0)
        # Legs out of view say nothing of a trunk that is seen.
        hidden = min(float(refined.hidden[0]), 2.0 * self._trunk_hidden(found, look))
        hidden = self._beyond_ease(max(hidden, look.evidence.hidden_share))
        return replace(found, hidden=hidden)

    def _beyond_ease(self, hidden_share: float) -> float:
        return max(0.0, hidden_share - self.settings.hidden_at_ease)

    def _refined(
        self,
        poses: list[Pose],
        prior: Pose | None,
        look: FrameContext,
        iterations: int | None = None,
        hold: float = 1.0,
    ) -> Refined:
        settings = self.settings.refinement
        return refine(poses, prior, look.model, look.evidence, settings, iterations, hold)

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

    def _turned(self, pose: Pose, look: FrameContext) -> list[Pose]:
        """Candidates whose torso is turned about the neck, or about the pelvis, by turns; the
        limbs keep their directions in the room."""
        rng = self.subject.rng(UPPER_TORSO, look.evidence)
        vectors = rng.standard_normal((self.settings.turned, 3)) * self.settings.turn_sigma_rad
        to_pelvis = pose.Rs[UPPER_TORSO][:, 1] * look.model.lengths_m[UPPER_TORSO]
        to_pelvis += pose.Rs[LOWER_TORSO][:, 1] * look.model.lengths_m[LOWER_TORSO]
        poses = []
        for index, turn in enumerate(rotations_from_vectors(vectors)):
            Rs = pose.Rs.copy()
            turn_camera = Rs[UPPER_TORSO] @ turn @ Rs[UPPER_TORSO].T
            for part in (UPPER_TORSO, LOWER_TORSO):
                Rs[part] = turn_camera @ Rs[part]
            shift = to_pelvis - turn_camera @ to_pelvis if index % 2 else np.zeros(3)
            poses.append(Pose(pose.neck_camera + shift, Rs))
        return poses


def _with_torso_of(torso: Pose, limbs: Pose) -> Pose:
    """Head and torso of one pose, the limbs' directions of another."""
    Rs = limbs.Rs.copy()
    Rs[: LOWER_TORSO + 1] = torso.Rs[: LOWER_TORSO + 1]
    return Pose(torso.neck_camera, Rs)
