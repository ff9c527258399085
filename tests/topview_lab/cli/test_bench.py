from __future__ import annotations

import json

import cv2
import numpy as np
import pytest

from tiny_recordings import wall
from topview_lab.sim import scene_by_name, write_scene

MS_COLUMNS = ("ms/frame", "ms/person", "frames/s")


@pytest.mark.slow
def test_bench_measures_scenes_stages_and_inner_loops(topview, tmp_path):
    file = tmp_path / "new" / "bench.json"
    ended = topview("bench", "--frames", "2", "--json", file)
    assert ended.status == 0
    for told in ("core", "320x240", "640x480", "uTVR", "refinement of one body", *MS_COLUMNS):
        assert told in ended.out
    numbers = json.loads(file.read_text())
    threads = sorted({1, numbers["machine"]["threads"]})
    scenes = [(t["width"], t["people"], t["threads"]) for t in numbers["tracking"]]
    assert scenes == [(w, p, n) for w in (320, 640) for p in (1, 2) for n in threads]
    for time in numbers["tracking"]:
        assert time["frames"] == 2
        # A frame's stages are parts of it, and a person's share is part of a frame.
        assert 0 < time["stages_ms"]["people"] < time["ms_per_frame"]
        assert 0 < time["ms_per_person"] <= time["ms_per_frame"]
    finding = [(t["people"], t["detector"], t["threads"]) for t in numbers["finding"]]
    assert finding == [(4, d, n) for d in ("depth", "auto") for n in threads]
    for time in numbers["finding"]:
        assert {"scene", "heads", "users"} <= set(time["stages_ms"])
        assert ("colours" in time["stages_ms"]) == (time["detector"] == "auto")
        assert 0 < max(time["stages_ms"].values()) < time["ms_per_frame"]
    assert [kernel["threads"] for kernel in numbers["kernels"]] == [
        n for n in threads for _ in "ab"
    ]
    assert all(kernel["ms"] > 0 for kernel in numbers["kernels"])


class TestARecordingOfOnesOwn:
    def test_with_nobody_and_without_colour(self, topview, make_recording, tmp_path):
        source = make_recording([wall()] * 6)
        file = tmp_path / "bench.json"
        ended = topview("bench", source, "--json", file)
        assert ended.status == 0
        assert "recording: 64 x 48, 3 timed: frames 3 to 5, without colour" in ended.out
        numbers = json.loads(file.read_text())
        times = numbers["recording"]["tracking"]
        assert [t["threads"] for t in times] == sorted({1, numbers["machine"]["threads"]})
        for time in times:
            assert time["frames"] == 3
            assert time["ms_per_person"] is None
            assert list(time["by_people"]) == ["0"]
            assert 0 < time["stages_ms"]["people"] < time["ms_per_frame"]

    def test_somebody_who_comes_late_in_colour(self, topview, tmp_path):
        source, file = tmp_path / "late", tmp_path / "bench.json"
        write_scene(scene_by_name("stand", seed=1, frames=6), source)
        bare = np.full((240, 320), 3000, np.uint16)
        for index in range(4):  # nobody is there yet
            cv2.imwrite(str(source / "depth" / f"{index:06d}.png"), bare)
        ended = topview("bench", source, "--frames", "3", "--json", file)
        assert ended.status == 0
        assert "frames 3 to 5, with colour" in ended.out
        for time in json.loads(file.read_text())["recording"]["tracking"]:
            assert sum(group["frames"] for group in time["by_people"].values()) == 3
            assert time["by_people"]["0"]["frames"] >= 1

    def test_frames_that_cannot_be_read_are_named_once(self, topview, make_recording):
        source = make_recording([wall()] * 6)
        (source / "depth" / "000004.png").write_bytes(b"")
        ended = topview("bench", source)
        assert ended.status == 0
        assert "2 timed: frames 3 to 5" in ended.out
        assert len(ended.complaints) == 1
        assert "000004.png" in ended.complaints[0]

    @pytest.mark.parametrize("frames", [1, 3])
    def test_too_short_a_recording_is_one_line(self, topview, make_recording, frames):
        ended = topview("bench", make_recording([wall()] * frames))
        assert ended.status == 2
        assert len(ended.complaints) == 1
        assert f"too few of its frames could be read (it has {frames})" in ended.complaints[0]

    def test_a_bad_source_is_one_line(self, topview, tmp_path):
        ended = topview("bench", tmp_path / "nowhere")
        assert ended.status == 2
        assert len(ended.complaints) == 1
        assert "nowhere: no such file or folder" in ended.complaints[0]

    def test_flipping_back_needs_a_recording(self, topview):
        ended = topview("bench", "--mirrored")
        assert ended.status == 2
        assert "--mirrored is given without SOURCE" in ended.complaints[0]


@pytest.mark.parametrize("frames", ["0", "-1", "121"])
def test_bench_wants_a_sensible_number_of_frames(topview, frames):
    ended = topview("bench", "--frames", frames)
    assert ended.status == 2
    assert len(ended.complaints) == 1
    assert "--frames" in ended.complaints[0]
    assert frames in ended.complaints[0]


def test_bench_finds_out_at_once_that_it_cannot_write(topview, tmp_path):
    ended = topview("bench", "--json", tmp_path)
    assert ended.status == 2
    assert len(ended.complaints) == 1
    assert f"--json {tmp_path}" in ended.complaints[0]
