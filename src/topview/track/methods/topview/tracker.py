"""Tracks the body of one person from frame to frame."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import ClassVar, Final

import numpy as np
from numpy.typing import NDArray

from topview.detect.joints import JointProposals
from topview.filter.over_time import FRAME_S, begins_turn, frames_in, share_after
from topview.geometry.rotations import rotations_from_vectors, vectors_from_rotations
from topview.people.bodies import SHOWN_M2
from topview.people.unseen_heads import TOLD_M2
from topview.records import InputError
from topview.track.body_tracker import Needs, Subject
from topview.track.bone_lengths import BoneLengths
from topview.track.evidence import Evidence
from topview.track.familiarity import Familiarity
from topview.track.methods.topview.bias import Unbiased
from topview.track.methods.topview.body_size import BodySize
from topview.track.methods.topview.guided import Guide, GuideSettings, ProposedBody
from topview.track.methods.topview.posture import known_of
from topview.track.methods.topview.refinement import (
    Explained,
    RefinementSettings,
    explained,
    refine,
)
from topview.track.methods.topview.search import LOOK_S, Search
from topview.track.methods.topview.things import Things
from topview.track.methods.topview.unseen_limbs import shipped_unseen_limbs
from topview.track.methods.topview.walk import Walk
from topview.track.methods.topview.whole_body import (
    Found,
    FrameContext,
    RootCertainty,
    beyond_tolerance,
    costs_of,
)
from topview.track.pose import Pose
from topview.track.stances import STANDING, stand
from topview.track.stature import StatureBelief

Array = NDArray[np.float64]

# All ours.
HEIGHT_STEP_M: Final = 0.01  # a body is rebuilt when its height estimate moves by this
LEAST_BODY_POINTS: Final = 30  # with fewer the person counts as not seen, and keeps the pose
STATURE_S: Final = 0.5  # with the person in sight, in which statures are tried
VELOCITY_S: Final = 0.0295  # after which 63 % of a velocity is gone
# Of a hidden share from which on the predicted motion stops: what was estimated of it from the rest
# that was seen runs away.
STILL_OCCLUSION: Final = 0.1


@dataclass(frozen=True, slots=True)
class TopviewSettings:
    """The default method.

    Attributes:
        refinement, guide: of these steps.
        statures_m: tried while nobody could measure one, 0.3 to 3 metres; the first is assumed
            until then.

    Raises:
        InputError: no stature, or one out of range.
    """

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


class TopviewTracker:
    """One person's pose over time."""

    def __init__(
        self,
        subject: Subject,
        settings: TopviewSettings,
        unbiased: Unbiased | None = None,
    ) -> None:
        """`unbiased`: takes the bias out of poses; that which ships if None."""
        self.subject = subject
        self.settings = settings
        self.pose: Pose | None = None
        self._before: Pose | None = None
        self._last_s: float | None = None  # when the pose was
        self._step_s = 0.0  # from the one before to it
        self._hidden_share = 0.0
        self._in_sight_s = 0.0
        # The last pose that was guided since poses were searched, and which way was up.
        self._guided_to: tuple[Pose, Array] | None = None
        self._guide = Guide(settings.guide, subject.bones)
        self._root = RootCertainty()
        self._walk = Walk()
        self._stature = StatureBelief(subject.stature_is_given)
        self._size = BodySize(self.bones, self._stature, settings.refinement)
        self._things = Things()
        self._unbiased = unbiased or Unbiased()
        self._search = Search(settings.refinement, subject, self._stature, self._size)
        self.model = self.bones.model(settings.statures_m[0])

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
        told: Pose | None = None
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
                self._guided_to = found.pose, evidence.up_camera
                self._unbiased.forget()
            else:
                if self._guided_to is not None:
                    self._search.facing.begin(*self._guided_to)
                    self._guided_to = None
                found, told = self._searched(look, statures_m)
            pose, self.model = found.pose, found.model
            self._hidden_share = found.hidden
            if found.is_new:
                self.pose = None  # no motion leads from the one to the other
            if is_open:
                self._stature.begin(self.model.stature_m)
        self._before, self.pose = self.pose, pose
        self._watch(evidence, elapsed_s)
        self._last_s, self._step_s = evidence.timestamp_s, elapsed_s
        return self._with_unseen_limbs(told or pose, evidence)

    def _watch(self, evidence: Evidence, elapsed_s: float) -> None:
        """See how somebody moves: by the poses, of whom nothing is hidden, else by the head."""
        hidden = max(self._hidden_share, beyond_tolerance(evidence.hidden_share))
        if self._before and self.pose and elapsed_s > 0.0 and hidden < STILL_OCCLUSION:
            self._walk.update(self._before, self.pose, evidence.up_camera, elapsed_s)
        self._walk.look_back(evidence)

    def _scale_to(self, stature_m: float) -> None:
        if abs(stature_m - self.model.stature_m) > HEIGHT_STEP_M:
            self.model = self._size.model(stature_m)

    def _is_out_of_sight(self, evidence: Evidence) -> bool:
        """Whether too little is seen to look for a pose. Of whom joints have been proposed before,
        but not in this frame, that is less than somebody is found by; or, where the head is not
        seen, than tells where the head is."""
        if evidence.proposals is None and self._guide.has_begun:
            least_m2 = SHOWN_M2 if evidence.head_is_seen else TOLD_M2
            return evidence.seen_m2 < least_m2
        return len(evidence.points_camera) < LEAST_BODY_POINTS

    def _hidden(self, evidence: Evidence) -> Pose:
        """Nothing is seen: the pose is kept, below where the head is thought to be."""
        if self.pose is None:
            return stand(self.model, evidence.head_camera, STANDING, 0.0, evidence.up_camera)
        return Pose.below_head(evidence.head_camera, self.pose.Rs, self.model)

    def _searched(self, look: FrameContext, statures_m: Sequence[float]) -> tuple[Found, Pose]:
        """The cheapest of the pose that has moved on and what is found elsewhere, and that without
        its bias, with which the search goes on where nothing is hidden. Of whom joints have been
        proposed, and something is hidden now, the pose is known better than what is seen tells."""
        hidden, last = self._hidden_now(look), self.pose
        is_known = self._guide.has_begun and hidden > 0.0
        is_due = not is_known and begins_turn(look.evidence.timestamp_s, self._last_s, LOOK_S)
        if last is not None and hidden > 0.0:
            last = self._walk.goes_on(last, look.evidence, look.elapsed_s)
        starts = None if last is None else (last, self._predicted(last, look))
        with look.clock.stage("normals"):
            whole = look.evidence.with_normals()
        with look.clock.stage("things"):
            rest = self._things.left_out(whole)
            look = replace(look, evidence=rest)
        found = self._search.update(look, starts, hidden, statures_m, is_due, is_known)
        with look.clock.stage("things"):
            of_whole = self._explained(found, whole)
            self._things.update(whole, of_whole, look.elapsed_s)
        with look.clock.stage("bias"):
            of_rest = of_whole if rest is whole else self._explained(found, rest)
            told = self._unbiased.update(found, look, of_rest)
        return (found if found.hidden > 0.0 else replace(found, pose=told)), told

    def _with_unseen_limbs(self, pose: Pose, evidence: Evidence) -> Pose:
        """A pose with limbs that are out of sight where they are on average; of whom joints have
        been proposed they are better known."""
        if self._guide.has_begun:
            return pose
        return shipped_unseen_limbs().told(pose, known_of(pose, self.model, evidence))

    def _explained(self, found: Found, evidence: Evidence) -> Explained:
        return explained(found.pose, found.model, evidence, self.settings.refinement)

    def _guided(self, look: FrameContext, proposals: JointProposals) -> Found:
        """The best of the bodies that are proposed and the one that is predicted, each refined with
        the proposed joints."""
        stature_m = look.evidence.stature_m or look.model.stature_m
        with look.clock.stage("fit"):
            elapsed_s = self._guide.elapsed_s(look.evidence.timestamp_s)
            proposals = self._guide.filtered(proposals, elapsed_s)
            belief = self._guide.believe(proposals, elapsed_s)
            look = replace(look, model=self._guide.model(proposals, belief, stature_m))
            bodies = self._guide.bodies(proposals, belief, look.model, elapsed_s)
            if not look.evidence.head_is_seen:
                head = look.evidence.head_camera, look.evidence.head_sigma_m
                bodies = [body.with_head_at(*head) for body in bodies]
        moving = None if self.pose is None else self._predicted(self.pose, look)
        weights = self.settings.guide.refinement.prior_weights
        hold = self._root.hold(weights, elapsed_s, look.elapsed_s)
        with look.clock.stage("refinement"):
            found = min(
                (self._refined_guided(body, moving, hold, look) for body in bodies),
                key=lambda found: found.cost,
            )
        assert found.root_information is not None
        self._root.update(found.root_information)
        hidden = beyond_tolerance(max(found.hidden, look.evidence.hidden_share))
        return replace(found, hidden=hidden)

    def _refined_guided(
        self, body: ProposedBody, moving: Pose | None, hold: Array, look: FrameContext
    ) -> Found:
        """The better of the proposed and the predicted pose, refined with the proposed joints."""
        starts = [body.pose] if moving is None else [body.pose, moving]
        guide = self.settings.guide
        refined = refine(
            starts, moving, look.model, look.evidence, guide.refinement,
            hold=hold, targets=body.targets,
        )  # fmt: skip
        costs = costs_of(refined) + guide.joints_cost * refined.apart + body.cost
        best = int(np.argmin(costs))
        hidden = float(refined.hidden[best])
        known = refined.information[best]
        return Found(
            refined.poses[best], look.model, float(costs[best]), hidden, root_information=known
        )

    def _hidden_now(self, look: FrameContext) -> float:
        """Share that is hidden, or was in the last frame, beyond what is tolerated."""
        return max(self._hidden_share, beyond_tolerance(look.evidence.hidden_share))

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
