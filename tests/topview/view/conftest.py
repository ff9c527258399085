"""A made-up room with people who stand in it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from topview.body.ends import output_joints
from topview.body.kinematics import R_CAMERA_FACING, forward_kinematics
from topview.body.model import BodyModel
from topview.body.parts import OUTPUT_JOINTS, PARTS
from topview.body.proportions import ANATOMICAL
from topview.records import Camera, Frame, JointState, Person

MakePerson = Callable[..., Person]
MakeFrame = Callable[..., Frame]


@pytest.fixture(scope="session")
def make_person() -> MakePerson:
    def make(
        person_id: int = 1,
        crown: tuple[float, float, float] = (0.0, -0.8, 3.0),
        state: JointState = JointState.VISIBLE,
    ) -> Person:
        """Someone of 1.75 m who stands upright and faces the camera."""
        body = BodyModel.of(1.75, ANATOMICAL)
        Rs = np.repeat(R_CAMERA_FACING[None], len(PARTS), axis=0)
        Ts_camera_part = forward_kinematics(body, np.array(crown), Rs)
        return Person(
            id=person_id,
            height_m=1.75,
            joints_camera=output_joints(body, Ts_camera_part),
            joint_state=np.full(len(OUTPUT_JOINTS), state, np.uint8),
            joint_confidence=np.ones(len(OUTPUT_JOINTS), np.float32),
            Ts_camera_part=Ts_camera_part,
        )

    return make


@pytest.fixture(scope="session")
def make_frame() -> MakeFrame:
    def make(index: int = 0, width: int = 160, height: int = 120, wall_m: float = 4.0) -> Frame:
        """A wall that fills the image of a camera one metre over the floor."""
        focal = 0.9 * width
        camera = Camera(focal, focal, (width - 1) / 2, (height - 1) / 2, width, height)
        depth_m = np.full((height, width), wall_m, np.float32)
        return Frame(index, index / 30, depth_m, camera)

    return make
