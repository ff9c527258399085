from __future__ import annotations

import json
import multiprocessing
import os
import signal
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from io import StringIO
from pathlib import Path

import msgspec
import pytest
from rich.console import Console

from patience import HANGS_S
from skeleton_sequences import track_distance, write_rendered
from topview.records import InputError, Recording
from topview.track.run import TrackingResult
from topview.track.settings import TrackerSettings
from topview_lab.cli.evaluate import evaluate
from topview_lab.datasets import FolderRecording, find_folder_recordings
from topview_lab.evaluate.report import print_report
from topview_lab.evaluate.run import EvaluationRun, run_evaluation
from topview_lab.metrics import Evaluation, summarise

SETTINGS = TrackerSettings()


def interrupt_at_b(recording: Recording, settings: TrackerSettings) -> TrackingResult:
    result = track_distance(recording, settings)
    return replace(result, interrupted=recording.name == "b")


def interrupt_parent(recording: Recording, settings: TrackerSettings) -> TrackingResult:
    """As if Ctrl-C were pressed while this recording, and no other, takes very long."""
    if recording.name == "b":
        os.kill(os.getppid(), signal.SIGINT)
        time.sleep(2 * HANGS_S)
    return track_distance(recording, settings)


def die(recording: Recording, settings: TrackerSettings) -> TrackingResult:
    os.kill(os.getpid(), signal.SIGKILL)
    return track_distance(recording, settings)


def two_threads_are_too_many(recording: Recording, settings: TrackerSettings) -> TrackingResult:
    assert settings.threads == 1
    return track_distance(recording, settings)


@pytest.fixture
def recordings(tmp_path: Path) -> list[FolderRecording]:
    """The tracker will be right in a, 5 cm off in b, and far off in one of four frames in c."""
    write_rendered(tmp_path / "a", [2.0, 2.5, 3.0])
    for name, truth_m in (("b", [2.05, 2.55, 3.05]), ("c", [2.0, 2.5, 3.0, 2.0])):
        folder = write_rendered(tmp_path / name, [2.0, 2.5, 3.0, 3.5][: len(truth_m)])
        write_rendered(tmp_path / "truth" / name, truth_m)
        (tmp_path / "truth" / name / "groundtruth.npz").replace(folder / "groundtruth.npz")
    return [FolderRecording(tmp_path / name) for name in "abc"]


def run(recordings: list[FolderRecording], workers: int = 1, **other: Callable) -> EvaluationRun:
    track = other.get("track", track_distance)
    console = Console(file=StringIO())
    return run_evaluation(recordings, SETTINGS, workers, track, console)


def numbers(evaluation: Evaluation) -> bytes:
    return msgspec.json.encode(summarise(evaluation))


def test_known_errors(recordings: list[FolderRecording]) -> None:
    summary = summarise(run(recordings).evaluation)
    a, b, c = summary.sequences
    assert [s.name for s in (a, b, c)] == ["a", "b", "c"]
    assert a.joints.raw.mean == pytest.approx(0.0, abs=1e-4)
    assert b.joints.raw.mean == pytest.approx(5.0, abs=1e-4)
    assert c.people.missed == c.people.false_person_frames == c.people.frames_lost == 1
    assert summary.people.frames == 10
    assert summary.frames_per_second == pytest.approx(10 / 1.5)


def test_the_numbers_do_not_depend_on_the_number_of_processes(
    recordings: list[FolderRecording],
) -> None:
    assert numbers(run(recordings, 2).evaluation) == numbers(run(recordings, 1).evaluation)


def test_every_tracker_has_one_thread(recordings: list[FolderRecording]) -> None:
    settings = TrackerSettings(threads=2)
    console = Console(file=StringIO())
    result = run_evaluation(recordings, settings, 1, two_threads_are_too_many, console)
    assert len(result.evaluation.sequences) == len(recordings)


def test_what_cannot_be_read_is_named_and_the_rest_goes_on(
    recordings: list[FolderRecording],
) -> None:
    (recordings[0].path / "groundtruth.npz").write_bytes(b"broken")
    (recordings[1].path / "depth" / "000001.png").write_bytes(b"broken")
    result = run(recordings)
    assert [s.name for s in result.evaluation.sequences] == ["b", "c"]
    assert result.evaluation.sequences[0].people.frames_unread == 1
    assert len(result.problems) == 2
    assert result.problems[0].startswith("a: ")
    assert "groundtruth.npz: is truncated or damaged" in result.problems[0]
    assert "000001.png" in result.problems[1]
    assert not any("\n" in problem for problem in result.problems)


@pytest.mark.parametrize("truth_m", [[2.0, 2.5], [2.0, 2.5, 3.0, 3.5]])
def test_a_reference_of_another_length(tmp_path: Path, truth_m: list[float]) -> None:
    write_rendered(tmp_path / "a", [2.0, 2.5, 3.0])
    write_rendered(tmp_path / "truth", truth_m)
    (tmp_path / "truth" / "groundtruth.npz").replace(tmp_path / "a" / "groundtruth.npz")
    result = run(find_folder_recordings([tmp_path / "a"]))
    (problem,) = result.problems
    assert problem.startswith(f"a: the recording has 3 frames, its reference {len(truth_m)};")


def test_a_gap_in_the_recording_is_no_other_length(recordings: list[FolderRecording]) -> None:
    (recordings[0].path / "depth" / "000001.png").unlink()
    (errors,) = run(recordings[:1]).evaluation.sequences
    assert (errors.people.frames, errors.people.frames_unread) == (2, 1)


def test_ctrl_c_keeps_what_is_done(recordings: list[FolderRecording]) -> None:
    result = run(recordings, track=interrupt_at_b)
    assert result.interrupted
    assert [s.name for s in result.evaluation.sequences] == ["a"]


