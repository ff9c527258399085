"""The numbers of frames by the names of images; what is no frame number is refused or named."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

import topview
from topview.io.readers.frame_names import MAX_NAME_LINES, by_number
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
def test_time_stamps_are_refused(names):
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


def renamed(root: Path, names: list[str]) -> Path:
    for index, name in enumerate(names):
        image = root / "depth" / f"{index:06d}.png"
        image.rename(image.with_name(name))
    for image in (root / "depth").glob("00000?.png"):
        image.unlink()
    return root


def test_a_recording_named_by_time_stamps_is_refused(write_folder):
    root = renamed(write_folder(), ["1305031102.933333.png", "1305031102.833333.png"])
    with pytest.raises(InputError, match=r"walk/depth/1305031102\.833333\.png: seems to be named"):
        topview.open(root)


def test_colour_named_so_is_left_aside(write_folder, depths):
    names = ["1305031102.911111.png", "1305031102.944444.png"]
    root = write_folder(color=dict.fromkeys(names, b"image"))
    recording = topview.open(root)
    assert [frame.color for frame in recording] == [None] * len(depths)
    (problem,) = recording.problems
    assert "seems to be named by a time stamp" in problem
    assert problem.endswith("going on without colour")


def test_every_shared_recording_is_still_read(shared):
    for folder in ("recordings", "recordings/composites", "bench"):
        for root in sorted((shared / folder).glob("*/depth")):
            recording = topview.open(root)
            assert recording.frame_count == len(list(root.glob("*.png")))
            assert recording.problems == []
