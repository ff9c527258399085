"""The annotation page: one process, on this machine only, without anything from the network."""

from __future__ import annotations

import re
from base64 import b64encode
from collections.abc import Callable
from hashlib import sha256
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler
from importlib.resources import files
from typing import Any, Final

import msgspec
import numpy as np
from numpy.typing import NDArray

from topview.camera import undistorted_camera
from topview.records import InputError, shown
from topview_lab.annotate.connections import BoundedServer
from topview_lab.annotate.landmarks import NAMES, PARENTS, SIDE_NAMES, relative_angles_deg
from topview_lab.annotate.project import VIEW_NAMES
from topview_lab.annotate.session import Session

HOST: Final = "127.0.0.1"
MOST_BODY_BYTES: Final = 100_000
"""Of a request's body; the largest that the page sends is a few hundred."""
MOST_PORT: Final = 65535
PAGE: Final = files("topview_lab.annotate").joinpath("page.html").read_bytes()


def _hash_of_script(page: bytes) -> str:
    """As a Content-Security-Policy names a page's one script."""
    (script,) = re.findall(rb"<script>(.*?)</script>", page, re.DOTALL)
    return f"'sha256-{b64encode(sha256(script).digest()).decode()}'"


# Of every answer: the page runs its own script only, asks nobody else, and is in nobody's frame.
_HEADERS: Final = {
    "Cache-Control": "no-store",
    "Content-Security-Policy": "; ".join(
        (
            "default-src 'none'",
            f"script-src {_hash_of_script(PAGE)}",
            "style-src 'unsafe-inline'",
            "img-src 'self' data: blob:",
            "connect-src 'self'",
            "base-uri 'none'",
            "form-action 'none'",
            "frame-ancestors 'none'",
        )
    ),
    "X-Frame-Options": "DENY",
    "X-Content-Type-Options": "nosniff",
    "Cross-Origin-Resource-Policy": "same-origin",
}


class AnnotationServer(BoundedServer):
    """Serves one session until it is shut down."""

    def __init__(self, session: Session, port: int = 0) -> None:
        self.session = session
        right = f"it must be a free port, 1 to {MOST_PORT}, or 0 for any"
        if not 0 <= port <= MOST_PORT:
            raise InputError(f"--port is {port}; {right}")
        try:
            super().__init__((HOST, port), _Handler)
        except OSError as error:
            raise InputError(f"--port {port}: {error.strerror or error}; {right}") from error

    @property
    def url(self) -> str:
        return f"http://{HOST}:{self.server_address[1]}/"


