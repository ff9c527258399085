"""A project file that was damaged or edited by hand is one line."""

from __future__ import annotations

import json
from typing import Any

import pytest

from conftest import FRAMES, Marked
from topview.records import InputError
from topview_lab.annotate.automatic import FindOptions
from topview_lab.annotate.session import Session

CHANGE = {"kind": "delete", "person": 0, "joint": "head", "frame": 3, "pixel": [1.0, 1.0]}


def edited(session: Session, **values: Any) -> bytes:
    project = json.loads((session.folder / "annotation.json").read_bytes())
    return json.dumps(project | values).encode()


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ({"changes": [{**CHANGE, "frame": FRAMES}]}, f"frame is {FRAMES}"),
        ({"changes": [{**CHANGE, "frame": -1}]}, "frame is -1"),
        ({"changes": [{**CHANGE, "person": 3}]}, "person is 3"),
        ({"changes": [{**CHANGE, "joint": "tail"}]}, "joint is 'tail'"),
        ({"looks": [{"red": 300, "green": 0, "blue": 0, "radius_m": 0.02}]}, "<= 255"),
        ({"looks": [{"red": 200, "green": 0, "blue": 0, "radius_m": 0.0}]}, ">= 0.005"),
        ({"format": "topview annotation 9"}, "must be 'topview annotation 1'"),
    ],
)
def test_values_that_cannot_be(
    marked: Marked, session: Session, values: dict[str, Any], said: str
) -> None:
    check(marked, session, edited(session, **values), said)


@pytest.mark.parametrize(
    "data", [b"", b"{", b"[" * 50_000, b'{"front":' * 15_000, b'"\xff"', b"7" * 5000]
)
def test_what_is_no_json(marked: Marked, session: Session, data: bytes) -> None:
    check(marked, session, data, "is not an annotation project")


def check(marked: Marked, session: Session, data: bytes, said: str) -> None:
    session.close()
    path = session.folder / "annotation.json"
    path.write_bytes(data)
    with pytest.raises(InputError) as raised:
        Session(marked.front, marked.rear, session.folder, FindOptions())
    assert str(raised.value).startswith(f"{path}: ")
    assert said in str(raised.value)
    assert path.read_bytes() == data
