"""Rendered people against their truth: mirror images, masks under joints, occlusion."""

from __future__ import annotations

import numpy as np
import pytest

from topview.camera.projection import project
from topview.records import Camera
from topview_lab.sim import GroundTruth, Scene, scene_by_name
from topview_lab.sim.bodies import SIM_JOINT_NAMES, SIM_PART_NAMES, build_body
from topview_lab.sim.images import FURNITURE
from topview_lab.sim.render import Renderer, draw_people
from topview_lab.sim.room import render_room
from topview_lab.sim.scene import Box, Cylinder, Mount, Room
from topview_lab.sim.skeleton import segment_poses
from topview_lab.sim.truth import frame_truth, stack_truth

SHARES = ("occ_person", "occ_furniture", "occ_inter", "occ_self", "outside")


def test_a_mirrored_pose_gives_the_mirrored_image(tiny_camera: Camera, render_plain) -> None:
    scene = scene_by_name("all_actions", seed=4)
    performance = scene.actors[0].performance
    body = build_body(scene.actors[0].body.appearance.even())
    empty = render_plain(np.full((tiny_camera.height, tiny_camera.width), np.inf, np.float32))
    swap = [
        SIM_PART_NAMES.index(
            name[:-1] + {"l": "r", "r": "l"}[name[-1]] if name[-2] == "_" else name
        )
        for name in SIM_PART_NAMES
    ]
    swap = np.array([*swap, *range(len(swap), 256)])
    for time_s in (1.3, 3.1, 5.5):
        pose = performance.pose(body, time_s)
        images = [
            draw_people(
                [body],
                [Mount().T_camera_room() @ segment_poses(body.offsets_m, p)],
                empty,
                tiny_camera,
            )
            for p in (pose, pose.mirrored())
        ]
        original, mirrored = images
        assert (original.instance == 1).mean() > 0.05
        same = mirrored.instance[:, ::-1] == original.instance
        assert same.mean() > 0.999  # rounding may shift a silhouette by a pixel
        hit = same & (original.instance == 1)
        np.testing.assert_allclose(mirrored.depth_m[:, ::-1][hit], original.depth_m[hit], atol=1e-5)
        assert (swap[mirrored.part[:, ::-1][hit]] == original.part[hit]).mean() > 0.995


def test_joints_in_plain_view_lie_inside_their_persons_mask(
    pass_by: Scene, pass_by_truth: GroundTruth
) -> None:
    renderer, truth = Renderer(pass_by), pass_by_truth
    hidden = truth.joint_occ_inter + truth.joint_occ_self + truth.joint_outside
    seen = 0
    for f in range(0, pass_by.frames, 10):
        instance = renderer.draw(f).rendering.instance
        pixels = np.rint(project(truth.joints[f], pass_by.camera)).astype(int)
        for p in range(2):
            u, v = pixels[p][hidden[f, p] == 0.0].T
            assert (instance[v, u] == p + 1).all()
            seen += len(u)
    assert seen > 250  # of 12 x 2 x 21


def test_seen_surfaces_lie_near_the_joints_that_they_cover(
    pass_by: Scene, pass_by_truth: GroundTruth
) -> None:
    truth = pass_by_truth
    hidden = truth.joint_occ_inter + truth.joint_occ_self + truth.joint_outside
    drawing = Renderer(pass_by).draw(0)
    for p in range(2):
        seen = hidden[0, p] == 0.0
        u, v = np.rint(project(truth.joints[0, p, seen], pass_by.camera)).astype(int).T
        behind = truth.joints[0, p, seen, 2] - drawing.rendering.depth_m[v, u]
        assert (behind > -0.02).all()
        assert (behind < 0.2).all()


def test_shares_are_shares(pass_by: Scene, pass_by_truth: GroundTruth) -> None:
    for name in SHARES:
        for scope, shape in (
            ("joint", (120, 2, 21)),
            ("part", (120, 2, 15)),
            ("person", (120, 2)),
        ):
            share = getattr(pass_by_truth, f"{scope}_{name}")
            assert share.shape == shape
            assert share.dtype == np.float32
            assert ((share >= 0.0) & (share <= 1.0)).all()


def test_passing_by_hides_person_1_for_a_while(pass_by_truth: GroundTruth) -> None:
    truth = pass_by_truth
    hidden = truth.person_occ_person[:, 0]
    assert hidden[:10].max() == 0.0
    assert hidden[-15:].max() < 0.05
    assert hidden.max() > 0.4
    assert 15 <= (hidden > 0.05).sum() <= 60  # about a second
    assert truth.person_occ_person[:, 1].max() == 0.0
    torso = SIM_JOINT_NAMES.index("torso")
    assert truth.joint_occ_person[:, 0, torso].max() == 1.0
    assert truth.present.all()


