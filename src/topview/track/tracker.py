"""The tracker: find people, order them by depth, segment, then each body, nearest first."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from topview.body.kinematics import joints_from_parts
from topview.body.parts import JOINTS
from topview.detect.seeing import Light
from topview.kernels.threads import use_threads
from topview.people.finder import PeopleFinder, PeopleSettings
from topview.people.users import HandCandidate, User
from topview.records import Frame, JointState, Person
from topview.score.utvr import DepthView
from topview.timing import StageClock
from topview.track.areas import UserAreas
from topview.track.body_tracker import BodySettings, BodyTracker
from topview.track.evidence import gather, thin_view, working_stride
from topview.track.part_by_part import PartByPartSettings, PartByPartTracker
from topview.track.pose import Pose
from topview.track.settings import TrackerSettings
from topview.track.upper_body import UpperBodySettings, UpperBodyTracker
from topview.track.upper_body.tracker import UpperBodyPose
from topview.track.visibility import confidences, look
from topview_lab.rivals.ellipsoids import EllipsoidSettings, EllipsoidTracker
from topview_lab.rivals.forest.tracker import ForestSettings, ForestTracker
from topview_lab.rivals.swarm import SwarmSettings, SwarmTracker


@dataclass(slots=True)
class _Tracked:
    """One person's tracker and what is remembered of the joints."""

    tracker: (
        BodyTracker
        | PartByPartTracker
        | SwarmTracker
        | UpperBodyTracker
        | EllipsoidTracker
        | ForestTracker
    )
    last_seen_s: NDArray[np.float64] = field(default_factory=lambda: np.full(len(JOINTS), -np.inf))


class Tracker:
    """Tracks every person in a stream of frames.

    for frame in topview.open(path):
        people = tracker.update(frame)

    Attributes:
        settings: what it was made with.
        clock: seconds spent in each stage of each frame.
        finder: of the people.
        lights: how many frames had colours that could be used, or why not.
    """

    def __init__(
        self,
        settings: TrackerSettings | None = None,
        body: BodySettings | None = None,
        part_by_part: PartByPartSettings | None = None,
        swarm: SwarmSettings | None = None,
        upper_body: UpperBodySettings | None = None,
    ) -> None:
        self.settings = settings or TrackerSettings()
        self.clock = StageClock()
        self._body = body or BodySettings()
        self._part_by_part = part_by_part or PartByPartSettings()
        self._swarm = swarm or SwarmSettings()
        self._upper_body = upper_body or UpperBodySettings()
        self.finder = PeopleFinder(PeopleSettings(detector=self.settings.detector))
        self.lights: Counter[Light] = Counter()
        self._areas = UserAreas()
        self._hands: tuple[HandCandidate, ...] = ()
        self._threads = 1
        self._bodies: dict[int, _Tracked] = {}
        self._people: list[Person] = []

    def update(self, frame: Frame, hands: Sequence[HandCandidate] = ()) -> list[Person]:
        """The people in the next frame, nearest first; `hands`, where something else has detected
        any besides those of the colour of skin, are heeded by "utvr" and "btvr"."""
        self._threads = use_threads(self.settings.threads)
        with self.clock.stage("people"):
            users = self.finder.update(frame, self._people)
        self._hands = (*hands, *self.finder.hands)
        if self.finder.sight is not None:
            self.lights[self.finder.sight.light] += 1
        self._bodies = {user.id: self._body_of(user) for user in users}
        owner = _owners(users, frame)
        hidden_shares: dict[int, float] = {}
        if self.settings.method in ("utvr", "btvr"):
            hidden_shares = self._areas.hidden_shares(users, owner, frame.camera)
        views: dict[int, DepthView] = {}
        poses = [
            self._track(user, frame, views, owner, hidden_shares.get(user.id, 0.0))
            for user in users
        ]
        with self.clock.stage("visibility"):
            self._people = [
                self._person(user, pose, frame, owner)
                for user, pose in zip(users, poses, strict=True)
            ]
        self.clock.end_frame()
        return self._people

    def _body_of(self, user: User) -> _Tracked:
        tracked = self._bodies.get(user.id)
        if tracked is not None:
            return tracked
        s = self.settings
        if s.method == "thesis":
            return _Tracked(PartByPartTracker(user.id, s.seed, self._part_by_part, self._threads))
        if s.method in ("bpso", "ppso"):
            perturbed = s.method == "ppso"
            return _Tracked(
                SwarmTracker(user.id, s.seed, self._swarm, self._threads, perturbed=perturbed)
            )
        if s.method == "btvr":
            return _Tracked(UpperBodyTracker(user.id, s.seed, self._upper_body, self._threads))
        if s.method == "ellipsoids":
            return _Tracked(EllipsoidTracker(EllipsoidSettings()))
        if s.method == "forest":
            return _Tracked(ForestTracker(ForestSettings()))
        return _Tracked(BodyTracker(user.id, s.seed, self._body, self._threads))

    def _track(
        self,
        user: User,
        frame: Frame,
        views: dict[int, DepthView],
        owner: NDArray[np.int32],
        hidden_share: float,
    ) -> Pose | UpperBodyPose:
        """One person's pose, from the image thinned to what the person's distance needs."""
        tracked = self._bodies[user.id]
        stride = working_stride(frame.camera, float(user.head_camera[2]))
        with self.clock.stage("evidence"):
            if stride not in views:
                views[stride] = thin_view(frame.depth_m, frame.camera, stride)
            evidence = gather(user, views[stride], stride, frame.camera.width, self.finder.floor)
            evidence = replace(evidence, hidden_share=hidden_share, hands=self._hands)
            if self.settings.method == "btvr":
                nobodys = owner[::stride, ::stride] == 0
                evidence = replace(evidence, nobodys=nobodys)
        measured_m = user.height_m if user.height_is_measured else None
        return tracked.tracker.update(measured_m, evidence, frame.index, self.clock)

    def _person(
        self, user: User, pose: Pose | UpperBodyPose, frame: Frame, owner: NDArray[np.int32]
    ) -> Person:
        tracked = self._bodies[user.id]
        model = tracked.tracker.model
        Ts_camera_part = pose.transforms(model)
        joints = joints_from_parts(model, Ts_camera_part)
        visibility = look(joints, model, user.id, frame.depth_m, owner, frame.camera)
        is_seen = visibility.joint_state == JointState.VISIBLE
        tracked.last_seen_s[is_seen] = frame.timestamp_s
        return Person(
            user.id,
            model.stature_m,
            joints,
            visibility.joint_state,
            confidences(visibility, frame.timestamp_s - tracked.last_seen_s),
            Ts_camera_part,
        )


def _owners(users: list[User], frame: Frame) -> NDArray[np.int32]:
    """[H, W] id of the user that each pixel belongs to, 0 for none; shared ones to the nearest."""
    owner = np.zeros(frame.depth_m.shape, np.int32)
    for user in reversed(users):
        owner.ravel()[user.pixels] = user.id
    return owner