@pytest.fixture
def heeds_ctrl_c() -> Iterator[None]:
    """What a shell starts in the background ignores SIGINT, and so would the tests."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.usefixtures("heeds_ctrl_c")
def test_ctrl_c_ends_the_processes(recordings: list[FolderRecording]) -> None:
    assert run(recordings, 2, track=interrupt_parent).interrupted
    # Not `join`: the pool's own thread joins them, too, and only one of the two learns of the end.
    end_s = time.monotonic() + HANGS_S
    while multiprocessing.active_children():
        assert time.monotonic() < end_s
        time.sleep(0.01)


def test_a_process_that_dies_is_told(recordings: list[FolderRecording]) -> None:
    result = run(recordings, 2, track=die)
    assert result.evaluation.sequences == ()
    assert result.problems == (
        "one of 2 processes was killed, for lack of memory perhaps; use fewer",
    )


def test_workers_must_not_be_negative(recordings: list[FolderRecording]) -> None:
    with pytest.raises(InputError, match="workers is -1"):
        run(recordings, -1)


class TestReport:
    def test_the_tables_fit_a_terminal(self, recordings: list[FolderRecording]) -> None:
        text = StringIO()
        console = Console(file=text, width=80)
        print_report(run(recordings).evaluation, console, "a title", per_sequence=True)
        lines = text.getvalue().splitlines()
        assert "a title" in lines
        assert max(map(len, lines)) <= 80
        assert "…" not in text.getvalue()
        row = next(line for line in lines if line.startswith("left_elbow"))
        # a: 3 x 0 cm, b: 3 x 5 cm, c: 3 x 0 cm
        assert row.split()[1:4] == ["1.7", "2.4", "100.0%"]

    def test_the_worst_sequence_comes_first(self, recordings: list[FolderRecording]) -> None:
        text = StringIO()
        print_report(run(recordings).evaluation, Console(file=text), per_sequence=True)
        table = text.getvalue().split("worst first")[1]
        names = [line.split()[0] for line in table.splitlines() if line[:2] in ("a ", "b ", "c ")]
        assert names[0] == "b"
        assert sorted(names) == ["a", "b", "c"]

    def test_nobody_found(self, recordings: list[FolderRecording]) -> None:
        text = StringIO()
        evaluation = run(recordings[2:]).evaluation
        print_report(evaluation, Console(file=text), per_sequence=True)
        assert "nan" not in text.getvalue()


class TestCommand:
    @pytest.fixture(autouse=True)
    def _fake_tracker(self, monkeypatch: pytest.MonkeyPatch) -> None:
        fake = partial(run_evaluation, track=track_distance)
        monkeypatch.setattr("topview_lab.cli.evaluate.run_evaluation", fake)

    def call(self, *arguments: str | Path) -> int:
        return evaluate(
            [str(a) for a in arguments],
            exit_on_error=False,
            print_error=False,
            result_action="return_value",
        )

    def test_folder_with_json(
        self,
        recordings: list[FolderRecording],
        tmp_path: Path,
        capsys: pytest.CaptureFixture[str],
    ) -> None:
        file = tmp_path / "new" / "numbers.json"
        folders = [recording.path for recording in recordings]
        arguments = ("--json", file, "--workers", "1", "--seed", "3", "--sequences", "a,c")
        assert self.call("folder", *folders, *arguments) == 0
        assert "2 of 2 recordings" in " ".join(capsys.readouterr().out.split())
        report = json.loads(file.read_text())
        assert report["settings"] == TrackerSettings(seed=3).as_json()
        assert [s["name"] for s in report["summary"]["sequences"]] == ["a", "c"]
        assert report["summary"]["people"]["person_frames"] == 7
        assert report["summary"]["joints_cm"]["hidden ≥ 30%"]["neck"]["raw"]["mean"] is None
        assert [path.name for path in file.parent.iterdir()] == ["numbers.json"]

    def test_problems_are_told_once_on_stderr(
        self, recordings: list[FolderRecording], capsys: pytest.CaptureFixture[str]
    ) -> None:
        (recordings[0].path / "camera.json").unlink()
        assert self.call("folder", *[r.path for r in recordings], "--workers", "1") == 2
        captured = capsys.readouterr()
        assert captured.err.count("camera.json") == 1
        assert "2 of 3 recordings" in " ".join(captured.out.split())

    def test_nothing_could_be_evaluated(self, recordings: list[FolderRecording]) -> None:
        (recordings[0].path / "camera.json").unlink()
        with pytest.raises(InputError, match="none of the 1 recordings could be evaluated"):
            self.call("folder", recordings[0].path, "--workers", "1")

    def test_no_folder(self) -> None:
        with pytest.raises(InputError, match="give at least one"):
            self.call("folder")

    def test_a_json_file_that_cannot_be_written(
        self, recordings: list[FolderRecording], tmp_path: Path
    ) -> None:
        (tmp_path / "file").write_text("")
        with pytest.raises(InputError, match="file"):
            self.call("folder", recordings[0].path, "--json", tmp_path / "file" / "x.json")
        with pytest.raises(InputError, match="is a folder; it must be a file"):
            self.call("folder", recordings[0].path, "--json", tmp_path)

    def test_utd_mhad_is_called_an_agreement(
        self, shared: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        root = shared / "recordings" / "utd_mhad"
        assert self.call("utd-mhad", root, "--sequences", "a1_s1_t1", "--workers", "1") == 0
        out = " ".join(capsys.readouterr().out.split())
        assert "agreement with the Kinect SDK v1 skeleton (a reference, not truth)" in out
