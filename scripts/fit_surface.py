"""What shape have people in their clothes? Prints `DRESSED` and `BETWEEN` of
`topview.body.shapes`.

    python scripts/fit_surface.py FOLDER... [--every N] [--rounds N]

Puts a body at the true joints of the one person in each recording with a `groundtruth.npz`, with
bones of the true lengths, and asks of every N-th frame how much of the points its surface leaves
unexplained, as refinement counts it. Every number of the shapes is moved up and down, and kept
where that is less, in steps that are halved; so is how much farther out than most each person's
surface lies, which is thrown away. Recordings are of people of known stature.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
from fit_head_before import StandingSettings
from numpy.typing import NDArray

from topview.body import JOINT_NAMES, PART_NAMES
from topview.body.shapes import BETWEEN, DRESSED, of_both_sides
from topview.body.surface import Between, Surface
from topview.camera import undistorted
from topview.detect.joints import JointProposals
from topview.kernels.body import assign_points
from topview.track import Tracker, TrackerSettings
from topview.track.bone_lengths import BoneLengths
from topview.track.evidence import Evidence
from topview.track.joint_fit import JointFitSettings, fit_joints
from topview.track.methods.topview.refinement import RefinementSettings
from topview_lab.datasets import FolderRecording

Array = NDArray[np.float64]

SURE_M: Final = 0.01
"""Scale of a true joint: bodies have their joints a little elsewhere."""
STEPS: Final = 0.008, 0.004, 0.002, 0.001
"""Shares of the stature."""
RADII: Final = [
    *(6 * part + axis for part in range(len(DRESSED)) for axis in range(4)),
    *(6 * len(DRESSED) + number for number in (0, 1, 3)),
]
"""Which numbers a thicker body has larger."""


@dataclass(frozen=True, eq=False)
class Look:
    """One frame of somebody.

    Attributes:
        who: number of the recording.
        stature_m: true.
        lengths_m, joints_parent, Rs, origins: of the body at the true joints.
        points, normals: [N, 3] and [N, 3], camera frame.
    """

    who: int
    stature_m: float
    lengths_m: Array
    joints_parent: Array
    Rs: Array
    origins: Array
    points: Array
    normals: Array


def proposed(joints_camera: Array) -> JointProposals:
    """True [16, 3] joints as somebody's only mode."""
    return JointProposals(
        joints_camera[None, None],
        np.full((1, 1, len(joints_camera), 3), SURE_M),
        np.ones((1, 1)),
        np.ones(1),
        JOINT_NAMES,
    )


def looks(folder: Path, who: int, every: int) -> list[Look]:
    """At the person of a recording, where all true joints are known."""
    recording = FolderRecording(folder)
    truth = recording.reference()
    order = [truth.joint_names.index(name) for name in JOINT_NAMES]
    true_camera = dict(zip(truth.frame_index.tolist(), truth.joints_camera[:, 0], strict=True))
    stature_m = float(np.load(folder / "groundtruth.npz")["stature"][0])
    seen: list[tuple[Evidence, float]] = []
    tracker = Tracker(TrackerSettings(method="utvr"), body=StandingSettings(seen))
    bones, kept = BoneLengths(), list[tuple[Evidence, JointProposals]]()
    for number, frame in enumerate(map(undistorted, recording.open())):
        seen.clear()
        tracker.update(frame)
        joints = true_camera.get(frame.index, np.full((1, 3), np.nan))
        if number % every or len(seen) != 1 or not np.isfinite(joints).all():
            continue
        proposals = proposed(joints[order])
        bones.update(proposals, 0, stature_m)
        kept.append((seen[0][0].with_normals().thinned(), proposals))
    model = bones.model(stature_m)
    found = []
    for evidence, proposals in kept:
        (pose,) = fit_joints(model, proposals, JointFitSettings()).poses
        body = model.lengths_m, model.joints_parent, pose.Rs, pose.origins(model)
        found.append(Look(who, stature_m, *body, evidence.points_camera, evidence.normals_camera))
    return found


