"""The pose table finds what it holds, whatever part of it is hidden."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from rendered_bodies import CAMERA, MODEL, UP, evidence_of, joints_of
from topview.kernels.lookup import project, squared_distances
from topview.track.methods.topview import lookup
from topview.track.methods.topview.lookup import packed, shipped_poses, turned, unpacked
from topview.track.pose import Pose
from topview.track.stances import STANDING, stand

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


def test_the_table_holds_poses_and_each_turned_pose_once():
    table = shipped_poses()
    assert_allclose(np.linalg.det(table.Rs), 1.0, atol=1e-6)
    assert sum(len(own) for own in table.entries) == table.yaws_rad.size


@pytest.mark.parametrize("yaw_deg", [0.0, 60.0, 120.0, 180.0, 240.0, 300.0])
def test_who_stands_is_found_whichever_way_they_face(yaw_deg):
    pose = stand(MODEL, HEAD, STANDING, np.radians(yaw_deg), UP)
    found = shipped_poses().look_up(evidence_of(pose), MODEL, 20)
    errors = [np.linalg.norm(joints_of(own) - joints_of(pose), axis=1).mean() for own in found]
    assert min(errors) < 0.15


def test_the_trunk_is_found_where_the_legs_are_outside_of_the_image():
    pose = stand(MODEL, HEAD, STANDING, 0.3, UP)
    evidence = evidence_of(pose, camera=replace(CAMERA, height=70))
    assert lookup.hidden_cells(evidence, MODEL.stature_m).any()
    found = shipped_poses().look_up(evidence, MODEL, 10)
    trunk = slice(0, 4)
    errors = [
        np.linalg.norm(joints_of(own)[trunk] - joints_of(pose)[trunk], axis=1).mean()
        for own in found
    ]
    assert min(errors) < 0.08


def test_what_is_found_differs():
    pose = stand(MODEL, HEAD, STANDING, 0.3, UP)
    found = shipped_poses().look_up(evidence_of(pose), MODEL, 8)
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
