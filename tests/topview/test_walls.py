"""What the walls between the rooms are there for: the product runs without the laboratory, and a
user pays at the start for nothing that is not asked for. `lint-imports` checks the imports."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from pkgutil import resolve_name

import pytest

import topview
from topview.laboratory import COMMANDS, RIVAL_METHODS, RIVAL_PROPOSERS

PRODUCT = Path(topview.__file__).parent


def test_one_file_of_the_product_names_the_laboratory():
    naming = {
        str(file.relative_to(PRODUCT))
        for file in PRODUCT.rglob("*.py")
        if "topview_lab" in file.read_text()
    }
    assert naming == {"laboratory.py"}


ADDED = [*COMMANDS.values(), *RIVAL_METHODS.values(), *RIVAL_PROPOSERS.values()]


@pytest.mark.parametrize(("place", "sentence"), ADDED, ids=[place for place, _ in ADDED])
def test_whatever_the_laboratory_adds_is_there(place, sentence):
    assert callable(resolve_name(place))
    assert sentence


def loaded_by(statement: str) -> set[str]:
    """The top-level modules that are loaded after a statement, in a Python of its own."""
    script = f"import sys\n{statement}\nprint(*{{name.partition('.')[0] for name in sys.modules}})"
    ended = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    )
    return set(ended.stdout.split())


def test_importing_topview_is_cheap():
    loaded = loaded_by("import topview")
    assert "topview" in loaded
    assert not loaded & {"numba", "cv2", "scipy", "onnxruntime", "topview_lab"}


def test_help_is_cheap():
    loaded = loaded_by(
        "from topview.cli.main import main\ntry: main(['--help'])\nexcept SystemExit: pass"
    )
    assert "cyclopts" in loaded
    assert not loaded & {"numba", "cv2", "scipy", "onnxruntime", "topview_lab"}


def test_tracking_needs_nothing_of_the_laboratory():
    loaded = loaded_by("import topview\ntopview.Tracker()")
    assert "numba" in loaded
    assert "topview_lab" not in loaded
