"""Measure a plain install: seconds, megabytes by package, and whether `topview demo` runs outside
the project.

    python scripts/measure_install.py

Makes a virtual environment in a temporary folder, which is removed.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
import venv
from pathlib import Path
from time import perf_counter

ROOT = Path(__file__).resolve().parents[1]
NOT_OURS = ("pip", "setuptools", "pkg_resources", "_distutils_hack")


def size_mb(folder: Path) -> float:
    return sum(file.stat().st_size for file in folder.rglob("*") if file.is_file()) / 2**20


def main() -> None:
    with tempfile.TemporaryDirectory() as place:
        environment, outside = Path(place) / "venv", Path(place) / "outside"
        outside.mkdir()
        venv.create(environment, with_pip=True)
        start = perf_counter()
        pip = [environment / "bin" / "python", "-m", "pip", "install", "--quiet", ROOT]
        subprocess.run(pip, check=True)
        print(f"installed in {perf_counter() - start:.0f} s")
        (packages,) = environment.glob("lib/python3*/site-packages")
        folders = [path for path in packages.iterdir() if path.name not in NOT_OURS]
        sizes = {path.name: size_mb(path) for path in folders if path.is_dir()}
        for name, megabytes in sorted(sizes.items(), key=lambda item: -item[1])[:12]:
            print(f"{megabytes:8.0f} MB  {name}")
        print(f"{sum(sizes.values()):8.0f} MB  all together")
        demo = [environment / "bin" / "topview", "demo"]
        sys.exit(subprocess.run(demo, cwd=outside, env={"HOME": place}, check=False).returncode)


if __name__ == "__main__":
    main()