def surface_of(shares: Array, look: Look) -> Surface:
    """Of numbers [48] as `start` has them."""
    parts = dict(zip(DRESSED, shares[: 6 * len(DRESSED)].reshape(-1, 6), strict=True))
    surface = Surface.of_parts(look.lengths_m, of_both_sides(parts) * look.stature_m)
    between = Between(*map(tuple, shares[6 * len(DRESSED) :].reshape(2, 3)))
    return surface.with_between(between, look.stature_m, look.joints_parent)


def start() -> Array:
    """[48] the numbers that ship, one after the other."""
    return np.concatenate([*DRESSED.values(), *BETWEEN])


def unexplained(look: Look, surface: Surface, settings: RefinementSettings) -> float:
    """Share of the points that the surface leaves unexplained."""
    N = len(look.points)
    labels, off = np.full(N, -1, np.int32), np.empty(N)
    assign_points(
        look.points, look.normals, *surface.placed(look.Rs, look.origins), surface.lengths_m,
        surface.shapes_m, settings.reach_m, labels, np.empty(N), np.empty((N, 3)), off,
    )  # fmt: skip
    explained = np.where(labels < 0, 0.0, 1.0 / (1.0 + (off / settings.scale_m) ** 2))
    return 1.0 - float(explained.mean())


def fit(several: Sequence[Look], rounds: int, tell: Callable[[str], None]) -> Array:
    """[48] with which the looks leave least unexplained, each person counting alike."""
    settings, shares = RefinementSettings(), start()
    thickness_m = np.zeros(max(look.who for look in several) + 1)
    counts = np.bincount([look.who for look in several])
    mean_stature_m = float(np.mean([look.stature_m for look in several]))

    def costs(shares: Array, thickness_m: Array) -> Array:
        """[people] mean of each one's looks."""
        own = np.zeros(len(counts))
        for look in several:
            by_m = np.full(len(PART_NAMES), thickness_m[look.who])
            own[look.who] += unexplained(look, surface_of(shares, look).thicker(by_m), settings)
        return own / np.maximum(counts, 1)

    own = costs(shares, thickness_m)
    for number in range(rounds):
        step = STEPS[min(number, len(STEPS) - 1)]
        for way_m in (-step, step):
            tried = costs(shares, thickness_m + way_m)
            thickness_m = np.where(tried < own, thickness_m + way_m, thickness_m)
            own = np.minimum(own, tried)
        mean_m = float(thickness_m.mean())  # as most are is what is fitted
        shares[RADII] += mean_m / mean_stature_m
        thickness_m = thickness_m - mean_m
        own = costs(shares, thickness_m)
        for index in range(len(shares)):
            for way in (-step, step):
                other = shares.copy()
                other[index] += way
                tried = costs(other, thickness_m)
                if tried.mean() < own.mean():
                    shares, own = other, tried
                    break
        spread_m = float(thickness_m.std())
        tell(f"round {number + 1}: unexplained {own.mean():.4f}, thickness +- {spread_m:.3f} m")
    return shares


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("folders", nargs="+", type=Path)
    parser.add_argument("--every", type=int, default=10)
    parser.add_argument("--rounds", type=int, default=8)
    options = parser.parse_args()
    several = [
        look
        for who, folder in enumerate(options.folders)
        for look in looks(folder, who, options.every)
    ]
    print(f"{len(several)} looks")
    shares = fit(several, options.rounds, lambda line: print(line, flush=True))
    *parts, girdle, hips = np.split(shares, [*range(6, len(shares) - 5, 6), len(shares) - 3])
    for name, numbers in zip(DRESSED, parts, strict=True):
        print(f'    "{name}": ({", ".join(f"{number:.3f}" for number in numbers)}),')
    print(f"girdle={tuple(girdle.round(3).tolist())}, hips={tuple(hips.round(3).tolist())}")


if __name__ == "__main__":
    main()
