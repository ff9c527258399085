"""`topview track`: a recording in, skeletons out."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Annotated

import numpy as np
from cyclopts import Parameter
from numpy.typing import NDArray

from topview.cli.outputs import prepare_output_file
from topview.cli.progress import follow_with_progress, print_frames, warn, with_progress
from topview.cli.results import (
    CONTACT_SHEET,
    FRAMES_NAME,
    OVERLAY,
    PART_MAPS,
    PEOPLE_SHEET,
    check_free,
    look_both_ways,
    print_people,
    show_again,
    write_result,
)
from topview.cli.status import INTERRUPTED
from topview.cli.view import check_viewer, tell_address, wait_for_end
from topview.detect.color_view import Light
from topview.io import (
    DepthRange,
    FramesFile,
    MirroredRecording,
    StoredFrames,
    open_recording,
    prepare_output_folder,
)
from topview.io.writers.bodies import write_bodies
from topview.io.writers.registry import format_named
from topview.live import LiveRecording, is_camera, open_camera
from topview.people.users import label_image
from topview.records import Frame, InputError, Recording
from topview.skeletons import TrackedFrame
from topview.stream import Outlet, open_stream
from topview.track import KeepFrame, Tracker, TrackerSettings, TrackingRun
from topview.track.known_people import LEARNT_S
from topview.view import ContactSheet, OverlayVideo, PartMaps, PeopleSheet, Sheet, Viewers
from topview.view.rerun_view import RerunView

DEFAULTS = TrackerSettings()


class NobodyFoundError(InputError):
    """The result is written, and holds nobody."""


def track(
    source: Path,
    /,
    *,
    out: Path,
    pictures: Annotated[bool, Parameter(negative="")] = False,
    video: Annotated[bool, Parameter(negative="")] = False,
    part_map: Annotated[bool, Parameter(negative="")] = False,
    format: str = "",
    mirrored: Annotated[bool, Parameter(negative="")] = False,
    gravity: tuple[float, float, float] | None = None,
    stream: tuple[str, ...] = (),
    record: Path | None = None,
    view: Annotated[bool, Parameter(negative="")] = False,
    offline: Annotated[bool, Parameter(negative="")] = False,
    save_body: Path | None = None,
    force: Annotated[bool, Parameter(negative="")] = False,
    settings: Annotated[TrackerSettings, Parameter(name="*")] = DEFAULTS,
) -> int:
    """Track everyone in a recording.

    Writes DIR/skeletons.npz and DIR/skeletons.csv. Whatever ends it early, Ctrl-C, a signal or an
    error, what was tracked so far is written. Until the end it lies in DIR/skeletons.frames; if
    that is left, as after a power failure, `topview recover DIR` makes the result of it.

    Args:
        source: a folder with depth/, camera.json and maybe rgb/; a ROS bag; an Azure Kinect's
            .mkv; a depth .npy; whatever else docs/recordings.md lists. Or a live camera,
            realsense:, orbbec: or oak:, until Ctrl-C; realsense:SERIAL for one of several. Or the
            topics of ROS 2, ros2: or ros2:DEPTH_TOPIC,INFO_TOPIC,COLOR_TOPIC.
        out: folder for the results, made if it is missing.
        pictures: write DIR/contact_sheet.png, the skeletons, and DIR/people.png, how people were
            found, too.
        video: write DIR/overlay.mp4, the images with the skeletons over them, too.
        part_map: write DIR/part_maps.zip, too: whose each pixel is, and which part of the body, as
            two PNGs of each frame.
        format: write the skeletons in these formats, too, separated by commas: jsonl, parquet, bvh,
            trc, mot, c3d, glb, mcap, rrd; as DIR/skeletons.c3d, or as DIR/skeletons_person1.bvh for
            each person.
        mirrored: the images are flipped left-right, as OpenNI and the Kinect SDK give them by
            default; camera.json describes them as they are stored. They are flipped back: left is
            the person's left, and positions are in the frame of the camera as it really stood.
        gravity: three numbers that point down in the frame of the camera (x right, y down, z
            forward), as 0 0.97 0.26 for a camera that is tilted down by 15 degrees; it levels the
            world of the outputs, in place of the floor that is seen. Mirrored images are flipped
            back before.
        stream: send the skeletons to other programs meanwhile: osc:HOST:PORT, websocket:PORT (this
            machine alone, with a page at http://127.0.0.1:PORT/) or websocket:HOST:PORT; may be
            given several times.
        record: of a live camera: record the frames that are tracked to this new folder.
        view: show it in a browser, meanwhile and afterwards until Ctrl-C (needs topview[view]).
        offline: of a recording: look both ways in time, 5 seconds ahead and more. When all is
            tracked, it is tracked once more, backwards, which takes a third longer. Joints that
            were hidden are then told by what was seen before and after, and all is quieter;
            pictures and video show that. No live camera and no --stream, which cannot wait; --view
            shows what is tracked meanwhile.
        save_body: write what was learnt of everybody's stature and bones to this file; --body FILE
            takes it for another recording of the same people.
        force: replace the result that DIR holds, and the file of --save-body.
    """
    if offline:
        check_offline(source, stream)
    if view:
        check_viewer()
    formats = [format_named(name) for name in format.split(",") if name]
    prepare_output_folder(out)
    check_free(out, force=force)
    if save_body is not None:
        prepare_output_file("--save-body", save_body, force)
    recording, live = opened(source, record)
    if mirrored:
        recording = MirroredRecording(recording)
    tracker = Tracker(settings)
    sheets: dict[str, Sheet] = {}
    if pictures:
        name, count = recording.name, recording.frame_count
        sheets[CONTACT_SHEET] = ContactSheet(name, count)
        sheets[PEOPLE_SHEET] = PeopleSheet(name, count, lambda: tracker.finder.found)
    if video:
        sheets[OVERLAY] = OverlayVideo(out)
    if part_map:
        sheets[PART_MAPS] = PartMaps(out, tracker.part_map)
    seen = DepthRange()
    window = [opened_view(recording.name, tracker)] if view else []
    run = TrackingRun(recording, tracker, gravity, offline=offline)
    shown_last = [sheets[name] for name in (CONTACT_SHEET, OVERLAY) if offline and name in sheets]
    shown_first = [sheet for sheet in sheets.values() if sheet not in shown_last]
    failure: Exception | None = None
    try:
        with streams_opened(stream) as send, FramesFile(out / FRAMES_NAME, run.about) as frames:
            viewers = Viewers([*shown_first, *window, seen])
            follow_with_progress(run, recording, viewers, kept_and_sent(frames.append, send, live))
    except Exception as error:  # whatever it is, what was tracked is written before it is told
        failure = error
    if live is not None:
        live.close()
    warn(*recording.problems, *light_problems(tracker))
    kept = "nothing was tracked, nothing written"
    stored = StoredFrames(out / FRAMES_NAME) if run.frame_count else None
    if stored is not None and offline:
        stored = tracked_both_ways(stored, run, ended_early=failure is not None)
        if shown_last:
            show_again(recording, stored, Viewers(shown_last))
    if stored is not None:
        kept = f"the {stored.frame_count} frames tracked so far are kept in {out}"
        unwritten = write_result(stored, sheets, out, formats if stored.totals.people else ())
        print_people(recording.name, stored.totals)
        print_frames(run, recording, ended_early=failure is not None)
        if not unwritten:
            print(f"written to {out}")
        elif failure is None:
            raise InputError("; ".join(unwritten))
        warn(*unwritten)
        if save_body is not None:
            save_bodies(tracker, save_body)
    if window and failure is None and not run.interrupted:
        wait_for_end()
    if failure is not None:
        if stored is not None:
            warn(f"ended by an error: {kept}")
        raise failure
    if live is not None and stored is not None:
        print(live.told)
    if run.interrupted and live is None:
        warn(f"interrupted: {kept}")
        return INTERRUPTED
    if stored is None:
        count = "" if recording.frame_count is None else f"{recording.frame_count} "
        raise InputError(f"{source}: none of its {count}frames could be read")
    if not stored.totals.people:
        why = seen.problem or f"{seen.told}; if they do not, the unit of depth is wrong"
        raise NobodyFoundError(
            f"{source}: no person was found in {stored.frame_count} frames; {why}"
        )
    return 0


def check_offline(source: Path, stream: Sequence[str]) -> None:
    """Raises InputError where nobody can wait for what comes later."""
    if is_camera(str(source)):
        raise InputError(
            f"--offline {source}: a live camera shows nothing of what comes; it must be a "
            "recording: --record keeps one"
        )
    if stream:
        raise InputError(
            f"--stream {stream[0]}: sends each frame at once, and --offline waits for later ones; "
            "leave one of them out"
        )


def tracked_both_ways(stored: StoredFrames, run: TrackingRun, *, ended_early: bool) -> StoredFrames:
    """The frames looked at both ways, for which they are tracked backwards, too, unless the run has
    ended early. What ends that leaves what was tracked forward; Ctrl-C ends the run."""
    if not (ended_early or run.interrupted):
        again = with_progress(run.backwards(), "tracking backwards", stored.frame_count)
        try:
            return look_both_ways(stored, again)
        except InputError as error:
            warn(f"not tracked backwards: {error}")
        except KeyboardInterrupt:
            run.interrupted = True
    return look_both_ways(stored)


def save_bodies(tracker: Tracker, path: Path) -> None:
    """Write what was learnt of everybody, or tell that nothing was."""
    bodies = tracker.bodies()
    if bodies:
        write_bodies(bodies, path)
        print(f"bodies of {len(bodies)} people written to {path}")
    else:
        warn(f"{path} is not written: nobody was followed for {LEARNT_S:g} s")


def opened_view(name: str, tracker: Tracker) -> RerunView:
    """rerun's viewer, with whose each pixel is as the tracker sees it."""

    def labels(frame: Frame) -> NDArray[np.int32] | None:
        found = tracker.finder.found
        return None if found is None else label_image(found.users, frame.depth_m.shape)

    viewer = RerunView(name, labels)
    tell_address(viewer)
    return viewer


@contextmanager
def streams_opened(words: Sequence[str]) -> Iterator[list[Outlet]]:
    """The outlets of `--stream`, until the run ends."""
    with ExitStack() as open_ones:
        outlets = []
        for one in words:
            outlets.append(open_stream(one))
            open_ones.callback(outlets[-1].close)
        yield outlets
    warn(*(f"stream ended: {outlet.problem}" for outlet in outlets if outlet.problem))


def opened(source: Path, record: Path | None) -> tuple[Recording, LiveRecording | None]:
    """A recording; a camera is one too, and is given twice."""
    if is_camera(str(source)):
        live = open_camera(str(source), record)
        return live, live
    if record is not None:
        raise InputError(f"--record {record}: {source} is a recording already; leave it out")
    return open_recording(source), None


def kept_and_sent(
    keep: KeepFrame, outlets: Sequence[Outlet], live: LiveRecording | None
) -> KeepFrame:
    """Keeps a frame first; then it is sent."""

    def both(frame: TrackedFrame) -> None:
        keep(frame)
        if live is not None:
            live.note_written()
        for outlet in outlets:
            outlet.send(frame)

    return both


def light_problems(tracker: Tracker) -> list[str]:
    """What kept the colours from telling anything, a line for each reason."""
    return [
        f"{light} in {count} of {tracker.lights.total()} frames; its colours are not used there"
        for light, count in tracker.lights.items()
        if light not in (Light.USABLE, Light.ABSENT)
    ]
