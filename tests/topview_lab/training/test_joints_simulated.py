"""Simulated people to learn joints from: where the rendered people have their joints."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from topview.detect.joints import PROPOSED_JOINTS
from topview_lab.sim.bodies import SIM_JOINT_NAMES, SIM_PART_NAMES
from topview_lab.sim.scenes import KINECT_V1_HALF
from topview_lab.sim.scenes.postures import (
    POSTURES_A_BODY,
    SEATED_A_BODY,
    TOUCHING_A_BODY,
    posture_scene,
)
from topview_lab.sim.truth import simulate_truth
from topview_lab.training.joints.recordings import gathered
from topview_lab.training.joints.simulated import (
    CENTRE_PARTS,
    JOINT_CENTRES,
    joints_of_rig,
    posture_recording,
    simulated_recording,
)

SCENE = replace(posture_scene(0, KINECT_V1_HALF), frames=3)
TRUTH = simulate_truth(SCENE)


def test_every_joint_has_a_centre_and_a_part() -> None:
    stems = {name.removesuffix("_l").removesuffix("_r") for name in SIM_JOINT_NAMES}
    assert set(JOINT_CENTRES) == set(CENTRE_PARTS) == stems


def test_joints_move_as_the_table_says_outwards_on_both_sides() -> None:
    moved = joints_of_rig(TRUTH) - TRUTH.joints
    of_stature = np.linalg.norm(moved, axis=-1) / TRUTH.stature[:, None]
    for j, name in enumerate(SIM_JOINT_NAMES):
        way = JOINT_CENTRES[name.removesuffix("_l").removesuffix("_r")]
        np.testing.assert_allclose(of_stature[..., j], np.linalg.norm(way), atol=1e-6)
    right = TRUTH.Ts_camera_part[:, :, SIM_PART_NAMES.index("lower_torso"), :3, 0]
    left_hip, right_hip = (
        (moved[:, :, SIM_JOINT_NAMES.index(f"hip_{side}")] * right).sum(-1) for side in "lr"
    )
    assert (left_hip < 0.0).all()
    np.testing.assert_allclose(right_hip, -left_hip, atol=1e-6)


def test_a_scene_becomes_a_recording_to_learn_from() -> None:
    recording = simulated_recording(SCENE)
    assert len(gathered([recording])) == 3
    assert recording.joints_camera.shape == (3, 1, len(PROPOSED_JOINTS), 3)
    knee = recording.joints_camera[:, 0, PROPOSED_JOINTS.index("left_knee")]
    truth = TRUTH.joints[:, 0, SIM_JOINT_NAMES.index("knee_l")]
    assert np.linalg.norm(knee - truth, axis=-1).max() < 0.02
    hidden = recording.hidden[:, 0, PROPOSED_JOINTS.index("left_knee")]
    np.testing.assert_array_equal(
        hidden, TRUTH.joint_occ_inter[:, 0, SIM_JOINT_NAMES.index("knee_l")]
    )


@pytest.mark.slow
def test_postures_are_learnt_in_the_room_on_a_seat_and_with_hands_on_the_body() -> None:
    recording = posture_recording(3)
    frames = POSTURES_A_BODY + SEATED_A_BODY + TOUCHING_A_BODY
    assert len(recording.depth_mm) == len(recording.masks) == len(recording.hidden) == frames
    assert len(gathered([recording])) > 0.9 * frames
