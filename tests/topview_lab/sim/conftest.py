"""Scenes and simulated frames that the simulator's tests share."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from topview.records import Camera
from topview_lab.sim import GroundTruth, Scene, scene_by_name, simulate_truth
from topview_lab.sim.images import NO_MATERIAL, NO_PART, Rendering


@pytest.fixture(scope="session")
def pass_by() -> Scene:
    return scene_by_name("pass_by", seed=1)


@pytest.fixture(scope="session")
def pass_by_truth(pass_by: Scene) -> GroundTruth:
    return simulate_truth(pass_by)


@pytest.fixture(scope="session")
def tiny_camera() -> Camera:
    return Camera(fx=60.0, fy=60.0, cx=31.5, cy=23.5, width=64, height=48)


def plain_rendering(depth_m: NDArray[np.float32]) -> Rendering:
    """A rendering of surfaces that face the camera, without people."""
    shape = depth_m.shape
    normals = np.zeros((*shape, 3), np.float32)
    normals[..., 2] = -1.0
    return Rendering(
        depth_m=depth_m,
        instance=np.zeros(shape, np.uint8),
        part=np.full(shape, NO_PART, np.uint8),
        material=np.full(shape, NO_MATERIAL, np.uint8),
        normals=normals,
        albedo=np.full((*shape, 3), 0.5, np.float32),
    )


@pytest.fixture(scope="session")
def render_plain():
    return plain_rendering
