"""`topview bench`: where the time goes on this machine."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, replace
from itertools import product
from pathlib import Path
from typing import Annotated, Any, Final

from cyclopts import Parameter
from rich.table import Table

from topview.cli.outputs import prepare_output_file
from topview.cli.printing import plain_console
from topview.cli.progress import compile_kernels, progress_bar, warn
from topview.detect.joints.proposers import ProposalsName
from topview.io import MirroredRecording, open_recording
from topview.io.writers import write_atomically
from topview.records import Camera, Frame, InputError
from topview.track.settings import TrackerSettings
from topview_lab.bench.finding import CROWD, CROWD_SCENE, time_finding
from topview_lab.bench.inner_loops import time_kernels
from topview_lab.bench.machine import Machine
from topview_lab.bench.recording import TimedRecording, time_recording
from topview_lab.bench.tables import (
    finding_table,
    kernel_table,
    people_table,
    recording_stage_table,
    stage_table,
    tracking_table,
)
from topview_lab.bench.tracking import (
    TWO_USERS_SCENE,
    TrackingTime,
    simulated_frames,
    summarise_times,
    time_frames,
)
from topview_lab.sim.scenes import KINECT_V1_FULL, KINECT_V1_HALF

DEFAULTS = TrackerSettings()

SCENE_FRAMES: Final = 40
MOST_SCENE_FRAMES: Final = 120
"""Frames of a simulated scene: if not given, and at most (ours)."""


def bench(
    source: Path | None = None,
    /,
    *,
    frames: int | None = None,
    proposals: ProposalsName = DEFAULTS.proposals,
    mirrored: Annotated[bool, Parameter(negative="")] = False,
    json_file: Annotated[Path | None, Parameter(name="--json")] = None,
    force: Annotated[bool, Parameter(negative="")] = False,
) -> None:
    """Measure the tracker's speed, with one thread and with all.

    With SOURCE, on that recording: per frame, per person, and in each stage. Without, on the
    demo's scene with one person and with two, at 320 x 240 and 640 x 480; then finding four people
    without tracking them, by depth alone and with colour; then the inner loops alone. Compiling,
    reading and the first three frames are left out. NUMBA_NUM_THREADS, where it is set, limits the
    threads.

    Args:
        source: a recording, as `topview track` reads it.
        frames: to time: of SOURCE all if not given; of each scene 40, at most 120.
        proposals: what proposes joints, if the tracker asks for it.
        mirrored: the images of SOURCE are flipped left-right, as for `topview track`.
        json_file: file for all numbers.
        force: replace the file that is there.
    """
    _check_frames(frames, MOST_SCENE_FRAMES if source is None else None)
    if mirrored and source is None:
        raise InputError("--mirrored is given without SOURCE; it must go with a recording")
    if json_file is not None:
        prepare_output_file("--json", json_file, force)
    settings = TrackerSettings(proposals=proposals)
    compile_kernels()
    if source is None:
        machine = Machine.here()
        numbers = _bench_scenes(machine, SCENE_FRAMES if frames is None else frames, settings)
    else:
        recording = open_recording(source)
        if mirrored:
            recording = MirroredRecording(recording)
        machine = Machine.here()
        passes = len(machine.thread_counts)
        with progress_bar() as progress:
            expected = [n for n in (recording.frame_count, frames) if n is not None]
            total = passes * min(expected) if expected else None
            bar = progress.add_task(f"timing {recording.name}", total=total)
            timed = time_recording(
                recording, machine.thread_counts, frames, lambda: progress.advance(bar), settings
            )
        warn(*timed.problems)
        _print(machine, [people_table(timed), recording_stage_table(timed)], _used_frames(timed))
        numbers = {"recording": asdict(timed)}
    if json_file is not None:
        text = json.dumps({"machine": asdict(machine), **numbers}, indent=2) + "\n"
        write_atomically(json_file, text.encode())


def _check_frames(frames: int | None, most: int | None) -> None:
    if frames is not None and not 1 <= frames <= (most or frames):
        right = "1 or more" if most is None else f"1 to {most}"
        raise InputError(f"--frames is {frames}; it must be {right}")


def _bench_scenes(machine: Machine, frames: int, settings: TrackerSettings) -> dict[str, Any]:
    """Measure and print the simulated scenes; gives the numbers for the file."""
    tracking: list[TrackingTime] = []
    for camera, people in product((KINECT_V1_HALF, KINECT_V1_FULL), (1, 2)):
        simulated = _simulate(camera, people, frames)
        tracking += [
            summarise_times(
                list(time_frames(simulated, replace(settings, threads=threads))),
                camera,
                threads,
                people,
            )
            for threads in machine.thread_counts
        ]
    crowd = _simulate(KINECT_V1_FULL, CROWD, frames, CROWD_SCENE)
    finding = [
        time_finding(crowd, detector, threads)
        for detector, threads in product(("depth", "auto"), machine.thread_counts)
    ]
    someone = next(simulated_frames(KINECT_V1_FULL, people=1, frames=0))
    kernels = [
        time
        for threads in machine.thread_counts
        for time in time_kernels(someone, KINECT_V1_FULL, threads)
    ]
    tables = [
        tracking_table(tracking),
        stage_table(tracking),
        finding_table(finding),
        kernel_table(kernels),
    ]
    _print(machine, tables)
    return {
        "tracking": [asdict(time) for time in tracking],
        "finding": [asdict(time) for time in finding],
        "kernels": [asdict(time) for time in kernels],
    }


def _simulate(
    camera: Camera, people: int, frames: int, scene_name: str = TWO_USERS_SCENE
) -> list[Frame]:
    with progress_bar() as progress:
        made = simulated_frames(camera, people, frames, scene_name)
        return list(progress.track(made, description="simulating"))


def _used_frames(timed: TimedRecording) -> str:
    """Which frames of a recording were timed."""
    size = f"{timed.tracking[0].width} x {timed.tracking[0].height}"
    color = "with colour" if timed.colored_frames else "without colour"
    if 0 < timed.colored_frames < timed.frames:
        color = f"{timed.colored_frames} of them with colour"
    numbers = f"frame {timed.first_frame}"
    if timed.frames > 1:
        numbers = f"frames {timed.first_frame} to {timed.last_frame}"
    return (
        f"{timed.name}: {size}, {timed.frames} timed: {numbers}, {color}; "
        f"the {timed.warm_up_frames} before warm up"
    )


def _print(machine: Machine, tables: Sequence[Table], used_frames: str = "") -> None:
    print(machine)
    if used_frames:
        print(used_frames)
    console = plain_console()
    for table in tables:
        console.print(table)
