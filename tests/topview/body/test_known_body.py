"""Bodies that are known beforehand: what is written is read again, and nothing else is."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

import topview
from topview.body.known_body import BODIES_VERSION, BONE_NAMES, KnownBody, KnownBone, read_bodies
from topview.records import InputError

BONES = {name: KnownBone(0.1 + 0.01 * k, 0.004) for k, name in enumerate(BONE_NAMES)}
bones = st.builds(
    KnownBone,
    st.floats(0.0, 1.0, exclude_min=True),
    st.floats(0.0, 1.0, exclude_min=True),
)
bodies = st.builds(
    KnownBody,
    st.none() | st.floats(0.5, 2.5),
    st.just({}) | st.fixed_dictionaries(dict.fromkeys(BONE_NAMES, bones)),
    st.floats(0.0, 1e6),
)


@given(written=st.lists(bodies, min_size=1, max_size=4))
def test_what_is_written_is_read_to_the_bit(
    written: list[KnownBody], tmp_path_factory: pytest.TempPathFactory
) -> None:
    path = tmp_path_factory.mktemp("bodies") / "bodies.json"
    topview.write_bodies(written, path)
    assert list(topview.read_bodies(path)) == written


def told(**changed: Any) -> dict[str, Any]:
    body = {"stature_m": 1.7, "seconds": 3.0} | changed
    return {"version": BODIES_VERSION, "bodies": [body]}


def refused(path: Path, text: str) -> str:
    """The one line by which a file is refused."""
    path.write_text(text)
    with pytest.raises(InputError) as error:
        read_bodies(path)
    line = str(error.value)
    assert line.startswith(str(path))
    assert "\n" not in line
    return line


def with_bones(**changed: Any) -> dict[str, Any]:
    own = {name: {"length_m": 0.2, "sigma_m": 0.01} for name in BONE_NAMES}
    return told(bones=own | changed)


@pytest.mark.parametrize(
    ("content", "named"),
    [
        ({"version": 2, "bodies": []}, "version is 2; it must be 1"),
        ({"bodies": []}, "version"),
        ({"version": BODIES_VERSION, "bodies": []}, "holds no body"),
        (told(stature_m=17.8), "stature_m is 17.8; it must be metres, 0.5 to 2.5"),
        (told(seconds=-1.0), "seconds is -1.0"),
        (told(stature_m="tall"), "stature_m"),
        (told(height=1.7), "height"),
        (told(bones={"head": {"length_m": 0.2, "sigma_m": 0.01}}), "bones are head; they must be"),
        (with_bones(head={"length_m": -0.2, "sigma_m": 0.01}), "length_m of head is -0.2"),
        (with_bones(head={"length_m": 0.2, "sigma_m": 0.0}), "sigma_m of head is 0.0"),
        (with_bones(tail={"length_m": 0.2, "sigma_m": 0.1}), "tail; they must be"),
    ],
)
def test_a_file_that_no_body_has_is_one_line(
    content: dict[str, Any], named: str, tmp_path: Path
) -> None:
    assert named in refused(tmp_path / "bodies.json", json.dumps(content))


@pytest.mark.parametrize("text", ["", "{", "[1, 2]", '{"version": 1, "bodies": [NaN]}', "\x00\xff"])
def test_what_is_no_file_of_bodies_is_one_line(text: str, tmp_path: Path) -> None:
    assert "it must be a file that" in refused(tmp_path / "bodies.json", text)


def test_shoulders_may_lie_behind_the_neck(tmp_path: Path) -> None:
    path = tmp_path / "bodies.json"
    path.write_text(json.dumps(with_bones(shoulder_front={"length_m": -0.02, "sigma_m": 0.01})))
    assert read_bodies(path)[0].bones["shoulder_front"].length_m == -0.02


def test_a_missing_file_and_no_body_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"nowhere\.json: cannot be read"):
        read_bodies(tmp_path / "nowhere.json")
    with pytest.raises(InputError, match=r"bodies\.json: no body to write"):
        topview.write_bodies([], tmp_path / "bodies.json")
