"""The numbers of frames by the names of images; what is no frame number is refused or named."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import topview
from damage import cut, flipped
from topview.io.readers.frame_names import MAX_NAME_LINES, by_number, by_time
from topview.records import InputError

NUMBERS = st.lists(st.integers(0, 10**9 - 1), min_size=1, max_size=30, unique=True)
AROUND = st.text("abc_-2", max_size=6).filter(lambda text: not text or not text[-1].isdigit())


@given(NUMBERS, AROUND, st.sampled_from(["", "_depth", ".depth"]), st.integers(0, 12))
def test_a_frame_number_comes_back_whatever_is_around_it(numbers, before, after, digits):
    names = {n: f"{before}{n:0{digits}d}{after}.png" for n in numbers}
    numbered, problems = by_number(names.values())
    assert problems == []
    assert list(numbered.items()) == sorted(names.items())


@pytest.mark.parametrize(
    "names",
    [
        ["1305031102.933333.png", "1305031102.833333.png", "1305031103.033333.png"],
        ["1305031102.933333.png", "1305031102.966666.png"],
        ["1403636579763555584.png", "1403636579813555456.png"],
        ["1305031102933.png", "1305031102966.png"],
        ["1305031102.png", "1305031103.png"],
        ["depth_1305031102.933333.png", "depth_1305031102.966666.png"],
        ["12.933333.png", "12.966666.png"],
        ["frame_1403636579763555584.png"],
    ],
)
def test_time_stamps_are_no_frame_numbers(names):
    with pytest.raises(InputError, match=r"seems to be named by a time stamp; .* 000000\.png") as e:
        by_number(names)
    assert min(names) in str(e.value)


@pytest.mark.parametrize(
    "names",
    [
        ["000000_cam1.png", "000000_cam2.png", "000001_cam1.png", "000001_cam2.png"],
        ["000000_cam1.png", "000001_cam1.png"],
        ["cam1_000000.png", "cam2_000000.png"],
        ["000000.png", "preview_000000.png"],
        ["2024-05-01-12-00-05.png", "2024-05-01-12-01-05.png"],
    ],
)
def test_names_that_differ_in_more_than_a_number_are_refused(names):
    with pytest.raises(InputError, match="differ in more than their last number") as error:
        by_number(names)
    assert names[0] in str(error.value)


def test_a_single_odd_name_is_named_and_left_out():
    numbered, problems = by_number(["0.png", "1.png", "01.png", f"{2**63}.png", "last.png"])
    assert numbered == {0: "0.png", 1: "01.png"}
    assert [problem.partition(":")[0] for problem in problems] == [
        "1.png",
        "last.png",
        f"{2**63}.png",
    ]


def test_many_odd_names_share_a_line():
    numbered, problems = by_number(["0.png", *(f"{letter}.png" for letter in "abcdefghij")])
    assert numbered == {0: "0.png"}
    assert len(problems) == MAX_NAME_LINES + 1
    assert problems[-1] == f"{10 - MAX_NAME_LINES} more names are left out, too"


@given(st.lists(st.text(max_size=30), unique=True, max_size=8))
def test_whatever_the_names_are_it_is_numbers_or_one_line(names):
    try:
        numbered, problems = by_number(names)
    except InputError:
        return
    assert set(numbered.values()) <= set(names)
    assert len(problems) <= MAX_NAME_LINES + 1


STAMPS = ["1305031102.175304", "1305031102.208630", "1305031102.242010", "1305031102.275326"]


def renamed(root: Path, folder: str, stems: list[str]) -> None:
    """Images named anew, the first of them last, so that order is not that of writing."""
    for image, stem in zip(sorted((root / folder).iterdir()), reversed(stems), strict=True):
        image.rename(image.with_name(f"{stem}{image.suffix}"))


def test_a_recording_named_by_time_stamps_is_read_in_order_with_its_times(write_folder, depths):
    color = {i: np.full((*depths[0].shape, 3), 40 * i, np.uint8) for i in depths}
    root = write_folder(color={f"{i:06d}.png": image for i, image in color.items()})
    renamed(root, "depth", STAMPS)
    late = [f"{float(stamp) + 0.004:.6f}" for stamp in STAMPS[1:]]
    (root / "rgb" / "000003.png").unlink()  # that of the first depth image
    renamed(root, "rgb", late)
    recording = topview.open(root)
    frames = list(recording)
    assert [frame.index for frame in frames] == [0, 1, 2, 3]
    assert [frame.name for frame in frames] == [f"{stamp}.png" for stamp in STAMPS]
    times_s = [float(stamp) - float(STAMPS[0]) for stamp in STAMPS]
    assert [frame.timestamp_s for frame in frames] == times_s
    for frame, written in zip(frames, (3, 2, 1, 0), strict=True):
        np.testing.assert_array_equal(frame.depth_m, (depths[written] / 1e3).astype(np.float32))
    shades = [None if frame.color is None else int(frame.color[0, 0, 0]) for frame in frames]
    assert shades == [None, 80, 40, 0]
    assert recording.problems == [
        "rgb/: has no image for 1 of 4 frames, the first of them frame 0; they come without colour"
    ]


@pytest.mark.parametrize("factor", [1, 10**3, 10**6, 10**9])
def test_times_since_1970_may_be_whole_numbers_of_any_unit(factor):
    names = [f"{(1305031102 + n) * factor + n}.png" for n in (2, 0, 1)]
    seconds, problems = by_time(names) or ({}, [])
    assert problems == []
    assert list(seconds) == sorted(names)
    steps = np.diff(list(seconds.values()))
    np.testing.assert_allclose(steps, 1.0 + 1.0 / factor, atol=1e-6)


def test_time_stamps_of_two_cameras_are_refused():
    with pytest.raises(InputError, match=r"cam1_1305031102\.1\.png and cam2_.* of one camera only"):
        by_time(["cam1_1305031102.1.png", "cam2_1305031102.2.png", "cam1_1305031102.3.png"])


def test_pauses_and_images_of_the_same_time_are_one_line(write_folder, depths):
    root = write_folder(dict.fromkeys(range(6), depths[0]))
    renamed(root, "depth", ["1.00", "1.03", "1.030", "1.06", "1.09", "9.00"])
    recording = topview.open(root)
    assert [frame.timestamp_s for frame in recording] == pytest.approx([0, 0.03, 0.06, 0.09, 8.0])
    assert recording.problems == [
        "depth/1.030.png: has the time of the image before; left out",
        "depth/: pauses between frames: 1, the longest 7.91 s after 1.09.png; frames come every "
        "0.030 s",
    ]


def test_depth_numbered_and_colour_named_by_times_do_not_go_together(write_folder, depths):
    names = ["1305031102.911111.png", "1305031102.944444.png"]
    recording = topview.open(write_folder(color=dict.fromkeys(names, b"image")))
    assert [frame.color for frame in recording] == [None] * len(depths)
    (problem,) = recording.problems
    assert problem.startswith("rgb/: images have times, those of depth/ numbers;")


def test_frames_numbered_by_milliseconds_are_doubted(write_folder, depths):
    root = write_folder(dict.fromkeys(range(0, 330, 33), depths[0]))
    (problem,) = topview.open(root).problems
    assert problem.endswith("at 30 frames/s they last 10 s. If the numbers are times, name images "
                            "by seconds, as 12.345678.png")  # fmt: skip


LIST = "# depth maps\n# timestamp filename\n"


class TestTimesInAList:
    def test_they_are_those_of_the_frames(self, write_folder, depths):
        root = write_folder()
        lines = [f"{10 + 0.5 * i:.6f} depth/{i:06d}.png" for i in depths]
        (root / "depth.txt").write_text(LIST + "\n".join(lines))
        recording = topview.open(root)
        assert [frame.timestamp_s for frame in recording] == [0.0, 0.5, 1.0, 1.5]
        assert recording.problems == []

    def test_what_is_odd_in_it_is_one_line_each(self, write_folder):
        root = write_folder()
        text = "3.0 depth/000001.png\n2.0 depth/000000.png\n2.5 depth/000009.png\n"
        (root / "depth.txt").write_text(text)
        recording = topview.open(root)
        assert [frame.name for frame in recording] == ["000000.png", "000001.png"]
        assert recording.problems == [
            "depth.txt: images that it names and depth/ does not hold: 1",
            "depth.txt: images of depth/ that it does not name, left out: 2",
            "depth.txt: times out of order: 1; frames are read by time",
        ]

    def test_cut_or_spoiled_anywhere_it_costs_the_frames_of_these_lines(self, write_folder):
        root = write_folder()
        whole = "".join(f"{10 + i}.5 depth/{i:06d}.png\n" for i in range(4)).encode()
        for data in (*cut(whole), *flipped(whole)):
            (root / "depth.txt").write_bytes(data)
            lines = data.count(b"\n") if whole.startswith(data) else 3
            if not lines:
                continue
            recording = topview.open(root)
            assert len(list(recording)) >= lines
            assert len(list(recording)) == 4 or recording.problems

    @pytest.mark.parametrize("text", ["", "depth/000000.png", "x depth/000000.png", "\0", "nan a"])
    def test_a_broken_one_is_one_line(self, write_folder, text):
        root = write_folder()
        (root / "depth.txt").write_text(text)
        with pytest.raises(InputError, match=r"depth\.txt: .*it must hold lines of seconds"):
            topview.open(root)


def test_a_sequence_of_tum_rgbd_is_read_as_it_is_published(tmp_path):
    depth = np.arange(640 * 480, dtype=np.uint16).reshape(480, 640)
    for name, image in (("depth", depth), ("rgb", np.zeros((480, 640, 3), np.uint8))):
        (tmp_path / name).mkdir()
        cv2.imwrite(str(tmp_path / name / "1305031102.160407.png"), image)
        line = f"1305031102.160407 {name}/1305031102.160407.png\n"
        (tmp_path / f"{name}.txt").write_text("# color images\n" + line)
    recording = topview.open(tmp_path)
    (frame,) = recording
    np.testing.assert_array_equal(frame.depth_m, (depth / 5000.0).astype(np.float32))
    assert frame.color is not None
    assert (frame.camera.fx, frame.camera.cx) == (525.0, 319.5)
    (problem,) = recording.problems
    assert problem.startswith(
        "camera.json is missing; taken for TUM RGB-D's default camera: fx 525"
    )
    cv2.imwrite(str(tmp_path / "depth" / "1305031102.160407.png"), depth[:200])
    with pytest.raises(InputError, match="depth images are 640 x 200, not TUM RGB-D's 640 x 480"):
        topview.open(tmp_path)


def test_every_shared_recording_is_still_read(shared):
    for folder in ("recordings", "recordings/composites", "bench"):
        for root in sorted((shared / folder).glob("*/depth")):
            recording = topview.open(root)
            assert recording.frame_count == len(list(root.glob("*.png")))
            assert recording.problems == []
