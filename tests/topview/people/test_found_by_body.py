"""Who shows no upright head is found by the body, if the joint network says so."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from msgspec.structs import replace
from numpy.typing import NDArray
from standing_bodies import Standing

from dressed_scenes import FLOOR, GROUND_Y, ROOM, scene_of, track_at
from people_scenes import Ball, box, frame, head_of, limb, render, standing_person, with_noise
from topview.body.parts import JOINT_NAMES
from topview.detect.joints import JointProposals, Windows
from topview.people.bodies import is_short
from topview.people.clusters import (
    CLUSTER_ID,
    LOOKED_AT_S,
    Cluster,
    Clusters,
    clusters_in,
    track_of_cluster,
)
from topview.people.existence import DOUBTED, ENDED, Existence
from topview.people.features import SHAPE
from topview.people.likelihood import BODY_ODDS, CUT, MOST_LOG_ODDS, Evidence, shipped_likelihood
from topview.people.settings import PeopleSettings
from topview.people.step import Step
from topview.people.told import Told
from topview.people.told_head import ToldHead
from topview.track import Tracker, TrackerSettings

UP = np.array([0.0, -1.0, 0.0])
HEAD = np.array([-0.75, GROUND_Y - 0.13, 2.6])
FRAME_S = 1.0 / 30.0


def lying_person() -> list[Ball]:
    """Along the image, the head on the left."""

    def at(right: float, up: float, ahead: float = 0.0) -> tuple[float, float, float]:
        return (HEAD[0] + right, GROUND_Y - up, HEAD[2] - ahead)

    balls: list[Ball] = [(HEAD, 0.11), *limb(at(0.12, 0.12), at(0.2, 0.12), 0.06)]
    for side in (-1.0, 1.0):
        balls += limb(at(0.3, 0.13, side * 0.08), at(0.75, 0.12, side * 0.07), 0.11)
        balls += limb(at(0.8, 0.11, side * 0.08), at(1.55, 0.08, side * 0.1), 0.07)
        balls += limb(at(0.25, 0.1, side * 0.2), at(0.8, 0.08, side * 0.24), 0.045)
    return balls


LYING = render(lying_person(), ROOM)
IS_LYING = render(lying_person(), ROOM) < render([], ROOM)
CHEST = box((0.9, GROUND_Y - 0.5, 3.2), (1.5, GROUND_Y, 3.6))
WARDROBE = box((-2.0, GROUND_Y - 2.3, 3.6), (-0.9, GROUND_Y, 4.0))


def small(full: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """[h, w] of the cloud's pixels."""
    return full[::2, ::2]


def nobodys(depth_m: NDArray[np.float32]) -> NDArray[np.bool_]:
    return np.zeros(small(depth_m > 0.0).shape, np.bool_)


def test_a_cluster_has_a_persons_size_and_is_no_track_s() -> None:
    depth_m = np.minimum(np.minimum(LYING, CHEST), WARDROBE)
    found = list(clusters_in(scene_of(depth_m, None, 0), nobodys(depth_m)))
    assert len(found) == 2  # the wardrobe is too high
    [(is_own, area_m2)] = [one for one in found if one[0][small(IS_LYING)].any()]
    assert is_own[small(IS_LYING)].mean() > 0.9
    assert (is_own & ~small(IS_LYING)).sum() < 0.05 * is_own.sum()
    assert 0.2 < area_m2 < 0.8
    left = list(clusters_in(scene_of(depth_m, None, 0), small(IS_LYING)))
    assert len(left) == 1


@pytest.mark.parametrize(("length_m", "is_cluster"), [(0.6, True), (0.2, False)])
def test_an_arm_is_a_cluster_and_a_hand_is_none(length_m: float, is_cluster: bool) -> None:
    """Whoever is hidden but for an arm beside the one in front is asked about."""
    top = np.array([0.0, GROUND_Y - 1.3, 3.0])
    depth_m = render(limb(top, top + np.array([0.0, length_m, 0.0]), 0.05), ROOM)
    found = list(clusters_in(scene_of(depth_m, None, 0), nobodys(depth_m)))
    assert [0.05 < area_m2 < 0.1 for _, area_m2 in found] == [True] * is_cluster


def test_who_lies_stretched_is_longer_than_anybody_is_high() -> None:
    scene = scene_of(LYING, None, 0)
    right_m, forward_m = scene.plan_m
    for half_m, is_a_persons in ((1.2, True), (1.4, False)):
        is_own = (np.abs(right_m) < half_m) & (forward_m > 3.0) & (forward_m < 4.0)
        is_own &= scene.heights_m < 1.5
        assert np.ptp(right_m[is_own]) > 1.9 * half_m
        assert is_short(scene, is_own) == is_a_persons


