"""What the page's server withstands: requests that no page of ours sends."""

from __future__ import annotations

import contextlib
import socket
import threading
from collections.abc import Callable

import pytest

from patience import HANGS_S
from topview_lab.annotate.connections import MOST_CONNECTIONS
from topview_lab.annotate.server import HOST, AnnotationServer
from topview_lab.annotate.session import Session

Serve = Callable[[Session], AnnotationServer]


def connected(server: AnnotationServer) -> socket.socket:
    return socket.create_connection((HOST, server.server_port), timeout=HANGS_S)


def exchange(server: AnnotationServer, *lines: str, body: bytes = b"") -> bytes:
    """All that is answered to a request, until the server closes the connection."""
    head = "\r\n".join((*lines, "Connection: close", "", ""))
    with connected(server) as connection:
        connection.sendall(head.encode("latin-1") + body)
        return b"".join(iter(lambda: connection.recv(65536), b""))


def status(answer: bytes) -> int:
    return int(answer.split(b" ", 2)[1])


def post(server: AnnotationServer, path: str, body: bytes, *headers: str) -> bytes:
    return exchange(
        server, f"POST {path} HTTP/1.1", "Host: 127.0.0.1:1", "Content-Type: application/json",
        f"Content-Length: {len(body)}", *headers, body=body,
    )  # fmt: skip


def get(server: AnnotationServer, path: str) -> bytes:
    return exchange(server, f"GET {path} HTTP/1.1", "Host: localhost:1")


@pytest.mark.parametrize("path", ["/api/spots/front/", "/image/rear/"])
def test_a_number_of_5000_digits_is_not_found(session: Session, serve: Serve, path: str) -> None:
    answer = get(serve(session), path + "1" * 5000)
    assert status(answer) == 404
    assert len(answer) < 2000


@pytest.mark.parametrize(
    ("length", "expected"),
    [("1" * 5000, 413), ("100001", 413), ("many", 411), ("-1", 411), ("\xb2", 411), ("", 411)],
)
def test_a_length_that_makes_no_sense_is_refused(
    session: Session, serve: Serve, length: str, expected: int
) -> None:
    answer = exchange(
        serve(session), "POST /api/undo HTTP/1.1", "Host: localhost:1",
        "Content-Type: application/json", f"Content-Length: {length}",
    )  # fmt: skip
    assert status(answer) == expected


def test_a_request_that_does_not_come_whole_is_not_waited_for(
    session: Session, serve: Serve
) -> None:
    server = serve(session)
    server.patience_s = 0.2
    answer = exchange(
        server, "POST /api/undo HTTP/1.1", "Host: localhost:1", "Content-Type: application/json",
        "Content-Length: 99999", body=b"{}",
    )  # fmt: skip
    assert answer == b"" or status(answer) == 408
    with connected(server) as silent:
        assert silent.recv(1) == b""


def test_a_request_that_comes_a_byte_at_a_time_is_not_waited_for(
    session: Session, serve: Serve
) -> None:
    server = serve(session)
    server.patience_s = 0.5
    ended = threading.Event()
    with connected(server) as dripping:

        def drip() -> None:
            with contextlib.suppress(OSError):
                while not ended.wait(0.1):
                    dripping.sendall(b"G")

        thread = threading.Thread(target=drip)
        thread.start()
        with contextlib.suppress(ConnectionResetError):
            assert dripping.recv(1) == b""
        ended.set()
        thread.join()


def test_300_idle_connections_are_few_threads_and_keep_nobody_out(
    session: Session, serve: Serve
) -> None:
    server = serve(session)
    before = threading.active_count()
    idle = [connected(server) for _ in range(300)]
    assert status(get(server, "/api/state")) == 200
    assert threading.active_count() <= before + MOST_CONNECTIONS + 1
    for connection in idle:
        connection.close()


@pytest.mark.parametrize("path", ["/api/change", "/api/pick"])
@pytest.mark.parametrize("body", [b"[" * 50_000, b'{"a":' * 15_000, b"1" * 5000, b"\xff", b"{"])
def test_a_body_that_is_no_json_is_a_bad_request(
    session: Session, serve: Serve, path: str, body: bytes
) -> None:
    before = session.project
    assert status(post(serve(session), path, body)) in (400, 422)
    assert session.project == before


@pytest.mark.parametrize(
    ("origin", "expected"),
    [
        ("http://127.0.0.1:1", 200),
        ("http://127.0.0.1:2", 403),
        ("https://127.0.0.1:1", 403),
        ("http://elsewhere.example", 403),
        ("null", 403),
    ],
)
def test_posts_of_other_origins_are_refused(
    session: Session, serve: Serve, origin: str, expected: int
) -> None:
    answer = post(serve(session), "/api/undo", b"{}", f"Origin: {origin}")
    assert status(answer) == expected


@pytest.mark.parametrize("path", ["/", "/api/state", "/nowhere", "/image/front/0"])
def test_no_other_page_may_frame_or_guess_an_answer(
    session: Session, serve: Serve, path: str
) -> None:
    head = get(serve(session), path).partition(b"\r\n\r\n")[0].decode()
    assert "frame-ancestors 'none'" in head
    assert "default-src 'none'" in head
    assert "X-Frame-Options: DENY" in head
    assert "X-Content-Type-Options: nosniff" in head


def test_a_bug_is_told_and_the_server_goes_on(
    session: Session, serve: Serve, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture
) -> None:
    server = serve(session)
    monkeypatch.setattr(Session, "change", lambda self, value: 1 / 0)
    answer = post(server, "/api/change", b"{}")
    assert status(answer) == 500
    assert b"please report it" in answer
    assert status(get(server, "/api/state")) == 200
    assert capsys.readouterr().err == ""
