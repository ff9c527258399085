"""`topview info`: what is in a recording, of any format, in a few lines or one JSON object."""

from __future__ import annotations

import json

import numpy as np
import pytest

from tiny_bags import BagWriter, depth_mm


def test_a_folder_is_told_in_lines_that_fit(topview, make_recording):
    ended = topview("info", make_recording())
    assert ended.status == 0
    assert ended.complaints == []
    told = ended.out.splitlines()
    assert all(len(line) <= 88 for line in told)
    assert told == [
        "name    recording",
        "format  folder: a folder with depth/000000.png ... and camera.json",
        "camera  64 x 48 pixels, fx 57.00, fy 57.00, cx 31.50, cy 23.50",
        "        noise as of kinect1, no lens distortion",
        "colour  none",
        "frames  3 at 30.0 per second, 0.1 s",
        "depth   3.00 to 3.00 m, median 3.00; 100% of pixels have a reading; 3 frames looked at",
        "world   pose of the camera not known",
    ]


def test_json_says_the_same_in_numbers(topview, make_recording):
    images = [np.where(np.arange(64) < 16, 0, 1000 * n).astype(np.uint16) for n in (1, 2, 3, 4)]
    source = make_recording([np.tile(image, (48, 1)) for image in images], fps=10)
    told = json.loads(topview("info", source, "--json").out)
    assert (told["frames"], told["frames_per_s"], told["format"]) == (
        4,
        pytest.approx(10),
        "folder",
    )
    assert told["length_s"] == pytest.approx(0.3)
    assert told["valid_share"] == pytest.approx(0.75)
    assert told["nearest_m"] == pytest.approx(1.0, rel=0.01)
    assert told["farthest_m"] == pytest.approx(4.0, rel=0.01)
    assert told["camera"]["fx"] == 57.0


def test_a_bag_is_told_by_its_first_frames(topview, tmp_path):
    with BagWriter(tmp_path, "mcap") as bag:
        bag.info("/camera_info", "a")
        for index in range(12):
            bag.image("/depth", depth_mm(index), "16UC1", 5.0 + 0.2 * index, "a")
    told = json.loads(topview("info", bag.path, "--json").out)
    assert (told["format"], told["frames"], told["frames_looked_at"]) == ("ros", 12, 8)
    assert told["frames_per_s"] == pytest.approx(5.0)
    assert told["length_s"] == pytest.approx(2.2)
    assert told["problems"] == ["has no colour images"]


def test_depth_of_another_unit_is_noted(topview, make_recording):
    ended = topview("info", make_recording(depth_scale=2e-5))
    assert ended.status == 0
    assert "note    readings lie from 0.06 to 0.06 m; people must be seen" in ended.out


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("x.oni", "is an OpenNI recording"),
        ("x.xef", "is a Kinect Studio recording"),
        ("x.mp4", "is a video without depth"),
        ("x.npz", "save the depth alone as depth.npy"),
        ("x.bag", "no format that is known"),
        ("gone", "no such file or folder"),
    ],
)
def test_what_cannot_be_read_is_one_line_that_says_what_to_do(topview, tmp_path, name, told):
    if name != "gone":
        (tmp_path / name).write_bytes(b"whatever")
    ended = topview("info", tmp_path / name)
    assert ended.status == 2
    assert ended.out == ""
    (line,) = ended.complaints
    assert told in line


def test_a_folder_of_broken_images_is_one_line(topview, make_recording):
    source = make_recording()
    for image in (source / "depth").iterdir():
        image.write_bytes(b"")
    ended = topview("info", source)
    assert ended.status == 2
    (line,) = ended.complaints
    assert "none of the frames looked at can be read: depth/000000.png: is empty" in line
