from __future__ import annotations

import json

import pytest

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