def test_furniture_hides_what_stands_behind_it() -> None:
    scene = scene_by_name("stand", seed=2)
    table = Box((0.0, 1.8, 0.35), (2.0, 0.3, 0.7), (0.5, 0.4, 0.3))
    hidden = Scene(
        name="behind_a_table", seed=2, frames=1, camera=scene.camera, mount=scene.mount,
        room=scene.room, furniture=(table,), actors=scene.actors,
    )  # fmt: skip
    drawing = Renderer(hidden).draw(0)
    bodies = [actor.body for actor in hidden.actors]
    truth = frame_truth(bodies, drawing.Ts_camera_segment, drawing.rendering, hidden.camera)
    by_table = dict(zip(SIM_JOINT_NAMES, truth.joint_hidden.by_furniture[0], strict=True))
    assert by_table["ankle_l"] == by_table["ankle_r"] == 1.0
    assert by_table["head"] == by_table["neck"] == 0.0
    assert (truth.joint_hidden.by == 0.0).all()


def test_in_profile_the_own_trunk_hides_the_far_side() -> None:
    scene = scene_by_name("walk", seed=3)
    actor = scene.actors[0]
    pose = actor.performance.pose(actor.body, 0.0)  # looks to the right: the right side is near
    Ts = scene.mount.T_camera_room() @ segment_poses(actor.body.offsets_m, pose)
    background = render_room(scene.room, (), scene.camera, scene.mount)
    rendering = draw_people([actor.body], [Ts], background, scene.camera)
    truth = frame_truth([actor.body], [Ts], rendering, scene.camera)
    by_self = dict(zip(SIM_JOINT_NAMES, truth.joint_hidden.by_self[0], strict=True))
    assert by_self["shoulder_l"] > 0.7
    assert by_self["hip_l"] > 0.7
    assert by_self["shoulder_r"] < 0.2
    assert by_self["knee_r"] < 0.2


def test_a_person_out_of_the_image_is_outside() -> None:
    scene = scene_by_name("stand", seed=2)
    renderer = Renderer(scene)
    body = scene.actors[0].body
    Ts = renderer.draw(0).Ts_camera_segment[0].copy()
    Ts[:, 0, 3] += 10.0
    truth = frame_truth([body], [Ts], renderer.background, scene.camera)
    assert (truth.joint_hidden.outside == 1.0).all()
    assert (truth.part_hidden.outside == 1.0).all()
    assert not stack_truth(scene, [truth]).present.any()


def test_the_floor_lies_where_the_camera_says() -> None:
    camera, mount = Camera(262.5, 262.5, 159.5, 119.5, 320, 240), Mount(1.3, np.radians(10))
    room = render_room(Room(), (), camera, mount)
    T_room_camera = np.linalg.inv(mount.T_camera_room())
    up_camera = mount.T_camera_room()[:3, 2]
    is_floor = room.normals @ up_camera > 0.99
    v, u = np.nonzero(is_floor)
    assert len(v) > 10_000
    rays = np.stack([(u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, np.ones(len(u))], 1)
    points_camera = rays * room.depth_m[v, u, None]
    heights = points_camera @ T_room_camera[2, :3] + T_room_camera[2, 3]
    np.testing.assert_allclose(heights, 0.0, atol=1e-5)


@pytest.mark.parametrize(
    ("piece", "depth_m"),
    [
        (Box((0.0, 3.0, 1.0), (0.4, 0.6, 2.0), (0.5, 0.5, 0.5)), 2.7),
        (Box((0.0, 3.0, 1.0), (0.6, 0.4, 2.0), (0.5, 0.5, 0.5), np.pi / 2), 2.7),
        (Cylinder((0.0, 3.0, 0.0), 0.25, 2.0, (0.5, 0.5, 0.5)), 2.75),
    ],
)
def test_furniture_stands_where_it_was_put(piece: Box | Cylinder, depth_m: float) -> None:
    camera, mount = Camera(100.0, 100.0, 40.0, 30.0, 81, 61), Mount(1.0, 0.0)
    room = render_room(Room(), (piece,), camera, mount)
    assert room.instance[30, 40] == FURNITURE
    assert room.depth_m[30, 40] == pytest.approx(depth_m)
    assert room.normals[30, 40] == pytest.approx((0.0, 0.0, -1.0), abs=1e-6)
