"""Colour images of every kind that files hold: none of them loses a frame."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from numpy.testing import assert_array_equal

import topview

SIZE = (6, 8)
GREY = np.random.default_rng(0).integers(0, 256, SIZE, np.uint8)
RGB = np.random.default_rng(1).integers(0, 256, (*SIZE, 3), np.uint8)
ALPHA = np.full((*SIZE, 1), 7, np.uint8)
GREY_RGB = np.stack([GREY] * 3, -1)


def png(image_bgr: np.ndarray) -> bytes:
    return cv2.imencode(".png", image_bgr)[1].tobytes()


@pytest.mark.parametrize(
    ("stored", "expected"),
    [
        (GREY, GREY_RGB),
        (GREY_RGB, GREY_RGB),
        (GREY.astype(np.uint16) * 257, GREY_RGB),
        (RGB[..., ::-1], RGB),
        (np.concatenate([RGB[..., ::-1], ALPHA], -1), RGB),
        (RGB[..., ::-1].astype(np.uint16) * 257, RGB),
        (np.zeros((*SIZE, 3), np.uint8), np.zeros((*SIZE, 3), np.uint8)),
        (np.full((*SIZE, 3), 255, np.uint8), np.full((*SIZE, 3), 255, np.uint8)),
    ],
    ids=["grey", "equal channels", "16-bit grey", "RGB", "alpha", "16-bit RGB", "dark", "white"],
)
def test_every_kind_of_png_is_read_as_rgb(write_folder, depths, stored, expected):
    recording = topview.open(write_folder(color={f"{i:06d}.png": png(stored) for i in depths}))
    frames = list(recording)
    assert len(frames) == len(depths)
    for frame in frames:
        assert frame.color is not None
        assert_array_equal(frame.color, expected)
    assert recording.problems == []


def test_grey_jpeg_is_read_as_rgb(write_folder, depths):
    flat = np.full(SIZE, 90, np.uint8)
    jpeg = cv2.imencode(".jpg", flat)[1].tobytes()
    for frame in topview.open(write_folder(color={f"{i:06d}.jpg": jpeg for i in depths})):
        assert frame.color is not None
        assert_array_equal(frame.color, np.full((*SIZE, 3), 90))


def test_a_recording_of_nothing_but_odd_colour_still_has_every_frame(write_folder, depths, encode):
    """One line for what is missing, one for each file that cannot be read."""
    color = {
        "000000.png": png(GREY),
        "000001.png": encode(RGB)[:-9],
        "000002.png": b"GIF89a",
    }
    recording = topview.open(write_folder(color=color))
    for _ in range(2):
        assert [frame.color is None for frame in recording] == [False, True, True, True]
    assert len(recording.problems) == 3
    assert all("\n" not in line and line.startswith("rgb/") for line in recording.problems)


def test_many_unreadable_colour_files_share_a_line(write_folder, depths):
    images = dict.fromkeys(range(40), depths[0])
    recording = topview.open(write_folder(images, {f"{i:06d}.png": b"" for i in images}))
    for _ in range(2):
        assert [frame.color for frame in recording] == [None] * 40
        assert [line[: len("rgb/000000.png")] for line in recording.problems[:5]] == [
            f"rgb/{i:06d}.png" for i in range(5)
        ]
        assert recording.problems[5:] == ["35 more frames come without colour"]


def test_many_unreadable_depth_files_share_a_line(write_folder, depths):
    folder = write_folder(dict.fromkeys(range(40), depths[0]))
    for index in range(1, 40):
        (folder / "depth" / f"{index:06d}.png").write_bytes(b"no image")
    recording = topview.open(folder)
    for _ in range(2):
        assert [frame.index for frame in recording] == [0]
        assert len(recording.problems) == 6
        assert recording.problems[-1] == "34 more images of depth/ cannot be read"
