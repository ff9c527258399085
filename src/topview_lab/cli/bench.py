"""`topview bench`: where the time goes on this machine."""

from __future__ import annotations

import json
import os
import platform
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass
from itertools import islice, product
from pathlib import Path
from statistics import median
from time import perf_counter
from typing import Annotated

import numpy as np
from cyclopts import Parameter
from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table

from topview.body.model import BodyModel
from topview.body.proportions import ANATOMICAL
from topview.camera.pyramid import DepthView, Pyramid
from topview.cli.progress import compile_kernels, progress_bar
from topview.detect.detectors import DetectorName
from topview.geometry.rotations import rotations_from_angles
from topview.io.writers import prepare_output_folder, write_atomically
from topview.kernels.threads import use_threads
from topview.people.finder import PeopleFinder, PeopleSettings
from topview.people.users import by_depth, label_image
from topview.records import Camera, Frame, InputError
from topview.score.utvr import placed_parts, score_hypotheses
from topview.timing import StageClock
from topview.track import Tracker, TrackerSettings
from topview.track.evidence import Evidence, gather
from topview.track.methods.topview.refinement import RefinementSettings, refine
from topview.track.stances import STANDING, stand
from topview_lab.cli.demo import SCENE, WARM_UP_FRAMES
from topview_lab.sim import SimulatedRecording, scene_by_name
from topview_lab.sim.scenes import KINECT_V1_HALF

KINECT_V1 = Camera(fx=525, fy=525, cx=319.5, cy=239.5, width=640, height=480)  # nominal
CROWD_SCENE, CROWD = "four_users", 4
KERNEL_RUNS = 15  # the median of so many is told


@dataclass(frozen=True, slots=True)
class Machine:
    """What was measured on."""

    cpu: str
    cores: int
    threads: int  # that the kernels may use


@dataclass(frozen=True, slots=True)
class TrackingTime:
    """Medians over the frames of one scene, in milliseconds.

    Attributes:
        people: in the scene.
        ms_per_person: a frame's time over the number of people tracked in it; None if nobody was.
        stages_ms: over the frames in which the stage ran.
    """

    width: int
    height: int
    people: int
    threads: int
    frames: int
    ms_per_frame: float
    ms_per_person: float | None
    stages_ms: dict[str, float]


@dataclass(frozen=True, slots=True)
class FindingTime:
    """Medians over the frames of one scene, in milliseconds, of finding people without tracking
    their bodies."""

    width: int
    height: int
    people: int
    detector: DetectorName
    threads: int
    ms_per_frame: float
    stages_ms: dict[str, float]


@dataclass(frozen=True, slots=True)
class KernelTime:
    """Median of one call, in milliseconds."""

    name: str
    threads: int
    ms: float


def bench(
    *, frames: int = 40, json_file: Annotated[Path | None, Parameter(name="--json")] = None
) -> None:
    """Measure the tracker's speed on the demo's scene, with one thread and with all.

    One person and two, at 320 x 240 and 640 x 480; then finding four people without tracking
    them, by depth alone and with colour; then the inner loops alone. Compiling is left out.
    NUMBA_NUM_THREADS, where it is set, limits the threads.

    Args:
        frames: measured in each scene, up to 120.
        json_file: file for all numbers.
    """
    if not 1 <= frames <= 120:
        raise InputError(f"--frames is {frames}; it must be 1 to 120")
    if json_file is not None:
        if json_file.is_dir():
            raise InputError(f"--json {json_file} is a folder; it must be a file")
        prepare_output_folder(json_file.parent)
    compile_kernels()
    machine = Machine(_cpu_model(), os.cpu_count() or 1, use_threads(0))
    threads = sorted({1, machine.threads})
    tracking: list[TrackingTime] = []
    for camera, people in product((KINECT_V1_HALF, KINECT_V1), (1, 2)):
        filmed = _filmed(camera, people, frames)
        tracking += [_time_tracking(filmed, people, count) for count in threads]
    crowd = _filmed(KINECT_V1, CROWD, frames, CROWD_SCENE)
    finding = [
        _time_finding(crowd, detector, count)
        for detector, count in product(("depth", "auto"), threads)
    ]
    someone = _filmed(KINECT_V1, people=1, frames=0)[0]
    kernels = [time for count in threads for time in _time_kernels(someone, count)]
    _print(machine, tracking, finding, kernels, Console())
    if json_file is not None:
        _write(json_file, machine, tracking, finding, kernels)


