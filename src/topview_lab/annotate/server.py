"""The annotation page: one process, on this machine only, without anything from the network."""

from __future__ import annotations

import re
from collections.abc import Callable
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from importlib.resources import files
from typing import Any, Final

import msgspec
import numpy as np
from numpy.typing import NDArray

from topview.camera import undistorted_camera
from topview.records import InputError
from topview_lab.annotate.landmarks import NAMES, PARENTS, SIDE_NAMES, relative_angles_deg
from topview_lab.annotate.project import VIEW_NAMES
from topview_lab.annotate.session import Session

HOST: Final = "127.0.0.1"
MOST_BYTES: Final = 100_000
"""Of a request; the largest that the page sends is a few hundred."""


class AnnotationServer(ThreadingHTTPServer):
    """Serves one session until it is shut down."""

    daemon_threads = True

    def __init__(self, session: Session, port: int = 0) -> None:
        self.session = session
        try:
            super().__init__((HOST, port), _Handler)
        except OSError as error:
            raise InputError(
                f"--port {port}: {error.strerror or error}; it must be a free port, or 0 for any"
            ) from error

    @property
    def url(self) -> str:
        return f"http://{HOST}:{self.server_address[1]}/"


class _Handler(BaseHTTPRequestHandler):
    server: AnnotationServer  # pyright: ignore[reportIncompatibleVariableOverride]
    protocol_version = "HTTP/1.1"

    def do_GET(self) -> None:
        self._answer(_GETS, b"")

    def do_POST(self) -> None:
        length = self.headers.get("Content-Length", "")
        if not length.isdigit() or int(length) > MOST_BYTES:
            self.close_connection = True
            self._say(HTTPStatus.REQUEST_ENTITY_TOO_LARGE, "the request is too large")
            return
        body = self.rfile.read(int(length))
        # A page of another origin cannot send this type without being asked first.
        if self.headers.get("Content-Type") != "application/json":
            self._say(HTTPStatus.UNSUPPORTED_MEDIA_TYPE, "the request must be JSON")
            return
        self._answer(_POSTS, body)

    def _answer(self, routes: dict[str, Route], body: bytes) -> None:
        host = self.headers.get("Host", "").rpartition(":")[0]
        if host not in (HOST, "localhost"):  # some other name that was pointed at this machine
            self._say(HTTPStatus.FORBIDDEN, f"host is {host!r}; it must be {HOST}")
            return
        path = self.path.partition("?")[0]
        for pattern, route in routes.items():
            match = re.fullmatch(pattern, path)
            if match is None:
                continue
            try:
                kind, data = route(self.server.session, match.groups(), body)
            except InputError as error:
                self._say(HTTPStatus.UNPROCESSABLE_ENTITY, str(error))
            except KeyError as missing:
                self._say(HTTPStatus.NOT_FOUND, f"there is no {missing.args[0]}")
            else:
                self._send(HTTPStatus.OK, kind, data)
            return
        self._say(HTTPStatus.NOT_FOUND, f"there is no {path}")

    def _say(self, status: HTTPStatus, error: str) -> None:
        self._send(status, JSON, msgspec.json.encode({"error": error}))

    def _send(self, status: HTTPStatus, kind: str, data: bytes) -> None:
        self.send_response(status)
        self.send_header("Content-Type", kind)
        self.send_header("Content-Length", str(len(data)))
        self.send_header("Cache-Control", "no-store")
        self.end_headers()
        self.wfile.write(data)

    def log_message(self, format: str, *args: Any) -> None:
        """Quiet: the command line says what there is to say."""


JSON: Final = "application/json"
Answer = tuple[str, bytes]
Route = Callable[[Session, tuple[str, ...], bytes], Answer]


def _page(session: Session, parts: tuple[str, ...], body: bytes) -> Answer:
    page = files("topview_lab.annotate").joinpath("page.html").read_bytes()
    return "text/html; charset=utf-8", page


def _image(session: Session, parts: tuple[str, ...], body: bytes) -> Answer:
    jpeg = session.jpeg(VIEW_NAMES.index(parts[0]), int(parts[1]))  # type: ignore[arg-type]
    if jpeg is None:
        raise KeyError(f"image of frame {parts[1]} in the {parts[0]} recording")
    return "image/jpeg", jpeg


def _state(session: Session, parts: tuple[str, ...], body: bytes) -> Answer:
    return JSON, msgspec.json.encode(state(session))


