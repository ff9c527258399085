"""Skeletons in other formats: by `topview convert`, and beside the result of a run."""

from __future__ import annotations

import json
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from made_frames import ABOUT, frames_with
from moving_bodies import moving_people
from tiny_recordings import wall
from topview.cli.results import write_result
from topview.io import (
    FramesFile,
    StoredFrames,
    open_recording,
    read_skeletons_npz,
    write_skeletons_npz,
)
from topview.io.writers.registry import format_named
from topview.records import InputError
from topview.view import OverlayVideo
from topview.view.palette import person_color
from topview.view.video import size_px


@pytest.fixture
def result(tmp_path: Path) -> Path:
    write_skeletons_npz(moving_people(), tmp_path / "skeletons.npz")
    return tmp_path


def names_in(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir()}


def test_the_ending_says_the_format(topview, result):
    ended = topview("convert", result, result / "to ö" / "moves.bvh")
    assert (ended.status, ended.complaints) == (0, [])
    assert names_in(result / "to ö") == {"moves_person1.bvh", "moves_person3.bvh"}
    assert ended.out.count("written to") == 2
    assert "person 3: joints lie up to 0.0 mm from those of rigid bones" in ended.out


def test_one_person_alone_gets_the_very_file(topview, result):
    file = result / "who.txt"
    ended = topview("convert", result / "skeletons.npz", file, "--person", 3, "--format", "JSONL")
    assert ended.status == 0
    frames = [json.loads(line) for line in file.read_text().splitlines()]
    assert [[person["id"] for person in frame["people"]] for frame in frames] == [
        [3] * n for n in (0, 1, 0, 1, 1)
    ]


def test_what_is_there_is_replaced_by_force_alone(topview, result):
    (result / "o_person3.trc").write_text("older")
    ended = topview("convert", result, result / "o.trc")
    assert ended.status == 2
    assert "o_person3.trc: is there already; --force replaces it" in ended.complaints[0]
    assert "o_person1.trc" not in names_in(result)
    assert topview("convert", result, result / "o.trc", "--force").status == 0
    assert (result / "o_person3.trc").read_text().startswith("PathFileType")


def test_a_video_shows_the_skeletons_over_the_frames_of_the_recording(
    topview, make_recording, tmp_path
):
    source = make_recording([wall()] * 4)
    camera = open_recording(source).camera
    made = moving_people({0.0: [1], 1 / 30: [1, 3], 3 / 30: [3]})
    people = replace(made, camera=camera, frame_index=np.array([0, 1, 3]))
    write_skeletons_npz(people, tmp_path / "skeletons.npz")
    for name in ("a.mp4", "b.mp4"):
        ended = topview("convert", tmp_path, tmp_path / name, "--source", source)
        assert (ended.status, ended.complaints) == (0, [])
    assert (tmp_path / "a.mp4").read_bytes() == (tmp_path / "b.mp4").read_bytes()
    video = cv2.VideoCapture(str(tmp_path / "a.mp4"))
    seen, times_ms = [], []
    while (read := video.read())[0]:
        seen.append([shows(read[1], person_color(person)) for person in (1, 3)])
        times_ms.append(video.get(cv2.CAP_PROP_POS_MSEC))
    assert seen == [[True, False], [True, True], [False, True]]
    assert times_ms == pytest.approx([0, 33, 100], abs=1)
    write_skeletons_npz(replace(people, camera=replace(camera, fx=99.0)), tmp_path / "other.npz")
    ended = topview("convert", tmp_path / "other.npz", tmp_path / "c.mp4", "--source", source)
    assert "has another camera than the skeletons; it must be theirs" in ended.complaints[0]
    assert not (tmp_path / "c.mp4").exists()


