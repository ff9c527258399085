"""Is everybody found as soon, whatever the rate of frames? A table of five rates.

    python scripts/measure_rates.py SOURCE... [--seconds S] [--scene-seed N]

SOURCE is a recording of 30 frames a second, whose frames are left out (5, 15) or shown several
times (60, 120), or a scene of the simulator, which is rendered at each rate. Prints when each
person is first tracked, in seconds, and how far the rates lie apart.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import replace
from itertools import takewhile
from pathlib import Path

from rich.console import Console
from rich.table import Table

import topview
from topview.records import Frame
from topview_lab.sim import SCENES, SimulatedRecording, scene_by_name

RATES = (5, 15, 30, 60, 120)
OWN_RATE = 30


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("sources", nargs="+")
    parser.add_argument("--seconds", type=float, default=5.0)
    parser.add_argument("--scene-seed", type=int, default=0)
    options = parser.parse_args()
    table = Table("source", "person", *(f"{rate} /s" for rate in RATES), "apart, s")
    for source in options.sources:
        found = [
            first_seen_s(frames_of(source, rate, options.scene_seed), options.seconds)
            for rate in RATES
        ]
        for person in sorted(set().union(*found)):
            times_s = [times.get(person, float("nan")) for times in found]
            cells = [f"{time_s:.2f}" for time_s in times_s]
            apart_s = max(times_s) - min(times_s)
            table.add_row(Path(source).name, str(person), *cells, f"{apart_s:.2f}")
    Console(width=120).print(table)


def frames_of(source: str, rate: int, seed: int) -> Iterator[Frame]:
    """The source's frames as they come at a rate."""
    if source in SCENES:
        scene = scene_by_name(source, seed=seed)
        frames = round(scene.frames * rate / scene.fps)
        yield from SimulatedRecording(replace(scene, fps=rate, frames=frames))
        return
    index = 0
    for n, frame in enumerate(topview.open(source)):
        times = rate // OWN_RATE if rate >= OWN_RATE else int(n % (OWN_RATE // rate) == 0)
        for k in range(times):
            yield replace(frame, index=index, timestamp_s=frame.timestamp_s + k / rate)
            index += 1


def first_seen_s(frames: Iterator[Frame], seconds: float) -> dict[int, float]:
    """When each person was first tracked, by the id."""
    tracker = topview.Tracker()
    first: dict[int, float] = {}
    for frame in takewhile(lambda frame: frame.timestamp_s < seconds, frames):
        for person in tracker.update(frame):
            first.setdefault(person.id, frame.timestamp_s)
    return first


if __name__ == "__main__":
    main()
