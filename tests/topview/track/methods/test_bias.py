"""How far off a found pose is on average, as a law of its traits."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from rendered_bodies import MODEL, evidence_of, joints_of, standing_pose
from topview.body.parts import (
    JOINT_NAMES,
    LEFT_FOREARM,
    LEFT_LOWER_LEG,
    LEFT_UPPER_LEG,
    RIGHT_UPPER_LEG,
    UPPER_TORSO,
    other_side,
)
from topview.geometry.rotations import vectors_from_rotations
from topview.timing import StageClock
from topview.track.evidence import Evidence
from topview.track.methods.topview import bias
from topview.track.methods.topview.bias import (
    BIAS_S,
    MIRRORED_TRAITS,
    N_STEPS,
    TURNED,
    PoseBias,
    Unbiased,
    pose_traits,
    shipped_bias,
    stepped,
)
from topview.track.methods.topview.refinement import RefinementSettings, explained
from topview.track.methods.topview.whole_body import Found, FrameContext
from topview.track.pose import LIMBS, MIRRORED, OTHER_SIDE, Pose

POSE = standing_pose()
SETTINGS = RefinementSettings()
TRAITS = len(MIRRORED_TRAITS[0])
# Of a mirrored pose the turns about x stay, those about y and z are the other way round, as is the
# way along x.
_PLACES = {(int(part), int(axis)): d for d, (part, axis) in enumerate(TURNED, start=3)}
STEPS_MIRRORED = [0, 1, 2] + [_PLACES[OTHER_SIDE[part], int(axis)] for part, axis in TURNED]
STEP_SIGNS = np.append([-1.0, 1.0, 1.0], np.array([1.0, -1.0, -1.0])[TURNED[:, 1]])


def in_a_mirror(pose: Pose) -> Pose:
    return Pose(pose.neck_camera @ MIRRORED, (MIRRORED @ pose.Rs @ MIRRORED)[list(OTHER_SIDE)])


def look_at(pose: Pose, elapsed_s: float = 1 / 30) -> FrameContext:
    return FrameContext(MODEL, evidence_of(pose).with_normals(), StageClock(), elapsed_s)


def traits_in(evidence: Evidence, pose: Pose) -> np.ndarray:
    return pose_traits(pose, MODEL, evidence, explained(pose, MODEL, evidence, SETTINGS))


def traits_of(pose: Pose) -> np.ndarray:
    return traits_in(evidence_of(pose).with_normals(), pose)


def told_by(unbiased: Unbiased, found: Found, look: FrameContext) -> Pose:
    return unbiased.update(found, look, explained(found.pose, MODEL, look.evidence, SETTINGS))


def a_law(weights: np.ndarray, widest: float = np.inf) -> PoseBias:
    return PoseBias("made up", weights, np.full(TRAITS, -widest), np.full(TRAITS, widest))


def test_a_pose_in_a_mirror_has_mirrored_traits() -> None:
    signs, order = MIRRORED_TRAITS
    assert_array_equal(np.sort(order), np.arange(TRAITS))
    seen = evidence_of(POSE).with_normals()
    in_mirror = replace(
        seen,
        points_camera=seen.points_camera @ MIRRORED,
        normals_camera=seen.normals_camera @ MIRRORED,
    )
    own = traits_in(seen, POSE)
    mirrored = traits_in(in_mirror, in_a_mirror(POSE))
    assert own.shape == (TRAITS,)
    assert np.abs(own - mirrored).max() > 0.2
    assert_allclose(signs * own[order], mirrored, atol=1e-9)


def test_a_surface_that_fits_has_no_points_off_it_and_one_that_is_too_near_has() -> None:
    evidence = evidence_of(POSE).with_normals()
    pulled = Pose(0.99 * POSE.neck_camera, POSE.Rs)
    off = [traits_in(evidence, pose)[38 : 38 + 33].reshape(11, 3) for pose in (POSE, pulled)]
    gaps_m = [np.einsum("kij,kj->ki", POSE.Rs, own)[:, 2] for own in off]
    assert np.abs(gaps_m[0]).max() < 0.02
    assert gaps_m[1][UPPER_TORSO] - gaps_m[0][UPPER_TORSO] > 0.01


def test_what_ships_treats_left_and_right_alike() -> None:
    law, (signs, order) = shipped_bias(), MIRRORED_TRAITS
    traits = traits_of(POSE)
    steps = law.steps(traits)
    assert np.abs(steps).max() > 1e-3
    assert_allclose(
        law.steps(signs * traits[order]), (STEP_SIGNS * steps)[STEPS_MIRRORED], atol=1e-3
    )


def test_no_step_leaves_a_pose_as_it_is_and_steps_keep_its_lengths() -> None:
    assert_allclose(stepped(POSE, np.zeros(N_STEPS)).Rs, POSE.Rs, atol=1e-9)
    steps = 0.05 * np.random.default_rng(0).standard_normal(N_STEPS)
    moved = stepped(POSE, steps)
    assert_allclose(moved.neck_camera, POSE.neck_camera + POSE.Rs[UPPER_TORSO] @ steps[:3])
    for name in JOINT_NAMES:
        if name.endswith(("_elbow", "_hand", "_knee", "_ankle")):
            joint, before = JOINT_NAMES.index(name), JOINT_NAMES.index(name) - 1
            bones_m = [
                np.linalg.norm(joints_of(pose)[joint] - joints_of(pose)[before])
                for pose in (POSE, moved)
            ]
            assert bones_m[1] == pytest.approx(bones_m[0], abs=1e-9)


def test_knees_and_elbows_stay_hinges() -> None:
    """Whose parts share an axis, x."""
    steps = 0.1 * np.random.default_rng(1).standard_normal(N_STEPS)
    before, after = (
        [pose.Rs[upper, :, 0] @ pose.Rs[upper + 1, :, 0] for upper in LIMBS]
        for pose in (POSE, stepped(POSE, steps))
    )
    assert_allclose(after, before, atol=1e-9)


def test_a_step_turns_a_part_about_its_axis_and_what_hangs_from_it() -> None:
    steps = np.zeros(N_STEPS)
    steps[_PLACES[LEFT_FOREARM, 0]] = 0.1
    moved, hand = stepped(POSE, steps), JOINT_NAMES.index("left_hand")
    way = joints_of(moved)[hand] - joints_of(POSE)[hand]
    expected = 0.1 * MODEL.lengths_m[LEFT_FOREARM]
    assert np.linalg.norm(way) == pytest.approx(expected, rel=0.01)
    others = [joint for joint in range(len(JOINT_NAMES)) if joint != hand]
    assert_allclose(joints_of(moved)[others], joints_of(POSE)[others], atol=1e-9)
    assert other_side("left_hand") == "right_hand"


def test_traits_are_taken_as_no_farther_out_than_known() -> None:
    weights = np.ones((N_STEPS, TRAITS))
    assert_allclose(a_law(weights, 0.5).steps(np.full(TRAITS, 9.0)), 0.5 * TRAITS)
    assert_allclose(a_law(weights, 0.5).steps(np.full(TRAITS, -9.0)), -0.5 * TRAITS)


def test_a_bias_changes_smoothly_but_for_a_pose_that_is_new(monkeypatch) -> None:
    weights = np.zeros((N_STEPS, TRAITS))
    laws = [a_law(weights.copy()) for _ in range(2)]
    laws[1].weights[2, 0] = 0.1  # along z of the torso
    unbiased, found = Unbiased(), Found(POSE, MODEL, 0.1, 0.0)

    def told_m(law: PoseBias, found: Found, elapsed_s: float = 1 / 30) -> float:
        monkeypatch.setattr(bias, "shipped_bias", lambda: law)
        told = told_by(unbiased, found, look_at(POSE, elapsed_s))
        return float(POSE.Rs[UPPER_TORSO, :, 2] @ (told.neck_camera - POSE.neck_camera))

    assert told_m(laws[0], found) == pytest.approx(0.0, abs=1e-9)
    assert told_m(laws[1], found, BIAS_S) == pytest.approx(0.1 * (1 - np.exp(-1)))
    assert told_m(laws[1], replace(found, is_new=True)) == pytest.approx(0.1)
    assert told_m(laws[0], found) > 0.05
    unbiased.forget()
    assert told_m(laws[0], found) == pytest.approx(0.0, abs=1e-9)


def test_of_a_part_that_is_out_of_sight_nothing_is_told(monkeypatch) -> None:
    """Here the left forearm's; the other parts take their steps."""
    law = a_law(np.zeros((N_STEPS, TRAITS)))
    law.weights[:, 0] = 0.05
    out = np.zeros(len(OTHER_SIDE))
    out[LEFT_FOREARM] = 1.0
    monkeypatch.setattr(bias, "shipped_bias", lambda: law)
    monkeypatch.setattr(bias, "parts_out_of_sight", lambda *_: out)
    told = told_by(Unbiased(), Found(POSE, MODEL, 0.1, 0.0), look_at(POSE))
    turned = vectors_from_rotations(np.swapaxes(POSE.relative(), 1, 2) @ told.relative())
    assert_allclose(turned[LEFT_FOREARM], 0.0, atol=1e-9)
    assert turned[OTHER_SIDE[LEFT_FOREARM], 0] == pytest.approx(0.05)
    assert turned[UPPER_TORSO, 1] == pytest.approx(0.05)


def test_a_leg_that_is_out_of_sight_stands_however_the_trunk_turns(monkeypatch) -> None:
    law, hidden = a_law(np.zeros((N_STEPS, TRAITS))), [LEFT_UPPER_LEG, LEFT_LOWER_LEG]
    law.weights[_PLACES[UPPER_TORSO, 0], 0] = 0.1
    out = np.zeros(len(OTHER_SIDE))
    out[hidden] = 1.0
    monkeypatch.setattr(bias, "shipped_bias", lambda: law)
    monkeypatch.setattr(bias, "parts_out_of_sight", lambda *_: out)
    told = told_by(Unbiased(), Found(POSE, MODEL, 0.1, 0.0), look_at(POSE))
    turned = vectors_from_rotations(np.swapaxes(POSE.Rs, 1, 2) @ told.Rs)
    assert_allclose(turned[hidden], 0.0, atol=1e-9)
    assert np.linalg.norm(turned[RIGHT_UPPER_LEG]) == pytest.approx(0.1)
