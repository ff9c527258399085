"""Skeletons in other formats: by `topview convert`, and beside the result of a run."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from made_frames import ABOUT, frames_with
from moving_bodies import moving_people
from topview.cli.results import write_result
from topview.io import FramesFile, StoredFrames, write_skeletons_npz
from topview.io.writers.registry import format_named


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


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
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


def test_a_new_result_takes_away_what_belongs_to_the_older_one(tmp_path):
    older = ["contact_sheet.png", "people.png", "skeletons_person7.bvh", "skeletons.c3d"]
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
