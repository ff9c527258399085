"""`topview annotate`: truth from colour markers in two recordings."""

from __future__ import annotations

import re
import webbrowser
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from topview.cli.progress import progress_bar, warn
from topview.records import InputError
from topview_lab.annotate.automatic import FindOptions
from topview_lab.annotate.boards import Board
from topview_lab.annotate.joints import JointBasis
from topview_lab.annotate.server import AnnotationServer
from topview_lab.annotate.session import Session


def annotate(
    front: Path,
    rear: Path,
    /,
    *,
    out: Path | None = None,
    people: int = 1,
    board: str | None = None,
    offset: float | None = None,
    pick: str | None = None,
    automatic: Annotated[bool, Parameter(negative="")] = False,
    port: int = 0,
    browser: bool = True,
) -> int:
    """Take the truth from colour markers that two cameras see.

    Opens a page of this machine on which a marker's colour is clicked once; the markers are then
    found, named and followed in both recordings, and can be moved, deleted and interpolated.
    People begin standing, facing the front camera, with a marker in front of and behind each joint.
    Writes groundtruth.npz, which `topview evaluate folder` takes. Everything is saved at once.

    Args:
        front: the front camera's recording, a folder with depth/, rgb/ and camera.json.
        rear: the raised rear camera's recording.
        out: folder for groundtruth.npz and the project's files; the front recording if not given.
        people: how many wear markers.
        board: that both cameras see, to place the rear one: COLUMNSxROWS:METRES of a chessboard's
            inner corners, or charuco:COLUMNSxROWS:SQUARE:MARKER; by the markers if not given.
        offset: seconds by which the rear recording is late; found by the motion if not given.
        pick: a marker's pixel, VIEW:FRAME:U:V, such as front:0:320:200, instead of a click.
        automatic: find everything, accept it and write it, without a page.
        port: of the page, 1 to 65535, 0 for any.
        browser: open the page in the browser.
    """
    if not 1 <= people <= MOST_PEOPLE:
        raise InputError(f"--people is {people}; it must be 1 to {MOST_PEOPLE}")
    if offset is not None and not abs(offset) <= MOST_GIVEN_OFFSET_S:
        raise InputError(f"--offset is {offset}; it must be at most {MOST_GIVEN_OFFSET_S} seconds")
    wishes = FindOptions(people, None if board is None else Board.parse(board), offset)
    with Session(front, rear, out, wishes) as session:
        if pick is not None:
            view, frame, u, v = _pixel(pick)
            session.pick(view, frame, u, v, add=False)
        if automatic:
            _find(session)
            print(f"written to {session.accept()}")
            return 0
        return _serve(session, port, browser)


MOST_PEOPLE = 6
MOST_GIVEN_OFFSET_S = 3600  # either way; ours


DIGITS = "[0-9]{1,9}"


def _pixel(text: str) -> tuple[int, int, float, float]:
    match = re.fullmatch(
        rf"(front|rear):({DIGITS}):({DIGITS}(?:\.[0-9]+)?):({DIGITS}(?:\.[0-9]+)?)", text
    )
    if match is None:
        raise InputError(f"--pick is {text!r}; it must be VIEW:FRAME:U:V, such as front:0:320:200")
    return int(match[1] == "rear"), int(match[2]), float(match[3]), float(match[4])


def _find(session: Session) -> None:
    if not session.project.looks:
        raise InputError("--automatic needs a marker's pixel: give --pick VIEW:FRAME:U:V")
    with progress_bar() as progress:
        bar = progress.add_task("", total=1)
        session.run(
            lambda doing, done, total: progress.update(
                bar, description=doing, completed=done, total=total
            )
        )
    warn(*(problem for recording in session.recordings for problem in recording.problems))
    found, joints = session.found, session.joints
    if found is None or joints is None:
        return
    shares = {seen: float((joints.seen == seen).mean()) for seen in JointBasis}
    print(
        f"{session.frames} frames; rear camera {found.offset_frames} frames late, placed to "
        f"{100 * found.extrinsics.residual_m:.1f} cm; joints: "
        + ", ".join(f"{share:.0%} {seen.name.lower()}" for seen, share in shares.items())
    )


def _serve(session: Session, port: int, browser: bool) -> int:
    with AnnotationServer(session, port) as server:
        print(f"annotate at {server.url} (Ctrl-C ends; everything is saved at once)", flush=True)
        if browser:
            webbrowser.open(server.url)
        try:
            server.serve_forever()
        except KeyboardInterrupt:
            print(f"saved in {session.folder}")
    return 0
