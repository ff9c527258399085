"""Where points are seen in the small cloud."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from topview.detect.cloud import Cloud
from topview.records import Camera, Frame

CAMERA = Camera(35.0, 36.0, 19.5, 14.5, 40, 30)
CLOUD = Cloud.from_frame(Frame(0, 0.0, np.full((30, 40), 2.0, np.float32), CAMERA))
COORDINATES = st.floats(-4.0, 4.0)


@given(COORDINATES, COORDINATES, COORDINATES)
def test_a_single_point_is_seen_where_many_are(x: float, y: float, z: float) -> None:
    point = np.array([x, y, z])
    row, column, is_inside = CLOUD.pixel_of(point)
    assert CLOUD.pixel_at(point) == (row, column, is_inside)
