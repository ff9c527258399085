"""`--stature`, `--save-body` and `--body`: a body learnt in one recording is known in the next."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import topview as package
from topview.body.known_body import BODIES_VERSION
from topview_lab.sim import scene_by_name
from topview_lab.sim.write import write_scene

FRAMES = 36  # somebody must be followed for a second


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Somebody who stands and gestures."""
    folder = tmp_path_factory.mktemp("known") / "boxing"
    write_scene(scene_by_name("boxing", frames=FRAMES), folder)
    return folder


def settings_in(out: Path) -> dict[str, Any]:
    return package.read_skeletons(out / "skeletons.npz").settings


def test_a_body_is_saved_and_taken(topview, recording, tmp_path):
    body = tmp_path / "body.json"
    first = topview("track", recording, "--out", tmp_path / "a", "--save-body", body)
    assert first.status == 0
    assert f"bodies of 1 people written to {body}" in first.out
    (saved,) = package.read_bodies(body)
    assert saved.bones

    again = topview("track", recording, "--out", tmp_path / "b", "--body", body)
    assert again.status == 0
    assert settings_in(tmp_path / "b")["bodies"]["name"] == "body.json"
    skeletons = package.read_skeletons(tmp_path / "b" / "skeletons.npz")
    assert np.unique(skeletons.heights_m).tolist() == pytest.approx([saved.stature_m])

    ended = topview("track", recording, "--out", tmp_path / "c", "--save-body", body)
    assert (ended.status, len(ended.complaints)) == (2, 1)
    assert f"--save-body {body}: is there already" in ended.complaints[0]


def test_a_stature_is_kept(topview, recording, tmp_path):
    assert topview("track", recording, "--out", tmp_path / "out", "--stature", "1.6").status == 0
    skeletons = package.read_skeletons(tmp_path / "out" / "skeletons.npz")
    assert skeletons.heights_m.tolist() == [pytest.approx(1.6)]


def test_where_nobody_is_no_body_is_written(topview, make_recording, tmp_path):
    body = tmp_path / "body.json"
    ended = topview("track", make_recording(), "--out", tmp_path / "out", "--save-body", body)
    assert any(f"{body} is not written" in line for line in ended.complaints)
    assert not body.exists()


@pytest.mark.parametrize(
    ("options", "named"),
    [
        (("--stature", "17.8"), "stature is 17.8; it must be metres"),
        (("--stature", "tall"), "--stature is 'tall'"),
        (("--stature", "1.7", "--body", "{file}"), "give one of them"),
        (("--body", "{file}.none"), "cannot be read"),
        (("--body", "{file}"), "version is 7"),
    ],
)
def test_what_cannot_be_known_is_one_line(topview, recording, tmp_path, options, named):
    file = tmp_path / "bodies.json"
    file.write_text(json.dumps({"version": BODIES_VERSION + 6, "bodies": []}))
    options = [option.format(file=file) for option in options]
    ended = topview("track", recording, "--out", tmp_path / "out", *options)
    assert (ended.status, len(ended.complaints)) == (2, 1), ended.complaints
    assert named in ended.complaints[0]
