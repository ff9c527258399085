"""Which reader a path gets, and what is said where there is none."""

from __future__ import annotations

import subprocess
import sys

import pytest

import topview
from topview import InputError, Recording


def test_a_reader_is_a_recording(write_folder):
    assert isinstance(topview.open(write_folder()), Recording)


def test_the_format_may_be_named(write_folder):
    assert topview.open(write_folder(), format="folder").frame_count == 4


@pytest.mark.parametrize("name", ["gone", "gone/", "x" * 5000])
def test_a_missing_path_is_refused(tmp_path, name):
    with pytest.raises(
        InputError, match=r"no such file or folder; docs/recordings\.md .*docs/live\.md"
    ):
        topview.open(tmp_path / name)


def test_an_unknown_kind_of_file_is_refused(tmp_path):
    path = tmp_path / "clip.dat"
    for content, told in ((b"", "is empty"), (b"whatever", "no format that is known")):
        path.write_bytes(content)
        right = "it must be one of folder .*utd-mhad .*pcd"
        with pytest.raises(InputError, match=rf"clip\.dat: {told}; {right}"):
            topview.open(path)


def test_an_unknown_format_is_refused(write_folder):
    with pytest.raises(InputError, match="format is 'oni'; it must be one of folder"):
        topview.open(write_folder(), format="oni")


@pytest.mark.parametrize("format", ["pcd", "utd-mhad"])
def test_a_folder_is_no_file(tmp_path, format):
    with pytest.raises(InputError, match="is no regular file; it must be"):
        topview.open(tmp_path, format)


def test_the_public_names_are_there_and_import_is_light():
    code = (
        "import sys, topview; assert 'numba' not in sys.modules and 'scipy' not in sys.modules; "
        "[getattr(topview, name) for name in topview.__all__]"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
    with pytest.raises(AttributeError, match="has no attribute 'nothing'"):
        _ = topview.nothing  # pyright: ignore[reportAttributeAccessIssue]
