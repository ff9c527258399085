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
from topview.track.methods.topview.facing import FacingBelief
from topview.track.methods.topview.guided import Guide, GuideSettings, ProposedBody
from topview.track.methods.topview.limbs import LIMBS, Kept, LimbSearch, LimbSettings
from topview.track.methods.topview.lookup import SHARES, Likeness, shipped_poses
from topview.track.methods.topview.refinement import Refined, RefinementSettings, refine
from topview.track.methods.topview.usual_poses import usual_poses
from topview.track.pose import Pose
from topview.track.stances import STANDING, heading, stand, stand_all
from topview.track.stature import StatureBelief

Array = NDArray[np.float64]

# All ours. A pose's cost is the share of the person's points that it leaves unexplained, and what
# is added to that; all costs, margins and weights are in that unit.
HEIGHT_STEP_M: Final = 0.01  # a body is rebuilt when its height estimate moves by this
LEAST_BODY_POINTS: Final = 30  # with fewer the person counts as not seen, and keeps the pose
STATURE_S: Final = 0.5  # with the person in sight, in which statures are tried
LOOK_S: Final = 1 / 15  # from one look for poses elsewhere, and for limbs, to the next
STOOP_WEIGHT: Final = 0.2  # of a stature, per logarithm of its ratio to the head's height
LIFT_WEIGHT_PER_M: Final = 0.3  # of both feet off the floor, beyond `LIFT_M`
LIFT_M: Final = 0.15
FREE_SPACE_COST: Final = 1.0  # of the share of the body in free space
DEPARTURE_COST: Final = 0.3  # of the mean squared turn away from the prior, per square radian
VELOCITY_S: Final = 0.0295  # after which 63 % of a velocity is gone
USUAL_S: Final = 0.15  # after which a prior's limbs are by 63 % where people usually have them
# A pose is lost, and searched anew from stances, where its cost is above the first, to which the
# second is added in proportion to the occluded share.
LOST_COST: Final = 0.3
LOST_COST_OCCLUDED: Final = 0.5
# Poses from elsewhere are refined in so many steps at a first look, and the best so many of them
# once more. One is taken that is cheaper by so much than the pose that has moved on, and of which
# no more is hidden than a share of the body.
LOOKED_UP: Final = 6
LOOKED_UP_ITERATIONS: Final = 5
LOOKED_AT_AGAIN: Final = 2
NEWS_MARGIN: Final = 0.02
LOOKED_UP_HIDDEN: Final = 0.05
# Of so many bodies of the table each limb is tried in the pose, refined in so many steps, and taken
# where all of it is cheaper by so much.
LENDERS: Final = 5
LENT_ITERATIONS: Final = 3
LIMB_MARGIN: Final = 0.005
# Occlusion beyond the tolerated share scales the prior, per share, and from the last on stops the
# predicted motion: what was estimated of it from the rest that was seen runs away.
TOLERATED_OCCLUSION: Final = 0.15
OCCLUDED_PRIOR_SCALE: Final = 30.0
STILL_OCCLUSION: Final = 0.1