def test_the_network_looks_at_each_cluster_in_turn_and_no_more_until_that_is_forgotten() -> None:
    depth_m = np.minimum(LYING, CHEST)
    clusters = Clusters()
    turns = []
    for index in range(8):
        waiting = clusters.update(scene_of(depth_m, None, index), nobodys(depth_m), FRAME_S)
        cluster = clusters.next
        turns.append(None if cluster is None else bool(cluster.is_own[small(IS_LYING)].any()))
        assert waiting.any() == (cluster is not None)
        asked = [] if cluster is None else [cluster.as_user(scene_of(depth_m, None, index))]
        assert [user.id for user in asked] == [CLUSTER_ID] * len(asked)
        clusters.tell(asked)
    looks = int(np.ceil(LOOKED_AT_S / FRAME_S))
    assert turns[0] is not None
    assert turns[: 2 * looks] == [turns[0], not turns[0]] * looks
    assert turns[2 * looks :] == [None] * (8 - 2 * looks)
    clusters.update(scene_of(depth_m, None, 8), nobodys(depth_m), 5.0)
    assert clusters.next is not None


def test_who_is_asked_about_another_keeps_the_turn() -> None:
    clusters = Clusters()
    for index in range(3):
        clusters.update(scene_of(LYING, None, index), nobodys(LYING), FRAME_S)
        clusters.tell([])
    assert clusters.next is not None
    assert clusters.next.asked_s == 0.0


@dataclass
class Network:
    """Says so of every window with the person in the middle, whose head is where it is."""

    p_person: float
    asked: int = 0

    def propose(self, windows: Windows) -> JointProposals:
        P, J = len(windows.is_used), len(JOINT_NAMES)
        self.asked += P
        middles = windows.to_camera(np.zeros((P, 1, 3)))[:, 0]
        is_there = np.linalg.norm(middles - HEAD - [0.7, 0.0, 0.0], axis=1) < 0.4
        joints = np.tile(HEAD, (P, 1, J, 1))
        joints[:, :, JOINT_NAMES.index("pelvis"), 0] += 0.75
        return JointProposals(
            joints,
            np.full((P, 1, J, 3), 0.05),
            windows.is_used[:, None].astype(np.float64),
            np.where(windows.is_used & is_there, self.p_person, 0.001),
            JOINT_NAMES,
        )


def users_in(depth_m: NDArray[np.float32], network: Network, frames: int = 20) -> list[list[int]]:
    """[F] the ids, frame by frame."""
    tracker = tracker_with(network)
    return [
        [person.id for person in tracker.update(frame(with_noise(depth_m, index), index))]
        for index in range(frames)
    ]


def tracker_with(network: Network) -> Tracker:
    return Tracker(TrackerSettings(threads=1), body=Standing(), proposer=network)


def test_who_lies_is_found_if_the_network_says_so_and_keeps_the_identity() -> None:
    ids = users_in(np.minimum(LYING, CHEST), Network(0.999))
    assert ids[0] == []
    assert ids[8:] == [[1]] * 12
    assert {number for each in ids for number in each} == {1}


@pytest.mark.parametrize("p_person", [0.001, 0.4, 0.8])
def test_who_lies_is_not_found_if_the_network_is_not_sure(p_person: float) -> None:
    network = Network(p_person)
    assert not any(users_in(np.minimum(LYING, CHEST), network))
    assert network.asked > 0


def test_without_a_network_nobody_is_found_by_the_body() -> None:
    tracker = Tracker(TrackerSettings(threads=1, proposals="none"))
    for index in range(8):
        assert tracker.update(frame(with_noise(LYING, index), index)) == []
        assert tracker.finder.doubtful == () or tracker.finder.doubtful[0].id != CLUSTER_ID


def test_the_body_of_who_lies_is_whole() -> None:
    tracker = tracker_with(Network(0.999))
    for index in range(12):
        tracker.update(frame(with_noise(LYING, index), index))
    [user] = tracker.finder.found.users
    is_own = np.zeros(LYING.shape, np.bool_)
    is_own.ravel()[user.pixels] = True
    heights_m = GROUND_Y - (np.arange(240)[:, None] - 119.5) / 285.0 * LYING
    is_clear = IS_LYING & (heights_m > 0.06)  # what is lower may be the floor's
    assert is_own[is_clear].mean() > 0.85
    assert (is_own & ~IS_LYING).sum() < 0.05 * is_own.sum()
    assert not user.height_is_measured


