"""The particle swarm, its space of poses, and the trackers that it makes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rendered_bodies import MODEL, at_frame, evidence_of, joints_of, standing_pose, subject
from topview.body.parts import PART_NAMES
from topview.geometry.rotations import rotations_from_angles
from topview.records import Camera, InputError
from topview.track import Tracker, TrackerSettings
from topview.track.methods import method_by_name
from topview.track.pose import Pose
from topview_lab.rivals.pose_space import HIGH, LOW, N_DIMENSIONS, N_GLOBAL, PoseSpace
from topview_lab.rivals.swarm import (
    Observation,
    SwarmSettings,
    SwarmTracker,
    discrepancy_m,
    minimise,
    perturbed_swarm,
    start_sigmas,
)
from topview_lab.sim import SimulatedRecording, scene_by_name

SPACE = PoseSpace(standing_pose().Rs[1])
SMALL = SwarmSettings(generations=20, perturbed=True)

shares = st.lists(st.floats(0.01, 0.99), min_size=N_DIMENSIONS, max_size=N_DIMENSIONS)


def vector_of(share: list[float]) -> np.ndarray:
    """[27] a place within the limits; the global part within a metre or radian."""
    low, high = np.maximum(LOW, -1.0), np.minimum(HIGH, 1.0)
    low[N_GLOBAL:], high[N_GLOBAL:] = LOW[N_GLOBAL:], HIGH[N_GLOBAL:]
    return low + np.array(share) * (high - low)


def turned(pose: Pose, part: str, degrees: tuple[float, float, float]) -> Pose:
    relative = pose.relative()
    relative[PART_NAMES.index(part)] = rotations_from_angles(np.radians(degrees))
    return Pose.from_relative(pose.neck_camera, relative)


def raised(degrees: float) -> Pose:
    return turned(standing_pose(), "right_upper_arm", (0.0, 0.0, -degrees))


CAMERA = Camera(fx=285, fy=285, cx=159.5, cy=119.5, width=320, height=240)
RAISING = [raised(degrees) for degrees in range(25, 65, 5)]


def tracked(
    truths: list[Pose],
    settings: SwarmSettings,
    seed: int = 0,
    threads: int = 1,
) -> Pose:
    """The pose after the last of some frames."""
    tracker = SwarmTracker(subject(seed, threads), settings)
    return [
        tracker.update(at_frame(evidence_of(truth, camera=CAMERA), index))
        for index, truth in enumerate(truths)
    ][-1]


@given(shares)
def test_a_vector_within_the_limits_is_a_rigid_pose_and_the_way_back_leads_to_it(share):
    pose = SPACE.pose(vector_of(share))
    np.testing.assert_allclose(pose.Rs @ np.swapaxes(pose.Rs, 1, 2), [np.eye(3)] * 11, atol=1e-9)
    again = SPACE.pose(SPACE.vector(pose))
    np.testing.assert_allclose(joints_of(again), joints_of(pose), atol=1e-6)


@given(shares, shares)
def test_many_poses_are_the_same_as_one_by_one(first, second):
    vectors = np.array([vector_of(first), vector_of(second)])
    many = SPACE.poses(vectors)
    for m, vector in enumerate(vectors):
        one = SPACE.pose(vector)
        np.testing.assert_allclose(many.Rs[:, m], one.Rs, atol=1e-12)
        np.testing.assert_allclose(many.origins(MODEL)[:, m], one.origins(MODEL), atol=1e-12)


def test_angles_beyond_the_limits_are_brought_within():
    vector = SPACE.vector(turned(standing_pose(), "left_forearm", (-60, 0, 0)))
    assert (vector >= LOW).all()
    assert (vector <= HIGH).all()


def test_the_discrepancy_is_least_at_the_pose_that_is_seen():
    truth = standing_pose()
    seen = Observation.around(evidence_of(truth), truth.origins(MODEL))
    rng = np.random.default_rng(0)
    vectors = SPACE.vector(truth) + start_sigmas() * rng.standard_normal((50, N_DIMENSIONS))
    vectors[7] = SPACE.vector(truth)
    costs = discrepancy_m(SPACE.poses(vectors), MODEL, seen, 1)
    assert costs.argmin() == 7
    assert costs[7] == pytest.approx(0.0, abs=1e-4)


@pytest.mark.parametrize("perturbed", [False, True])
def test_the_swarm_finds_the_bottom_of_a_bowl(perturbed):
    start = SPACE.vector(standing_pose())
    bottom = np.clip(start + 0.2, LOW, HIGH)
    seen: list[np.ndarray] = []

    def cost(places: np.ndarray) -> np.ndarray:
        seen.append(places)
        return ((places - bottom) ** 2).sum(1)

    found = minimise(cost, start, SwarmSettings(perturbed=perturbed), np.random.default_rng(1))
    assert cost(found[None]) < 0.2 * cost(start[None])
    places = np.concatenate(seen)
    assert len(places) == 64 * 40 + 2
    assert ((places >= LOW) & (places <= HIGH)).all()


def test_the_swarm_is_never_worse_than_where_it_starts():
    start = SPACE.vector(standing_pose())
    found = minimise(
        lambda places: (places != start).any(1).astype(float),
        start, SMALL, np.random.default_rng(2),
    )  # fmt: skip
    np.testing.assert_array_equal(found, start)


@pytest.mark.parametrize("perturbed", [False, True], ids=["bpso", "ppso"])
def test_it_follows_an_arm(perturbed):
    """In most runs; with some seeds it loses a limb."""
    settings, truth = SwarmSettings(perturbed=perturbed), joints_of(RAISING[-1])
    poses = [tracked(RAISING, settings, seed) for seed in range(5)]
    errors_m = np.array([np.linalg.norm(joints_of(pose) - truth, axis=1) for pose in poses])
    assert np.median(errors_m.mean(axis=1)) < 0.03
    assert np.median(errors_m.max(axis=1)) < 0.12


def test_the_same_seed_gives_the_same_pose_for_any_number_of_threads():
    pose = tracked(RAISING[:4:3], perturbed_swarm())
    np.testing.assert_array_equal(pose.Rs, tracked(RAISING[:4:3], perturbed_swarm(), threads=2).Rs)
    assert not np.array_equal(pose.Rs, tracked(RAISING[:4:3], perturbed_swarm(), seed=1).Rs)
    assert not np.array_equal(pose.Rs, tracked(RAISING[:4:3], SwarmSettings()).Rs)


def test_a_person_without_evidence_keeps_the_last_pose():
    tracker = SwarmTracker(subject(), SMALL)
    seen = evidence_of(standing_pose())
    before = tracker.update(seen)
    hidden = replace(seen, points_camera=np.empty((0, 3)))
    after = tracker.update(at_frame(hidden, 1))
    np.testing.assert_array_equal(after.Rs, before.Rs)
    np.testing.assert_array_equal(after.neck_camera, before.neck_camera)


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"particles": 0}, "particles is 0; it must be 1 or more"),
        ({"generations": -1}, "generations is -1; it must be 1 or more"),
    ],
)
def test_a_swarm_that_cannot_be_is_refused(changed, message):
    with pytest.raises(InputError, match=message):
        SwarmSettings(**changed)


@pytest.mark.parametrize("method", ["bpso", "ppso"])
def test_the_tracker_takes_it_by_its_name(method):
    recording = SimulatedRecording(scene_by_name("stand", frames=3))
    tracker = Tracker(
        TrackerSettings(threads=1),
        body=replace(method_by_name(method), generations=20),
    )
    people = [tracker.update(frame) for frame in recording]
    assert len(people[-1]) == 1
    assert tracker.clock.seconds["swarm"] > 0.0
