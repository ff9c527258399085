"""Somebody seen through a lens is tracked as without it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from lenses import LENSES
from topview.camera import pixel_rays, project, undistorted
from topview.records import Distortion, Frame
from topview.track.tracker import Tracker
from topview_lab.sim import SimulatedRecording, scene_by_name

FRAMES = 12


def as_seen_through(lens: Distortion, frame: Frame) -> Frame:
    """The same scene by a camera with a lens, as far as the frame shows it."""
    camera = replace(frame.camera, distortion=lens)
    column, row = np.moveaxis(np.rint(project(pixel_rays(camera), frame.camera)), -1, 0)
    is_shown = (column >= 0) & (column < camera.width) & (row >= 0) & (row < camera.height)
    column, row = (np.where(is_shown, place, 0).astype(int) for place in (column, row))
    assert frame.color is not None
    depth_m = np.where(is_shown, frame.depth_m[row, column], np.float32(0.0))
    color = np.where(is_shown[..., None], frame.color[row, column], np.uint8(0))
    return replace(frame, depth_m=depth_m, camera=camera, color=color)


@pytest.mark.parametrize("name", ["brown_conrady", "rational"])
def test_a_users_own_frames_with_a_lens_give_the_same_joints(name):
    recording = list(SimulatedRecording(scene_by_name("wave", seed=5, frames=FRAMES)))
    plain, lensed, by_hand, untold = (Tracker() for _ in range(4))
    off_cm, untold_cm = [], []
    for frame in recording:
        seen = as_seen_through(LENSES[name], frame)
        people = (
            plain.update(frame),
            lensed.update(seen),
            by_hand.update(undistorted(seen)),
            untold.update(replace(seen, camera=replace(seen.camera, distortion=None))),
        )
        joints = [person.joints_camera for (person,) in people]
        np.testing.assert_array_equal(joints[1], joints[2])
        for told, other in ((off_cm, joints[1]), (untold_cm, joints[3])):
            told.append(100.0 * np.linalg.norm(other - joints[0], axis=1))
    assert np.median(off_cm) < 1.5
    assert np.median(untold_cm) > 2.0 * np.median(off_cm)
