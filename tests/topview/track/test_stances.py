"""Which way somebody faces who is started upright, before a camera that may be tilted."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from rendered_bodies import MODEL
from topview.body.parts import UPPER_TORSO
from topview.track.pose import OTHER_SIDE
from topview.track.stances import STANCES, facing, heading, stand

MIRROR = np.diag([-1.0, 1.0, 1.0])
yaws = st.floats(-3.1, 3.1)
ups = st.builds(
    lambda pitch, roll: np.array(
        [np.sin(roll), -np.cos(roll) * np.cos(pitch), -np.cos(roll) * np.sin(pitch)]
    ),
    st.floats(-0.6, 0.6),
    st.floats(-0.3, 0.3),
)


@given(yaws, ups)
def test_somebody_upright_stands_along_gravity_and_heads_where_told(yaw_rad, up):
    R = facing(yaw_rad, up)
    assert_allclose(R.T @ R, np.eye(3), atol=1e-12)
    assert_allclose(R[:, 1], -up, atol=1e-12)
    assert heading(R, up) == pytest.approx(yaw_rad, abs=1e-9)


def test_facing_the_camera_is_zero_and_a_positive_turn_is_to_the_own_right():
    up = np.array([0.0, -1.0, 0.0])
    assert_allclose(facing(0.0, up)[:, 2], (0.0, 0.0, -1.0), atol=1e-12)
    own_right = facing(0.0, up)[:, 0]
    assert facing(0.5, up)[:, 2] @ own_right > 0.4


@given(yaws, ups)
@pytest.mark.parametrize("stance", STANCES)
def test_every_stance_mirrors(stance, yaw_rad, up):
    """Left for right, turned the other way, under a camera that rolls the other way."""
    head = np.array([0.3, -0.5, 2.5])
    pose = stand(MODEL, head, stance, yaw_rad, up)
    other = stand(MODEL, MIRROR @ head, stance, -yaw_rad, MIRROR @ up)
    assert_allclose(other.neck_camera, MIRROR @ pose.neck_camera, atol=1e-12)
    assert_allclose(other.Rs, MIRROR @ pose.Rs[list(OTHER_SIDE)] @ MIRROR, atol=1e-9)
    assert other.Rs[UPPER_TORSO][2, 2] == pytest.approx(pose.Rs[UPPER_TORSO][2, 2])