def shows(picture: NDArray[Any], color: tuple[int, int, int]) -> bool:
    """Whether much of the picture above the legend is of a colour, as far as a video keeps it."""
    aside = np.abs(picture[:-32].astype(int) - np.array(color)[::-1]).sum(-1)
    return bool(np.count_nonzero(aside < 60) > 20)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["o.mp4"], "--source is missing; it must name the recording for mp4, and only for that"),
        (["o.csv", "--source", "."], "--source is .; it must name the recording for mp4, and only"),
        (["o.xyz"], "format is 'xyz'; it must be one of npz, csv, jsonl"),
        (["o"], "has no ending; give one, or --format npz|csv"),
        (["o.bvh", "--person", "2"], "skeletons.npz: has no person 2; its people are 1, 3"),
    ],
)
def test_what_cannot_be_is_one_line(topview, result, monkeypatch, arguments, said):
    monkeypatch.chdir(result)
    ended = topview("convert", "skeletons.npz", *arguments)
    assert (ended.status, len(ended.complaints)) == (2, 1)
    assert said in ended.complaints[0]
    assert names_in(result) == {"skeletons.npz"}


def test_an_unknown_format_is_told_before_anything_is_tracked(topview, make_recording, tmp_path):
    ended = topview("track", make_recording(), "--out", tmp_path / "out", "--format", "csv,fbx")
    assert ended.status == 2
    assert "format is 'fbx'; it must be one of" in ended.complaints[0]
    assert not (tmp_path / "out").exists()


def test_gravity_and_a_video_go_with_a_result(topview, make_recording, tmp_path):
    """Also where nobody is found; the camera looks up a little."""
    arguments = ("--gravity", 0, 0.99, -0.1, "--video", "--smoothing-s", 0.1, "--method", "utvr")
    ended = topview("track", make_recording([wall()] * 2), "--out", tmp_path / "out", *arguments)
    assert "no person was found in 2 frames" in ended.complaints[-1]
    people = read_skeletons_npz(tmp_path / "out" / "skeletons.npz")
    assert people.gravity_camera == pytest.approx(np.array([0, 0.99, -0.1]) / np.hypot(0.99, 0.1))
    assert people.settings["smoothing_s"] == 0.1
    video = cv2.VideoCapture(str(tmp_path / "out" / "overlay.mp4"))
    assert video.get(cv2.CAP_PROP_FRAME_COUNT) == 2
    up = topview("track", tmp_path / "recording", "--out", tmp_path / "up", "--gravity", 0, -9.8, 0)
    assert up.status == 2
    assert "it must be three numbers that point down in the frame of the camera" in up.complaints[0]


def test_a_video_is_even_and_neither_tiny_nor_huge():
    for width, height in ((32, 24), (1, 1), (641, 577), (4096, 3072), (1, 5000)):
        made = np.array(size_px(width, height))
        assert (made % 2 == 0).all()
        assert 2 <= made.min() <= made.max() <= 1280
    assert size_px(32, 24) == (640, 480)


def test_the_library_of_videos_is_asked_for_in_one_line(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "av", None)
    with pytest.raises(InputError, match=r"needs av; install it with: pip install 'topview\[video"):
        OverlayVideo(tmp_path)


def test_a_new_result_takes_away_what_belongs_to_the_older_one(tmp_path):
    older = [
        "contact_sheet.png",
        "people.png",
        "overlay.mp4",
        "skeletons_person7.bvh",
        "skeletons.c3d",
    ]
    for name in (*older, "notes.txt"):
        (tmp_path / name).write_text("older")
    kept = [*older, "notes.txt"]
    for formats in ([], [format_named("jsonl"), format_named("bvh")]):
        with FramesFile(tmp_path / "skeletons.frames", ABOUT) as file:
            for frame in frames_with([[1, 2], [2]]):
                file.append(frame)
        stored = StoredFrames(tmp_path / "skeletons.frames")
        assert write_result(stored, {}, tmp_path, formats) == []
        # The first one found none that was older: what lay there may be somebody else's.
        assert names_in(tmp_path) == {"skeletons.npz", "skeletons.csv", *kept}
        kept = [
            "notes.txt",
            *(f"skeletons{end}" for end in (".jsonl", "_person1.bvh", "_person2.bvh")),
        ]
