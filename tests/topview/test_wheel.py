"""The wheel alone: all its files and declared dependencies, and nothing else, run the demo.

The environment is empty but for the wheel, which pip installs, and links to the distributions that
the plain install declares, directly or through others. So nothing is fetched. Kernels are those
that these tests have compiled already.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import venv
from importlib.metadata import distribution
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
from packaging.requirements import Requirement

from topview.kernels.caching import folder

ROOT = Path(__file__).parents[2]
BUILD = "from setuptools import build_meta; build_meta.build_wheel('dist')"


def dependencies(name: str) -> set[str]:
    """The distributions that one needs without extras, and all that those need."""
    found: set[str] = set()
    waiting = [name]
    while waiting:
        for line in distribution(waiting.pop()).requires or []:
            wanted = Requirement(line)
            is_wanted = wanted.marker is None or wanted.marker.evaluate({"extra": ""})
            if is_wanted and wanted.name not in found:
                found.add(wanted.name)
                waiting.append(wanted.name)
    return found


def link(name: str, packages: Path) -> None:
    """Have a distribution of this environment in another, too."""
    own = distribution(name)
    for top in {file.parts[0] for file in own.files or []} - {"..", "__pycache__"}:
        (packages / top).symlink_to(Path(str(own.locate_file(top))))


def take_compiled(kernels: Path) -> None:
    """Give an installed copy what numba has compiled of the same sources here."""
    cache = kernels / "__pycache__"
    cache.mkdir(exist_ok=True)
    for path in folder().iterdir():
        if path.suffix in (".nbi", ".nbc") or path.name.startswith("compiled."):
            shutil.copy2(path, cache)
    for source in kernels.glob("*.py"):  # numba compares sizes and times
        shutil.copystat(ROOT / "src" / "topview" / "kernels" / source.name, source)


@pytest.mark.slow
def test_the_wheel_alone_runs_the_demo(tmp_path, compiled):
    base = Path(sys.base_prefix) / "bin" / "python3"
    if not base.exists() or subprocess.run([base, "-c", "import pip"], check=False).returncode:
        pytest.skip("needs pip in the Python that made this environment")
    if find_spec("setuptools") is None:
        pytest.skip("needs setuptools, which makes the wheel")
    made, environment, outside = (tmp_path / name for name in ("made", "environment", "outside"))
    outside.mkdir()
    shutil.copytree(
        ROOT / "src", made / "src", ignore=shutil.ignore_patterns("__pycache__", "*.egg-info")
    )
    for name in ("pyproject.toml", "README.md", "LICENSE", "NOTICE"):
        shutil.copy(ROOT / name, made)
    subprocess.run([sys.executable, "-c", BUILD], cwd=made, check=True, capture_output=True)
    (wheel,) = (made / "dist").glob("*.whl")
    clean = {"HOME": str(outside), "PATH": os.defpath}  # and no PYTHONPATH
    venv.create(environment)
    python = environment / "bin" / "python"
    words = ["--python", python, "install", "--quiet", "--no-index", "--no-deps", "--no-compile"]
    subprocess.run([base, "-m", "pip", *words, wheel], check=True, env=clean)
    (packages,) = environment.glob("lib/python3*/site-packages")
    for name in dependencies("topview"):
        link(name, packages)
    take_compiled(packages / "topview" / "kernels")
    ended = subprocess.run(
        [environment / "bin" / "topview", "demo", "--frames", "3"],
        cwd=outside,
        env=clean,
        check=False,
        capture_output=True,
        text=True,
    )
    assert (ended.returncode, ended.stderr) == (0, "")
    assert "frames per second" in ended.stdout
    with np.load(outside / "out" / "demo" / "skeletons.npz") as skeletons:
        assert skeletons["frame_index"].tolist() == [0, 1, 2]
