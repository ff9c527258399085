"""Part frames, and what hides parts and by whom."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from topview_lab.sim import GroundTruth, Scene, scene_by_name
from topview_lab.sim.appearance import random_appearance
from topview_lab.sim.bodies import SIM_JOINT_NAMES, SIM_PART_NAMES, Body, build_body
from topview_lab.sim.render import Renderer, draw_people
from topview_lab.sim.room import render_room
from topview_lab.sim.scene import Box
from topview_lab.sim.skeleton import segment_poses
from topview_lab.sim.truth import FrameTruth, frame_truth, part_frames, stack_truth

FAR_END = {
    "head": "neck", "upper_torso": "torso", "lower_torso": "pelvis", "upper_arm_l": "elbow_l",
    "forearm_r": "wrist_r", "hand_l": "hand_l", "upper_leg_r": "knee_r", "lower_leg_l": "ankle_l",
    "foot_r": "foot_r",
}  # fmt: skip


def by_part(shares: NDArray[np.float64]) -> dict[str, float]:
    return dict(zip(SIM_PART_NAMES, shares.tolist(), strict=True))


def first_frame(scene: Scene) -> FrameTruth:
    drawing = Renderer(scene).draw(0)
    bodies = [actor.body for actor in scene.actors]
    return frame_truth(bodies, drawing.Ts_camera_segment, drawing.rendering, scene.camera)


def test_part_frames_are_right_handed_and_point_to_the_far_joint(
    pass_by_truth: GroundTruth,
) -> None:
    Ts = pass_by_truth.Ts_camera_part[::10].astype(np.float64)
    Rs, joints = Ts[..., :3, :3], pass_by_truth.joints[::10]
    np.testing.assert_allclose(
        np.swapaxes(Rs, -1, -2) @ Rs, np.broadcast_to(np.eye(3), Rs.shape), atol=1e-5
    )
    np.testing.assert_allclose(np.linalg.det(Rs), 1.0, atol=1e-5)
    assert (Ts[..., 3, :] == (0, 0, 0, 1)).all()
    for part, joint in FAR_END.items():
        b, j = SIM_PART_NAMES.index(part), SIM_JOINT_NAMES.index(joint)
        end_part = np.einsum("fpij,fpi->fpj", Rs[:, :, b], joints[:, :, j] - Ts[:, :, b, :3, 3])
        np.testing.assert_allclose(end_part[..., (0, 2)], 0.0, atol=1e-5)
        assert (end_part[..., 1] > 0.03).all()


def test_who_faces_the_camera_has_the_right_side_at_the_images_left() -> None:
    Rs = first_frame(scene_by_name("stand", seed=2)).Ts_camera_part[0, :, :3, :3]
    feet = [SIM_PART_NAMES.index(f"foot_{side}") for side in "lr"]
    others = np.setdiff1d(np.arange(len(SIM_PART_NAMES)), feet)
    assert (Rs[:, 0, 0] < -0.6).all()  # +x to the person's right
    assert (Rs[others, 2, 2] < -0.6).all()  # +z to the front
    assert (Rs[others, 1, 1] > 0.7).all()  # +y down the part
    assert (Rs[feet, 2, 1] < -0.6).all()  # a foot points to the front


def test_a_mirrored_pose_has_mirrored_part_frames() -> None:
    body = build_body(random_appearance(np.random.default_rng(3)).even())
    performance = scene_by_name("all_actions", seed=4).actors[0].performance
    swap = [
        SIM_PART_NAMES.index(
            name[:-1] + {"l": "r", "r": "l"}[name[-1]] if name[-2] == "_" else name
        )
        for name in SIM_PART_NAMES
    ]
    flip = np.diag([-1.0, 1.0, 1.0])
    for time_s in (1.3, 3.1, 5.5):
        pose = performance.pose(body, time_s)
        original, mirrored = (
            part_frames(body.joints(Ts), Ts)
            for Ts in (segment_poses(body.offsets_m, p) for p in (pose, pose.mirrored()))
        )
        np.testing.assert_allclose(
            mirrored[swap][:, :3, :3], flip @ original[:, :3, :3] @ flip, atol=1e-9
        )
        np.testing.assert_allclose(
            mirrored[swap][:, :3, 3], original[:, :3, 3] * (-1, 1, 1), atol=1e-9
        )


def test_alone_and_facing_the_camera_hardly_anything_is_hidden() -> None:
    hidden = first_frame(scene_by_name("stand", seed=2)).part_hidden
    assert (hidden.by == 0.0).all()
    assert (hidden.by_furniture == 0.0).all()
    assert (hidden.outside == 0.0).all()
    upper_arms = [SIM_PART_NAMES.index(f"upper_arm_{side}") for side in "lr"]
    assert (np.delete(hidden.by_self[0], upper_arms) < 0.15).all()
    assert (hidden.by_self[0, upper_arms] < 0.3).all()  # the shoulders' flesh


def test_the_trunk_is_hidden_from_behind_a_wall_and_the_head_above_it_is_not() -> None:
    scene = replace(
        scene_by_name("stand", seed=2),
        frames=1,
        furniture=(Box((0.0, 1.8, 0.6), (3.0, 0.2, 1.2), (0.5, 0.4, 0.3)),),
    )
    truth = first_frame(scene)
    by_wall = by_part(truth.part_hidden.by_furniture[0])
    assert by_wall["head"] == 0.0
    assert all(by_wall[f"{part}_leg_{s}"] == 1.0 for part in ("upper", "lower") for s in "lr")
    assert 0.0 < by_wall["upper_torso"] < 1.0
    assert (truth.part_hidden.by_self[0, [SIM_PART_NAMES.index("lower_leg_l")]] == 0.0).all()


def test_a_whole_wall_hides_all() -> None:
    scene = replace(
        scene_by_name("stand", seed=2),
        frames=1,
        furniture=(Box((0.0, 1.8, 1.25), (4.0, 0.2, 2.5), (0.5, 0.4, 0.3)),),
    )
    truth = stack_truth(scene, [first_frame(scene)])
    assert (truth.part_occ_furniture == 1.0).all()
    assert truth.person_occ_furniture == pytest.approx(1.0)
    assert (truth.part_occ_inter == truth.part_occ_furniture).all()
    assert truth.present.all()


def test_who_hides_is_told(pass_by_truth: GroundTruth) -> None:
    truth = pass_by_truth
    for scope, things in (("joint", 21), ("part", 15)):
        by = getattr(truth, f"{scope}_occ_by")
        assert by.shape == (120, 2, things, 2)
        np.testing.assert_allclose(by.sum(-1), getattr(truth, f"{scope}_occ_person"), atol=1e-6)
        for p in range(2):
            assert (by[:, p, :, p] == 0.0).all()
        assert by[:, 0, :, 1].max() == 1.0
        assert (by[:, 1] == 0.0).all()


def test_shares_exclude_each_other(pass_by_truth: GroundTruth) -> None:
    for scope in ("joint", "part", "person"):
        names = ("occ_person", "occ_furniture", "occ_self", "outside")
        shares = np.stack([getattr(pass_by_truth, f"{scope}_{name}") for name in names])
        assert (shares.sum(0) <= 1.0 + 1e-6).all()


PIECES = (
    "start_segments", "starts_m", "start_radii_m", "end_segments", "ends_m", "end_radii_m",
    "scales", "parts", "materials", "colors",
)  # fmt: skip


def only(body: Body, part: int) -> Body:
    """The flesh of one part."""
    kept = body.parts == part
    return replace(body, **{name: getattr(body, name)[kept] for name in PIECES})


def test_sampled_shares_are_those_of_the_pixels() -> None:
    """Of all pixels that a part has alone in the room, so many show the person in front."""
    scene = scene_by_name("pass_by", seed=1)
    renderer = Renderer(scene)
    room = render_room(scene.room, scene.furniture, scene.camera, scene.mount)
    bodies = [actor.body for actor in scene.actors]
    differences = []
    for frame in (48, 54, 60):
        drawing = renderer.draw(frame)
        poses = drawing.Ts_camera_segment
        truth = frame_truth(bodies, poses, drawing.rendering, scene.camera)
        for b in range(len(SIM_PART_NAMES)):
            alone = draw_people([only(bodies[0], b)], poses[:1], room, scene.camera)
            covered = (drawing.rendering.instance[alone.instance == 1] == 2).mean()
            share = truth.part_hidden.by[0, b, 1]
            assert share == pytest.approx(covered, abs=0.12)
            if 0.05 < covered < 0.95:
                differences.append(abs(share - covered))
    assert len(differences) >= 10
    assert np.mean(differences) < 0.04


def test_a_person_half_out_of_the_image() -> None:
    scene = scene_by_name("stand", seed=2)
    Ts = Renderer(scene).draw(0).Ts_camera_segment[0].copy()
    pelvis = Ts[0, :3, 3]
    edge_x = (scene.camera.width - 0.5 - scene.camera.cx) / scene.camera.fx
    Ts[:, 0, 3] += edge_x * pelvis[2] - pelvis[0]  # the pelvis on the right edge
    body = scene.actors[0].body
    room = render_room(scene.room, (), scene.camera, scene.mount)
    rendering = draw_people([body], [Ts], room, scene.camera)
    truth = frame_truth([body], [Ts], rendering, scene.camera)
    outside = by_part(truth.part_hidden.outside[0])
    assert outside["upper_arm_l"] == 1.0
    assert outside["upper_arm_r"] < 0.05
    assert outside["lower_torso"] == pytest.approx(0.5, abs=0.15)


def test_behind_the_camera_is_outside() -> None:
    scene = scene_by_name("stand", seed=2)
    renderer = Renderer(scene)
    Ts = renderer.draw(0).Ts_camera_segment[0].copy()
    Ts[:, 2, 3] -= 6.0
    truth = frame_truth([scene.actors[0].body], [Ts], renderer.background, scene.camera)
    assert (truth.part_hidden.outside == 1.0).all()
    assert np.isfinite(truth.part_area).all()
    record = stack_truth(scene, [truth])
    assert not record.present.any()
    assert all(np.isfinite(a).all() for a in record.arrays().values() if a.dtype.kind == "f")


def test_actions_are_told_for_every_moment(pass_by: Scene, pass_by_truth: GroundTruth) -> None:
    assert pass_by_truth.actions.shape == (120, 2)
    for f in range(0, 120, 17):
        expected = [a.performance.action_at(f / pass_by.fps) for a in pass_by.actors]
        assert pass_by_truth.actions[f].tolist() == expected
    assert len(set(pass_by_truth.actions[:, 0].tolist())) > 1
    assert pass_by_truth.bodies.shape == (2,)
    assert len(set(pass_by_truth.bodies.tolist())) == 2


def test_an_empty_room_has_a_truth_too(pass_by: Scene) -> None:
    scene = replace(pass_by, actors=(), frames=2)
    truth = stack_truth(scene, [first_frame(scene)] * 2)
    assert truth.joints.shape == (2, 0, 21, 3)
    assert truth.part_occ_by.shape == (2, 0, 15, 0)
    assert truth.person_occ_self.shape == truth.actions.shape == (2, 0)
