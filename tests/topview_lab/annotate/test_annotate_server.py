"""What the page asks of the server, without a browser."""

from __future__ import annotations

import json
import time
import urllib.error
import urllib.request
from collections.abc import Callable
from typing import Any

import pytest

from conftest import FRAMES, Marked
from topview_lab.annotate.automatic import FindOptions
from topview_lab.annotate.landmarks import NAMES
from topview_lab.annotate.server import AnnotationServer
from topview_lab.annotate.session import Session

Serve = Callable[[Session], AnnotationServer]


def ask(server: AnnotationServer, path: str, body: Any = None, **headers: str) -> tuple[int, bytes]:
    data = None if body is None else json.dumps(body).encode()
    request = urllib.request.Request(
        server.url + path, data, {"Content-Type": "application/json", **headers}
    )
    try:
        with urllib.request.urlopen(request) as answer:
            return answer.status, answer.read()
    except urllib.error.HTTPError as error:
        return error.code, error.read()


def value(answer: tuple[int, bytes]) -> Any:
    assert answer[0] == 200, answer
    return json.loads(answer[1])


DELETE = {"kind": "delete", "person": 0, "joint": "head", "frame": 3, "pixel": [1.0, 1.0]}


def test_the_page_and_its_images_come_from_here(session: Session, serve: Serve) -> None:
    server = serve(session)
    status, page = ask(server, "")
    assert status == 200
    assert b"http://" not in page.replace(b"http://www.w3.org/2000/svg", b"")  # works off-line
    assert b"https://" not in page
    status, image = ask(server, f"image/rear/{FRAMES - 1}")
    assert status == 200
    assert image.startswith(b"\xff\xd8")
    assert ask(server, f"image/front/{FRAMES}")[0] == 404
    assert ask(server, "image/side/0")[0] == 404


def test_state_and_tracks_fit_each_other(session: Session, serve: Serve) -> None:
    server = serve(session)
    state, tracks = value(ask(server, "api/state")), value(ask(server, "api/tracks"))
    assert state["found"]
    assert state["frames"] == len(tracks["joints"]) == len(tracks["seen"]) == FRAMES
    assert len(tracks["joints"][0][0]) == len(state["joints"]) == len(NAMES)
    assert len(tracks["pixels"]) == 2
    assert len(tracks["pixels"][0][0][0]) == 2 * len(NAMES)
    assert len(value(ask(server, "api/spots/front/0"))["spots"]) >= len(NAMES)


def test_changes_are_on_disk_at_once_and_can_be_taken_back(
    session: Session, marked: Marked, serve: Serve
) -> None:
    server = serve(session)
    before = value(ask(server, "api/tracks"))
    assert len(value(ask(server, "api/change", DELETE))["changes"]) == 1
    changed = value(ask(server, "api/tracks"))
    head = NAMES.index("head") * 2
    assert changed["pixels"][0][3][0][head] == [None, None]
    session.close()
    other = Session(marked.front, marked.rear, session.folder, FindOptions())
    assert other.project == session.project
    value(ask(server, "api/undo", {}))
    assert value(ask(server, "api/tracks")) == before


def test_a_placed_marker_moves_its_joint(session: Session, serve: Serve) -> None:
    server = serve(session)
    knee = NAMES.index("knee_l")
    before = value(ask(server, "api/tracks"))
    u, v = before["pixels"][0][3][0][2 * knee]
    place = {"kind": "place", "person": 0, "joint": "knee_l", "frame": 3, "pixel": [u + 12, v]}
    value(ask(server, "api/change", place))
    after = value(ask(server, "api/tracks"))
    assert after["joints"][3][0][knee][0] > before["joints"][3][0][knee][0] + 0.005
    assert after["joints"][20] == before["joints"][20]


def test_what_was_said_holds_when_markers_are_followed_again(session: Session) -> None:
    found = session.found
    assert found is not None
    knee, hip = NAMES.index("knee_l"), NAMES.index("hip_l")
    pixel = found.blobs[0][5].pixels[found.tracks.spots[0, 5, 0, knee, 0]]
    session.change({"kind": "place", "person": 0, "joint": "hip_l", "frame": 5,
                    "pixel": pixel.tolist()})  # fmt: skip
    session.change({**DELETE, "frame": 7})
    ankle = found.blobs[0][9].pixels[found.tracks.spots[0, 9, 0, NAMES.index("ankle_l"), 0]]
    session.change({"kind": "place", "person": 0, "joint": "ankle_l", "frame": 9,
                    "pixel": (ankle - (0, 15)).tolist()})  # fmt: skip
    session.follow_again()
    while session.job.running:
        time.sleep(0.01)
    assert session.job.error == ""
    assert session.found is not None
    spots = session.found.tracks.spots
    assert spots[0, 5, 0, hip, 0] == found.tracks.spots[0, 5, 0, knee, 0]
    assert spots[0, 5, 0, knee, 0] != spots[0, 5, 0, hip, 0]
    assert spots[0, 7, 0, NAMES.index("head"), 0] == -1
    placed = session.found.blobs[0][9].pixels[spots[0, 9, 0, NAMES.index("ankle_l"), 0]]
    assert placed == pytest.approx(ankle - (0, 15))


@pytest.mark.parametrize(
    ("path", "body", "said"),
    [
        ("api/change", {**DELETE, "joint": "tail"}, "joint is 'tail'"),
        ("api/change", {**DELETE, "frame": FRAMES}, f"0 to {FRAMES - 1}"),
        ("api/change", {**DELETE, "person": 1}, "person is 1"),
        ("api/change", {**DELETE, "kind": "paint"}, "cannot be used"),
        ("api/change", {**DELETE, "kind": "place", "pixel": None}, "no pixel"),
        ("api/change", {**DELETE, "kind": "place", "pixel": [-50, 3]}, "no depth"),
        ("api/pick", {"view": "front", "frame": 0, "pixel": [250, 90]}, "nearly grey"),
        ("api/pick", {"view": "front", "frame": 0, "pixel": [9000, 90]}, "outside of the image"),
        ("api/pick", {"view": "side", "frame": 0, "pixel": [1, 1]}, "front or rear"),
        ("api/pick", {"frame": 0}, "cannot be used"),
    ],
)
def test_refusals_are_one_line_and_change_nothing(
    session: Session, serve: Serve, path: str, body: Any, said: str
) -> None:
    server, before = serve(session), session.project
    status, answer = ask(server, path, body)
    error = json.loads(answer)["error"]
    assert status == 422
    assert said in error
    assert "\n" not in error
    assert session.project == before


def test_other_pages_are_kept_out(session: Session, serve: Serve) -> None:
    server = serve(session)
    assert ask(server, "api/state", Host="elsewhere.example:80")[0] == 403
    assert ask(server, "api/undo", {}, **{"Content-Type": "text/plain"})[0] == 415
    assert ask(server, "api/change", "x" * 200_000)[0] == 413
