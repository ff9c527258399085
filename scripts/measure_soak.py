"""Hours on end: does the memory grow, does a frame take longer?

    python scripts/measure_soak.py [--frames N] [--scene NAME]

Plays a scene of the simulator again and again, as one recording whose time goes on, and writes the
frames as `topview track` does it. Prints a line for each tenth of them: memory in use, in MB, the
median time of a frame, in ms, people so far, and the size of the file.
"""

from __future__ import annotations

import argparse
import resource
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from statistics import median
from time import perf_counter

from topview.io import FramesFile
from topview.records import Camera, Frame, Person
from topview.track import Tracker, TrackingRun
from topview_lab.sim import SimulatedRecording, scene_by_name


@dataclass
class Repeated:
    """A recording that plays the same frames until there are enough."""

    frames: list[Frame]
    frame_count: int
    camera: Camera
    name: str = "soak"
    problems: list[str] = field(default_factory=list)

    def __iter__(self) -> Iterator[Frame]:
        step_s = self.frames[1].timestamp_s - self.frames[0].timestamp_s
        for index in range(self.frame_count):
            frame = self.frames[index % len(self.frames)]
            yield Frame(index, index * step_s, frame.depth_m, frame.camera, frame.color)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--frames", type=int, default=20_000)
    parser.add_argument("--scene", default="enter_and_leave")
    options = parser.parse_args()
    scene = scene_by_name(options.scene)
    recording = Repeated(list(SimulatedRecording(scene)), options.frames, scene.camera)
    with tempfile.TemporaryDirectory() as folder:
        soak(recording, Path(folder) / "skeletons.frames")


def soak(recording: Repeated, path: Path) -> None:
    """Track it, and print what it takes."""
    run = TrackingRun(recording, Tracker())
    ids: set[int] = set()
    times_ms: list[float] = []
    last = perf_counter()
    print("frames  memory MB  ms/frame  people  file MB")

    def on_frame(frame: Frame, people: list[Person]) -> None:
        nonlocal last
        now = perf_counter()
        times_ms.append(1e3 * (now - last))
        last = now
        ids.update(person.id for person in people)
        if (frame.index + 1) % (recording.frame_count // 10) == 0:
            size_mb = path.stat().st_size / 1e6
            print(
                f"{frame.index + 1:6}  {memory_mb():9.0f}  {median(times_ms):8.1f}  "
                f"{len(ids):6}  {size_mb:7.1f}",
                flush=True,
            )
            times_ms.clear()

    with FramesFile(path, run.about) as file:
        run.follow(file.append, on_frame)


def memory_mb() -> float:
    """In use now; the most so far where the system does not tell."""
    if sys.platform == "linux":
        pages = int(Path("/proc/self/statm").read_text().split()[1])
        return pages * resource.getpagesize() / 1e6
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3


if __name__ == "__main__":
    main()