class _Handler(BaseHTTPRequestHandler):
    server: AnnotationServer  # pyright: ignore[reportIncompatibleVariableOverride]
    protocol_version = "HTTP/1.1"

    def setup(self) -> None:
        super().setup()
        self.connection.settimeout(self.server.patience_s)

    def do_GET(self) -> None:
        if self._is_from_here():
            self._answer(_GETS, b"")

    def do_POST(self) -> None:
        body = self._body()
        if body is None or not self._is_from_here():
            return
        # A page of another origin cannot send this type without being asked first.
        if self.headers.get("Content-Type") != JSON:
            self._say(HTTPStatus.UNSUPPORTED_MEDIA_TYPE, "the request must be JSON")
            return
        self._answer(_POSTS, body)

    def _is_from_here(self) -> bool:
        """Whether the request is meant for this server and of its own page, if of one; it is
        answered otherwise."""
        host = self.headers.get("Host", "")
        if host.rpartition(":")[0] not in (HOST, "localhost"):  # a name pointed at this machine
            self._say(HTTPStatus.FORBIDDEN, f"host is {shown(host)}; it must be {HOST}")
            return False
        # A browser sends it with every post; what is no browser may not.
        origin = self.headers.get("Origin", f"http://{host}")
        if origin != f"http://{host}":
            self._say(HTTPStatus.FORBIDDEN, f"origin is {shown(origin)}; it must be http://{host}")
            return False
        return True

    def _body(self) -> bytes | None:
        """The request's body; None if there is none to be had, which is then answered."""
        length = self.headers.get("Content-Length", "")
        if re.fullmatch("[0-9]+", length) is None:
            refusal = HTTPStatus.LENGTH_REQUIRED, "the request must say its length"
        elif len(length) > len(str(MOST_BODY_BYTES)) or int(length) > MOST_BODY_BYTES:
            refusal = HTTPStatus.REQUEST_ENTITY_TOO_LARGE, "the request is too large"
        else:
            try:
                body = self.rfile.read(int(length))
            except TimeoutError:
                body = b""
            if len(body) == int(length):
                return body
            refusal = HTTPStatus.REQUEST_TIMEOUT, f"the request is shorter than its {length} bytes"
        self.close_connection = True  # what is left of it would be read as another request
        self._say(*refusal)
        return None

    def _answer(self, routes: dict[str, Route], body: bytes) -> None:
        path = self.path.partition("?")[0]
        for pattern, route in routes.items():
            match = re.fullmatch(pattern, path)
            if match is None:
                continue
            with self.server.at_work(self.connection):
                answer = self._made(route, match.groups(), body)
            self._send(*answer)
            return
        self._say(HTTPStatus.NOT_FOUND, f"there is no {shown(path)}")

    def _made(
        self, route: Route, parts: tuple[str, ...], body: bytes
    ) -> tuple[HTTPStatus, str, bytes]:
        try:
            return HTTPStatus.OK, *route(self.server.session, parts, body)
        except _NoJsonError as error:
            return HTTPStatus.BAD_REQUEST, JSON, _error(str(error))
        except InputError as error:
            return HTTPStatus.UNPROCESSABLE_ENTITY, JSON, _error(str(error))
        except KeyError as missing:
            return HTTPStatus.NOT_FOUND, JSON, _error(f"there is no {missing.args[0]}")
        except Exception as error:  # the page shows it, and can be worked on with
            told = f"a bug of topview ({type(error).__name__}: {error}); please report it"
            return HTTPStatus.INTERNAL_SERVER_ERROR, JSON, _error(told)

    def _say(self, status: HTTPStatus, error: str) -> None:
        self._send(status, JSON, _error(error))

    def _send(self, status: HTTPStatus, kind: str, data: bytes) -> None:
        self.send_response(status)
        self.send_header("Content-Type", kind)
        self.send_header("Content-Length", str(len(data)))
        if self.close_connection:
            self.send_header("Connection", "close")
        self.end_headers()
        self.wfile.write(data)

    def end_headers(self) -> None:
        for name, value in _HEADERS.items():
            self.send_header(name, value)
        super().end_headers()

    def log_message(self, format: str, *args: Any) -> None:
        """Quiet: the command line says what there is to say."""


def _error(text: str) -> bytes:
    return msgspec.json.encode({"error": text})


JSON: Final = "application/json"
Answer = tuple[str, bytes]
Route = Callable[[Session, tuple[str, ...], bytes], Answer]


def _page(session: Session, parts: tuple[str, ...], body: bytes) -> Answer:
    return "text/html; charset=utf-8", PAGE


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


class _NoJsonError(InputError):
    """The body of a request cannot be decoded."""


def _json(body: bytes, type: Any, what: str) -> Any:
    """The body as JSON of a type.

    Raises:
        InputError: it is none (`_NoJsonError`), or of another type.
    """
    try:
        return msgspec.json.decode(body, type=type)
    except msgspec.ValidationError as error:
        raise InputError(f"{what} cannot be used: {error}") from None
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
        raise _NoJsonError(f"{what} cannot be used: {error}") from None


def _do_pick(session: Session, parts: tuple[str, ...], body: bytes) -> Answer:
    pick: _Pick = _json(body, _Pick, "the pick")
    if pick.view not in VIEW_NAMES:
        raise InputError(f"view is {pick.view!r}; it must be front or rear")
    count = session.pick(VIEW_NAMES.index(pick.view), pick.frame, *pick.pixel, pick.add)
    return JSON, msgspec.json.encode({"spots": count, **state(session)})


def _do_change(session: Session, parts: tuple[str, ...], body: bytes) -> Answer:
    session.change(_json(body, Any, "the change"))
    return JSON, msgspec.json.encode(state(session))


def _do_simply(act: Callable[[Session], object]) -> Route:
    def route(session: Session, parts: tuple[str, ...], body: bytes) -> Answer:
        act(session)
        return JSON, msgspec.json.encode(state(session))

    return route


_VIEW: Final = "(front|rear)"
_FRAME: Final = "([0-9]{1,9})"
_GETS: Final[dict[str, Route]] = {
    "/": _page,
    "/api/state": _state,
    "/api/tracks": _tracks,
    f"/api/spots/{_VIEW}/{_FRAME}": _spots,
    f"/image/{_VIEW}/{_FRAME}": _image,
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
