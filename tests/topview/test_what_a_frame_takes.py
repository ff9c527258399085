"""A frame keeps readings and nothing else, and leaves what it was given alone."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from topview.records import Camera, Frame, InputError
from topview.track import Tracker, TrackerSettings

CAMERA = Camera(fx=10.0, fy=10.0, cx=3.5, cy=2.5, width=8, height=6)
SHAPE = (6, 8)


def frame_of(depth_m, index=0, timestamp_s=0.0, camera=CAMERA) -> Frame:
    return Frame(index, timestamp_s, depth_m, camera)


@given(
    arrays(
        np.float32,
        SHAPE,
        elements=st.sampled_from([0.0, -0.0, -1.0, np.nan, np.inf, -np.inf, 1e30, 150.0, 2.5, 99.0])
        | st.floats(0.5, 20.0, width=32),
    )
)
def test_what_is_no_reading_becomes_none(depth_m):
    far = np.count_nonzero((depth_m > 30) & (depth_m < np.inf))
    near = np.count_nonzero((depth_m > 0) & (depth_m <= 30))
    if far > near:
        with pytest.raises(InputError, match="millimetres"):
            frame_of(depth_m)
        return
    kept = frame_of(depth_m).depth_m
    is_reading = (depth_m > 0) & (depth_m <= 100)
    np.testing.assert_array_equal(kept, np.where(is_reading, depth_m, 0))
    assert not np.signbit(kept).any() or (depth_m[np.signbit(kept)] == 0).all()


@pytest.mark.parametrize("depth_m", [[[1.0] * 8] * 6, None, "depth", np.ones(SHAPE), np.float32(2)])
def test_what_is_no_depth_image_is_refused_in_one_line(depth_m):
    with pytest.raises(
        InputError, match=r"frame 0: depth is .*; it must be float32 metres, \(6, 8\) as the camera"
    ):
        frame_of(depth_m)


def test_the_given_array_stays_the_givers():
    depth_m, color = np.ones(SHAPE, np.float32), np.zeros((*SHAPE, 3), np.uint8)
    frame = Frame(0, 0.0, depth_m, CAMERA, color)
    depth_m[:], color[:] = 2.0, 9
    assert (frame.depth_m == 1.0).all()
    assert frame.color is not None
    assert (frame.color == 0).all()
    assert not frame.depth_m.flags.writeable


def test_a_view_of_a_buffer_that_is_used_again_is_copied():
    buffer = np.ones(SHAPE, np.float32)
    view = buffer[:]
    view.setflags(write=False)
    frame = frame_of(view)
    buffer[:] = 5.0
    assert (frame.depth_m == 1.0).all()


def test_a_columnwise_array_is_kept_rowwise():
    assert frame_of(np.asfortranarray(np.ones(SHAPE, np.float32))).depth_m.flags.c_contiguous


@pytest.mark.parametrize("times_s", [(0.5, 0.5), (0.5, 0.4), (0.5, np.nan), (np.nan,), (np.inf,)])
def test_times_that_do_not_increase_are_refused(times_s):
    tracker, depth_m = Tracker(TrackerSettings(threads=1)), np.ones(SHAPE, np.float32)
    *before, last = [frame_of(depth_m, k, time_s) for k, time_s in enumerate(times_s)]
    for frame in before:
        tracker.update(frame)
    with pytest.raises(InputError, match="times must be numbers that increase"):
        tracker.update(last)


def test_another_camera_is_refused():
    tracker, depth_m = Tracker(TrackerSettings(threads=1)), np.ones(SHAPE, np.float32)
    tracker.update(frame_of(depth_m))
    other = Camera(fx=11.0, fy=10.0, cx=3.5, cy=2.5, width=8, height=6)
    with pytest.raises(InputError, match="a tracker follows one camera"):
        tracker.update(frame_of(depth_m, 1, 0.1, other))


@pytest.mark.parametrize(
    ("settings", "complaint"),
    [
        ({"method": "x"}, "method is 'x'"),
        ({"detector": "x"}, "detector is 'x'"),
        ({"seed": 1.5}, "seed is 1.5"),
        ({"seed": True}, "seed is True"),
        ({"threads": 2.5}, "threads is 2.5"),
        ({"threads": "2"}, "threads is '2'"),
    ],
)
def test_settings_that_make_no_sense_are_refused(settings, complaint):
    with pytest.raises(InputError, match=complaint):
        TrackerSettings(**settings)


def test_a_whole_number_of_numpy_is_a_number():
    assert type(TrackerSettings(seed=np.int64(3)).seed) is int  # type: ignore[arg-type]