@dataclass(frozen=True, slots=True)
class TopviewSettings:
    """The default method.

    Attributes:
        limbs, refinement, guide: of these steps.
        statures_m: tried while nobody could measure one, 0.3 to 3 metres; the first is assumed
            until then.

    Raises:
        InputError: no stature, or one out of range.
    """

    limbs: LimbSettings = field(default_factory=LimbSettings)
    refinement: RefinementSettings = field(default_factory=RefinementSettings)
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
    the share of it that is occluded, and whether it has not moved on from the last one."""

    pose: Pose
    kept: Kept
    model: BodyModel
    cost: float
    hidden: float
    is_new: bool = False


class TopviewTracker:
    """One person's pose over time."""

    def __init__(self, subject: Subject, settings: TopviewSettings) -> None:
        self.subject = subject
        self.settings = settings
        self.pose: Pose | None = None
        self._limbs = LimbSearch(settings.limbs, subject.threads)
        self._facing = FacingBelief()
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
                self._facing.begin(heading(found.pose.Rs[UPPER_TORSO], evidence.up_camera))
            else:
                found = self._searched(look, statures_m)
            pose, self._kept, self.model = found.pose, found.kept, found.model
            self._hidden_share = found.hidden
            if found.is_new:
                self.pose = None  # no motion leads from the one to the other
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

    def _searched(self, look: FrameContext, statures_m: Sequence[float]) -> _Found:
        """The cheapest of the last pose as it has moved on, captured bodies that look like what is
        seen, poses with limbs of these, and with limbs that were searched."""
        evidence = look.evidence
        with look.clock.stage("lookup"):
            share = None if self.pose is None else self._share
            alike = shipped_poses().likeness(evidence, look.model.stature_m, share)
            self._share = (self._share + 1) % SHARES
            self._facing.update(alike, look.elapsed_s)
        found = None if self.pose is None else self._moved_on(self.pose, look)
        is_due = begins_turn(evidence.timestamp_s, self._last_s, LOOK_S)
        if found is None or is_due:
            with look.clock.stage("body"):
                found = self._or_alike(found, alike, look, statures_m)
                if found.hidden == 0.0:
                    found = self._or_with_lent_limbs(found, alike, look)
            found = self._or_with_searched_limbs(found, look)
        hidden = min(found.hidden, 2.0 * self._trunk_hidden(found, look))
        hidden = _beyond_tolerance(max(hidden, evidence.hidden_share))
        found = replace(found, hidden=hidden)
        is_lost = found.cost > LOST_COST + LOST_COST_OCCLUDED * hidden
        if is_due and not found.is_new and self._stature.is_doubted(is_lost):
            return self._with_stature(found, is_lost, look)
        return found

    def _moved_on(self, last: Pose, look: FrameContext) -> _Found:
        """The last pose, or where it has moved to, refined."""
        hidden = self._hidden_now(look)
        prior_scale = _firmness(look.elapsed_s) * (1.0 + OCCLUDED_PRIOR_SCALE * hidden)
        starts = [last, self._predicted(last, look)]
        with look.clock.stage("body"):
            founds = self._founds(starts, look, last, prior_scale=prior_scale)
        best = min(founds, key=lambda found: found.cost)
        return replace(best, kept=self._kept)

    def _or_alike(
        self,
        found: _Found | None,
        alike: Likeness,
        look: FrameContext,
        statures_m: Sequence[float],
    ) -> _Found:
        """What was found, that turned half round, or a body that looks like what is seen; where the
        pose is lost, or there is none, a stance, too. What is seen of whom much is hidden may look
        like a smaller body: of them stances alone are tried."""
        is_lost = found is None or self._is_lost(found, look)
        is_hidden = found is not None and self._hidden_now(look) > 0.0
        if found is not None and is_hidden and not is_lost:
            return found
        evidence = look.evidence
        others: list[_Found] = []
        for stature_m in statures_m:
            model, own = look.model, alike
            if stature_m != model.stature_m:
                model = dressed_body(stature_m)
                own = shipped_poses().likeness(evidence, stature_m)
            starts = [] if is_hidden else own.poses(model, LOOKED_UP if found else 2 * LOOKED_UP)
            if found is not None:
                starts.append(found.pose.turned_round())
            if is_lost:
                yaws_rad = [self._facing.likeliest_rad]
                starts += stand_all(model, evidence.head_camera, yaws_rad, evidence.up_camera)
            others += self._best_of(starts, replace(look, model=model))
        if len(statures_m) > 1:
            others = [self._with_stature_cost(other, evidence) for other in others]
            found = found and self._with_stature_cost(found, evidence)
        best = min(others, key=lambda other: other.cost)
        if found is None:
            return replace(best, is_new=True)
        is_doubtful = best.hidden > LOOKED_UP_HIDDEN and not is_hidden
        if is_doubtful or best.cost > found.cost - NEWS_MARGIN:
            return found
        return replace(best, is_new=True)

    def _best_of(self, starts: list[Pose], look: FrameContext) -> list[_Found]:
        """The best poses at a first look, refined once more."""
        thinned = replace(look, evidence=look.evidence.thinned())
        first = self._founds(starts, thinned, None, LOOKED_UP_ITERATIONS)
        first.sort(key=lambda found: found.cost)
        return self._founds([found.pose for found in first[:LOOKED_AT_AGAIN]], look, None)

    def _or_with_lent_limbs(self, found: _Found, alike: Likeness, look: FrameContext) -> _Found:
        """What was found, or that with limbs of bodies that look like what is seen, where all of it
        is cheaper."""
        look = replace(look, model=found.model)
        own = found.pose.relative()
        starts = [found.pose]
        for lender in alike.poses(found.model, LENDERS):
            lent = lender.relative()
            for upper in LIMBS:
                mixed = own.copy()
                mixed[upper : upper + 2] = lent[upper : upper + 2]
                starts.append(Pose.from_relative(found.pose.neck_camera, mixed))
        thinned = replace(look, evidence=look.evidence.thinned())
        as_it_is, *tried = self._founds(starts, thinned, None, LENT_ITERATIONS)
        together, is_better = as_it_is.pose.relative(), False
        for index, upper in enumerate(LIMBS):
            best = min(tried[index :: len(LIMBS)], key=lambda other: other.cost)
            if best.cost < as_it_is.cost - LIMB_MARGIN:
                together[upper : upper + 2] = best.pose.relative()[upper : upper + 2]
                is_better = True
        if not is_better:
            return found
        mixed_pose = Pose.from_relative(as_it_is.pose.neck_camera, together)
        before, after = self._founds([found.pose, mixed_pose], look, None)
        return _cheaper(found, after, before.cost - after.cost)

    def _or_with_searched_limbs(self, found: _Found, look: FrameContext) -> _Found:
        """What was found, or that with its limbs searched by their own scores, where all of it is
        cheaper."""
        look = replace(look, model=found.model)
        kept = {} if found.is_new else found.kept
        with look.clock.stage("limbs"):
            rngs = {upper: self.subject.rng(upper, look.evidence) for upper in LIMBS}
            pose, kept = self._limbs.search(
                found.pose, found.pose, look.model, look.evidence, rngs, kept
            )
        with look.clock.stage("refinement"):
            before, after = self._founds([found.pose, pose], look, None)
        return replace(_cheaper(found, after, before.cost - after.cost), kept=kept)

    def _founds(
        self,
        starts: list[Pose],
        look: FrameContext,
        prior: Pose | None,
        iterations: int | None = None,
        prior_scale: float = 1.0,
    ) -> list[_Found]:
        """Poses, refined, and all that speaks against each."""
        evidence = look.evidence
        refined = self._refined(starts, prior, look, iterations, prior_scale)
        found = [
            _Found(pose, {}, look.model, float(cost), float(hidden))
            for pose, cost, hidden in zip(
                refined.poses, self._costs(refined), refined.hidden, strict=True
            )
        ]
        return [
            replace(
                own,
                cost=own.cost
                + self._facing.cost(own.pose, evidence.up_camera)
                + self._lift_cost(own, evidence),
            )
            for own in found
        ]

    def _is_lost(self, found: _Found, look: FrameContext) -> bool:
        return found.cost > LOST_COST + LOST_COST_OCCLUDED * self._hidden_now(look)

    def _with_stature_cost(self, found: _Found, evidence: Evidence) -> _Found:
        return replace(found, cost=found.cost + self._stature_cost(found.model, evidence))

    def _with_stature(self, found: _Found, is_lost: bool, look: FrameContext) -> _Found:
        """What was found, or a pose of another stature if that is believed from now on."""
        believed_m, tried_m = self._stature.stature_m, self._stature.next_m()
        _, cost = self._of_stature(found, found.model.stature_m, is_lost, look)
        pose, tried_cost = self._of_stature(found, tried_m, is_lost, look)
        self._stature.judge(cost, tried_cost)
        if self._stature.stature_m == believed_m:
            return found
        return replace(found, pose=pose, model=dressed_body(tried_m))

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

    def _trunk_hidden(self, found: _Found, look: FrameContext) -> float:
        """Share of the axes of head and torso that is out of sight."""
        trunk = [HEAD, UPPER_TORSO, LOWER_TORSO]
        along = ((np.arange(4) + 0.5) / 4)[:, None, None] * found.model.lengths_m[trunk, None]
        places = found.pose.origins(found.model)[trunk] + along * found.pose.Rs[trunk, :, 1]
        radius_m = found.model.radii_m[trunk].min()
        return float(look.evidence.out_of_sight(places.reshape(-1, 3), radius_m).mean())

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


def _firmness(elapsed_s: float) -> float:
    """Factor on a prior's weight after so long: the longer ago a pose was seen, the less it tells
    of the present one; its variance grows with the time, as a random walk's does."""
    return 1.0 / max(frames_in(elapsed_s), 0.25)


def _beyond_tolerance(hidden_share: float) -> float:
    return max(0.0, hidden_share - TOLERATED_OCCLUSION)


def _cheaper(found: _Found, other: _Found, gain: float) -> _Found:
    """What was found, or the other one, if that costs so much less."""
    if gain < LIMB_MARGIN:
        return found
    return replace(found, pose=other.pose, cost=found.cost - gain)
