"""Tracks the body of one person from frame to frame."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import ClassVar, Final

import numpy as np
from numpy.typing import NDArray

from topview.body.model import HEAD_CENTRE, BodyModel
from topview.body.parts import HEAD, LEFT_LOWER_LEG, LOWER_TORSO, RIGHT_LOWER_LEG, UPPER_TORSO
from topview.detect.joints import JointProposals
from topview.filter.over_time import FRAME_S, begins_turn, frames_in, share_after
from topview.geometry.rotations import rotations_from_vectors, vectors_from_rotations
from topview.people.bodies import SHOWN_M2
from topview.records import InputError
from topview.timing import StageClock
from topview.track.body_tracker import Needs, Subject
from topview.track.bone_lengths import BoneLengths, dressed_body
from topview.track.evidence import Evidence
from topview.track.familiarity import Familiarity
from topview.track.joint_fit import JointTargets
from topview.track.methods.topview.facing import Facing, FacingSettings
from topview.track.methods.topview.guided import Guide, GuideSettings, ProposedBody
from topview.track.methods.topview.limbs import LIMBS, Kept, LimbSearch, LimbSettings
from topview.track.methods.topview.lookup import SHARES, shipped_poses
from topview.track.methods.topview.refinement import Refined, RefinementSettings, refine
from topview.track.methods.topview.usual_poses import usual_poses
from topview.track.pose import HALF_ROUND, OTHER_SIDE, Pose
from topview.track.stances import STANDING, heading, stand, stand_all
from topview.track.stature import StatureBelief

Array = NDArray[np.float64]

# All ours. A pose's cost is the share of the person's points that it leaves unexplained, and what
# is added to that; all costs, margins and weights are in that unit.
HEIGHT_STEP_M: Final = 0.01  # a body is rebuilt when its height estimate moves by this
LEAST_BODY_POINTS: Final = 30  # with fewer the person counts as not seen, and keeps the pose
STATURE_S: Final = 0.5  # with the person in sight, in which statures are tried
LIMB_SEARCH_S: Final = 1 / 15  # from one search of the limbs to the next
STOOP_WEIGHT: Final = 0.2  # of a stature, per logarithm of its ratio to the head's height
LIFT_WEIGHT_PER_M: Final = 0.3  # of both feet off the floor, beyond `LIFT_M`
LIFT_M: Final = 0.15
FREE_SPACE_COST: Final = 1.0  # of the share of the body in free space
DEPARTURE_COST: Final = 0.3  # of the mean squared turn away from the prior, per square radian
VELOCITY_S: Final = 0.0295  # after which 63 % of a velocity is gone
USUAL_S: Final = 0.15  # after which a prior's limbs are by 63 % where people usually have them
# A person is searched anew at first, and when the pose is lost: its cost is above `LOST_COST`, to
# which the second is added in proportion to the occluded share. A recovery must be better by
# `LOST_MARGIN`.
START_YAWS_RAD: Final = (0.0, -0.7, 0.7, -1.4, 1.4)  # from facing the camera
START_ITERATIONS: Final = 10  # of refinement, of each candidate
SEARCHED: Final = 3  # best candidates whose limbs are searched
LOST_COST: Final = 0.3
LOST_COST_OCCLUDED: Final = 0.5
LOST_MARGIN: Final = 0.02
LOST_YAWS_RAD: Final = (0.0, -0.7, 0.7)  # from that of the torso
LOST_ITERATIONS: Final = 8
TURNED: Final = 12  # candidates whose torso is turned at random
TURN_SIGMA_RAD: Final = (0.5, 0.5, 0.25)  # about its x, y and z
# Bodies of the pose table that are refined whenever the limbs are searched; of one that costs no
# more than this above what there is, the limbs are searched, too.
LOOKED_UP: Final = 6
LOOKED_UP_ITERATIONS: Final = 5
LOOKED_UP_HIDDEN: Final = 0.05  # share of a body; one of which more is hidden is not taken
PROMISING: Final = 0.02
# It is asked whether the front is the back, up to this share of head and torso out of sight, and
# this cost.
FACING_OCCLUSION: Final = 0.3
FACING_COST: Final = 0.28
# Occlusion beyond the tolerated share scales the prior, per share, and from the last on stops the
# predicted motion: what was estimated of it from the rest that was seen runs away.
TOLERATED_OCCLUSION: Final = 0.15
OCCLUDED_PRIOR_SCALE: Final = 30.0
STILL_OCCLUSION: Final = 0.1


@dataclass(frozen=True, slots=True)
class TopviewSettings:
    """The default method.

    Attributes:
        limbs, refinement, facing, guide: of these steps.
        statures_m: tried while nobody could measure one, 0.3 to 3 metres; the first is assumed
            until then.

    Raises:
        InputError: no stature, or one out of range.
    """

    limbs: LimbSettings = field(default_factory=LimbSettings)
    refinement: RefinementSettings = field(default_factory=RefinementSettings)
    facing: FacingSettings = field(default_factory=FacingSettings)
    guide: GuideSettings = field(default_factory=GuideSettings)
    statures_m: tuple[float, ...] = (1.72, 1.25, 1.4, 1.55, 1.9)

    def __post_init__(self) -> None:
        if not self.statures_m or not all(0.3 <= m <= 3.0 for m in self.statures_m):
            raise InputError(
                f"statures_m is {self.statures_m}; it must hold one or more of 0.3 to 3 metres"
            )

    needs: ClassVar[Needs] = Needs(hidden_share=True, joints=True)

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
    elapsed_s: float  # since the frame before


@dataclass(frozen=True, slots=True, eq=False)
class _Found:
    """A pose and the limb hypotheses that go on with it, the body it was found for, its cost,
    and the share of it that is occluded, beyond what is tolerated."""

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
        self._last_s: float | None = None  # when the pose was
        self._step_s = 0.0  # from the one before to it
        self._kept: Kept = {}
        self._hidden_share = 0.0
        self._in_sight_s = 0.0
        self._share = 0  # of the table, which is looked through next
        self._guide = Guide(settings.guide, subject.bones)
        self._stature = StatureBelief(subject.stature_is_given)
        self.model = dressed_body(settings.statures_m[0])

    @property
    def bones(self) -> BoneLengths:
        """As far as they are known."""
        return self._guide.bones

    @property
    def familiarity(self) -> Familiarity:
        """Of the last frame with proposals."""
        return self._guide.familiarity

    def update(self, evidence: Evidence) -> Pose:
        """The pose in the next frame."""
        stature_m = evidence.stature_m
        if stature_m is not None:
            self._stature.tell(stature_m)
            self._scale_to(self._stature.stature_m)
        elapsed_s = 0.0 if self._last_s is None else max(evidence.timestamp_s - self._last_s, 0.0)
        if self._is_out_of_sight(evidence):
            pose = self._hidden(evidence)
        else:
            look = FrameContext(self.model, evidence, self.subject.clock, elapsed_s)
            is_open = stature_m is None and self._in_sight_s < STATURE_S
            statures_m = self.settings.statures_m if is_open else (self.model.stature_m,)
            self._in_sight_s += FRAME_S * frames_in(elapsed_s)
            if evidence.proposals is not None:
                found = self._guided(look, evidence.proposals)
            elif self.pose is None:
                found = self._start(look, statures_m)
            else:
                found = self._follow(self.pose, look, statures_m)
            if evidence.proposals is None:
                found = self._facing_front(found, look)
            pose, self._kept, self.model = found.pose, found.kept, found.model
            self._hidden_share = found.hidden
            if is_open:
                self._stature.begin(self.model.stature_m)
        self._before, self.pose = self.pose, pose
        self._last_s, self._step_s = evidence.timestamp_s, elapsed_s
        return pose

    def _scale_to(self, stature_m: float) -> None:
        if abs(stature_m - self.model.stature_m) > HEIGHT_STEP_M:
            self.model = dressed_body(stature_m)

    def _is_out_of_sight(self, evidence: Evidence) -> bool:
        """Whether too little is seen to look for a pose. Of whom joints have been proposed before,
        but not in this frame, that is less than somebody is found by."""
        points = len(evidence.points_camera)
        if evidence.proposals is None and self._guide.has_begun:
            return points * evidence.point_area_m2 < SHOWN_M2
        return points < LEAST_BODY_POINTS

    def _hidden(self, evidence: Evidence) -> Pose:
        """Nothing is seen: the pose is kept, below where the head is thought to be."""
        if self.pose is None:
            return stand(self.model, evidence.head_camera, STANDING, 0.0, evidence.up_camera)
        return Pose.below_head(evidence.head_camera, self.pose.Rs, self.model)

    def _follow(self, last: Pose, look: FrameContext, statures_m: Sequence[float]) -> _Found:
        """Predict, refine, search the limbs, refine; if that does not explain the person, look
        wider."""
        hidden, moving = self._hidden_now(look), self._predicted(last, look)
        with look.clock.stage("body"):
            prior_scale = _firmness(look.elapsed_s) * (1.0 + OCCLUDED_PRIOR_SCALE * hidden)
            refined = self._refined([last, moving], last, look, prior_scale=prior_scale)
            pose = refined.poses[int(np.argmin(self._costs(refined)))]
        torso = moving if hidden > 0.0 else None
        if self._limbs_are_due(look):
            found = self._with_limbs(pose, moving, self._kept, look, torso, prior_scale)
        else:
            found = self._refined_whole(pose, self._kept, look, torso, prior_scale)
        if found.hidden == 0.0 and self._limbs_are_due(look):
            found = self._or_looked_up(found, look)
        is_lost = found.cost > LOST_COST + LOST_COST_OCCLUDED * found.hidden
        if self._limbs_are_due(look) and self._stature.is_doubted(is_lost):
            found = self._with_stature(found, is_lost, look)
        if not is_lost:
            return found
        with look.clock.stage("body"):
            up = look.evidence.up_camera
            yaw = heading(last.Rs[UPPER_TORSO], up)
            yaws = [yaw + turn for turn in LOST_YAWS_RAD]
            trials = [(look.model, self._turned(moving, look))]
            trials += self._stances(yaws, look, statures_m)
        others = self._best_with_limbs(trials, LOST_ITERATIONS, look)
        gain = found.cost + self._lift_cost(found, look.evidence)
        gain -= others.cost + self._lift_cost(others, look.evidence)
        return others if gain > LOST_MARGIN else found

    def _with_stature(self, found: _Found, is_lost: bool, look: FrameContext) -> _Found:
        """What was found, or a pose of another stature if that is believed from now on."""
        believed_m, tried_m = self._stature.stature_m, self._stature.next_m()
        _, cost = self._of_stature(found, found.model.stature_m, is_lost, look)
        pose, tried_cost = self._of_stature(found, tried_m, is_lost, look)
        self._stature.judge(cost, tried_cost)
        if self._stature.stature_m == believed_m:
            return found
        return self._with_limbs(pose, pose, {}, replace(look, model=dressed_body(tried_m)))

    def _of_stature(
        self, found: _Found, stature_m: float, is_lost: bool, look: FrameContext
    ) -> tuple[Pose, float]:
        """The pose that was found, or a stance if it is lost, of a body of another stature, and
        what it costs."""
        model, evidence = dressed_body(stature_m), look.evidence
        poses = [found.pose]
        with look.clock.stage("body"):
            if is_lost:
                yaw_rad = heading(found.pose.Rs[UPPER_TORSO], evidence.up_camera)
                poses += stand_all(model, evidence.head_camera, [yaw_rad], evidence.up_camera)
            first_look = replace(look, model=model, evidence=evidence.thinned())
            refined = self._refined(poses, None, first_look, LOOKED_UP_ITERATIONS)
            costs = self._costs(refined)
        return refined.poses[int(np.argmin(costs))], float(costs.min())

    def _or_looked_up(self, found: _Found, look: FrameContext) -> _Found:
        """What was found, or a body of the table that looks like what is seen and costs less."""
        evidence = look.evidence
        first_look = replace(look, model=found.model, evidence=evidence.thinned())
        with look.clock.stage("lookup"):
            alike = shipped_poses().likeness(evidence, found.model.stature_m, self._share)
            poses = alike.poses(found.model, LOOKED_UP)
            self._share = (self._share + 1) % SHARES
        with look.clock.stage("body"):
            refined = self._refined(poses, None, first_look, LOOKED_UP_ITERATIONS)
            costs = self._costs(refined)
        best = int(np.argmin(costs))
        if costs[best] > found.cost + PROMISING or refined.hidden[best] > LOOKED_UP_HIDDEN:
            return found
        pose = refined.poses[best]
        other = self._with_limbs(pose, pose, {}, replace(look, model=found.model))
        gain = found.cost + self._lift_cost(found, evidence)
        gain -= other.cost + self._lift_cost(other, evidence)
        if gain < LOST_MARGIN:
            return found
        if found.pose.Rs[UPPER_TORSO][:, 2] @ other.pose.Rs[UPPER_TORSO][:, 2] < 0.0:
            self._facing.turn_round()
        return other

    def _guided(self, look: FrameContext, proposals: JointProposals) -> _Found:
        """The best of the bodies that are proposed and the one that is predicted, each refined with
        the proposed joints."""
        stature_m = look.evidence.stature_m or look.model.stature_m
        with look.clock.stage("fit"):
            elapsed_s = self._guide.elapsed_s(look.evidence.timestamp_s)
            proposals = self._guide.filtered(proposals, elapsed_s)
            belief = self._guide.believe(proposals, elapsed_s)
            look = replace(look, model=self._guide.model(proposals, belief, stature_m))
            bodies = self._guide.bodies(proposals, belief, look.model, elapsed_s)
        moving = None if self.pose is None else self._predicted(self.pose, look)
        with look.clock.stage("refinement"):
            found = min(
                (self._refined_guided(body, moving, look) for body in bodies),
                key=lambda found: found.cost,
            )
        hidden = _beyond_tolerance(max(found.hidden, look.evidence.hidden_share))
        return replace(found, hidden=hidden)

    def _refined_guided(
        self, body: ProposedBody, moving: Pose | None, look: FrameContext
    ) -> _Found:
        """The better of the proposed and the predicted pose, refined with the proposed joints."""
        starts = [body.pose] if moving is None else [body.pose, moving]
        firmness = _firmness(look.elapsed_s)
        refined = self._refined(starts, moving, look, prior_scale=firmness, targets=body.targets)
        costs = self._costs(refined) + self.settings.guide.joints_cost * refined.apart + body.cost
        best = int(np.argmin(costs))
        hidden = float(refined.hidden[best])
        return _Found(refined.poses[best], self._kept, look.model, float(costs[best]), hidden)

    def _start(self, look: FrameContext, statures_m: Sequence[float]) -> _Found:
        """Try every stance in several directions."""
        trials = self._stances(START_YAWS_RAD, look, statures_m)
        return self._best_with_limbs(trials, START_ITERATIONS, look)

    def _facing_front(self, found: _Found, look: FrameContext) -> _Found:
        """What was found, or that turned round where its back is the front."""
        self._facing.step(found.pose, look.evidence.up_camera)
        is_clear = found.cost < FACING_COST and self._trunk_hidden(found, look) < FACING_OCCLUSION
        if not is_clear or not self._facing.is_due(look.evidence.timestamp_s):
            return found
        look = replace(look, model=found.model)
        with look.clock.stage("facing"):
            refined = self._refined([found.pose.turned_round()], None, look)
            twin = refined.poses[0]
            self._facing.look(found.pose, twin, found.model, look.evidence)
        if not self._facing.is_reversed():
            return found
        kept = {upper: found.kept[OTHER_SIDE[upper]] @ HALF_ROUND for upper in found.kept}
        turned = self._with_limbs(twin, twin, kept, look, holds_hidden=False)
        if turned.cost > found.cost + LOST_MARGIN:
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
        models = [dressed_body(m) for m in statures_m]
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
        for _, index, pose in tried[:SEARCHED]:
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
        return float(STOOP_WEIGHT * abs(stoop))

    def _lift_cost(self, found: _Found, evidence: Evidence) -> float:
        """What speaks against a pose whose feet are both off the floor."""
        if not evidence.floor.any():
            return 0.0
        legs = [LEFT_LOWER_LEG, RIGHT_LOWER_LEG]
        soles = found.pose.origins(found.model)[legs]
        soles = soles + found.pose.Rs[legs, :, 1] * found.model.lengths_m[legs, None]
        lowest_m = float((soles @ evidence.floor[:3]).min() + evidence.floor[3])
        return LIFT_WEIGHT_PER_M * max(0.0, lowest_m - LIFT_M)

    def _limbs_are_due(self, look: FrameContext) -> bool:
        """Whether to search the limbs: at the same moments whatever the rate of frames; refinement
        alone follows them in between."""
        return begins_turn(look.evidence.timestamp_s, self._last_s, LIMB_SEARCH_S)

    def _with_limbs(
        self,
        pose: Pose,
        predicted: Pose,
        kept: Kept,
        look: FrameContext,
        torso: Pose | None = None,
        prior_scale: float = 1.0,
        *,
        holds_hidden: bool = True,
    ) -> _Found:
        """The pose with its limbs searched and all of it refined."""
        with look.clock.stage("limbs"):
            rngs = {upper: self.subject.rng(upper, look.evidence) for upper in LIMBS}
            pose, kept = self._limbs.search(
                pose, predicted, look.model, look.evidence, rngs, kept, holds_hidden=holds_hidden
            )
        return self._refined_whole(pose, kept, look, torso, prior_scale)

    def _refined_whole(
        self,
        pose: Pose,
        kept: Kept,
        look: FrameContext,
        torso: Pose | None,
        prior_scale: float,
    ) -> _Found:
        """The pose with all parts refined, and what it costs; head and torso are held to those of
        `torso` where much is hidden."""
        with look.clock.stage("refinement"):
            prior = pose if torso is None else _with_torso_of(torso, pose)
            refined = self._refined([pose], prior, look, prior_scale=prior_scale)
        cost = float(self._costs(refined)[0])
        found = _Found(refined.poses[0], kept, look.model, cost, 0.0)
        # Legs out of view say nothing of a trunk that is seen.
        hidden = min(float(refined.hidden[0]), 2.0 * self._trunk_hidden(found, look))
        hidden = _beyond_tolerance(max(hidden, look.evidence.hidden_share))
        return replace(found, hidden=hidden)

    def _refined(
        self,
        poses: list[Pose],
        prior: Pose | None,
        look: FrameContext,
        iterations: int | None = None,
        prior_scale: float = 1.0,
        targets: JointTargets | None = None,
    ) -> Refined:
        """Poses that are held to a prior, or each to where it starts. Where no joints are proposed,
        a prior is drawn to what bodies usually do."""
        settings = self.settings.guide.refinement if targets else self.settings.refinement
        if prior is not None and targets is None:
            share = share_after(max(look.elapsed_s, FRAME_S), USUAL_S)
            prior = usual_poses().towards(prior, share)
        return refine(
            poses, prior, look.model, look.evidence, settings, iterations, prior_scale, targets
        )

    def _costs(self, refined: Refined) -> Array:
        return (
            refined.unexplained
            + FREE_SPACE_COST * refined.in_free_space
            + DEPARTURE_COST * refined.departure
        )

    def _hidden_now(self, look: FrameContext) -> float:
        """Share that is hidden, or was in the last frame, beyond what is tolerated."""
        return max(self._hidden_share, _beyond_tolerance(look.evidence.hidden_share))

    def _predicted(self, last: Pose, look: FrameContext) -> Pose:
        """Where the last pose has moved to; of whom much is hidden that is not known."""
        is_seen = self._hidden_now(look) < STILL_OCCLUSION
        return self._extrapolated(last, look.elapsed_s) if is_seen else last

    def _extrapolated(self, last: Pose, elapsed_s: float) -> Pose:
        """Constant velocity, damped."""
        if self._before is None or self._step_s <= 0.0:
            return last
        share = VELOCITY_S * share_after(elapsed_s, VELOCITY_S) / self._step_s
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
        vectors = rng.standard_normal((TURNED, 3)) * TURN_SIGMA_RAD
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


def _firmness(elapsed_s: float) -> float:
    """Factor on a prior's weight after so long: the longer ago a pose was seen, the less it tells
    of the present one; its variance grows with the time, as a random walk's does."""
    return 1.0 / max(frames_in(elapsed_s), 0.25)


def _beyond_tolerance(hidden_share: float) -> float:
    return max(0.0, hidden_share - TOLERATED_OCCLUSION)


def _with_torso_of(torso: Pose, limbs: Pose) -> Pose:
    """Head and torso of one pose, the limbs' directions of another."""
    Rs = limbs.Rs.copy()
    Rs[: LOWER_TORSO + 1] = torso.Rs[: LOWER_TORSO + 1]
    return Pose(torso.neck_camera, Rs)
