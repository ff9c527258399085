"""Whole-body hypotheses from proposed joints: what the search alone may not find (ours).

A proposer has looked at the whole person at once. Each of its modes becomes a body, of bones that
its joints have told over time. The joints then speak in the refinement and in the cost, each as
loudly as its scale says, beside the surface that is seen.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.body.model import BodyModel
from topview.body.parts import UPPER_TORSO
from topview.detect.joints import JointProposals
from topview.records import check_range
from topview.track.bone_lengths import BoneLengths
from topview.track.joint_fit import JointFitSettings, JointTargets, body_joints, fit_joints
from topview.track.pose import Pose

Array = NDArray[np.float64]

LEAST_WEIGHT: Final = 1e-6  # of a mode, where its logarithm is taken
_OTHER: Final = {"left": "right", "right": "left"}


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

    def faces(self, front_camera: Array) -> bool:
        """Whether the trunk turns its front there, [3], rather than its back."""
        return bool(self.pose.Rs[UPPER_TORSO][:, 2] @ front_camera > 0.0)


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

    def bodies(
        self, proposals: JointProposals, model: BodyModel, front_camera: Array | None
    ) -> list[ProposedBody]:
        """Every mode that counts.

        A body looks much alike from both sides, and a mode that has mistaken one for the other has
        its joints in the right places all the same: it is taken with its sides exchanged.

        Args:
            proposals: of one person.
            model: the body.
            front_camera: [3] where the person is taken to face; None where nobody knows.
        """
        weights = proposals.weights[0]
        bodies = self._bodies(proposals, model)
        if front_camera is not None:
            turned = self._bodies(_sides_exchanged(proposals), model)
            bodies = [
                body if body.faces(front_camera) else other
                for body, other in zip(bodies, turned, strict=True)
            ]
        likely = np.flatnonzero(weights > self.settings.least_weight * weights.max())
        return [bodies[mode] for mode in likely]

    def _bodies(self, proposals: JointProposals, model: BodyModel) -> list[ProposedBody]:
        """Every mode."""
        poses = fit_joints(model, proposals, self.settings.fit).poses
        costs = -self.settings.mode_cost * np.log(np.maximum(proposals.weights[0], LEAST_WEIGHT))
        targets = map(JointTargets, *body_joints(proposals))
        return [
            ProposedBody(pose, target, float(cost))
            for pose, target, cost in zip(poses, targets, costs, strict=True)
        ]


def _sides_exchanged(proposals: JointProposals) -> JointProposals:
    """The same places, of which those of the left are taken for the right, and the other way."""
    names = (
        "_".join(_OTHER.get(word, word) for word in n.split("_")) for n in proposals.joint_names
    )
    return replace(proposals, joint_names=tuple(names))
