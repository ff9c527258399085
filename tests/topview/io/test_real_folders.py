"""The real and the rendered folder recordings are read whole, without a problem."""

from __future__ import annotations

import pytest

import topview


@pytest.mark.parametrize(
    ("folder", "frames", "has_color"),
    [
        ("five_people", 1, True),
        ("four_people_kinect2", 1, True),
        ("skeltrack", 6, False),
        ("urfall_fall01", 98, False),
        ("composites/box_sweep", 120, False),
    ],
)
def test_real_folders(recordings, folder, frames, has_color):
    recording = topview.open(recordings / folder)
    assert recording.frame_count == frames
    frame = next(iter(recording))
    assert (frame.color is not None) == has_color
    assert 0.5 < frame.depth_m[frame.depth_m > 0].mean() < 8.0
    assert recording.problems == []


def test_a_rendered_folder(bench):
    recording = topview.open(bench / "b1_pass_by")
    frames = list(recording)
    assert [frame.index for frame in frames] == list(range(recording.frame_count or 0))
    assert all(frame.color is not None for frame in frames)
    assert 0.5 < frames[0].depth_m[frames[0].depth_m > 0].mean() < 8.0
    assert recording.problems == []
