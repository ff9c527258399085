"""`topview demo`: two simulated people, tracked, and compared with the truth."""

from __future__ import annotations

from itertools import islice
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated

from cyclopts import Parameter

from topview.cli.printing import plain_console
from topview.cli.progress import compile_kernels, follow_with_progress, progress_bar, warn
from topview.cli.results import CONTACT_SHEET, write_results
from topview.cli.status import INTERRUPTED
from topview.io import open_recording, prepare_output_folder
from topview.records import Recording
from topview.skeletons import SkeletonSequence, TrackedFrame
from topview.track import Tracker, TrackerSettings, TrackingRun
from topview.view import ContactSheet
from topview_lab.bench.tracking import TWO_USERS_SCENE, WARM_UP_FRAMES
from topview_lab.datasets import read_groundtruth
from topview_lab.evaluate.report import print_brief, print_report
from topview_lab.metrics import evaluate_sequence
from topview_lab.sim import scene_by_name, write_scene

SCENE = TWO_USERS_SCENE


def demo(
    *,
    out: Path = Path("out/demo"),
    seed: int = 0,
    frames: int = 120,
    detail: Annotated[bool, Parameter(negative="")] = False,
) -> int:
    """Simulate two people, track them, and print the error against the truth.

    One walks past in front of the other, before a Kinect-like camera. Writes skeletons.npz,
    skeletons.csv and contact_sheet.png.

    Args:
        out: folder for the results, made if it is missing.
        seed: of the simulated people and of the tracker.
        frames: how many, at 30 a second.
        detail: print the errors of every joint and angle, too.
    """
    settings = TrackerSettings(seed=seed)
    prepare_output_folder(out)
    with TemporaryDirectory(prefix="topview-demo-") as folder:
        room = Path(folder) / SCENE
        _simulate(room, seed, frames)
        recording = open_recording(room)
        compile_kernels()
        _warm_up(recording, settings)
        sheet = ContactSheet("topview demo: two simulated people", recording.frame_count)
        run = TrackingRun(recording, Tracker(settings))
        tracked: list[TrackedFrame] = []
        follow_with_progress(run, recording, sheet, tracked.append)
        skeletons = SkeletonSequence.from_frames(tracked, run.about)
        truth = read_groundtruth(room / "groundtruth.npz")
    write_results(skeletons, {CONTACT_SHEET: sheet}, out)
    if tracked:
        evaluation = evaluate_sequence(skeletons, truth, SCENE, run.seconds)
        tell = print_report if detail else print_brief
        tell(evaluation, plain_console(), "error against the simulated truth")
    print(f"look at {out / CONTACT_SHEET}; the skeletons are beside it")
    if run.interrupted:
        warn(f"interrupted: the {len(tracked)} frames tracked so far are kept in {out}")
        return INTERRUPTED
    return 0


def _simulate(folder: Path, seed: int, frames: int) -> None:
    scene = scene_by_name(SCENE, seed=seed, frames=frames)
    with progress_bar() as progress:
        bar = progress.add_task("simulating", total=scene.frames)
        write_scene(scene, folder, on_frame=lambda _: progress.advance(bar))


def _warm_up(recording: Recording, settings: TrackerSettings) -> None:
    """Have the inner loops loaded before the clock runs."""
    tracker = Tracker(settings)
    for frame in islice(recording, WARM_UP_FRAMES):
        tracker.update(frame)
