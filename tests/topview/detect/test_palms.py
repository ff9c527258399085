"""The palm of a bare arm is at its end, wherever the arm points."""

from __future__ import annotations

import numpy as np
import pytest

from detect_scenes import CAMERA, SKIN_RGB, Disc, frame_of
from topview.camera.pyramid import Pyramid
from topview.detect.faces_and_hands import FacesAndHands, SkinBlob
from topview.records import Frame

HEAD = np.array([0.0, -0.3, 2.0])


def arm_of(elbow_px: tuple[float, float], palm_px: tuple[float, float], slope_m: float) -> Frame:
    """A bare forearm of discs from elbow to palm, `slope_m` nearer at the palm."""
    discs: list[Disc] = [
        (*(np.array(elbow_px) * (1 - t) + np.array(palm_px) * t), 5.0, 2.0 - slope_m * t, SKIN_RGB)
        for t in np.linspace(0.0, 1.0, 25)
    ]
    return frame_of(discs)


def blob_in(frame: Frame, heads: list[np.ndarray]) -> SkinBlob:
    (blob,) = FacesAndHands().update(Pyramid(frame), heads).blobs
    return blob


@pytest.mark.parametrize(
    "palm_px", [(140.0, 30.0), (150.0, 60.0), (140.0, 90.0), (115.0, 98.0), (105.0, 26.0)]
)
@pytest.mark.parametrize("slope_m", [0.0, 0.06])
def test_the_palm_is_at_the_arms_end(palm_px: tuple[float, float], slope_m: float) -> None:
    blob = blob_in(arm_of((108.0, 62.0), palm_px, slope_m), [HEAD])
    z = 2.0 - slope_m
    palm = z * np.array(
        [(palm_px[0] - CAMERA.cx) / CAMERA.fx, (palm_px[1] - CAMERA.cy) / CAMERA.fy, 1.0]
    )
    assert blob.palm_camera is not None
    assert blob.surface_camera is not None
    assert np.linalg.norm(blob.palm_camera - palm) < 0.06
    assert np.linalg.norm(blob.surface_camera - palm) > 0.09


def test_without_a_head_or_an_arm_the_palm_is_the_middle() -> None:
    arm = arm_of((108.0, 62.0), (150.0, 60.0), 0.0)
    hand = frame_of([(120, 60, 11, 2.0, SKIN_RGB)])
    for frame, heads in ((arm, []), (arm, [HEAD + 2.0]), (hand, [HEAD])):
        blob = blob_in(frame, heads)
        assert blob.palm_camera is not None
        assert blob.surface_camera is not None
        assert np.array_equal(blob.palm_camera, blob.surface_camera)
