"""How surely do limbs tell front from back? What `FRONT_RATIO` and `FRONT_WEIGHT` of
`topview.track.methods.topview.usual_poses` are taken from.

    python scripts/fit_usual_front.py FOLDER... [--method utvr] [--every N]

Tracks the person in recordings with a `groundtruth.npz`, without this cue, and asks of every N-th
frame by what factor the nearest captured pose is farther from the tracked one turned half round
than from it as it is.
A logistic regression tells that of who is taken to face the right way from that of who faces the
wrong one; each recording counts alike, and so do both.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import dataclass
from math import cos, log
from pathlib import Path
from typing import Final

import numpy as np
from ablation import left_out
from fit_head_before import true_yaw_rad
from numpy.typing import NDArray
from scipy.optimize import minimize

from topview.body import JOINT_NAMES
from topview.body.parts import UPPER_TORSO
from topview.camera import undistorted
from topview.track import Tracker, TrackerSettings
from topview.track.methods.topview.usual_poses import usual_poses
from topview.track.pose import Pose
from topview.track.stances import heading
from topview_lab.datasets import FolderRecording

RIGHT: Final = 0.5
"""Cosine between the true front and the tracked one of who faces the right way; below its negative
they face the wrong one."""
FEWEST: Final = 8
"""Frames of a recording that count."""


@dataclass(frozen=True, slots=True)
class Look:
    """One frame.

    Attributes:
        recording: its name.
        cosine: between the true front and the tracked one.
        log_ratio: of the squared distances to the nearest captured pose, turned round and not.
    """

    recording: str
    cosine: float
    log_ratio: float


def looks(folder: Path, method: str, every: int) -> Iterator[Look]:
    """Those of one recording of one person."""
    recording = FolderRecording(folder)
    truth = recording.reference()
    order = [truth.joint_names.index(name) for name in JOINT_NAMES]
    tracker = Tracker(TrackerSettings(method=method, proposals="none"))
    for number, frame in enumerate(map(undistorted, recording.open())):
        people = tracker.update(frame)
        joints_camera = truth.joints_camera[number][0, order]
        if number % every or len(people) != 1 or not np.isfinite(joints_camera).all():
            continue
        floor = tracker.finder.floor
        up_camera = np.array([0.0, -1.0, 0.0]) if floor is None else floor.normal_camera
        [person] = people
        pose = Pose(person.joints_camera[0], person.Ts_camera_part[:, :3, :3])
        off_rad = true_yaw_rad(joints_camera, up_camera) - heading(pose.Rs[UPPER_TORSO], up_camera)
        own, other = usual_poses().front_distances(pose)
        yield Look(folder.name, cos(off_rad), log(other / own))


def fitted(told: list[Look]) -> NDArray[np.float64]:
    """[2] `FRONT_WEIGHT`, and the logarithm of `FRONT_RATIO`."""
    ratios, weights, is_right = [], [], []
    for right in (True, False):
        sign = 1.0 if right else -1.0
        names = {look.recording for look in told}
        own = {
            name: [x.log_ratio for x in told if x.recording == name and sign * x.cosine > RIGHT]
            for name in names
        }
        own = {name: each for name, each in own.items() if len(each) >= FEWEST}
        for each in own.values():
            ratios += each
            weights += [1.0 / (len(own) * len(each))] * len(each)
            is_right += [right] * len(each)
        print(f"{'right' if right else 'wrong'}: {len(own)} recordings")
    x, w, y = np.array(ratios), np.array(weights), np.array(is_right, np.float64)

    def loss(law: NDArray[np.float64]) -> float:
        log_odds = law[0] * (x - law[1])
        return float(w @ (np.logaddexp(0.0, log_odds) - y * log_odds))

    return minimize(loss, [1.0, 1.0], method="Nelder-Mead").x


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("folders", nargs="+", type=Path)
    parser.add_argument("--method", default="utvr")
    parser.add_argument("--every", type=int, default=2)
    options = parser.parse_args()
    with left_out({"track.methods.topview.usual_poses.FRONT_WEIGHT": 0.0}):
        told = [
            look
            for folder in options.folders
            for look in looks(folder, options.method, options.every)
        ]
    weight, log_ratio = fitted(told)
    right = np.mean([look.cosine > RIGHT for look in told])
    print(f"{len(told)} frames, {100 * right:.1f} % face the right way")
    print(f"FRONT_RATIO {np.exp(log_ratio):.2f}, FRONT_WEIGHT {weight:.2f}")


if __name__ == "__main__":
    main()
