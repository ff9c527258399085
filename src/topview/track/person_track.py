"""One person's body over time: what is learnt of it, and when each joint was last visible."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from topview.body.ends import output_joints
from topview.body.known_body import KnownBody, KnownBone
from topview.body.parts import OUTPUT_JOINTS
from topview.detect.joints import JointProposals
from topview.people.users import User
from topview.records import JointState, Person
from topview.track.body_tracker import BodyMethod, KnowsFamiliarity, LearnsBones, Subject
from topview.track.familiarity import FAMILIAR, DisagreementOverTime, Familiarity
from topview.track.feet import Feet
from topview.track.joint_errors import JointSigns, shipped_joint_errors, told_errors
from topview.track.pose import FittedBody
from topview.track.scene import FittedScene
from topview.track.visibility import joint_visibility


class PersonTrack:
    """Tracks one person's body by a method, and knows when each joint was last visible.

    Attributes:
        signs: what the last frame told of how far the joints may be off; None before.
        last_s: time of the last frame in which the person was there.
    """

    def __init__(self, subject: Subject, method: BodyMethod) -> None:
        self._person = subject.person
        self._clock = subject.clock
        self._needs = method.needs
        tracker = self._tracker = method.tracker(subject)
        self._knowing = tracker if isinstance(tracker, KnowsFamiliarity) else None
        self._feet = Feet()
        self._disagreement = DisagreementOverTime()
        self._last_seen_s = np.full(len(OUTPUT_JOINTS), -np.inf)
        self.signs: JointSigns | None = None
        self._stature_m: float | None = None
        self._first_s: float | None = None
        self.last_s = 0.0

    def fit(self, scene: FittedScene, user: User) -> FittedBody:
        """Fit the body in a scene in which the nearer bodies are fitted."""
        with self._clock.stage("evidence"):
            evidence = scene.evidence_for(user, with_unowned_mask=self._needs.unowned_mask)
        self._stature_m = None if evidence.stature_m is None else float(evidence.stature_m)
        self.last_s = evidence.timestamp_s
        self._first_s = self.last_s if self._first_s is None else self._first_s
        pose = self._tracker.update(evidence)
        model = self._tracker.model
        return FittedBody(self._person, model, pose.transforms(model))

    def learnt(self) -> KnownBody:
        """What has been learnt of the body."""
        seconds = 0.0 if self._first_s is None else self.last_s - self._first_s
        bones: dict[str, KnownBone] = {}
        if isinstance(self._tracker, LearnsBones):
            bones = self._tracker.bones.known(self._tracker.model.stature_m)
        return KnownBody(self._stature_m, bones, seconds)

    def _familiarity(self, proposals: JointProposals | None, time_s: float) -> Familiarity:
        """How far the proposals of this frame can be relied on."""
        familiarity = FAMILIAR if self._knowing is None else self._knowing.familiarity
        if proposals is None:
            return familiarity
        return replace(familiarity, disagreement=self._disagreement.update(proposals, time_s))

    def seen_in(self, scene: FittedScene, body: FittedBody) -> Person:
        """The person, with the state of each joint in a scene in which all bodies are fitted."""
        frame = scene.image.frame
        proposals = scene.proposals.get(body.person)
        feet_leg_m = self._feet.update(body, proposals, frame.timestamp_s)
        joints_camera = output_joints(body.model, body.Ts_camera_part, feet_leg_m)
        visibility = joint_visibility(
            joints_camera, body.model, body.person, scene.image.full, scene.labels
        )
        is_seen = (visibility.joint_state == JointState.VISIBLE) & (visibility.confirmed > 0.0)
        self._last_seen_s[is_seen] = frame.timestamp_s
        self.signs = JointSigns(
            joints_camera,
            visibility,
            frame.timestamp_s - self._last_seen_s,
            proposals,
            self._familiarity(proposals, frame.timestamp_s),
        )
        covariances_m2, confidences = told_errors(self.signs, shipped_joint_errors())
        return Person(
            body.person,
            body.model.stature_m,
            joints_camera,
            visibility.joint_state,
            confidences,
            body.Ts_camera_part,
            covariances_m2,
        )
