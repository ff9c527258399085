"""Compiling ahead: what is listed, that it is enough, and that it is done once."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest
from numba.core import types
from numba.core.dispatcher import Dispatcher

from topview.kernels.compiling import dispatcher_of, listed, type_of

KERNELS = [(module, name) for module, kernels in listed().items() for name in kernels]
SOURCES = Path(__file__).resolve().parents[3] / "src"


@pytest.mark.parametrize(("module", "name"), KERNELS)
def test_what_is_listed_is_a_kernel_that_takes_so_many_arguments(module, name):
    parameters = dispatcher_of(module, name).py_func.__code__.co_argcount
    signatures = listed()[module][name]["signatures"]
    assert signatures
    for signature in signatures:
        assert [isinstance(type_of(one), types.Type) for one in signature] == [True] * parameters


def test_no_kernel_is_compiled_for_both_read_only_and_other_arrays():
    for module, name in KERNELS:
        signatures = listed()[module][name]["signatures"]
        alike = {json.dumps(one).replace("True, aligned", "False, aligned") for one in signatures}
        assert len(alike) == len(signatures), (module, name)


def test_no_two_modules_write_the_cache_of_one_kernel():
    """Processes that compile take whole modules; numba's cache of a kernel is for one writer."""
    for path in sorted((SOURCES / "topview" / "kernels").glob("*.py")):
        module = import_module(f"topview.kernels.{path.stem}")
        for name, value in vars(module).items():
            if isinstance(value, Dispatcher) and value.py_func.__module__ != module.__name__:
                assert value.stats.cache_path is None, (path.stem, name)


NOT_LISTED = """
import sys
from topview.cli.progress import compile_kernels
from topview.kernels.compiling import listed
compile_kernels()
import topview
from topview_lab.sim import scene_by_name, SimulatedRecording
frames = list(SimulatedRecording(scene_by_name("pass_by", seed=3, frames=6)))
from numba.core import event
compiled = []
class Listener(event.Listener):
    def on_start(self, event): compiled.append(event.data["dispatcher"].py_func.__name__)
    def on_end(self, event): pass
event.register("numba:compile", Listener())
tracker = topview.Tracker()
for frame in frames:
    tracker.update(frame)
print(compiled)
"""


def test_the_list_is_enough_for_tracking(compiled):
    """If this fails, run scripts/record_signatures.py."""
    ended = subprocess.run(
        [sys.executable, "-c", NOT_LISTED], capture_output=True, text=True, check=True
    )
    assert ended.stdout == "[]\n"


SMALL = "sizes"  # a module with two kernels, which hardly take time
ONE_MODULE = """
from topview.kernels import compiling
compiling.listed = lambda: LISTED
from topview.cli.progress import compile_kernels
compile_kernels()
print(compiling.folder(), compiling.is_compiled())
"""


def compile_one_module(**environment: str) -> tuple[Path, str]:
    """Compile a small module in a process of its own: where it is kept, and what was said."""
    code = ONE_MODULE.replace("LISTED", repr({SMALL: listed()[SMALL]}))
    ended = subprocess.run(
        [sys.executable, "-c", code],
        env=os.environ | {"PYTHONPATH": str(SOURCES)} | environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert ended.returncode == 0, ended.stderr
    where, is_compiled = ended.stdout.split()
    assert is_compiled == "True"
    return Path(where), ended.stderr


def test_it_is_done_once_and_said(tmp_path):
    folder, said = compile_one_module(NUMBA_CACHE_DIR=str(tmp_path))
    assert said == "topview: compiling (once)\n"
    kept = {path.name for path in folder.glob(f"{SMALL}.*.nbc")}
    assert len(kept) == len(listed()[SMALL])
    assert compile_one_module(NUMBA_CACHE_DIR=str(tmp_path)) == (folder, "")


@pytest.mark.slow
def test_what_was_compiled_of_other_sources_is_forgotten(tmp_path):
    folder, _ = compile_one_module(NUMBA_CACHE_DIR=str(tmp_path))
    (stamp,) = folder.glob("compiled.*")
    python, _, machine = stamp.suffixes
    stamp.rename(stamp.with_name(f"compiled{python}.0123456789abcdef{machine}"))
    (folder / f"gone.kernel-1{python}.nbi").touch()
    (folder / f"gone.kernel-1{python}.1.nbc").touch()
    (folder / "gone.kernel-1.py27.1.nbc").touch()
    _, said = compile_one_module(NUMBA_CACHE_DIR=str(tmp_path))
    assert "compiling" in said
    assert [path.name for path in folder.glob("compiled.*")] == [stamp.name]
    assert [path.name for path in folder.glob("gone.*")] == ["gone.kernel-1.py27.1.nbc"]


@pytest.fixture
def read_only_installation(tmp_path: Path) -> Path:
    """A copy in which numba can make no `__pycache__` beside the kernels, not even as root."""
    installed = tmp_path / "installed"
    shutil.copytree(SOURCES, installed, ignore=shutil.ignore_patterns("__pycache__"))
    (installed / "topview" / "kernels" / "__pycache__").touch()
    return installed


def test_a_read_only_installation_is_kept_in_the_user_s_cache(read_only_installation, tmp_path):
    environment = {
        "PYTHONPATH": str(read_only_installation),
        "XDG_CACHE_HOME": str(tmp_path / "cache"),
        "NUMBA_CACHE_DIR": "",
    }
    folder, said = compile_one_module(**environment)
    assert folder.is_relative_to(tmp_path / "cache")
    assert said == "topview: compiling (once)\n"
    assert compile_one_module(**environment) == (folder, "")


@pytest.mark.slow
def test_where_nothing_can_be_kept_it_is_compiled_at_every_start(read_only_installation, tmp_path):
    (tmp_path / "home").touch()
    environment = {
        "PYTHONPATH": str(read_only_installation),
        "XDG_CACHE_HOME": str(tmp_path / "home" / "cache"),
        "NUMBA_CACHE_DIR": "",
        "TMPDIR": str(tmp_path),
    }
    for _ in range(2):
        folder, said = compile_one_module(**environment)
        assert said == "topview: compiling (at every start: no folder to keep it in)\n"
        assert folder.is_relative_to(tmp_path)
        assert not folder.exists()