@pytest.mark.parametrize("head_camera", [HEAD, HEAD + np.array([-0.4, 0.0, 0.3])])
def test_the_cluster_is_the_body_though_the_head_may_be_hidden(
    head_camera: NDArray[np.float64],
) -> None:
    """As that of somebody is who lies with the feet to the camera."""
    before, now = (scene_of(with_noise(LYING, index), None, index) for index in range(2))
    [(is_own, area_m2)] = list(clusters_in(before, nobodys(LYING)))
    told = told_of(CLUSTER_ID, head_camera, np.array([-1.0, 0.0, 0.0]))
    step = Step(now, before, told, PeopleSettings())
    track = track_of_cluster(step, Cluster(is_own, area_m2, 0.0), [], 1, Existence())
    assert track is not None
    assert track.body_m is not None
    is_body = track.body_m < np.inf
    assert is_body[is_own].mean() > 0.75
    assert (is_body & ~small(IS_LYING)).sum() < 0.05 * is_own.sum()


def told_of(id: int, head_camera: NDArray[np.float64], trunk: NDArray[np.float64] = UP) -> Told:
    return Told((), {id: ToldHead(0.99, head_camera, 0.03, trunk)}, True)


STANDING, A_FRAME_LATER = (
    scene_of(render(standing_person(0.2, 3.0, GROUND_Y), ROOM), None, index) for index in (0, 1)
)
BOTTOM = track_at(STANDING, head_of(0.2, 3.0, GROUND_Y) - 0.6 * UP)
IN_DOUBT = replace(BOTTOM, id=0)


def test_what_looks_like_a_head_is_not_the_head_if_the_network_sees_it_elsewhere() -> None:
    """Of who is known a moment must pass before that (`Track.corrected`)."""
    true_camera = head_of(0.2, 3.0, GROUND_Y)
    for track, off_m in ((IN_DOUBT, 0.0), (BOTTOM, 0.6)):
        told = told_of(track.told_as, true_camera, -UP)
        step = Step(STANDING, STANDING, told, PeopleSettings())
        [moved] = step.moved([track], {0: track.head})
        assert np.linalg.norm(moved.place_camera - true_camera) == pytest.approx(off_m, abs=0.02)
        assert moved.evidence.by_body == (track is IN_DOUBT)


def test_who_is_in_doubt_is_at_once_where_the_network_sees_an_upright_head() -> None:
    """Whether anything is followed there or not: shoulders are no people."""
    true_camera = head_of(0.2, 3.0, GROUND_Y)
    step = Step(STANDING, STANDING, told_of(IN_DOUBT.told_as, true_camera), PeopleSettings())
    for taken in ({0: IN_DOUBT.head}, {}):
        [moved] = step.moved([IN_DOUBT], taken)
        assert moved.is_seen
        assert not moved.evidence.by_body
        assert np.linalg.norm(moved.place_camera - true_camera) < 0.02


def test_what_was_said_of_another_place_does_not_count_at_the_head() -> None:
    """Of shoulders, before the head came into the picture."""
    said = replace(IN_DOUBT, evidence=IN_DOUBT.evidence.with_network(-3.0, 0.3, 0.0))
    told = told_of(IN_DOUBT.told_as, head_of(0.2, 3.0, GROUND_Y))
    step = Step(A_FRAME_LATER, STANDING, told, PeopleSettings())
    [moved] = step.with_evidence(step.moved([said], {0: said.head}), set())
    assert moved.evidence.network == pytest.approx(told.heads[IN_DOUBT.told_as].log_odds)
    assert moved.evidence.is_to_be_asked(A_FRAME_LATER.time_s)


def test_another_s_head_is_not_taken() -> None:
    true_camera = head_of(0.2, 3.0, GROUND_Y)
    other = replace(track_at(STANDING, true_camera, 2), id=0)
    told = told_of(IN_DOUBT.told_as, true_camera, -UP)
    step = Step(STANDING, STANDING, told, PeopleSettings())
    moved, _ = step.moved([IN_DOUBT, other], {0: IN_DOUBT.head, 1: other.head})
    assert not moved.evidence.by_body


