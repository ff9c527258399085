"""`--method forest`: bodies from the joints that the forest proposes."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from topview.body.parts import JOINT_NAMES
from topview.camera import project
from topview.camera.pyramid import DepthView
from topview.detect.joints import cut_windows
from topview.geometry.rotations import rotations_from_vectors
from topview.records import Frame, InputError
from topview.track import Tracker, TrackerSettings
from topview_lab.rivals.forest import default_forest, propose_joints
from topview_lab.rivals.forest.proposer import SURE_SCALE_M, ForestProposer
from topview_lab.rivals.forest.tracker import ForestSettings, rigid_fit
from topview_lab.sim import SimulatedRecording, scene_by_name
from topview_lab.sim.bodies import SIM_JOINT_NAMES
from topview_lab.sim.recording import SimulatedFrame

SCENE = scene_by_name("waving_two_hands", seed=2950, frames=30)


@pytest.fixture(scope="module")
def seen() -> SimulatedFrame:
    """Somebody who waves, of a seed that nothing was learnt from."""
    return SimulatedRecording(SCENE).simulate(20)


def depth_of(seen: SimulatedFrame) -> np.ndarray:
    return seen.depth_mm.astype(np.float32) / np.float32(1000.0)


@given(st.integers(0, 10_000))
def test_a_rigid_fit_finds_the_motion(seed: int) -> None:
    rng = np.random.default_rng(seed)
    points = rng.normal(0.0, 0.3, (7, 3))
    points[:, 2] *= rng.integers(0, 2)  # a flat trunk is no harder
    R, origin = rotations_from_vectors(rng.normal(0.0, 1.0, 3)), rng.normal(0.0, 1.0, 3)
    got_R, got_origin = rigid_fit(points, points @ R.T + origin, rng.uniform(0.1, 1.0, 7))
    assert got_R == pytest.approx(R, abs=1e-6)
    assert got_origin == pytest.approx(origin, abs=1e-6)


def test_points_without_weight_do_not_pull() -> None:
    points = np.random.default_rng(1).normal(0.0, 0.3, (7, 3))
    wished = points.copy()
    wished[0] += 5.0
    R, origin = rigid_fit(points, wished, np.array([0.0, 1, 1, 1, 1, 1, 1]))
    assert np.allclose(R, np.eye(3), atol=1e-9)
    assert np.allclose(origin, 0.0, atol=1e-9)


@pytest.mark.parametrize(
    ("ours", "theirs", "tolerance_m"),
    [("head", "head", 0.06), ("left_hand", "hand_l", 0.1), ("right_hand", "hand_r", 0.1)],
)
def test_head_and_hands_of_somebody_new_are_proposed(
    seen: SimulatedFrame, ours: str, theirs: str, tolerance_m: float
) -> None:
    candidates = propose_joints(depth_of(seen), seen.mask == 1, SCENE.camera, default_forest())
    best = next(candidate for candidate in candidates if candidate.joint == ours)
    truth = seen.truth.joints[0, SIM_JOINT_NAMES.index(theirs)]
    assert np.linalg.norm(best.place_camera - truth) < tolerance_m


def test_the_forest_proposes_in_the_network_s_place(seen: SimulatedFrame) -> None:
    lens = SCENE.camera
    view = DepthView(depth_of(seen), lens.fx, lens.fy, lens.cx, lens.cy)
    proposals = ForestProposer().propose(cut_windows(view, seen.mask.astype(np.int32), [7, 1]))
    assert proposals.weights.tolist() == [[0.0], [1.0]]  # nobody is 7
    assert proposals.p_person.tolist() == [0.0, 1.0]
    assert (proposals.scales_m[1] > SURE_SCALE_M).all()
    for ours, theirs in (("head", "head"), ("left_hand", "hand_l"), ("right_hand", "hand_r")):
        place = proposals.positions_camera[1, 0, JOINT_NAMES.index(ours)]
        truth = seen.truth.joints[0, SIM_JOINT_NAMES.index(theirs)]
        assert np.linalg.norm(place - truth) < 0.1, ours


def test_the_most_trusted_candidate_of_a_joint_comes_first(seen: SimulatedFrame) -> None:
    candidates = propose_joints(depth_of(seen), seen.mask == 1, SCENE.camera, default_forest())
    for joint in JOINT_NAMES:
        trust = [c.confidence for c in candidates if c.joint == joint]
        assert trust == sorted(trust, reverse=True)
        assert all(0.0 < confidence < 1.0 for confidence in trust)


def track(threads: int) -> np.ndarray:
    """[F, 20, 3] of who is tracked."""
    tracker = Tracker(TrackerSettings(method="forest", threads=threads))
    recording = SimulatedRecording(SCENE)
    people = [tracker.update(frame) for frame in list(recording)[:6]]
    return np.array([person.joints_camera for of_frame in people for person in of_frame])


def test_the_tracker_follows_the_forest_and_threads_do_not_matter() -> None:
    alone, together = track(1), track(2)
    assert alone.shape == (6, 20, 3)
    assert np.array_equal(alone, together)
    truth = SimulatedRecording(SCENE).simulate(5).truth.joints[0]
    for ours, theirs in (("head", "head"), ("left_knee", "knee_l"), ("right_elbow", "elbow_r")):
        gap = alone[5, JOINT_NAMES.index(ours)] - truth[SIM_JOINT_NAMES.index(theirs)]
        assert np.linalg.norm(gap) < 0.15, ours


def test_limbs_out_of_view_stay_with_the_trunk(seen: SimulatedFrame) -> None:
    """Only the upper body is left in the image: the legs are guessed, and nothing breaks."""
    depth_m = depth_of(seen)
    hips = seen.truth.joints[0, SIM_JOINT_NAMES.index("pelvis")]
    depth_m[int(project(hips[None], SCENE.camera)[0, 1]) :] = 0.0
    tracker = Tracker(TrackerSettings(method="forest"))
    people = [tracker.update(Frame(k, k / 30, depth_m, SCENE.camera)) for k in range(3)][-1]
    for person in people:
        assert np.isfinite(person.joints_camera).all()
        ankle = person.joints_camera[JOINT_NAMES.index("left_ankle")]
        assert ankle[1] > person.joints_camera[JOINT_NAMES.index("pelvis"), 1]


def test_left_and_right_are_not_at_the_same_place() -> None:
    """Seen from the side, one arm hides the other; both must not be found in the one that shows."""
    scene = scene_by_name("walk", seed=2952, frames=3)
    tracker = Tracker(TrackerSettings(method="forest"))
    people = [tracker.update(frame) for frame in SimulatedRecording(scene)][-1]
    for person in people:
        for joint in ("shoulder", "elbow", "knee", "ankle"):
            left, right = (
                person.joints_camera[JOINT_NAMES.index(f"{side}_{joint}")]
                for side in ("left", "right")
            )
            assert np.linalg.norm(left - right) > 0.05, joint


def test_a_confidence_out_of_range_is_refused():
    with pytest.raises(InputError, match=r"least_confidence is 1.5; it must be 0 to 1"):
        ForestSettings(least_confidence=1.5)
