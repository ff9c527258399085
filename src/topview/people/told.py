"""What a tracker of bodies, and the joint network that it asks, tell of the last frame."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from math import dist
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.body.parts import JOINTS
from topview.detect.heads import HEAD_RADIUS_M
from topview.detect.joints.proposals import JointProposals
from topview.geometry.segments import square_distances
from topview.people.likelihood import MOST_LOG_ODDS
from topview.people.places import HEADS_APART_M
from topview.people.segmentation import surface_distance
from topview.people.told_head import ToldHead
from topview.people.track import Track, is_off
from topview.records import Person
from topview.room.scene import Scene

Vector = NDArray[np.float64]

# All ours. A head that the network sees so near to another track's is that one's.
ANOTHERS_M: Final = 0.25
# What is no farther from the surface of a tracked body is on it, or by so many standard deviations
# of its joints.
ON_BODY_M: Final = 0.05
SPREAD: Final = 2.0
# No surface is farther from the bones.
THICKEST_M: Final = 0.25
# What the network takes for a person's by less than this is nobody's.
NOBODYS: Final = 0.05
# About so many points tell which share of a body is another's.
SHARE_POINTS: Final = 250
# Trunk and legs: no head of another is so near to a bone whose ends are in their places, within
# 10 cm, with this probability.
BODY_BONES: Final = np.array(
    [
        (index, joint.bone_to)
        for index, joint in enumerate(JOINTS)
        if joint.name.endswith(("torso", "pelvis", "hip", "knee", "ankle"))
    ]
)
ON_BONE_M, IN_PLACE = 0.1, 0.8
# The log-odds of a person where the head that the network sees is another's.
ELSEWHERE: Final = -4.0
# A head that is above the pelvis by less than this share of the way is of somebody who lies, bends
# or is on all fours.
UPRIGHT_SHARE: Final = 0.5


@dataclass(frozen=True, eq=False)
class Told:
    """What is known of the last frame.

    Attributes:
        people: as they were tracked.
        heads: what the network said, by the id of a user, of who is doubtful, or of a cluster
            (`Finder.doubtful`).
        has_network: whether a network is asked about everybody.
    """

    people: Sequence[Person] = ()
    heads: Mapping[int, ToldHead] = field(default_factory=dict)
    has_network: bool = False

    @classmethod
    def of(
        cls, people: Sequence[Person], proposals: Mapping[int, JointProposals], has_network: bool
    ) -> Told:
        """Of people as they were tracked, and of joints that were proposed, by id."""
        heads = {who: ToldHead.of(own) for who, own in proposals.items()}
        return cls(people, heads, has_network)

    def joints_of(self, id: int) -> Vector | None:
        """[J, 3] of a person, None where none is told."""
        person = self._person(id)
        return None if person is None else person.joints_camera

    def _person(self, id: int) -> Person | None:
        return next((person for person in self.people if person.id == id), None)

    def tells_of(self, track: Track) -> bool:
        """Whether the network was asked about a track."""
        return track.told_as in self.heads

    def head_of(
        self, track: Track, tracks: Sequence[Track], elapsed_s: float, *, roughly: bool = False
    ) -> Vector | None:
        """[3] a track's head, if the network knows it, or about where it is, and it is not
        another's; now, as the track has gone on for so long."""
        head = self.heads.get(track.told_as)
        if head is None or not (head.is_sure or (roughly and head.is_rough)):
            return None
        if self._is_anothers(head, track, tracks):
            return None
        return head.head_camera + elapsed_s * track.motion.velocity

    def is_nobodys(self, track: Track) -> bool:
        """Whether the network takes what is seen of a person without the head for no person's: it
        is not theirs."""
        head = self.heads.get(track.told_as)
        is_unseen = track.id > 0 and not track.is_seen
        return is_unseen and head is not None and head.p_person < NOBODYS

    def sigma_of(self, track: Track) -> float:
        """Standard deviation, metres, of a track's head as the network tells it, along each
        axis."""
        head = self.heads.get(track.told_as)
        return np.inf if head is None else head.sigma_m

    def is_elsewhere(
        self, head_camera: Vector, track: Track, tracks: Sequence[Track], elapsed_s: float
    ) -> bool:
        """Whether the network knows a track's head (`head_of`), and it is not the one at [3]."""
        told_camera = self.head_of(track, tracks, elapsed_s)
        return told_camera is not None and is_off(told_camera, head_camera)

    def is_near(self, track: Track) -> bool:
        """Whether the head that the network sees in a track's window may be the track's."""
        head = self.heads.get(track.told_as)
        return head is not None and head.is_near(track.place_camera)

    def is_upright(self, track: Track, up_camera: Vector) -> bool | None:
        """Whether the network sees an upright trunk in a track's window; None where it does not
        know."""
        head = self.heads.get(track.told_as)
        if head is None or head.trunk_camera is None or not head.is_sure:
            return None
        return float(head.trunk_camera @ up_camera) >= UPRIGHT_SHARE

    def claims(self, head_camera: Vector, tracks: Sequence[Track]) -> bool:
        """Whether a head at [3] is, for the network, that of one of the people."""
        told = (self.heads.get(track.id) for track in tracks if track.id)
        place = head_camera.tolist()
        return any(
            head is not None
            and head.is_rough
            and dist(head.head_camera.tolist(), place) < HEADS_APART_M
            for head in told
        )

    def is_on_body(self, head_camera: Vector) -> bool:
        """Whether a head at [3] is where the trunk or a leg of one of the people was."""
        first, last = self._bones_in_place
        if not first.size:
            return False
        low, high = self._box_of_bones
        place = head_camera.tolist()
        if not all(a < x < b for a, x, b in zip(low, place, high, strict=True)):
            return False
        return bool((square_distances(head_camera[None], first, last) < ON_BONE_M**2).any())

    @cached_property
    def _bones_in_place(self) -> Vector:
        """[2, B, 3] ends of people's trunks' and legs' bones that are in their places."""
        if not self.people:
            return np.empty((2, 0, 3))
        ends_camera = np.concatenate([p.joints_camera[BODY_BONES] for p in self.people])
        confidence = np.concatenate([p.joint_confidence[BODY_BONES] for p in self.people])
        is_in_place = (confidence > IN_PLACE).all(axis=1)
        is_in_place &= np.isfinite(ends_camera).all(axis=(1, 2))
        return ends_camera[is_in_place].transpose(1, 0, 2)

    @cached_property
    def _box_of_bones(self) -> tuple[list[float], list[float]]:
        """Two corners, well outside of which nothing is on a bone."""
        ends_camera = self._bones_in_place.reshape(-1, 3)
        corners = ends_camera.min(0) - 2 * ON_BONE_M, ends_camera.max(0) + 2 * ON_BONE_M
        return corners[0].tolist(), corners[1].tolist()

    def log_odds_of(self, track: Track, tracks: Sequence[Track]) -> float | None:
        """That a track is a person; None where nothing is told, or only of what is not theirs."""
        head = self.heads.get(track.told_as)
        if head is None or self.is_nobodys(track):
            return None
        is_anothers = self._is_anothers(head, track, tracks)
        is_elsewhere = is_anothers or not head.is_near(track.place_camera)
        return min(head.log_odds, ELSEWHERE) if is_elsewhere else head.log_odds

    def share_on_body(
        self, scene: Scene, is_own: NDArray[np.bool_], others: Sequence[Track]
    ) -> float:
        """Of pixels [h, w], of the last frame or the next, the largest share that is on the body of
        one of these people, as it was in the last frame; as far from it as that may be off."""
        points_camera = scene.cloud.points_camera[is_own].astype(np.float64)
        if not len(points_camera):
            return 0.0
        points_camera = points_camera[:: max(len(points_camera) // SHARE_POINTS, 1)]
        low, high = points_camera.min(0) - THICKEST_M, points_camera.max(0) + THICKEST_M
        most = 0.0
        for other in others:
            person = self._person(other.id)
            if person is None:
                continue
            joints, spread_m = person.joints_camera, _spread_of(person)
            farthest_m = np.nanmax(spread_m)
            is_near = (np.nanmax(joints, 0) > low - farthest_m).all()
            if is_near and (np.nanmin(joints, 0) < high + farthest_m).all():
                height_m = other.height.height_m
                away_m = surface_distance(points_camera, joints, height_m, spread_m)
                most = max(most, float((away_m < ON_BODY_M).mean()))
        return most

    def unless_anothers(self, log_odds: float, share: float) -> float:
        """Log-odds of a window of which a share is on another's body, for which that speaks."""
        own = min(log_odds, MOST_LOG_ODDS)
        return own + share * min(ELSEWHERE - own, 0.0)

    def _is_anothers(self, head: ToldHead, track: Track, tracks: Sequence[Track]) -> bool:
        """Whether a head that was told for one track is that of another's that is seen: the same
        that the network sees in the other's window, or where it knows of none there, nearer to the
        other's head than to the track's."""
        own_m = float(np.linalg.norm(head.head_camera - track.place_camera))
        for other in tracks:
            if other.key == track.key or not other.id or not other.is_seen:
                continue
            told = self.heads.get(other.id)
            there_camera, within_m = other.place_camera, ANOTHERS_M
            if told is not None and told.is_sure and told.is_near(other.place_camera):
                there_camera, within_m = told.head_camera, HEAD_RADIUS_M
            if np.linalg.norm(head.head_camera - there_camera) < min(within_m, own_m):
                return True
        return False


def _spread_of(person: Person) -> Vector:
    """[J] metres by which joints may be off, `SPREAD` standard deviations along each axis; 0 where
    a tracker does not tell."""
    variances_m2 = np.trace(person.joint_covariance_m2, axis1=-2, axis2=-1) / 3.0
    return SPREAD * np.sqrt(np.nan_to_num(variances_m2.astype(np.float64)))


NOTHING_TOLD: Final = Told()
