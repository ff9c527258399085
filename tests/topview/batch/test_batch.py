"""Many recordings: which they are, what is redone, what a crash costs."""

from __future__ import annotations

import json
import os
import signal
from functools import partial
from pathlib import Path
from uuid import uuid4

import pytest

from topview.batch.job import Job, do, remove_unfinished
from topview.batch.record import read_record
from topview.batch.schedulers import in_dask, in_processes
from topview.batch.sources import expanded, named
from topview.cli import batch as batch_command
from topview.records import InputError


def made_result(source: Path, out: Path, tries: int = 0) -> tuple[int, int]:
    """A tracker of nothing: what it reads is what it writes. One in the name kills its process so
    many times first, and each time is noted beside the source."""
    with source.open("a") as file:
        file.write("x")
    if "bad" in source.name:
        raise InputError(f"{source.name}: is broken")
    if "buggy" in source.name:
        raise ZeroDivisionError("odd")
    if "kills" in source.name and len(source.read_text()) <= tries:
        os.kill(os.getpid(), signal.SIGKILL)
    (out / "skeletons.npz").write_text(source.name)
    return 3, 1


@pytest.fixture
def jobs(tmp_path: Path):
    def make(*names: str, tries: int = 0, replaces: bool = False, **options: object) -> list[Job]:
        (tmp_path / "out").mkdir(exist_ok=True)
        for name in names:
            (tmp_path / name).touch()
        track = partial(made_result, tries=tries)
        out = tmp_path / "out"
        return [
            Job(name, tmp_path / name, out, options, uuid4().hex, replaces, track) for name in names
        ]

    return make


def test_a_path_a_pattern_and_a_list_name_recordings(tmp_path):
    for name in ("b", "a", "c"):
        (tmp_path / name).mkdir()
    (tmp_path / "list.txt").write_text("# which\nc\n\n  a\n")
    found = expanded([str(tmp_path / "list.txt"), str(tmp_path / "[ab]")])
    assert [path.name for path in found] == ["c", "a", "b"]
    with pytest.raises(InputError, match="nothing is there"):
        expanded([str(tmp_path / "d*")])
    (tmp_path / "list.txt").write_text("# none\n")
    with pytest.raises(InputError, match="names no recording"):
        expanded([str(tmp_path / "list.txt")])


def test_names_tell_all_recordings_apart():
    paths = [Path("/a/x/depth"), Path("/b/x/depth"), Path("/b/y"), Path("/b/z/depth")]
    assert list(named(paths)) == ["a-x-depth", "b-x-depth", "y", "z-depth"]


def test_a_result_appears_whole_and_is_not_made_again(jobs):
    (job,) = jobs("one")
    outcome = do(job)
    assert (outcome.state, outcome.frames, outcome.people) == ("done", 3, 1)
    assert [path.name for path in job.out.iterdir()] == ["one"]
    assert job.finished() == outcome == read_record(job.folder)
    (job.folder / "skeletons.npz").write_text("harmed")
    assert job.finished() is None
    job.check_free()  # what is harmed may be made again
    assert do(job) == outcome == job.finished()


def test_a_result_of_something_else_is_not_replaced(jobs):
    (first,) = jobs("one", seed=1)
    do(first)
    (other,) = jobs("one", seed=2)
    assert other.finished() is None
    with pytest.raises(InputError, match="with other options; --force"):
        other.check_free()
    (forced,) = jobs("one", seed=2, replaces=True)
    forced.check_free()
    assert do(forced).run == forced.run
    assert other.finished() is not None
    (again,) = jobs("one", seed=2, replaces=True)
    assert do(again).run == again.run
    assert [path.name for path in other.out.iterdir()] == ["one"]


def test_a_failure_leaves_nothing_behind(jobs):
    (job,) = jobs("bad")
    assert (do(job).state, do(job).error) == ("failed", "bad: is broken")
    assert list(job.out.iterdir()) == []


def test_a_bug_is_told_with_its_place(jobs):
    (job,) = jobs("buggy")
    outcome = do(job)
    assert outcome.error == "a bug of topview (ZeroDivisionError: odd)"
    assert "in made_result" in outcome.traceback


