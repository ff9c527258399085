"""Time the tracker's inner loops; the only place of `bench` that reaches into the tracker."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from statistics import median
from time import perf_counter
from typing import Final

import numpy as np

from topview.body.model import BodyModel
from topview.body.proportions import ANATOMICAL
from topview.camera.pyramid import DepthView, Pyramid
from topview.geometry.rotations import rotations_from_angles
from topview.kernels.threads import use_threads
from topview.people.finder import PeopleFinder
from topview.people.users import by_depth, label_image
from topview.records import Camera, Frame
from topview.score.utvr import Observed, placed_parts, score_hypotheses
from topview.track.evidence import Evidence, gather
from topview.track.methods.topview.refinement import RefinementSettings, refine
from topview.track.stances import STANDING, stand

KERNEL_RUNS: Final = 15
"""Calls that the median is taken over (ours)."""
STATURE_M: Final = 1.7
"""Of the body that is refined (ours)."""


@dataclass(frozen=True, slots=True)
class KernelTime:
    """Median of one call, in milliseconds."""

    name: str
    threads: int
    ms: float


def time_kernels(frame: Frame, camera: Camera, threads: int) -> list[KernelTime]:
    """Time scoring on a synthetic wall seen by `camera`, and refinement on the nearest person of a
    frame."""
    threads = use_threads(threads)
    evidence = _evidence_of_nearest(frame)
    model = BodyModel.of(STATURE_M, ANATOMICAL)
    pose = stand(model, evidence.head_camera, STANDING, 0.0, evidence.up_camera)
    settings = RefinementSettings()
    return [
        KernelTime(
            "uTVR, 256 hypotheses x (6,000 points + 12,000 rays)",
            threads,
            median_ms(_utvr_call(camera, threads)),
        ),
        KernelTime(
            f"refinement of one body, {settings.iterations} iterations",
            threads,
            median_ms(lambda: refine([pose], None, model, evidence, settings)),
        ),
    ]


def _evidence_of_nearest(frame: Frame) -> Evidence:
    """What the frame shows of the nearest person in it."""
    finder = PeopleFinder()
    image = Pyramid(frame)
    user = by_depth(finder.update(image))[0]
    return gather(user, image, label_image([user], frame.depth_m.shape), finder.floor)


def _utvr_call(camera: Camera, threads: int) -> Callable[[], object]:
    """A call that scores 256 upright cylinders 2 m away, of 76 x 157 pixels each at 640 x 480."""
    length_m, radii_m, distance_m = 0.6, np.array([0.145, 0.145]), 2.0
    rng = np.random.default_rng(0)
    wall = np.full((camera.height, camera.width), distance_m - 0.5 * radii_m[1], np.float32)
    view = DepthView(wall, camera.fx, camera.fy, camera.cx, camera.cy)
    observed = Observed.of(view, wall > 0.0)
    Rs = rotations_from_angles(rng.normal(0.0, 0.02, (256, 3)))
    origin = np.array([0.0, -length_m / 2, distance_m])
    no_parts = placed_parts(
        np.empty((0, 3, 3)), np.empty((0, 3)), np.empty(0), np.empty((0, 2))
    )  # fmt: skip
    return lambda: score_hypotheses(
        Rs, origin, length_m, radii_m, observed, no_parts, 0.05, threads
    )


def median_ms(call: Callable[[], object], runs: int = KERNEL_RUNS) -> float:
    """Of so many calls, after one that compiles."""
    call()
    times = []
    for _ in range(runs):
        start = perf_counter()
        call()
        times.append(1e3 * (perf_counter() - start))
    return median(times)
