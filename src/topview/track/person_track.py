"""One person's body over time: what is learnt of it, and when each joint was last visible."""

from __future__ import annotations

import numpy as np

from topview.body.kinematics import joints_from_parts
from topview.body.known_body import KnownBody, KnownBone
from topview.body.parts import JOINTS
from topview.people.users import User
from topview.records import JointState, Person
from topview.track.body_tracker import BodyMethod, LearnsBones, Subject
from topview.track.pose import FittedBody
from topview.track.scene import FittedScene
from topview.track.visibility import confidences, joint_visibility


class PersonTrack:
    """Tracks one person's body by a method, and knows when each joint was last visible."""

    def __init__(self, subject: Subject, method: BodyMethod) -> None:
        self._person = subject.person
        self._clock = subject.clock
        self._needs = method.needs
        self._tracker = method.tracker(subject)
        self._last_seen_s = np.full(len(JOINTS), -np.inf)
        self._stature_m: float | None = None
        self._first_s: float | None = None
        self._last_s = 0.0

    def fit(self, scene: FittedScene, user: User) -> FittedBody:
        """Fit the body in a scene in which the nearer bodies are fitted."""
        with self._clock.stage("evidence"):
            evidence = scene.evidence_for(user, with_unowned_mask=self._needs.unowned_mask)
        self._stature_m = None if evidence.stature_m is None else float(evidence.stature_m)
        self._last_s = evidence.timestamp_s
        self._first_s = self._last_s if self._first_s is None else self._first_s
        pose = self._tracker.update(evidence)
        model = self._tracker.model
        return FittedBody(self._person, model, pose.transforms(model))

    def learnt(self) -> KnownBody:
        """What has been learnt of the body."""
        seconds = 0.0 if self._first_s is None else self._last_s - self._first_s
        bones: dict[str, KnownBone] = {}
        if isinstance(self._tracker, LearnsBones):
            bones = self._tracker.bones.known(self._tracker.model.stature_m)
        return KnownBody(self._stature_m, bones, seconds)

    def seen_in(self, scene: FittedScene, body: FittedBody) -> Person:
        """The person, with the state of each joint in a scene in which all bodies are fitted."""
        frame = scene.image.frame
        joints_camera = joints_from_parts(body.model, body.Ts_camera_part)
        visibility = joint_visibility(
            joints_camera, body.model, body.person, frame.depth_m, scene.labels, frame.camera
        )
        is_seen = visibility.joint_state == JointState.VISIBLE
        self._last_seen_s[is_seen] = frame.timestamp_s
        return Person(
            body.person,
            body.model.stature_m,
            joints_camera,
            visibility.joint_state,
            confidences(visibility, frame.timestamp_s - self._last_seen_s),
            body.Ts_camera_part,
        )
