"""How surely do limbs tell front from back? What `FRONT_RATIO` and `FRONT_WEIGHT` of
`topview.track.methods.topview.usual_poses` are taken from.

    python scripts/fit_usual_front.py FOLDER... [--utd-mhad PATH --sequences GLOBS] [--every N]

Tracks the person in recordings with a `groundtruth.npz`, without this cue, and asks of every N-th
frame by what factor the nearest captured pose is farther from the tracked one turned half round
than from it as it is. A logistic regression of that factor's logarithm tells who is taken to face
the right way from who faces the wrong one; each recording counts alike, and so do both: its slope
is `FRONT_WEIGHT`.

People of a real sensor who stand at ease look nearly alike from both sides, and are not to be
turned round for that: the factor that nine in ten of those who face right are above is
`FRONT_RATIO`.
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
from topview.room.floor import CAMERA_UP
from topview.track import Tracker, TrackerSettings
from topview.track.methods.topview.usual_poses import usual_poses
from topview.track.pose import Pose
from topview.track.stances import heading
from topview_lab.datasets import EvaluatedRecording, find_folder_recordings, find_utd_mhad

RIGHT: Final = 0.5
"""Cosine between the true front and the tracked one of who faces the right way; below its negative
they face the wrong one."""
TURNED_AT_EASE: Final = 0.1
"""Share of those who face right that is told to face the wrong way."""
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


def looks(recording: EvaluatedRecording, every: int) -> Iterator[Look]:
    """Those of one recording of one person."""
    truth = recording.reference()
    order = [truth.joint_names.index(name) for name in JOINT_NAMES]
    joints_camera = dict(zip(truth.frame_index.tolist(), truth.joints_camera[:, 0], strict=True))
    tracker = Tracker(TrackerSettings(method="utvr"))
    for number, frame in enumerate(map(undistorted, recording.open())):
        people = tracker.update(frame)
        true_camera = joints_camera.get(frame.index, np.full((len(truth.joint_names), 3), np.nan))
        if number % every or len(people) != 1 or not np.isfinite(true_camera).all():
            continue
        floor = tracker.finder.floor
        up_camera = CAMERA_UP if floor is None else floor.normal_camera
        [person] = people
        pose = Pose(person.joints_camera[0], person.Ts_camera_part[:, :3, :3])
        yaw_rad = heading(pose.Rs[UPPER_TORSO], up_camera)
        own, other = usual_poses().front_distances(pose)
        cosine = cos(true_yaw_rad(true_camera[order], up_camera) - yaw_rad)
        yield Look(recording.name, cosine, log(other / own))


def fitted(told: list[Look]) -> float:
    """`FRONT_WEIGHT`."""
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

    return float(minimize(loss, [1.0, 1.0], method="Nelder-Mead").x[0])


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("folders", nargs="+", type=Path)
    parser.add_argument("--utd-mhad", type=Path)
    parser.add_argument("--sequences", default="*_s1_t1,*_s2_t1")
    parser.add_argument("--every", type=int, default=2)
    options = parser.parse_args()
    rendered = find_folder_recordings(options.folders)
    real: list[EvaluatedRecording] = []
    for glob in options.sequences.split(",") if options.utd_mhad else []:
        real += find_utd_mhad(options.utd_mhad, glob)
    with left_out({"track.methods.topview.usual_poses.FRONT_WEIGHT": 0.0}):
        told, told_of_real = (
            [look for recording in recordings for look in looks(recording, options.every)]
            for recordings in (rendered, real)
        )
    right = np.mean([look.cosine > RIGHT for look in told])
    print(f"{len(told)} frames, {100 * right:.1f} % face the right way")
    print(f"FRONT_WEIGHT {fitted(told):.2f}")
    if told_of_real:
        ratios = [look.log_ratio for look in told_of_real if look.cosine > RIGHT]
        ratio = np.exp(np.quantile(ratios, TURNED_AT_EASE))
        print(f"FRONT_RATIO {ratio:.2f}, of {len(ratios)} frames of the real sensor")


if __name__ == "__main__":
    main()
