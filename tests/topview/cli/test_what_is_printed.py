"""Printing ends no run: names of all kinds, terminals of few letters, a stdout that takes nothing.

With real processes, as streams are what a shell makes them.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from rich.table import Table

import topview
from tiny_recordings import wall
from topview.cli import progress
from topview.cli.printing import plain_console
from topview.lines import MOST_CHARACTERS, as_line

FULL = Path("/dev/full")


def topview_process(
    *arguments: object, shell: str = "", **environment: str
) -> subprocess.CompletedProcess[str]:
    """`topview`, with what a shell does to its streams."""
    command = [sys.executable, "-m", "topview", *map(str, arguments)]
    return subprocess.run(
        ["sh", "-c", f'"$@" {shell}', "sh", *command],
        capture_output=True,
        env=os.environ | environment,
        encoding="utf-8",
        errors="replace",
        check=False,
    )


@pytest.mark.parametrize(
    ("shell", "reason"),
    [(">&-", "Bad file descriptor"), (f"> {FULL}", "No space left on device")],
)
def test_a_stdout_that_takes_nothing_costs_no_result(
    compiled, make_recording, tmp_path, shell, reason
):
    if str(FULL) in shell and not FULL.exists():
        pytest.skip(f"needs {FULL}")
    out = tmp_path / "out"
    ended = topview_process("track", make_recording([wall()] * 3), "--out", out, shell=shell)
    assert ended.returncode == 2
    assert (out / "skeletons.npz").exists()
    assert (out / "skeletons.csv").exists()
    *_, last = ended.stderr.splitlines()
    assert last == f"topview: stdout: {reason}; files that were written are whole"
    assert "Traceback" not in ended.stderr
    assert "Exception" not in ended.stderr


def test_what_help_says_needs_a_place_too():
    ended = topview_process("--help", shell=">&-")
    assert ended.returncode == 2
    assert ended.stderr == (
        "topview: stdout: Bad file descriptor; files that were written are whole\n"
    )


@pytest.mark.parametrize(("arguments", "status"), [(["--help"], 141), (["track"], 2)])
def test_a_reader_that_has_seen_enough_is_no_fault(
    compiled, make_recording, tmp_path, arguments, status
):
    if arguments == ["track"]:
        arguments = ["track", str(make_recording([wall()] * 3)), "--out", str(tmp_path / "out")]
    process = subprocess.Popen(
        [sys.executable, "-m", "topview", *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert process.stdout is not None
    process.stdout.close()
    _, told = process.communicate()
    assert process.returncode == status
    assert "ipe" not in told
    assert len(told.splitlines()) == (0 if status == 141 else 1)  # no person was found


def test_without_stderr_its_lines_go_nowhere(tmp_path):
    ended = topview_process("track", tmp_path / "nothing", "--out", tmp_path / "o", shell="2>&-")
    assert ended.returncode == 2
    assert ended.stdout == ""


@pytest.mark.parametrize(
    "environment", [{"PYTHONIOENCODING": "ascii"}, {"LC_ALL": "C", "PYTHONCOERCECLOCALE": "0"}]
)
@pytest.mark.parametrize("name", ["Größe 人", "[red]y :smile:"])
def test_names_are_told_as_they_are_or_escaped(
    compiled, make_recording, tmp_path, name, environment
):
    source = make_recording([wall()] * 3).rename(tmp_path / name)
    ended = topview_process("track", source, "--out", tmp_path / "out", **environment)
    assert "Traceback" not in ended.stderr
    assert "bug of topview" not in ended.stderr
    (line,) = ended.stderr.splitlines()
    assert "no person was found in 3 frames" in line
    if name.isascii():
        assert name in line


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("a\nb\r\n c", "a b c"),
        ("red \x1b[31m", "red \\x1b[31m"),
        ("\udcff", "\\udcff"),
        ("Größe", "Größe"),
    ],
)
def test_a_line_is_one_line(text, line):
    assert as_line(text) == line


def test_a_long_line_loses_its_middle():
    line = as_line("begin" + "7" * 5000 + "end")
    assert len(line) < MOST_CHARACTERS + 10
    assert line.startswith("begin")
    assert line.endswith("end")


def test_brackets_and_colons_of_a_name_mean_nothing(capsys):
    table = Table("[red]person", title="a [/x] :smile:")
    table.add_row("[/x] [bold]")
    plain_console().print(table, "[/x] :smile:")
    printed = capsys.readouterr().out
    assert printed.count("[/x] :smile:") == 2
    assert "[/x] [bold]" in printed
    assert "[red]person" in printed


def test_every_console_of_the_commands_is_a_plain_one():
    source = Path(topview.__file__).parent
    for folder in (source / "cli", source.with_name("topview_lab") / "cli"):
        for file in folder.glob("*.py"):
            if file.name != "printing.py":
                assert not re.search(r"\bConsole\(", file.read_text()), file


def test_there_are_no_bars_where_there_is_no_terminal(topview):
    ended = topview(
        "evaluate", "simulated", "stand", "--frames", "1", "--workers", "1", "--method", "btvr"
    )
    assert ended.complaints == []
    assert ended.status == 0


def test_a_run_without_a_terminal_tells_how_far_it_is(
    topview, make_recording, tmp_path, monkeypatch
):
    monkeypatch.setattr(progress, "REPORT_S", 0.0)
    ended = topview("track", make_recording([wall()] * 3), "--out", tmp_path / "out")
    told = [line for line in ended.complaints if "frames/s" in line]
    assert [line.split(" frames, ")[0] for line in told] == [
        f"topview: {done} of 3" for done in (1, 2, 3)
    ]
    assert told[-1].endswith(" 0 s left")