def _filmed(camera: Camera, people: int, frames: int, scene_name: str = SCENE) -> list[Frame]:
    """The scene's frames, those to warm up with first."""
    scene = scene_by_name(scene_name, camera=camera, people=people, frames=WARM_UP_FRAMES + frames)
    with progress_bar() as progress:
        return list(progress.track(SimulatedRecording(scene), description="simulating"))


def _time_tracking(filmed: Sequence[Frame], people: int, threads: int) -> TrackingTime:
    tracker = Tracker(TrackerSettings(threads=threads))
    rest = iter(filmed)
    for frame in islice(rest, WARM_UP_FRAMES):  # compiles, finds the people, starts their poses
        tracker.update(frame)
    tracker.clock = StageClock()
    timed = list(_timed_updates(tracker, rest))
    camera = filmed[0].camera
    return TrackingTime(
        camera.width,
        camera.height,
        people,
        threads,
        len(timed),
        median(ms for ms, _ in timed),
        median(shares) if (shares := [ms / found for ms, found in timed if found]) else None,
        {name: 1e3 * median(seconds) for name, seconds in tracker.clock.seconds.items()},
    )


def _timed_updates(tracker: Tracker, frames: Iterator[Frame]) -> Iterator[tuple[float, int]]:
    """Milliseconds, and how many people were tracked, for each frame."""
    for frame in frames:
        start = perf_counter()
        found = len(tracker.update(frame))
        yield 1e3 * (perf_counter() - start), found


def _time_finding(filmed: Sequence[Frame], detector: DetectorName, threads: int) -> FindingTime:
    use_threads(threads)
    finder = PeopleFinder(PeopleSettings(detector=detector))
    for frame in filmed[:WARM_UP_FRAMES]:
        finder.update(Pyramid(frame))
    finder.clock.seconds.clear()
    times, people = [], 0
    for frame in filmed[WARM_UP_FRAMES:]:
        start = perf_counter()
        people = len(finder.update(Pyramid(frame)))
        times.append(1e3 * (perf_counter() - start))
    camera = filmed[0].camera
    stages_ms = {name: 1e3 * median(seconds) for name, seconds in finder.clock.seconds.items()}
    return FindingTime(
        camera.width, camera.height, people, detector, threads, median(times), stages_ms
    )


def _time_kernels(frame: Frame, threads: int) -> list[KernelTime]:
    threads = use_threads(threads)
    evidence = _evidence_of_someone(frame)
    model = BodyModel.of(1.7, ANATOMICAL)
    pose = stand(model, evidence.head_camera, STANDING, 0.0, evidence.up_camera)
    settings = RefinementSettings()
    return [
        KernelTime(
            "uTVR, 256 hypotheses x (6,000 points + 12,000 rays)",
            threads,
            _median_ms(_utvr_workload(threads)),
        ),
        KernelTime(
            f"refinement of one body, {settings.iterations} iterations",
            threads,
            _median_ms(lambda: refine([pose], None, model, evidence, settings)),
        ),
    ]


def _evidence_of_someone(frame: Frame) -> Evidence:
    """Of the nearest person in a frame."""
    finder = PeopleFinder()
    image = Pyramid(frame)
    user = by_depth(finder.update(image))[0]
    return gather(user, image, label_image([user], frame.depth_m.shape), finder.floor)


def _utvr_workload(threads: int) -> Callable[[], object]:
    """Score 256 upright cylinders, 2 m away at 640 x 480, of 76 x 157 pixels each."""
    length_m, radii_m, distance_m = 0.6, np.array([0.145, 0.145]), 2.0
    rng = np.random.default_rng(0)
    angle, y = rng.uniform(-np.pi, 0.0, 6000), rng.uniform(0.0, length_m, 6000)
    x, z = radii_m[0] * np.cos(angle), radii_m[1] * np.sin(angle)
    points = (
        x.astype(np.float32),
        (y - length_m / 2).astype(np.float32),
        (distance_m + z).astype(np.float32),
    )
    c = KINECT_V1
    wall = np.full((c.height, c.width), distance_m - radii_m[1], np.float32)
    view = DepthView(wall, c.fx, c.fy, c.cx, c.cy)
    Rs = rotations_from_angles(rng.normal(0.0, 0.02, (256, 3)))
    origin = np.array([0.0, -length_m / 2, distance_m])
    nothing = placed_parts(
        np.empty((0, 3, 3)), np.empty((0, 3)), np.empty(0), np.empty((0, 2))
    )  # fmt: skip
    return lambda: score_hypotheses(
        Rs, origin, length_m, radii_m, points, view, nothing, 0.05, threads
    )


