"""`topview view`: a recording or a result in rerun, in a browser."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator
from pathlib import Path
from threading import Event
from typing import Annotated

from cyclopts import Parameter

from topview.camera import undistorted
from topview.cli.progress import progress_bar, warn
from topview.cli.results import RESULT
from topview.io import SkeletonFile, open_recording
from topview.io.writers.extras import needed
from topview.records import Frame, Person
from topview.skeletons import SkeletonSequence
from topview.view.rerun_view import RerunView

NO_PEOPLE: list[Person] = []


def view(
    source: Path,
    /,
    *,
    recording: Path | None = None,
    once: Annotated[bool, Parameter(negative="")] = False,
) -> int:
    """Show a recording, or the skeletons of a result, in a browser.

    Needs rerun: pip install 'topview[view]'. It is served by this machine and needs no network;
    Ctrl-C ends it. `topview track --view` shows both while tracking runs.

    Args:
        source: a recording, as for `topview track`; or a skeletons.npz, or the folder with it.
        recording: that a result was made of, to show its images and points, too.
        once: end when all is loaded, and do not wait for Ctrl-C.
    """
    check_viewer()
    result = source / RESULT if source.is_dir() else source
    if result.suffix != ".npz" or not result.exists():
        shown_recording = open_recording(source)
        viewer = RerunView(shown_recording.name)
        tell_address(viewer)
        with progress_bar() as progress:
            for frame in progress.track(shown_recording, total=shown_recording.frame_count):
                viewer.show(undistorted(frame), NO_PEOPLE)
        warn(*shown_recording.problems)
    else:
        viewer = RerunView(source.name)
        tell_address(viewer)
        _show_result(viewer, SkeletonFile(result), recording)
    if not once:
        wait_for_end()
    return 0


def _show_result(viewer: RerunView, skeletons: SkeletonFile, source: Path | None) -> None:
    images = _Images(() if source is None else open_recording(source))
    for block in skeletons.blocks():
        for row, people in enumerate(people_of(block)):
            index, time_s = int(block.frame_index[row]), float(block.timestamps_s[row])
            frame = images.of(index)
            if frame is None:
                viewer.show_skeletons(index, time_s, people)
            else:
                viewer.show(frame, people)


class _Images:
    """Frames of a recording by their numbers, which are asked for in order."""

    def __init__(self, frames: Iterable[Frame]) -> None:
        self._frames = iter(frames)
        self._next: Frame | None = next(self._frames, None)

    def of(self, index: int) -> Frame | None:
        """Undistorted; None where the recording has none."""
        while self._next is not None and self._next.index < index:
            self._next = next(self._frames, None)
        is_it = self._next is not None and self._next.index == index
        return undistorted(self._next) if is_it and self._next is not None else None


def people_of(block: SkeletonSequence) -> Iterator[list[Person]]:
    """The people of each frame, as a tracker gives them."""
    return map(block.people_in, range(len(block.person_ids)))


def check_viewer() -> None:
    """Raises InputError where rerun is not installed."""
    needed("rerun", "the viewer", "view")


def tell_address(viewer: RerunView) -> None:
    """Serve it, and say where; a terminal's user gets a browser opened."""
    address = viewer.serve(open_browser=sys.stdout.isatty())
    print(f"viewer: {address}", flush=True)


def wait_for_end() -> None:
    """Until Ctrl-C."""
    print("Ctrl-C ends the viewer", flush=True)
    try:
        Event().wait()
    except KeyboardInterrupt:
        return
