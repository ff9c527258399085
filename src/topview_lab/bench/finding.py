"""Time the people finder alone, without tracking bodies."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from statistics import median
from time import perf_counter
from typing import Final

from topview.camera.pyramid import Pyramid
from topview.detect.detectors import DetectorName
from topview.kernels.threads import use_threads
from topview.people.finder import PeopleFinder, PeopleSettings
from topview.records import Frame
from topview_lab.bench.tracking import WARM_UP_FRAMES

CROWD_SCENE: Final = "four_users"
CROWD: Final = 4
"""People in `CROWD_SCENE`."""


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


def time_finding(frames: Sequence[Frame], detector: DetectorName, threads: int) -> FindingTime:
    """Find the people in frames of `CROWD_SCENE`; the first `WARM_UP_FRAMES` are not timed."""
    use_threads(threads)
    finder = PeopleFinder(PeopleSettings(detector=detector))
    for frame in frames[:WARM_UP_FRAMES]:
        finder.update(Pyramid(frame))
    times: list[float] = []
    stages: dict[str, list[float]] = defaultdict(list)
    for frame in frames[WARM_UP_FRAMES:]:
        start = perf_counter()
        finder.update(Pyramid(frame))
        times.append(1e3 * (perf_counter() - start))
        for name, seconds in finder.clock.seconds.items():
            stages[name].append(1e3 * seconds)
    camera = frames[0].camera
    stages_ms = {name: median(each) for name, each in stages.items()}
    return FindingTime(
        camera.width, camera.height, CROWD, detector, threads, median(times), stages_ms
    )
