"""`./run` without a network: a stand-in for Python writes down what it is asked to do."""

from __future__ import annotations

import os
import runpy
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]

# Plays `python3 -m venv`, pip, and the Python and the topview that they would have installed.
STAND_IN = """#!/bin/sh
echo "$(basename "$0") $*" >> "$CALLS"
case "$*" in
*venv*--without-pip*)
    mkdir -p .venv/bin
    cp "$0" .venv/bin/python
    cp "$0" .venv/bin/topview ;;
*install*) exit "$PIP_STATUS" ;;
*fail*) exit 7 ;;
esac
"""


AS_STAND_IN = """
import runpy, sys
sys.argv.pop(0)
sys.executable = sys.argv.pop(1)
runpy.run_path("run", run_name="__main__")
"""


class Project:
    """A copy of the script beside a pyproject.toml of its own."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.calls = folder / "calls"
        shutil.copy(ROOT / "run", folder / "run")
        (folder / "pyproject.toml").write_text("[project]")
        (folder / "python3").write_text(STAND_IN)
        (folder / "python3").chmod(0o755)

    def run(
        self, *arguments: str, pip_status: int = 0, **environment: str
    ) -> tuple[int, list[str], str]:
        """Exit status, the programs that were started, and stderr."""
        self.calls.write_text("")
        ended = subprocess.run(
            [sys.executable, "-c", AS_STAND_IN, "run", str(self.folder / "python3"), *arguments],
            cwd=self.folder,
            env=os.environ
            | {"CALLS": str(self.calls), "PIP_STATUS": str(pip_status)}
            | environment,
            capture_output=True,
            text=True,
            check=False,
        )
        return ended.returncode, self.calls.read_text().splitlines(), ended.stderr


@pytest.fixture
def project(tmp_path: Path) -> Project:
    return Project(tmp_path)


def test_the_first_call_sets_up_and_the_second_starts_at_once(project):
    status, calls, _ = project.run("demo")
    assert status == 0
    assert "venv" in calls[0]
    assert "install" in calls[1]
    assert calls[1].endswith(f"-e {project.folder}")
    assert calls[2:] == ["topview demo"]
    assert project.run("demo", "--seed", "1") == (0, ["topview demo --seed 1"], "")


def test_tests_are_run_by_pytest_with_the_arguments_passed_on(project):
    project.run("test")
    assert project.run("test", "-k", "some")[1] == ["python -m pytest -k some"]


@pytest.mark.parametrize(
    ("name", "extra"), [("test", "test"), ("reproduce", "report"), ("evaluate", "datasets")]
)
def test_what_only_some_commands_need_is_installed_for_them(project, name, extra):
    project.run("demo")
    _, calls, said = project.run(name)
    assert len(calls) == 2  # no new .venv: what is there stays
    assert calls[0].endswith(f"-e {project.folder}[{extra}]")
    assert f"what `{extra}` needs" in said
    assert len(project.run(name)[1]) == 1
    assert len(project.run("demo")[1]) == 1


def test_the_test_tools_hold_what_the_other_extras_need(project):
    _, calls, _ = project.run("test")
    assert "venv" in calls[0]
    assert calls[1].endswith(f"-e {project.folder}[test]")
    for name in ("demo", "reproduce", "evaluate"):
        assert len(project.run(name)[1]) == 1


def test_every_extra_is_declared_and_test_holds_the_others():
    script = runpy.run_path(str(ROOT / "run"))
    declared = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    extras = declared["optional-dependencies"]
    assert set(script["EXTRA_OF"].values()) <= set(extras)
    for extra, others in script["CONTAINED"].items():
        assert {f"topview[{other}]" for other in others} <= set(extras[extra])


def test_the_exit_status_is_the_child_s(project):
    assert project.run("fail")[0] == 7


@pytest.mark.parametrize(("never_written", "by_pip"), [("", False), ("1", True)])
def test_byte_code_is_made_by_pip_only_where_python_would_not_keep_it(
    project, never_written, by_pip
):
    _, calls, _ = project.run("demo", PYTHONDONTWRITEBYTECODE=never_written)
    assert ("--no-compile" not in calls[1]) == by_pip


def test_a_changed_declaration_is_installed_again(project):
    project.run("test")
    (project.folder / "pyproject.toml").write_text("[project] # changed")
    assert len(project.run("demo")[1]) == 3
    assert len(project.run("demo")[1]) == 1
    assert len(project.run("test")[1]) == 2  # the new .venv has no test tools yet


def test_a_failed_installation_leaves_no_stamp(project):
    status, calls, complaint = project.run("demo", pip_status=1)
    assert status == 1
    assert len(calls) == 2
    assert "setting up failed" in complaint
    assert len(project.run("demo")[1]) == 3


def test_a_failed_extra_leaves_what_was_there(project):
    project.run("demo")
    assert project.run("test", pip_status=1)[0] == 1
    assert len(project.run("demo")[1]) == 1
    assert len(project.run("test")[1]) == 2
