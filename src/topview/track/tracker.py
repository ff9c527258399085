"""The tracker: find the people, order them by depth, segment, fit each body, nearest first."""

from __future__ import annotations

import logging
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import asdict
from math import inf
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from topview.body.known_body import KnownBody, read_bodies
from topview.camera.pyramid import Pyramid
from topview.detect.color_view import Light
from topview.detect.joints.proposals import JointProposals, JointProposer
from topview.detect.joints.proposers import FINDER, OF_NO_BODY, proposer_by_name
from topview.detect.joints.windows import cut_windows
from topview.detect.protocol import HeadDetector
from topview.kernels.threads import use_threads
from topview.people.finder import PeopleFinder
from topview.people.protocol import Finder
from topview.people.told import Told
from topview.people.told_head import ToldHead
from topview.people.users import HandCandidate, User, by_depth, label_image
from topview.records import Frame, InputError, PartMap, Person, shown
from topview.room.camera_motion import CameraMotion
from topview.timing import StageClock
from topview.track.areas import UserAreas
from topview.track.body_tracker import BodyMethod, Needs, Subject
from topview.track.joint_errors import JointSigns
from topview.track.known_people import KnownPeople, LearntBodies
from topview.track.methods import method_by_name
from topview.track.part_map import part_map_of
from topview.track.person_track import PersonTrack
from topview.track.scene import FittedScene
from topview.track.settings import TrackerSettings
from topview.track.smoothing import Smoothing

_LOGGER: Final = logging.getLogger(__name__)

# Ours: for so long somebody's body and pose are kept while nobody can tell where the person is.
KEPT_S: Final = 10.0


