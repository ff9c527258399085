"""What a skeleton is in a mirror, and how far two trackings lie apart."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from skeleton_sequences import people_standing, standing
from topview.body import JOINT_NAMES
from topview.camera.projection import project
from topview.records import Camera
from topview_lab.metrics.mirror import measure_apart, mirrored_joints

CAMERA = Camera(fx=200, fy=200, cx=150.5, cy=119.5, width=320, height=240)


@given(st.integers(0, 2**32 - 1))
def test_the_mirror_image_of_the_mirror_image_is_what_was_there(seed):
    joints = np.random.default_rng(seed).normal(size=(3, 2, len(JOINT_NAMES), 3))
    assert_array_equal(mirrored_joints(mirrored_joints(joints)), joints)


def test_the_left_hand_is_the_right_one_at_the_flipped_pixel():
    joints = standing(x_m=0.4)
    joints[JOINT_NAMES.index("left_hand"), 1] -= 0.3
    mirrored = mirrored_joints(joints)
    flipped = Camera(200, 200, CAMERA.width - 1 - CAMERA.cx, 119.5, CAMERA.width, CAMERA.height)
    for name, other in (("left_hand", "right_hand"), ("right_knee", "left_knee"), ("head",) * 2):
        (u, v), (u_mirrored, v_mirrored) = (
            project(each[JOINT_NAMES.index(joint)], camera)
            for each, joint, camera in ((joints, name, CAMERA), (mirrored, other, flipped))
        )
        assert u_mirrored == pytest.approx(CAMERA.width - 1 - u)
        assert v_mirrored == pytest.approx(v)


def test_people_are_compared_whatever_their_order():
    first, second = people_standing(3, -1.0, 1.0), people_standing(3, 1.02, -1.0)
    apart = measure_apart(first, second)
    assert apart.alone == 0
    assert_allclose(np.sort(apart.distances_cm.mean(1)), [0.0] * 3 + [2.0] * 3, atol=1e-9)
    assert apart.quantile_cm(1.0) == pytest.approx(2.0)


def test_who_is_there_but_once_is_counted_and_compared_with_nobody():
    first, second = people_standing(2, -1.0), people_standing(2, -1.0, 1.0)
    second[1, 0] = np.nan
    apart = measure_apart(first, second)
    assert apart.alone == 3  # two frames of the other, one in which the first is lost
    assert apart.distances_cm.shape == (1, len(JOINT_NAMES))
    assert np.isnan(measure_apart(first, np.full_like(first, np.nan)).quantile_cm(0.5))
