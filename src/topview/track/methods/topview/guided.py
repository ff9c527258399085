"""Whole-body hypotheses from proposed joints: what the search alone may not find (ours).

A proposer has looked at the whole person at once. Each of its modes becomes a body, of bones that
its joints have told over time. The joints then speak in the refinement and in the cost, each as
loudly as its scale says, beside the surface that is seen.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from topview.body.model import BodyModel
from topview.detect.joints import JointProposals
from topview.records import check_range
from topview.track.bone_lengths import BoneLengths
from topview.track.joint_fit import JointFitSettings, JointTargets, body_joints, fit_joints
from topview.track.pose import Pose


@dataclass(frozen=True, slots=True)
class GuideSettings:
    """Ours, all of it.

    Attributes:
        least_weight: of a mode that becomes a hypothesis, 0 to 1.
        joints_cost: of joints that are one scale off, as a share of unexplained points, 0 to 10.
        mode_cost: of a mode, per logarithm of its weight, as a share of unexplained points, 0 to
            10.
        fit: of the body to the joints.

    Raises:
        InputError: a value out of range.
    """

    least_weight: float = 0.02
    joints_cost: float = 0.05
    mode_cost: float = 0.02
    fit: JointFitSettings = field(default_factory=JointFitSettings)

    def __post_init__(self) -> None:
        check_range(self, 0.0, 1.0, "least_weight")
        check_range(self, 0.0, 10.0, "joints_cost")
        check_range(self, 0.0, 10.0, "mode_cost")


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


class Guide:
    """What one person's proposals tell over time."""

    def __init__(self, settings: GuideSettings) -> None:
        self.settings = settings
        self._bones = BoneLengths()

    def model(self, proposals: JointProposals, stature_m: float) -> BodyModel:
        """The body whose bones are those of the proposals so far; learns from the likeliest
        mode."""
        self._bones.update(proposals, int(np.argmax(proposals.weights[0])), stature_m)
        return self._bones.model(stature_m)

    def bodies(self, proposals: JointProposals, model: BodyModel) -> list[ProposedBody]:
        """Every mode that counts."""
        poses = fit_joints(model, proposals, self.settings.fit).poses
        places, scales_m = body_joints(proposals)
        weights = proposals.weights[0]
        likely = np.flatnonzero(weights > self.settings.least_weight * weights.max())
        return [
            ProposedBody(
                poses[mode],
                JointTargets(places[mode], scales_m[mode]),
                -self.settings.mode_cost * float(np.log(weights[mode])),
            )
            for mode in likely
        ]
