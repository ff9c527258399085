"""The pose table finds what it holds, whatever part of it is hidden."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from rendered_bodies import CAMERA, MODEL, UP, evidence_in, evidence_of, joints_of
from topview.body.parts import UPPER_TORSO
from topview.filter.turning import N_YAWS, YAWS_RAD
from topview.kernels.lookup import project, squared_distances, squares_of_nearest
from topview.track.methods.topview import lookup
from topview.track.methods.topview.lookup import (
    FACING_GRID,
    packed,
    shipped_poses,
    turned,
    unpacked,
)
from topview.track.pose import Pose
from topview.track.stances import STANDING, facing, heading, stand

HEAD = np.array([0.05, -0.6, 2.6])


def test_rotations_come_back_but_for_rounding():
    Rs = Rotation.random(200, np.random.default_rng(2)).as_matrix()
    again = unpacked(packed(Rs))
    assert_allclose(
        again @ np.swapaxes(again, -1, -2), np.broadcast_to(np.eye(3), Rs.shape), atol=1e-9
    )
    cosines = ((Rs * again).sum((-1, -2)) - 1.0) / 2.0
    assert np.degrees(np.arccos(cosines.min())) < 1.0


def test_distances_are_those_over_what_is_not_hidden():
    rng = np.random.default_rng(5)
    axes = np.linalg.qr(rng.normal(size=(60, 8)))[0].astype(np.float32)
    entries = rng.normal(size=(8, 700)).astype(np.float32)
    seen = rng.normal(size=60).astype(np.float32)
    is_hidden = rng.random(60) < 0.4
    gram, place = np.empty((8, 8), np.float32), np.empty(8, np.float32)
    project(seen, is_hidden, axes, gram, place)
    squares = np.empty(700, np.float32)
    squared_distances(entries, gram, place, squares)
    off = (seen[:, None] - axes @ entries)[~is_hidden]
    assert_allclose(squares + (seen[~is_hidden] ** 2).sum(), (off**2).sum(0), rtol=1e-3, atol=1e-3)


def test_how_far_the_nearest_few_are_is_what_numpy_says():
    rng = np.random.default_rng(6)
    entries, wanted = (rng.normal(size=s).astype(np.float32) for s in ((7, 700), (9, 7)))
    counts = rng.random(7).astype(np.float32)
    lowest, squares = np.empty(4, np.float32), np.empty(9, np.float32)
    squares_of_nearest(entries, counts, wanted, lowest, squares)
    off = (wanted[:, :, None] - entries) ** 2
    assert_allclose(squares, np.sort(counts @ off)[:, :4].mean(1), rtol=1e-5)


def test_the_table_holds_poses_and_each_turned_pose_once():
    table = shipped_poses()
    assert_allclose(np.linalg.det(table.Rs), 1.0, atol=1e-6)
    assert sum(len(own) for own in table.entries) == table.yaws_rad.size


def test_who_shows_nothing_near_the_head_looks_like_something():
    evidence = evidence_of(stand(MODEL, HEAD, STANDING, 0.0, UP))
    far = replace(evidence, all_points_camera=evidence.all_points_camera + 9.0)
    assert np.isfinite(lookup.seen_descriptor(far, MODEL.stature_m)).all()


@pytest.mark.parametrize("yaw_deg", [0.0, 60.0, 120.0, 180.0, 240.0, 300.0])
def test_who_stands_is_found_whichever_way_they_face(yaw_deg):
    pose = stand(MODEL, HEAD, STANDING, np.radians(yaw_deg), UP)
    found = shipped_poses().likeness(evidence_of(pose), MODEL.stature_m).poses(MODEL, 20)
    errors = [np.linalg.norm(joints_of(own) - joints_of(pose), axis=1).mean() for own in found]
    assert min(errors) < 0.15


@pytest.mark.parametrize("aside_m", [0.0, -0.9])
@pytest.mark.parametrize("yaw_deg", [0.0, 45.0, -90.0, 180.0])
def test_all_that_looks_alike_tells_how_somebody_faces(yaw_deg, aside_m):
    """Wherever in the image they are. Somebody who stands at ease looks nearly alike from both
    sides, so it is a likelihood."""
    table, told = shipped_poses(), np.zeros(N_YAWS)
    for index in range(100, 4800, 400):
        R = facing(np.radians(yaw_deg), UP) @ FACING_GRID.T @ table.Rs[index]
        pose = Pose.below_head(HEAD + np.array([aside_m, 0.0, 0.0]), R, MODEL)
        true_rad = heading(pose.Rs[UPPER_TORSO], UP)
        own = table.likeness(evidence_of(pose), MODEL.stature_m).yaw_log_likelihood()
        told += np.interp(YAWS_RAD + true_rad, YAWS_RAD, own, period=2.0 * np.pi)
    assert abs(YAWS_RAD[np.argmax(told)]) < np.radians(15)
    assert told[N_YAWS // 2] > told[0] + 3.0


def test_nothing_that_is_seen_tells_no_yaw():
    wall = np.full((CAMERA.height, CAMERA.width), 1.0, np.float32)
    is_users = np.zeros_like(wall, bool)
    is_users[0, 0] = True
    hidden = evidence_in(wall, is_users, HEAD)
    told = shipped_poses().likeness(hidden, MODEL.stature_m).yaw_log_likelihood()
    assert np.ptp(told) < 0.1


def test_the_trunk_is_found_where_the_legs_are_outside_of_the_image():
    pose = stand(MODEL, HEAD, STANDING, 0.3, UP)
    evidence = evidence_of(pose, camera=replace(CAMERA, height=70))
    assert lookup.hidden_cells(evidence, MODEL.stature_m).any()
    found = shipped_poses().likeness(evidence, MODEL.stature_m).poses(MODEL, 10)
    trunk = slice(0, 4)
    errors = [
        np.linalg.norm(joints_of(own)[trunk] - joints_of(pose)[trunk], axis=1).mean()
        for own in found
    ]
    assert min(errors) < 0.08


def test_what_is_found_differs():
    pose = stand(MODEL, HEAD, STANDING, 0.3, UP)
    found = shipped_poses().likeness(evidence_of(pose), MODEL.stature_m).poses(MODEL, 8)
    assert len(found) == 8
    for index, one in enumerate(found):
        for other in found[:index]:
            assert np.linalg.norm(joints_of(one) - joints_of(other), axis=1).max() > 0.02


def test_turns_are_about_the_vertical():
    yaws = np.linspace(-3.0, 3.0, 7)
    Rs = turned(yaws)
    assert_allclose(Rs @ [0.0, 1.0, 0.0], np.broadcast_to([0.0, 1.0, 0.0], (7, 3)))
    assert_allclose(np.linalg.det(Rs), 1.0)
    assert isinstance(Pose(HEAD, Rs), Pose)