def _tracks(session: Session, parts: tuple[str, ...], body: bytes) -> Answer:
    return JSON, msgspec.json.encode(tracks(session))


def _spots(session: Session, parts: tuple[str, ...], body: bytes) -> Answer:
    view = VIEW_NAMES.index(parts[0])  # type: ignore[arg-type]
    return JSON, msgspec.json.encode({"spots": session.spots(view, int(parts[1]))})


class _Pick(msgspec.Struct, forbid_unknown_fields=True):
    view: str
    frame: int
    pixel: tuple[float, float]
    add: bool = False


def _do_pick(session: Session, parts: tuple[str, ...], body: bytes) -> Answer:
    try:
        pick = msgspec.json.decode(body, type=_Pick)
    except msgspec.MsgspecError as error:
        raise InputError(f"the pick cannot be used: {error}") from None
    if pick.view not in VIEW_NAMES:
        raise InputError(f"view is {pick.view!r}; it must be front or rear")
    count = session.pick(VIEW_NAMES.index(pick.view), pick.frame, *pick.pixel, pick.add)
    return JSON, msgspec.json.encode({"spots": count, **state(session)})


def _do_change(session: Session, parts: tuple[str, ...], body: bytes) -> Answer:
    try:
        value = msgspec.json.decode(body)
    except msgspec.MsgspecError as error:
        raise InputError(f"the change cannot be used: {error}") from None
    session.change(value)
    return JSON, msgspec.json.encode(state(session))


def _do_simply(act: Callable[[Session], object]) -> Route:
    def route(session: Session, parts: tuple[str, ...], body: bytes) -> Answer:
        act(session)
        return JSON, msgspec.json.encode(state(session))

    return route


_VIEW: Final = "(front|rear)"
_GETS: Final[dict[str, Route]] = {
    "/": _page,
    "/api/state": _state,
    "/api/tracks": _tracks,
    f"/api/spots/{_VIEW}/([0-9]+)": _spots,
    f"/image/{_VIEW}/([0-9]+)": _image,
}
_POSTS: Final[dict[str, Route]] = {
    "/api/pick": _do_pick,
    "/api/change": _do_change,
    "/api/find": _do_simply(Session.find),
    "/api/again": _do_simply(Session.follow_again),
    "/api/undo": _do_simply(Session.undo),
    "/api/accept": _do_simply(Session.accept),
}


def state(session: Session) -> dict[str, Any]:
    """What the page shows besides the tracks."""
    project, job, shown = session.project, session.job, session.snapshot()
    answer: dict[str, Any] = {
        "frames": session.frames,
        "fps": session.recordings[0].fps,
        "views": [
            {
                "name": name,
                "title": recording.name,
                "width": camera.width,
                "height": camera.height,
            }
            for name, recording in zip(VIEW_NAMES, session.recordings, strict=True)
            for camera in [undistorted_camera(recording.camera)]
        ],
        "joints": NAMES,
        "parents": PARENTS.tolist(),
        "sides": SIDE_NAMES,
        "people": project.people,
        "looks": project.looks,
        "changes": project.changes,
        "accepted": project.accepted,
        "folder": str(session.folder),
        "job": {
            "running": job.running,
            "doing": job.doing,
            "done": job.done,
            "total": job.total,
            "error": job.error,
        },
        "found": shown is not None,
    }
    if shown is not None:
        found = shown[0]
        answer["cameras"] = {
            "T_front_rear": found.extrinsics.T_front_rear.tolist(),
            "residual_cm": round(100 * found.extrinsics.residual_m, 1),
            "offset_frames": found.offset_frames,
        }
        answer["statures_m"] = [round(start.stature_m, 2) for start in found.starts]
    return answer


def tracks(session: Session) -> dict[str, Any]:
    """Per frame and person: joints in metres, what they rest on, pixels of their markers, and
    their relative angles; null where there is nothing."""
    shown = session.snapshot()
    if shown is None:
        return {"joints": [], "seen": [], "pixels": [[], []], "angles": []}
    _, joints, pixels = shown
    V, F, P = pixels.shape[:3]
    return {
        "joints": _rounded(joints.places_front, 3),
        "seen": ["".join(map(str, frame.ravel())) for frame in joints.seen],
        "pixels": _rounded(pixels.reshape(V, F, P, -1, 2), 1),
        "angles": _rounded(relative_angles_deg(joints.places_front), 1),
    }


def _rounded(values: NDArray[np.float64], digits: int) -> list[Any]:
    return np.round(values, digits).tolist()
