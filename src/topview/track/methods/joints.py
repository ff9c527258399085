"""The joints that the network proposes and a body fitted to them, and nothing else (ours).

It shows what a body tracker's objective and memory add to the network. Each frame's pose is found
on its own; what is remembered is how long the bones are, how familiar the person looks, which tells
how sure the joints are, and, for frames in which nothing is proposed, the last pose.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from topview.detect.joints import JointProposals
from topview.people.height import PRIOR_HEIGHT_M
from topview.track.body_tracker import Needs, Subject
from topview.track.evidence import Evidence
from topview.track.familiarity import Familiarity, FamiliarityOverTime
from topview.track.joint_fit import JointFitSettings, fit_joints
from topview.track.pose import Pose
from topview.track.stances import STANDING, stand


@dataclass(frozen=True, slots=True)
class JointsSettings:
    """The network and the fitted body alone.

    Attributes:
        fit: of the body to the joints.
    """

    fit: JointFitSettings = field(default_factory=JointFitSettings)

    needs: ClassVar[Needs] = Needs(joints=True, joints_only=True)

    @property
    def name(self) -> str:
        return "joints"

    def tracker(self, subject: Subject) -> JointsTracker:
        return JointsTracker(subject, self)


class JointsTracker:
    """One person's pose, a frame at a time."""

    def __init__(self, subject: Subject, settings: JointsSettings) -> None:
        self.subject = subject
        self.settings = settings
        self.bones = subject.bones
        self._last: Pose | None = None
        self._familiarity = FamiliarityOverTime()
        self._last_s: float | None = None
        self.model = self.bones.model(PRIOR_HEIGHT_M)

    @property
    def familiarity(self) -> Familiarity:
        return self._familiarity.now

    def update(self, evidence: Evidence) -> Pose:
        """The pose in the next frame: that of the likeliest mode. With nothing proposed, the last
        one goes on below where the head is thought to be."""
        stature_m = evidence.stature_m or self.model.stature_m
        proposals = evidence.proposals
        with self.subject.clock.stage("fit"):
            if proposals is None or not proposals.weights[0].any():
                self.model = self.bones.model(stature_m)
                self._last = self._unseen(evidence)
            else:
                mode = int(np.argmax(proposals.weights[0]))
                self.bones.update(proposals, mode, stature_m)
                self.model = self.bones.model(stature_m)
                self._last = self._fitted(proposals, mode, evidence.timestamp_s)
        return self._last

    def _fitted(self, proposals: JointProposals, mode: int, time_s: float) -> Pose:
        fitted = fit_joints(self.model, proposals, self.settings.fit)
        elapsed_s = 0.0 if self._last_s is None else time_s - self._last_s
        residual, p_person = float(fitted.residuals[mode]), float(proposals.p_person[0])
        self._familiarity.update(residual, p_person, elapsed_s)
        self._last_s = time_s
        return fitted.poses[mode]

    def _unseen(self, evidence: Evidence) -> Pose:
        if self._last is None:
            return stand(self.model, evidence.head_camera, STANDING, 0.0, evidence.up_camera)
        return Pose.below_head(evidence.head_camera, self._last.Rs, self.model)
