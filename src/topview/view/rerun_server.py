"""rerun's servers, for this machine alone: of the data in this process, of its page beside it.

rerun's own way to serve the page from a process listens on every interface of the machine; its
command takes an address.
"""

from __future__ import annotations

import atexit
import socket
import subprocess
import webbrowser
from pathlib import Path
from time import monotonic, sleep
from typing import Any, Final
from urllib.parse import quote

from topview.records import InputError

THIS_MACHINE: Final = "127.0.0.1"
KEPT_MEMORY: Final = "1GiB"  # of memory for what was shown; the oldest is forgotten first; ours
STARTS_S: Final = 30.0  # ours; the page is served after half a second
LOOKS_AGAIN_S: Final = 0.02  # ours
PROGRAMS: Final = ("Rerun.app/Contents/MacOS/Rerun", "rerun", "rerun.exe")


def serve(stream: Any, *, open_browser: bool) -> str:
    """Serve what a recording stream of rerun is told from now on, and rerun's web viewer.

    Returns:
        The address to open.

    Raises:
        InputError: the page cannot be served.
    """
    import rerun

    data = rerun.GrpcServerSink(THIS_MACHINE, free_port(), server_memory_limit=KEPT_MEMORY)
    stream.set_sinks(data)
    page = _serve_page(data.uri)
    address = f"{page}/?url={quote(data.uri, safe='')}"
    if open_browser:
        webbrowser.open(address)
    return address


def free_port() -> int:
    """A port of this machine that is free just now."""
    with socket.socket() as taken:
        taken.bind((THIS_MACHINE, 0))
        return taken.getsockname()[1]


def _serve_page(data: str) -> str:
    """Start rerun's command, which ends with this process; the address of its page."""
    port = free_port()
    words = ["--bind", THIS_MACHINE, "--web-viewer-port", str(port), "--serve-web", data]
    page = subprocess.Popen(
        [_program(), *words],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    atexit.register(page.terminate)
    end_s = monotonic() + STARTS_S
    while not _answers(port):
        if page.poll() is not None or monotonic() > end_s:
            page.terminate()
            raise InputError("rerun's viewer does not start; `rerun --serve-web` may tell why")
        sleep(LOOKS_AGAIN_S)
    return f"http://{THIS_MACHINE}:{port}"


def _program() -> Path:
    import rerun_cli

    places = [Path(str(rerun_cli.__file__)).parent / name for name in PROGRAMS]
    found = next(filter(Path.is_file, places), None)
    if found is None:
        raise InputError(
            "rerun is there without its viewer; install it with: pip install rerun-sdk"
        )
    return found


def _answers(port: int) -> bool:
    with socket.socket() as asked:
        return asked.connect_ex((THIS_MACHINE, port)) == 0
