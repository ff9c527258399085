"""Does the tracker tell the time? Scenes of the simulator against every second of their frames.

    python scripts/measure_half_rate.py SCENE... [--scene-seed S] [--method M] [--seed S]

Prints how far the joints on common frames lie apart, median and 95 % in cm, and whether the
identities are the same.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence

import numpy as np

from topview.records import Frame, Person
from topview.track import Tracker, TrackerSettings
from topview_lab.sim import SimulatedRecording, scene_by_name


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("scenes", nargs="+")
    parser.add_argument("--scene-seed", type=int, default=0)
    parser.add_argument("--method", default=TrackerSettings().method)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    settings = TrackerSettings(method=options.method, seed=options.seed)
    for name in options.scenes:
        frames = list(SimulatedRecording(scene_by_name(name, seed=options.scene_seed)))
        print(f"{name}: {told(tracked(frames, settings), tracked(frames[::2], settings))}")


def tracked(frames: Sequence[Frame], settings: TrackerSettings) -> dict[float, dict[int, Person]]:
    """People by identity, by timestamp."""
    tracker = Tracker(settings)
    return {
        frame.timestamp_s: {person.id: person for person in tracker.update(frame)}
        for frame in frames
    }


def told(full: dict[float, dict[int, Person]], half: dict[float, dict[int, Person]]) -> str:
    apart_cm = [
        100 * np.linalg.norm(person.joints_camera - full[time_s][key].joints_camera, axis=1)
        for time_s, people in half.items()
        for key, person in people.items()
        if key in full[time_s]
    ]
    same = all(people.keys() == full[time_s].keys() for time_s, people in half.items())
    median, most = np.quantile(apart_cm, [0.5, 0.95])
    identities = "the same identities" if same else "other identities"
    return f"{median:.2f} cm (median), {most:.2f} cm (95 %), {identities}"


if __name__ == "__main__":
    main()