def _median_ms(call: Callable[[], object]) -> float:
    call()  # compiles
    times = []
    for _ in range(KERNEL_RUNS):
        start = perf_counter()
        call()
        times.append(1e3 * (perf_counter() - start))
    return median(times)


def _cpu_model() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        lines = []
    named = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return named[0] if named else platform.processor() or platform.machine()


def _print(
    machine: Machine,
    tracking: Sequence[TrackingTime],
    finding: Sequence[FindingTime],
    kernels: Sequence[KernelTime],
    console: Console,
) -> None:
    cores = f"{machine.cores} core{'s' if machine.cores > 1 else ''}"
    print(f"{machine.cpu}, {cores}; the kernels may use {machine.threads} of them")
    for table in (
        _tracking_table(tracking),
        _stage_table(tracking),
        _finding_table(finding),
        _kernel_table(kernels),
    ):
        console.print(table)


def _tracking_table(tracking: Sequence[TrackingTime]) -> Table:
    title = "tracking, median over the frames"
    columns = ("people", "threads", "ms/frame", "ms/person", "frames/s", "share of 1 thread's")
    table = _table(title, "image", columns)
    for time in tracking:
        alone = next(t for t in tracking if _scene(t) == _scene(time) and t.threads == 1)
        table.add_row(
            *_scene(time),
            str(time.threads),
            f"{time.ms_per_frame:.1f}",
            "-" if time.ms_per_person is None else f"{time.ms_per_person:.1f}",
            f"{1e3 / time.ms_per_frame:.1f}",
            f"{time.ms_per_frame / alone.ms_per_frame:.2f}",
        )
    return table


def _stage_table(tracking: Sequence[TrackingTime]) -> Table:
    stages = list(dict.fromkeys(name for time in tracking for name in time.stages_ms))
    table = _table("ms per frame in each stage", "image", ("people", "threads", *stages))
    for time in tracking:
        row = [f"{time.stages_ms[name]:.1f}" if name in time.stages_ms else "-" for name in stages]
        table.add_row(*_scene(time), str(time.threads), *row)
    return table


def _finding_table(finding: Sequence[FindingTime]) -> Table:
    stages = list(dict.fromkeys(name for time in finding for name in time.stages_ms))
    columns = ("people", "detector", "threads", "ms/frame", *stages)
    table = _table("finding people without tracking them, ms per frame", "image", columns)
    for time in finding:
        row = [f"{time.stages_ms[name]:.1f}" if name in time.stages_ms else "-" for name in stages]
        total = f"{time.ms_per_frame:.1f}"
        table.add_row(*_scene(time), time.detector, str(time.threads), total, *row)
    return table


def _kernel_table(kernels: Sequence[KernelTime]) -> Table:
    table = _table("inner loops, median over the calls", "loop", ("threads", "ms"))
    for time in kernels:
        table.add_row(time.name, str(time.threads), f"{time.ms:.2f}")
    return table


def _table(title: str, first: str, others: Sequence[str]) -> Table:
    table = Table(
        first,
        title=title,
        title_justify="left",
        box=SIMPLE_HEAD,
        pad_edge=False,
        padding=(0, 1, 0, 0),
    )
    for column in others:
        table.add_column(column, justify="right")
    return table


def _scene(time: TrackingTime | FindingTime) -> tuple[str, str]:
    return f"{time.width}x{time.height}", str(time.people)


def _write(
    file: Path,
    machine: Machine,
    tracking: Sequence[TrackingTime],
    finding: Sequence[FindingTime],
    kernels: Sequence[KernelTime],
) -> None:
    numbers = {
        "machine": asdict(machine),
        "tracking": [asdict(time) for time in tracking],
        "finding": [asdict(time) for time in finding],
        "kernels": [asdict(time) for time in kernels],
    }
    write_atomically(file, (json.dumps(numbers, indent=2) + "\n").encode())
