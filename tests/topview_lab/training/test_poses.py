"""The table of poses: what is made of captures, and what it looks like."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from made_captures import write_captures
from topview.body.parts import LEFT_LOWER_LEG, LEFT_UPPER_LEG, PARTS, UPPER_TORSO
from topview.records import InputError
from topview.track.methods.topview import lookup
from topview.track.methods.topview.lookup import LEFT, TOP
from topview.track.pose import mirrored
from topview_lab.kernels.upright import draw_upright
from topview_lab.training.poses import (
    PosesRecipe,
    facing_camera,
    make_table,
    read_captures,
    seated,
    spread_poses,
)


@pytest.fixture(scope="module")
def captures(tmp_path_factory):
    return write_captures(tmp_path_factory.mktemp("captures") / "captures.npz")


def test_captures_become_poses_and_may_be_left_out(captures):
    Rs = read_captures(captures)
    assert Rs.shape == (60, len(PARTS), 3, 3)
    assert_allclose(np.linalg.det(Rs), 1.0, atol=1e-6)
    assert_array_equal(read_captures(captures, ["01_01"]), Rs[40:])
    with pytest.raises(InputError, match="has no capture 09_09 that could be left out"):
        read_captures(captures, ["01_01", "09_09"])
    with pytest.raises(InputError, match="no capture is left"):
        read_captures(captures, ["01_01", "01_02"])


def test_poses_face_the_camera_and_the_mirror_of_the_mirror_is_the_same(captures):
    Rs = facing_camera(read_captures(captures))
    assert_allclose(Rs[:, UPPER_TORSO, 2, 0], 0.0, atol=1e-12)
    assert (Rs[:, UPPER_TORSO, 0, 0] < 0.0).all()
    assert_allclose(mirrored(mirrored(Rs)), Rs)
    assert_allclose(np.linalg.det(mirrored(Rs)), 1.0, atol=1e-6)


def test_who_is_seated_has_thighs_to_the_front_and_shanks_down(captures):
    Rs = seated(facing_camera(read_captures(captures)), np.random.default_rng(0))
    thighs, shanks = Rs[:, LEFT_UPPER_LEG, :, 1], Rs[:, LEFT_LOWER_LEG, :, 1]
    assert thighs[:, 2].mean() < -0.7
    assert shanks[:, 1].mean() > 0.7


def test_poses_that_are_spread_differ_and_none_is_a_captured_one(captures):
    Rs = read_captures(captures)
    chosen = spread_poses(Rs, 10)
    assert len(np.unique(chosen.reshape(10, -1), axis=0)) == 10
    assert_allclose(
        chosen @ np.swapaxes(chosen, -1, -2), np.broadcast_to(np.eye(3), chosen.shape), atol=1e-9
    )
    assert not any(np.isclose(Rs, own, atol=1e-3).all((1, 2, 3)).any() for own in chosen)


def test_the_mean_of_poses_that_are_alike_is_the_pose(captures):
    Rs = np.repeat(read_captures(captures)[:3], 12, axis=0)
    chosen = spread_poses(Rs, 3)
    assert all(np.isclose(Rs, own).all((1, 2, 3)).any() for own in chosen)


def test_a_ball_covers_its_disc():
    """A part as long as its slices are thick, and as wide, is nearly a ball."""
    radius, cell = 0.1, 0.02
    covered, depth = np.empty((2, 1, 30, 30), np.float32)
    draw_upright(
        covered, depth, np.eye(3)[None, None], np.zeros((1, 1, 3)), np.array([1e-6]),
        np.array([[2 * radius, 2 * radius, 2 * radius, 2 * radius, 0.0, 0.0]]), -0.3, -0.3, cell, 4,
    )  # fmt: skip
    # flattened along the part to half of its radius
    assert_allclose(covered.sum() * cell**2, np.pi * 2 * radius * radius, rtol=0.05)
    assert depth.min() == pytest.approx(-2 * radius, abs=0.01)


def test_a_small_table_is_whole_and_the_same_again(captures):
    recipe = PosesRecipe(captured=12, lent=6, seated=4, directions=4, components=8)
    Rs = read_captures(captures)
    one, other = make_table(Rs, recipe), make_table(Rs, recipe)
    for name, array in one.items():
        assert_array_equal(array, other[name])
    poses = len(one["rotations"])
    assert one["yaws"].shape == (poses, 4)
    assert one["components"].shape == (4 * poses, 8)
    assert one["axes"].shape == (2 * lookup.GRID_ROWS * lookup.GRID_COLUMNS, 8)
    assert LEFT < 0.0 > TOP