def test_who_lies_has_no_upright_head() -> None:
    lying, upright = np.array([0.9, -0.4, 0.1]), np.array([0.3, -0.9, 0.1])
    here = BOTTOM.place_camera
    assert told_of(BOTTOM.id, here, lying).is_upright(BOTTOM, UP) is False
    assert told_of(BOTTOM.id, here, upright).is_upright(BOTTOM, UP) is True
    assert not told_of(BOTTOM.id, here + UP, lying).is_near(BOTTOM)
    assert Told().is_upright(BOTTOM, UP) is None
    track, unlike = BOTTOM, replace(BOTTOM, confidence=0.3)
    for trunk, before, is_by_body in (
        (upright, track, False),
        (lying, track, True),
        (upright, unlike, True),  # until an upright head is seen again
        (upright, track, False),
    ):
        step = Step(STANDING, STANDING, told_of(BOTTOM.id, here, trunk), PeopleSettings())
        known = replace(before, evidence=track.evidence)
        [track] = step.with_evidence([known], {known.key})
        assert track.evidence.by_body == is_by_body


def test_the_lack_of_an_upright_head_counts_no_more_than_a_cluster_does() -> None:
    likelihood, unlike = shipped_likelihood(), np.full(len(SHAPE), 4.0)
    by_head = Evidence.starting_with(unlike, 0.0).with_network(3.0, 0.1, 0.1)
    by_body = replace(by_head, by_body=True)
    said = likelihood.joint_bias + likelihood.by_network * 3.0
    assert by_body.log_odds(likelihood) == pytest.approx(said + BODY_ODDS)
    assert by_head.log_odds(likelihood) < by_body.log_odds(likelihood)
    upright = Evidence.starting_with(np.zeros(len(SHAPE)), 0.0).with_network(3.0, 0.1, 0.1)
    assert replace(upright, by_body=True).log_odds(likelihood) == upright.log_odds(likelihood)
    never_upright = replace(upright, by_body=True, was_upright=False)
    assert never_upright.log_odds(likelihood) == pytest.approx(said + BODY_ODDS)


def test_a_cluster_that_does_not_move_is_less_of_a_person() -> None:
    likelihood, shape = shipped_likelihood(), np.full(len(SHAPE), 4.0)
    shape[CUT] = 0.0
    odds = []
    for way_m in (0.0, 1.0):
        evidence = Evidence.starting_with(shape, 0.0).with_network(3.0, 0.1, 0.1)
        for index in range(1, 60):
            evidence = evidence.with_shape(shape, way_m, index / 30.0)
        never_upright = replace(evidence, by_body=True, was_upright=False)
        odds.append(never_upright.log_odds(likelihood))
    assert odds[0] < odds[1] - 0.5


def test_a_sure_network_confirms_and_an_unsure_one_does_not() -> None:
    existence, unlike = Existence(), np.full(len(SHAPE), 4.0)
    for log_odds, is_person in ((MOST_LOG_ODDS, True), (1.0, False)):
        evidence = Evidence.starting_with(unlike, 0.0).with_network(log_odds, 0.1, 0.1)
        track = replace(IN_DOUBT, evidence=replace(evidence, by_body=True), born_s=-1.0)
        [seen] = existence.confirmed([track], STANDING, {track.key}, True)
        assert (seen.id > 0) == is_person


def test_one_answer_about_another_head_confirms_nobody() -> None:
    """However sure it is: what is taken for somebody by it has to be so in the next frame, too; and
    for a moment more a doubt is enough to end it."""
    existence, sure = Existence(), np.zeros(len(SHAPE))
    existence.confirmed([], STANDING, set(), True)
    evidence = Evidence.starting_with(sure, 0.0).with_network(MOST_LOG_ODDS, 0.1, 0.1)
    track = replace(IN_DOUBT, evidence=evidence, born_s=-9.0).asked_anew(STANDING.time_s)
    track = replace(track, evidence=evidence)
    later = replace(track, seen_s=A_FRAME_LATER.time_s, time_s=A_FRAME_LATER.time_s)
    [first] = existence.confirmed([track], STANDING, {track.key}, True)
    [then] = existence.confirmed([later], A_FRAME_LATER, {track.key}, True)
    assert (first.id, then.id) == (0, 1)
    doubted = replace(then, evidence=replace(evidence, network=-2.8, still=0.0))
    assert ENDED < existence.existence_of(doubted) < DOUBTED
    assert existence.has_ended(doubted, A_FRAME_LATER)
    assert not existence.has_ended(replace(doubted, anew_s=-9.0), A_FRAME_LATER)


def test_the_floor_alone_has_no_cluster() -> None:
    depth_m = with_noise(render([], [FLOOR]), 1)
    assert list(clusters_in(scene_of(depth_m, None, 0), nobodys(depth_m))) == []
