"""Whole-body hypotheses from proposed joints: what the search alone may not find (ours).

A proposer has looked at the whole person at once. Each of its modes becomes a body, of bones that
its joints have told over time. Which way the person faces is believed over time, too, as nobody
turns round between two frames; it tells which mode is right. The joints then speak in the
refinement and in the cost, each as loudly as its scale says, beside the surface that is seen.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.body.model import BodyModel
from topview.body.parts import HEAD_CENTRE_JOINT
from topview.detect.joints import JointProposals
from topview.filter.over_time import frames_in
from topview.records import check_range
from topview.track.bone_lengths import BoneLengths
from topview.track.familiarity import Familiarity, FamiliarityOverTime
from topview.track.joint_filter import JointFilter, JointFilterSettings
from topview.track.joint_fit import JointFitSettings, JointTargets, body_joints, fit_joints
from topview.track.methods.topview.refinement import RefinementSettings
from topview.track.methods.topview.yaw_belief import YawBelief, trunk_yaws
from topview.track.pose import Pose

# Fitted on rendered people, seeds 20, 21 and 110 to 124. With these a fifth of that, single people
# are better still, and people who hug far worse: each is drawn to what is seen of the other. Limits
# are as soft against the joints as in `JointFitSettings`.
GUIDED_REFINEMENT: Final = RefinementSettings(
    free_space_weight=0.2,
    collision_weight=1.0,
    limit_weight=0.1,
    place_prior_weight=10.0,
    turn_prior_weight=0.3,
    twist_prior_weight=4.0,
    head_weight=0.5,
    joint_weight=0.01,
)


@dataclass(frozen=True, slots=True)
class GuideSettings:
    """Ours, all of it.

    Attributes:
        least_weight: of a mode that becomes a hypothesis, 0 to 1.
        joints_cost: of joints that are one scale off, as a share of unexplained points, 0 to 10.
        mode_cost: of a mode, per logarithm of its weight, as a share of unexplained points, 0 to
            10.
        mode_changes_hz: how often another mode becomes the right one, in a second, 0 to 30.
        mode_evidence: how much a frame's weights of the modes tell beside those of the frames
            before, 0 to 1; 1 were they independent.
        yaw_evidence: how much they tell of where the person faces beside the yaws of the modes, 0
            to 1; a proposer that takes the back for the front does so for long. Fitted on rendered
            people who turn, cut at the hips or above, seeds 60 to 69; 0.05 to 0.2 do as well.
        fit: of the body to the joints.
        filter: of the joints over time.
        refinement: of bodies with proposed joints. The surface counts far more than in that without
            any: the joints tell which part of the body it is.

    Raises:
        InputError: a value out of range.
    """

    least_weight: float = 0.02
    joints_cost: float = 0.05
    mode_cost: float = 0.02
    mode_changes_hz: float = 0.5
    mode_evidence: float = 0.3
    yaw_evidence: float = 0.1
    fit: JointFitSettings = field(default_factory=JointFitSettings)
    filter: JointFilterSettings = field(default_factory=JointFilterSettings)
    refinement: RefinementSettings = GUIDED_REFINEMENT

    def __post_init__(self) -> None:
        check_range(self, 0.0, 1.0, "least_weight")
        check_range(self, 0.0, 10.0, "joints_cost")
        check_range(self, 0.0, 10.0, "mode_cost")
        check_range(self, 0.0, 30.0, "mode_changes_hz")
        check_range(self, 0.0, 1.0, "mode_evidence")
        check_range(self, 0.0, 1.0, "yaw_evidence")


@dataclass(frozen=True, slots=True, eq=False)
class ProposedBody:
    """One mode as a hypothesis.

    Attributes:
        pose: fitted to the joints.
        targets: the joints.
        cost: of the mode, before anything is seen.
    """

    pose: Pose
    targets: JointTargets
    cost: float

    def with_head_at(self, place_camera: NDArray[np.float64], sigma_m: float) -> ProposedBody:
        """With the head at another place [3], if that is surer than the one that is proposed."""
        targets = self.targets.with_place(HEAD_CENTRE_JOINT, place_camera, sigma_m)
        return replace(self, targets=targets)


class Guide:
    """What one person's proposals tell over time."""

    def __init__(self, settings: GuideSettings, bones: BoneLengths | None = None) -> None:
        self.settings = settings
        self.bones = bones or BoneLengths()
        self._joints = JointFilter(settings.filter)
        self._yaw = YawBelief(settings.yaw_evidence)
        self._familiarity = FamiliarityOverTime()
        self._likely: NDArray[np.float64] | None = None
        self._last_s: float | None = None

    @property
    def familiarity(self) -> Familiarity:
        """Of the last frame with proposals."""
        return self._familiarity.now

    @property
    def has_begun(self) -> bool:
        """Whether there were any proposals yet."""
        return self._last_s is not None

    def elapsed_s(self, time_s: float) -> float:
        """Since the last frame with proposals, at the time of the next one; 0 of the first."""
        last_s, self._last_s = self._last_s, time_s
        return 0.0 if last_s is None else max(time_s - last_s, 0.0)

    def filtered(self, proposals: JointProposals, elapsed_s: float) -> JointProposals:
        """The next proposals, their joints averaged over time."""
        return self._joints.update(proposals, elapsed_s)

    def believe(self, proposals: JointProposals, elapsed_s: float) -> NDArray[np.float64]:
        """[M] how likely each mode is after this frame, by all frames so far: by which way the
        person is believed to face; by the modes' weights where they face alike."""
        yaws_rad, sigmas_rad = trunk_yaws(*body_joints(proposals))
        weights = proposals.weights[0]
        self._likely = self._likelier(weights, elapsed_s)
        return self._yaw.update(yaws_rad, sigmas_rad, weights, self._likely, elapsed_s)

    def _likelier(self, weights: NDArray[np.float64], elapsed_s: float) -> NDArray[np.float64]:
        """[M] how likely each mode is by the weights so far: a hidden Markov model of which mode is
        right."""
        if self._likely is None or len(self._likely) != len(weights):
            return weights
        unchanged = np.exp(-self.settings.mode_changes_hz * elapsed_s)
        predicted = unchanged * self._likely + (1.0 - unchanged) / len(weights)
        likely = predicted * weights ** min(1.0, self.settings.mode_evidence * frames_in(elapsed_s))
        return likely / likely.sum()

    def model(
        self, proposals: JointProposals, belief: NDArray[np.float64], stature_m: float
    ) -> BodyModel:
        """The body whose bones are those of the proposals so far; learns from the likeliest
        mode."""
        self.bones.update(proposals, int(np.argmax(belief)), stature_m)
        return self.bones.model(stature_m)

    def bodies(
        self,
        proposals: JointProposals,
        belief: NDArray[np.float64],
        model: BodyModel,
        elapsed_s: float,
    ) -> list[ProposedBody]:
        """Every mode that counts, its scales wider where the window looks unfamiliar."""
        fitted = fit_joints(model, proposals, self.settings.fit)
        residual = float(fitted.residuals[int(np.argmax(belief))])
        p_person = float(proposals.p_person[0])
        familiarity = self._familiarity.update(residual, p_person, elapsed_s)
        places, scales_m = body_joints(proposals, scales_m=familiarity.widened_scales_m(proposals))
        likely = np.flatnonzero(belief > self.settings.least_weight * belief.max())
        return [
            ProposedBody(
                fitted.poses[mode],
                JointTargets(places[mode], scales_m[mode]),
                -self.settings.mode_cost * float(np.log(belief[mode])),
            )
            for mode in likely
        ]