class Tracker:
    """Tracks every person in a stream of frames.

        for frame in topview.open(path):
            people = tracker.update(frame)

    Attributes:
        settings: what the tracker was made with.
        body: the method that tracks bodies, with its settings.
        clock: seconds spent in each stage of each frame.
        finder: finds the people.
        lights: how many frames had usable colours, or why they were not usable.
    """

    def __init__(
        self,
        settings: TrackerSettings | None = None,
        *,
        finder: Finder | None = None,
        body: BodyMethod | None = None,
        detector: HeadDetector | None = None,
        proposer: JointProposer | None = None,
    ) -> None:
        """Make a tracker; parts that are given replace those that `settings` name.

        Args:
            settings: the defaults if None.
            finder: finds the people, in place of the project's own finder.
            body: a method with settings of its own, for instance
                `topview.track.methods.utvr.UtvrSettings(hypotheses=240)`.
            detector: finds heads for the project's own finder.
            proposer: proposes joints, for methods that need them.

        Raises:
            InputError: weights that cannot be used, or that the method has no use for; a file of
                bodies that cannot be read.
        """
        self.settings = settings or TrackerSettings()
        self.body = body or method_by_name(self.settings.method)
        self.clock = StageClock()
        self._proposer = self._chosen_proposer(proposer)
        finding = self.settings.finding_with(proposes=self._proposer is not None)
        self.finder: Finder = finder or PeopleFinder(finding, detector)
        given = {"finder": finder, "detector": detector, "proposer": proposer}
        self._given = {part: type(own).__name__ for part, own in given.items() if own is not None}
        self.lights: Counter[Light] = Counter()
        self._areas = UserAreas()
        known = () if self.settings.body is None else read_bodies(self.settings.body)
        self._known = KnownPeople(self.settings.stature, known)
        self._learnt = LearntBodies()
        self._tracks: dict[int, PersonTrack] = {}
        self._away: dict[int, PersonTrack] = {}  # of who is not there for a moment
        self._people: list[Person] = []
        self._proposed: dict[int, JointProposals] = {}
        self._looks_mirrored = False
        self._came_left: dict[int, bool] = {}
        self._last: Frame | None = None
        self._last_scene: FittedScene | None = None
        smoothing_s = self.settings.smoothing_s
        self._camera_motion = None if self.settings.moving_camera else CameraMotion()
        self._smoothing = Smoothing(smoothing_s) if smoothing_s > 0.0 else None

    def update(self, frame: Frame, hands: Sequence[HandCandidate] = ()) -> list[Person]:
        """Find the people in the next frame and fit their bodies.

        Args:
            frame: the next one of the recording or camera; lens distortion is undone first.
            hands: candidates beside those of the finder.

        Returns:
            the people, nearest first.

        Raises:
            InputError: another camera's frame, one that is not later than the frame before, or,
                unless the settings allow it, one of a camera that moves.
        """
        self._check_next(frame)
        threads = use_threads(self.settings.threads)
        image = Pyramid(frame)
        with self.clock.stage("people"):
            told = Told.of(self._people, self._proposed, self._proposer is not None)
            users = self._known.told(by_depth(self.finder.update(image, told)))
            labels = label_image(users, image.frame.depth_m.shape)
            self._check_still(image, labels)
        self._count_light()
        scene = self._scene(image, labels, users, hands)
        known = self._still_known(frame.timestamp_s)
        tracks = {user.id: known.get(user.id) or self._new_track(user, threads) for user in users}
        self._learn(self._tracks.keys() - tracks.keys())
        self._away = {person: own for person, own in known.items() if person not in tracks}
        self._tracks = tracks
        for user in users:
            scene = scene.with_body(self._tracks[user.id].fit(scene, user))
        self._last_scene = scene
        before = {person.id for person in self._people}
        with self.clock.stage("visibility"):
            self._people = [self._tracks[body.person].seen_in(scene, body) for body in scene.bodies]
        self.clock.end_frame()
        _log_changes(frame, before, {person.id for person in self._people})
        if self._smoothing is None:
            return self._people
        return self._smoothing.update(self._people, frame.timestamp_s)

    @property
    def joint_signs(self) -> dict[int, JointSigns]:
        """Of those who are there, by id: what the last frame told of how far joints may be off."""
        tracks = self._tracks.items()
        return {person: track.signs for person, track in tracks if track.signs is not None}

    def part_map(self) -> PartMap | None:
        """Whose each pixel of the last frame is, and which part of the body; None before the first.
        It is made when it is asked for, by the bodies as they were fitted, before smoothing."""
        scene = self._last_scene
        return scene and part_map_of(scene.image.full, scene.labels, scene.bodies)

    def bodies(self) -> list[KnownBody]:
        """What has been learnt of everybody's body so far, in the order of the ids: to be written
        by `topview.write_bodies`, and given to another recording's tracker. Nothing is told of
        whoever was followed for less than 1 s."""
        self._learn(self._tracks.keys())
        return self._learnt.bodies()

    def settings_as_json(self) -> dict[str, Any]:
        """What the output depends on, in JSON types: settings, the body method's included, and the
        classes of a finder, a detector and a proposer that were given."""
        needs = Needs() if "proposer" in self._given else self.body.needs
        named = {"method": self.body.name, "body": asdict(self.body), **self._given}
        return {**self.settings.as_json(needs), **named}

    def _chosen_proposer(self, given: JointProposer | None) -> JointProposer | None:
        """What proposes joints to this method, or to the finder alone; None where neither asks."""
        settings, needs = self.settings, self.body.needs
        if needs.joints_only and settings.proposals in OF_NO_BODY and given is None:
            raise InputError(
                f"proposals is {settings.proposals}; method {self.body.name} needs proposed "
                "joints: leave it out, or take another method"
            )
        if needs.joints or settings.proposals == FINDER:
            return given or proposer_by_name(settings.proposals, settings.weights)
        if settings.weights is not None:
            raise InputError(
                f"weights is {shown(str(settings.weights))}; method {self.body.name} asks no "
                "network; leave them out, or take a method that does"
            )
        return None

    def _check_next(self, frame: Frame) -> None:
        """Refuse what does not go on with the frame before."""
        last = self._last
        if last is not None and frame.camera is not last.camera and frame.camera != last.camera:
            raise InputError(
                f"frame {frame.index}: its camera is another than that of frame {last.index}; "
                "a tracker follows one camera, whose images keep their size"
            )
        last_s = -inf if last is None else last.timestamp_s
        if not last_s < frame.timestamp_s < inf:
            raise InputError(
                f"frame {frame.index}: its time is {frame.timestamp_s} s after {last_s} s; "
                "times must be numbers that increase"
            )
        self._last = frame

    def _check_still(self, image: Pyramid, labels: NDArray[np.int32]) -> None:
        """Refuse what a camera sees that moves."""
        shift = None
        if self._camera_motion is not None:
            shift = self._camera_motion.update(image, labels)
        if shift is not None:
            raise InputError(
                f"frame {image.frame.index}: the camera moves: it has moved by {shift}; it must "
                "stand still (moving_camera goes on all the same)"
            )

    def _count_light(self) -> None:
        if self.finder.skin_detections is not None:
            self.lights[self.finder.skin_detections.light] += 1

    def _scene(
        self,
        image: Pyramid,
        labels: NDArray[np.int32],
        users: Sequence[User],
        hands: Sequence[HandCandidate],
    ) -> FittedScene:
        """The scene before any body is fitted."""
        shares: dict[int, float] = {}
        if self.body.needs.hidden_share:
            shares = self._areas.hidden_shares(
                users, labels, image.frame.camera, image.frame.timestamp_s
            )
        return FittedScene(
            image,
            labels,
            self.finder.floor,
            (*hands, *self.finder.hands),
            shares,
            proposals=self._proposals(image, labels, users),
        )

    def _proposals(
        self, image: Pyramid, labels: NDArray[np.int32], users: Sequence[User]
    ) -> dict[int, JointProposals]:
        """Of each user's joints, by id; those of somebody in doubt, and those whose head is
        another's, are only for the finder, and all where they are to be."""
        self._proposed = {}
        doubtful = self.finder.doubtful
        asked = [user.id for user in [*users, *doubtful[:1]]]
        if self._proposer is None or not asked:
            return {}
        with self.clock.stage("windows"):
            if doubtful:
                labels = label_image([*users, *doubtful], (labels.shape[0], labels.shape[1]))
            windows = cut_windows(
                image.full, labels, asked, self._are_mirrored(asked, [*users, *doubtful])
            )
        with self.clock.stage("joints"):
            proposals = self._proposer.propose(windows)
            to_cover_m = windows.to_cover_m(proposals.positions_camera)
        self._proposed = {
            person: proposals.of_person(index, to_cover_m)
            for index, person in enumerate(asked)
            if proposals.weights[index].any()
        }
        if self.settings.proposals == FINDER:
            return {}
        return {
            user.id: own
            for user in users
            if (own := self._proposed.get(user.id)) is not None
            and ToldHead.of(own).is_near(user.head_camera)
        }

    def _are_mirrored(self, asked: Sequence[int], there: Sequence[User]) -> list[bool]:
        """Whose windows are looked at in the mirror: everybody's in every other frame. Who came in
        the left half of the image begins there, so that in a mirrored recording the network sees
        the same."""
        self._came_left = {
            user.id: self._came_left.get(user.id, bool(user.head_camera[0] < 0.0)) for user in there
        }
        self._looks_mirrored = not self._looks_mirrored
        return [self._came_left[own] == self._looks_mirrored for own in asked]

    def _learn(self, ids: Iterable[int]) -> None:
        """Keep what is known of the bodies of those who are there."""
        for person in ids:
            self._learnt.add(person, self._tracks[person].learnt())

    def _still_known(self, time_s: float) -> dict[int, PersonTrack]:
        """By id, the tracks of those who were there in the last frame, or a moment ago."""
        away = self._away.items()
        recent = {person: track for person, track in away if time_s - track.last_s < KEPT_S}
        return recent | self._tracks

    def _new_track(self, user: User, threads: int) -> PersonTrack:
        """Of a user of whom none is known."""
        known = self._known.body_of(user.id)
        is_given = self._known.stature_of(user.id) is not None
        subject = Subject(user.id, self.settings.seed, threads, self.clock, known, is_given)
        return PersonTrack(subject, self.body)


def _log_changes(frame: Frame, before: set[int], here: set[int]) -> None:
    """Who has come and gone."""
    for ids, what in ((here - before, "came"), (before - here, "is gone")):
        for person_id in sorted(ids):
            _LOGGER.info("frame %d: person %d %s", frame.index, person_id, what)