def test_what_a_killed_process_left_is_removed_once_it_is_old(jobs, tmp_path):
    left = tmp_path / ".one.host.1.unfinished"
    left.mkdir()
    remove_unfinished(tmp_path)
    assert left.exists()
    os.utime(left, (0, 0))
    remove_unfinished(tmp_path)
    assert not left.exists()


@pytest.mark.slow
def test_a_killed_dask_worker_costs_no_recording(jobs):
    """Of two workers one is killed in the middle of a recording, and one recording is bad."""
    pytest.importorskip("distributed", reason="needs Dask")
    all_jobs = jobs("a", "bad", "b_kills", "c", tries=1)
    outcomes = {outcome.name: outcome.state for outcome in in_dask(all_jobs, 2)}
    assert outcomes == {"a": "done", "bad": "failed", "b_kills": "done", "c": "done"}
    tries = {job.name: len(job.source.read_text()) for job in all_jobs}
    assert {name: tries[name] for name in ("a", "b_kills", "c")} == {"a": 1, "b_kills": 2, "c": 1}
    assert all(read_record(job.folder) for job in all_jobs if job.name != "bad")


@pytest.mark.slow
def test_a_recording_that_kills_every_process_is_given_up(jobs, tmp_path):
    outcomes = {outcome.name: outcome for outcome in in_processes(jobs("kills", "a", tries=9), 2)}
    assert outcomes["a"].state == "done"
    assert outcomes["kills"].state == "failed"
    assert "3 processes that worked on it were killed" in outcomes["kills"].error
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["a"]


def test_the_command_goes_on_where_it_ended(topview, tmp_path, monkeypatch):
    monkeypatch.setattr(batch_command, "track_into", made_into)
    monkeypatch.setattr(batch_command, "scheduler_named", lambda *_: partial(map, do))
    for name in ("a", "bad", "c"):
        (tmp_path / name).touch()
    words = ("batch", tmp_path / "[abc]*", "--out", tmp_path / "out", "--workers", 2)
    ended = topview(*words)
    assert ended.status == 2
    assert ended.complaints == ["topview: bad: bad: is broken"]
    manifest = json.loads((tmp_path / "out" / "manifest.json").read_text())
    assert {told["name"]: told.get("state") for told in manifest["recordings"]} == {
        "a": "done",
        "bad": "failed",
        "c": "done",
    }
    (tmp_path / "bad").rename(tmp_path / "better")
    again = topview(*words)
    assert again.status == 0
    assert "2 of 3 recordings are done already" in again.out
    assert (tmp_path / "a").read_text() == "x"


def test_looking_both_ways_is_an_option_of_the_result(topview, tmp_path, monkeypatch):
    """Results of before there was such an option are still those without it."""
    monkeypatch.setattr(batch_command, "track_into", made_into)
    monkeypatch.setattr(batch_command, "scheduler_named", lambda *_: partial(map, do))
    (tmp_path / "a").touch()
    words = ("batch", tmp_path / "a", "--out", tmp_path / "out", "--workers", 1)
    assert topview(*words).status == 0
    outcome = read_record(tmp_path / "out" / "a")
    assert outcome is not None
    assert "offline" not in outcome.options
    refused = topview(*words, "--offline")
    assert refused.status == 2
    assert "with other options" in refused.complaints[0]
    assert topview(*words, "--offline", "--force").status == 0
    outcome = read_record(tmp_path / "out" / "a")
    assert outcome is not None
    assert outcome.options["offline"] is True


def made_into(source: Path, out: Path, **_: object) -> tuple[int, int]:
    return made_result(source, out)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ([], "no recordings are named"),
        (["nothing*"], "nothing is there"),
        ([".", "--workers", "-1"], "workers is -1"),
        ([".", "--scheduler", "slurm"], "scheduler is 'slurm'; it must be processes, dask"),
    ],
)
def test_what_cannot_be_done_is_one_line(topview, tmp_path, words, said):
    ended = topview("batch", *words, "--out", tmp_path / "out")
    assert ended.status == 2
    assert said in ended.complaints[0]
    assert len(ended.complaints) == 1
