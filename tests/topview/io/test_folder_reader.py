"""Folders of images: what is written is read, and what cannot be read is named and left out."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest

import topview
from topview import InputError
from topview.camera import undistorted
from topview.io.readers.camera_json import metres_per_unit
from topview.io.readers.notes import MAX_LINES_ALIKE
from topview.records import Frame


def test_depth_comes_back_exactly(write_folder, depths):
    recording = topview.open(write_folder())
    frames = list(recording)
    assert recording.frame_count == len(frames) == len(depths)
    for frame, (index, units) in zip(frames, depths.items(), strict=True):
        assert frame.index == index
        assert frame.timestamp_s == index / 30.0
        assert frame.color is None
        np.testing.assert_array_equal(frame.depth_m, (units / 1000.0).astype(np.float32))
    assert recording.problems == []
    assert recording.name == "walk"


@pytest.mark.parametrize("color_suffix", [".png", ".jpg"])
def test_color_comes_back_as_rgb(write_folder, depths, color_suffix):
    red = np.full((*depths[0].shape, 3), (250, 20, 10), np.uint8)
    names = [f"{index:06d}{color_suffix}" for index in depths]
    for frame in topview.open(write_folder(color=dict.fromkeys(names, red))):
        assert frame.color is not None
        np.testing.assert_allclose(frame.color, red, atol=3)


def test_both_conventions_of_the_depth_scale_give_the_same_depth(write_folder):
    root = write_folder()
    in_metres_per_unit = [frame.depth_m for frame in topview.open(root)]
    camera = json.loads((root / "camera.json").read_text())
    (root / "camera.json").write_text(json.dumps({**camera, "depth_scale": 1000}))
    in_units_per_metre = [frame.depth_m for frame in topview.open(root)]
    np.testing.assert_array_equal(in_metres_per_unit, in_units_per_metre)


def test_depth_scale_is_metres_per_unit_below_one_and_its_inverse_above():
    assert metres_per_unit(0.001) == metres_per_unit(1000) == 0.001
    assert metres_per_unit(0.0002) == metres_per_unit(5000) == 0.0002


@pytest.mark.parametrize("scale", [0, -0.001, -1000, float("nan"), float("inf"), 1, 0.5, 2, 1e9])
def test_a_depth_scale_of_no_camera_is_refused(scale):
    with pytest.raises(InputError, match=r"depth_scale is .* 0\.001 or 1000 for millimetres"):
        metres_per_unit(scale)


def test_it_can_be_iterated_twice_and_problems_are_listed_once(write_folder, depths):
    recording = topview.open(write_folder({**depths, 1: b""}))
    first, second = list(recording), list(recording)
    assert [frame.index for frame in first] == [frame.index for frame in second] == [0, 2, 3]
    for a, b in zip(first, second, strict=True):
        np.testing.assert_array_equal(a.depth_m, b.depth_m)
    assert recording.problems == [
        "depth/000001.png: is empty (0 bytes); it must be a PNG image",
    ]


def test_the_folder_may_be_named_in_other_ways(write_folder, depths, monkeypatch):
    root = write_folder()
    for path in (f"{root}/", str(root / "depth"), f"{root}/depth/"):
        recording = topview.open(path)
        assert recording.name == "walk"
        assert len(list(recording)) == len(depths)
    monkeypatch.chdir(root / "depth")
    assert topview.open(".").name == "walk"


def test_fps_gives_the_times(write_folder):
    times = [frame.timestamp_s for frame in topview.open(write_folder(fps=10))]
    assert times == [0.0, 0.1, 0.2, 0.3]


def test_any_number_in_the_name_is_the_index(write_folder, depths):
    root: Path = write_folder()
    for index in depths:
        image = root / "depth" / f"{index:06d}.png"
        image.rename(root / "depth" / f"cam1_depth{index + 8:04d}.png")
    (root / "depth" / ".DS_Store").write_bytes(b"x")
    (root / "depth" / "notes.txt").write_bytes(b"x")
    recording = topview.open(root)
    assert [frame.index for frame in recording] == [8, 9, 10, 11]
    assert recording.problems == []


def test_a_frame_of_zeros_is_a_frame(write_folder, depths):
    recording = topview.open(write_folder({0: np.zeros_like(depths[0])}))
    (frame,) = recording
    assert not frame.depth_m.any()
    assert recording.problems == []


def test_missing_frames_are_named(write_folder, depths):
    image = depths[0]
    recording = topview.open(write_folder(dict.fromkeys((0, 1, 5, 7), image)))
    assert [frame.index for frame in recording] == [0, 1, 5, 7]
    assert recording.problems == [
        "depth/: frames 2-4 are missing between 000001.png and 000005.png",
        "depth/: frame 6 is missing between 000005.png and 000007.png",
    ]


def test_many_gaps_share_a_line(write_folder, depths):
    recording = topview.open(write_folder(dict.fromkeys(range(0, 100, 10), depths[0])))
    assert recording.problems == [
        "depth/: 81 frames are missing in 9 gaps between 000000.png and 000090.png"
    ]


def test_names_without_a_number_or_with_a_taken_one_are_named(write_folder, depths, encode):
    root = write_folder()
    (root / "depth" / "1.png").write_bytes(encode(depths[0]))
    (root / "depth" / "last.png").write_bytes(encode(depths[0]))
    recording = topview.open(root)
    assert len(list(recording)) == len(depths)
    assert recording.problems == [
        "depth/1.png: has the same frame number as 000001.png; left out",
        "depth/last.png: has no frame number; it must be like 000000.png",
    ]


def spoil(data: bytes, position: int) -> bytes:
    return data[:position] + bytes([data[position] ^ 1]) + data[position + 1 :]


@pytest.mark.parametrize(
    ("broken", "problem"),
    [
        (lambda png, image: b"", r"is empty \(0 bytes\)"),
        (lambda png, image: b"GIF89a" + png(image), "starts with b'GIF89a.*must be a PNG image"),
        (lambda png, image: png((image >> 8).astype(np.uint8)), "is 8-bit grey; .* be 16-bit grey"),
        (lambda png, image: png(np.stack([image] * 3, -1)), "is 16-bit RGB; .* be 16-bit grey"),
        (lambda png, image: png(image[:-1]), "is 8 x 5 pixels; it must be 8 x 6, as camera.json"),
        (lambda png, image: spoil(png(image), 60), r"is damaged between bytes 33 .*checksum"),
        (lambda png, image: png(image)[8:], "must be a PNG image"),
    ],
    ids=["empty", "gif", "8-bit", "rgb", "other size", "flipped bit", "no signature"],
)
def test_a_bad_depth_image_costs_its_own_frame_only(write_folder, depths, encode, broken, problem):
    recording = topview.open(write_folder({**depths, 2: broken(encode, depths[2])}))
    assert [frame.index for frame in recording] == [0, 1, 3]
    (line,) = recording.problems
    assert re.fullmatch(rf"depth/000002\.png: .*{problem}.*", line)


def test_a_depth_png_cut_anywhere_is_told_from_a_whole_one(write_folder, depths, encode, capfd):
    whole = encode(depths[0])
    cuts = {length: whole[:length] for length in range(len(whole) + 1)}
    recording = topview.open(write_folder(cuts))
    assert [frame.index for frame in recording] == [len(whole)]
    more = len(whole) - MAX_LINES_ALIKE
    assert recording.problems[-1] == f"{more} more images of depth/ cannot be read"
    assert capfd.readouterr().err == ""


def test_a_folder_in_an_images_place_is_one_problem(write_folder, depths):
    root = write_folder()
    (root / "depth" / "000004.png").mkdir()
    recording = topview.open(root)
    assert len(list(recording)) == len(depths)
    assert recording.problems == ["depth/000004.png: is no regular file; it must be one"]


def test_color_of_another_size_is_one_problem_and_depth_goes_on(write_folder, depths):
    color = np.zeros((12, 16, 3), np.uint8)
    recording = topview.open(write_folder(color={f"{i:06d}.png": color for i in depths}))
    assert [frame.color for frame in recording] == [None] * 4
    assert recording.problems == [
        "rgb/: images are 16 x 12 pixels; they must be registered to the depth images, 8 x 6, "
        'or camera.json must have "color": {fx, fy, cx, cy, width, height, T_color_depth}; '
        "going on without colour"
    ]


@pytest.mark.parametrize("suffix", [".png", ".jpg"])
def test_unreadable_color_is_named_and_the_frame_still_comes(
    write_folder, depths, encode, suffix, capfd
):
    image = np.zeros((*depths[0].shape, 3), np.uint8)
    files: dict[str, object] = {f"{i:06d}{suffix}": image for i in depths}
    files[f"000001{suffix}"] = encode(image, suffix)[:-10]
    files[f"000002{suffix}"] = b""
    recording = topview.open(write_folder(color=files))
    assert [frame.color is None for frame in recording] == [False, True, True, False]
    truncated, empty = recording.problems
    assert truncated.startswith(f"rgb/000001{suffix}: is truncated after")
    assert empty.startswith(f"rgb/000002{suffix}: is empty")
    assert capfd.readouterr().err == ""


def test_missing_color_is_named_once(write_folder, depths):
    image = np.zeros((*depths[0].shape, 3), np.uint8)
    recording = topview.open(write_folder(color={"000000.png": image, "000003.png": image}))
    assert [frame.color is None for frame in recording] == [False, True, True, False]
    assert recording.problems == [
        "rgb/: has no image for 2 of 4 frames, the first of them frame 1; they come without colour"
    ]


def test_without_depth_images_it_is_refused(tmp_path):
    with pytest.raises(InputError, match=r"has no depth images; it must hold depth/000000\.png"):
        topview.open(tmp_path)


def test_without_camera_json_it_is_refused(write_folder):
    root = write_folder()
    (root / "camera.json").unlink()
    with pytest.raises(
        InputError, match=r"camera\.json: cannot be read: No such file .*fx, fy, cx"
    ):
        topview.open(root)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "is not JSON"),
        ("{", "is not JSON"),
        ("\xff", "is not JSON"),
        ("[1, 2]", "holds a JSON list; it must be an object"),
        ("{}", "has no fx, fy, cx, cy, width, height, depth_scale"),
    ],
)
def test_a_broken_camera_json_is_refused(write_folder, text, message):
    root = write_folder()
    (root / "camera.json").write_bytes(text.encode("latin-1"))
    with pytest.raises(InputError, match=rf"camera\.json: {message}") as error:
        topview.open(root)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("fx", -525.0, "fx is -525.0; it must be a focal length in pixels, 0.35"),
        ("fx", 1e-300, r"fx is 1e-300; .* 0\.35 to 20000 for an image of 8"),
        ("fy", 0, "fy is 0.0; it must be"),
        ("fx", 1e9, r"fx is 1000000000.0; it must be .* to 20000"),
        ("fx", float("nan"), "fx is nan; it must be"),
        ("fx", 10**400, r"fx is 10+ \.\.\.; it must be a number"),
        ("fx", "x" * 10**5, r"fx is .x+ \.\.\.; it must be a number"),
        ("cx", float("inf"), "cx is Infinity; it must be a number"),
        ("cx", 1e5, "cx is 100000.0; it must be a principal point"),
        ("cy", "2.5", 'cy is "2.5"; it must be a number'),
        ("cy", None, "cy is null; it must be a number"),
        ("width", 0, "width is 0; it must be 1 to"),
        ("width", -8, "width is -8; it must be 1 to"),
        ("height", 6.5, "height is 6.5; it must be a whole number"),
        ("height", True, "height is true; it must be a number"),
        ("fps", 0, "fps is 0; it must be 0.1 to 1000 per second"),
        ("fps", -30, "fps is -30; it must be 0.1 to 1000 per second"),
        ("fps", 5e-324, "fps is 4.94066e-324; it must be 0.1 to 1000 per second"),
        ("depth_scale", 0, "depth_scale is 0; it must be metres per unit"),
        ("depth_scale", 1, "depth_scale is 1; it must be metres per unit"),
    ],
)
def test_a_value_of_no_camera_is_refused(write_folder, key, value, message):
    with pytest.raises(InputError, match=rf"camera\.json: .*{message}") as error:
        topview.open(write_folder(**{key: value}))
    assert "\n" not in str(error.value)


def test_without_a_lens_every_value_is_as_stored(write_folder, depths):
    recording = topview.open(write_folder(distortion={"model": "none", "coefficients": [0] * 5}))
    for frame in recording:
        assert frame.camera is recording.camera
        expected = (depths[frame.index] * 0.001).astype(np.float32)
        np.testing.assert_array_equal(frame.depth_m, expected)


class TestThroughALens:
    LENS = {"model": "brown_conrady", "coefficients": [-0.2, 0.05, 0.001, -0.002]}  # noqa: RUF012

    def test_frames_are_undistorted_and_the_recording_keeps_its_camera(self, write_folder, depths):
        images = {f"{i:06d}.png": np.full((6, 8, 3), 90, np.uint8) for i in depths}
        recording = topview.open(write_folder(color=images, distortion=self.LENS))
        assert not recording.camera.is_pinhole
        for frame in recording:
            stored = (depths[frame.index] * 0.001).astype(np.float32)
            raw = Frame(0, 0.0, stored, recording.camera, np.full((6, 8, 3), 90, np.uint8))
            expected = undistorted(raw)
            np.testing.assert_array_equal(frame.depth_m, expected.depth_m)
            np.testing.assert_array_equal(frame.color, expected.color)
            assert frame.camera == expected.camera
        assert recording.problems == []

    def test_frames_are_named_after_their_images(self, write_folder):
        names = [frame.name for frame in topview.open(write_folder(distortion=self.LENS))]
        assert names == ["000000.png", "000001.png", "000002.png", "000003.png"]
