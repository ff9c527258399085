"""A day of passers-by: how much memory and disk the frames and the result take.

    python scripts/measure_day.py [--hours H] [--out FOLDER]

Made people, no images: 30 frames a second, somebody every two minutes for ten seconds, and three
at once every half hour. Frames are appended as `topview track` does it, then the result is made of
them, and it is read again in blocks. Prints what each step took, as lines of `name value`.
"""

from __future__ import annotations

import argparse
import resource
import tempfile
from collections.abc import Iterator
from pathlib import Path
from time import perf_counter

import numpy as np

from topview import JOINT_NAMES, PART_NAMES
from topview.io import (
    FramesFile,
    SkeletonFile,
    StoredFrames,
    write_skeletons_csv,
    write_skeletons_npz,
)
from topview.skeletons import About, TrackedFrame

FRAMES_PER_S = 30
PERSON_EVERY_S, PERSON_STAYS_S = 120, 10
THREE_EVERY_S = 1800
ABOUT = About(JOINT_NAMES, PART_NAMES)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--hours", type=float, default=24.0)
    parser.add_argument("--out", type=Path, help="keep the files there")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        measure(options.out or Path(folder), round(options.hours * 3600 * FRAMES_PER_S))


def measure(out: Path, frames: int) -> None:
    """Write and read that many frames."""
    out.mkdir(parents=True, exist_ok=True)
    path = out / "skeletons.frames"
    start = perf_counter()
    with FramesFile(path, ABOUT) as file:
        for frame in made_frames(frames):
            file.append(frame)
    told("append_s", perf_counter() - start)
    start = perf_counter()
    stored = StoredFrames(path)
    write_skeletons_npz(stored, out / "skeletons.npz")
    write_skeletons_csv(stored, out / "skeletons.csv")
    told("result_s", perf_counter() - start)
    start = perf_counter()
    read = seen = 0
    for block in SkeletonFile(out / "skeletons.npz").blocks():
        read += len(block.frame_index)
        seen += int(block.present.sum())
    told("read_s", perf_counter() - start)
    told("frames", read)
    told("person_frames", seen)
    told("people", len(stored.totals.people))
    told("slots", stored.totals.slots)
    for name in ("skeletons.frames", "skeletons.npz", "skeletons.csv"):
        told(f"{name}_mb", (out / name).stat().st_size / 1e6)
    told("memory_mb", most_memory_kb() / 1e3)


def most_memory_kb() -> float:
    """The most that this program has held. Linux counts what its parent held in `ru_maxrss`."""
    status = Path("/proc/self/status")
    if status.exists():
        fields = dict(line.split(":", 1) for line in status.read_text().splitlines())
        return float(fields["VmHWM"].split()[0])
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


def told(name: str, value: float) -> None:
    print(f"{name} {value:.6g}", flush=True)


def made_frames(count: int) -> Iterator[TrackedFrame]:
    """Frames with whoever is there."""
    rng = np.random.default_rng(0)
    for index in range(count):
        people = np.zeros(0, ABOUT.person_type)
        second = index // FRAMES_PER_S
        if second % PERSON_EVERY_S < PERSON_STAYS_S:
            at_once = 3 if second % THREE_EVERY_S < PERSON_STAYS_S else 1
            people = np.zeros(at_once, ABOUT.person_type)
            people["id"] = 3 * (second // PERSON_EVERY_S) + 1 + np.arange(at_once)
            people["height_m"] = 1.7
            for name in ("joints_camera", "Ts_camera_part"):  # as hard to compress as real ones
                people[name] = rng.normal(size=people[name].shape)
            people["joint_state"] = 1
            people["joint_confidence"] = rng.random(people["joint_confidence"].shape)
        yield TrackedFrame(index, index / FRAMES_PER_S, f"{index:06d}.png", people)


if __name__ == "__main__":
    main()
