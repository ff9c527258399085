"""How surely do captured bodies tell which way somebody faces? What `LIKE_BY_SQUARE` and
`UNLIKE_SHARE` of `topview.track.methods.topview.lookup` are taken from.

    python scripts/fit_likeness.py FOLDER... [--utd-mhad PATH --sequences GLOBS]

Tracks the person in recordings of one person with a known truth, by `--method utvr`, which looks
through the table of captured bodies ten times a second. For some values of `LIKE_BY_SQUARE` it
prints the `UNLIKE_SHARE` that makes the true yaws likeliest, how unlikely they are then (minus the
logarithm of their likelihood in a frame, on average; 4.09 where the table tells nothing), and in
which share of the frames the true front is likelier than the back. Each recording counts alike.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Final

import numpy as np
from ablation import left_out
from fit_head_before import true_yaw_rad
from numpy.typing import NDArray
from rich.console import Console
from rich.table import Table

from topview.body import JOINT_NAMES
from topview.camera import undistorted
from topview.filter.turning import N_YAWS, YAWS_RAD
from topview.room.floor import CAMERA_UP
from topview.track import Tracker, TrackerSettings
from topview.track.methods.topview.lookup import Likeness
from topview_lab.datasets import EvaluatedRecording, find_folder_recordings, find_utd_mhad

Array = NDArray[np.float64]

TRIED: Final = (0.25, 0.35, 0.5, 0.7, 1.0, 1.4)
"""Values of `LIKE_BY_SQUARE`."""
SIDE: Final = 5
"""Yaws on either side of the true one that count as the front."""
PATH: Final = "track.methods.topview.lookup.Likeness.yaw_log_likelihood"


def looks(recording: EvaluatedRecording) -> Iterator[tuple[int, list[Array]]]:
    """Of each look at one person: which of `YAWS_RAD` is true, and how likely each of `TRIED` says
    that each is."""
    truth = recording.reference()
    order = [truth.joint_names.index(name) for name in JOINT_NAMES]
    joints_camera = dict(zip(truth.frame_index.tolist(), truth.joints_camera[:, 0], strict=True))
    looked: list[Likeness] = []

    def told(alike: Likeness) -> Array:
        looked.append(alike)
        return tell(alike)

    tell, tracker = Likeness.yaw_log_likelihood, Tracker(TrackerSettings(method="utvr"))
    with left_out({PATH: told}):
        for frame in map(undistorted, recording.open()):
            looked.clear()
            tracker.update(frame)
            if len(looked) != 1 or frame.index not in joints_camera:
                continue
            true_camera = joints_camera[frame.index][order]
            if not np.isfinite(true_camera).all():
                continue
            floor = tracker.finder.floor
            up_camera = CAMERA_UP if floor is None else floor.normal_camera
            steps = (true_yaw_rad(true_camera, up_camera) - YAWS_RAD[0]) * N_YAWS / (2.0 * np.pi)
            yield round(steps) % N_YAWS, [looked[0].yaw_likelihood(like) for like in TRIED]


def print_fit(title: str, recordings: Sequence[EvaluatedRecording]) -> None:
    """A table of what is fitted on these."""
    true, likely, weights = [], [], []
    for recording in recordings:
        own = list(looks(recording))
        true += [yaw for yaw, _ in own]
        likely += [each for _, each in own]
        weights += [1.0 / len(own)] * len(own)
    yaws, weight = np.array(true), np.array(weights) / np.sum(weights)
    near = (yaws[:, None] + np.arange(-SIDE, SIDE + 1)) % N_YAWS
    rows, shares = np.arange(len(yaws))[:, None], np.linspace(0.0, 0.9, 901)
    table = Table("LIKE_BY_SQUARE", "UNLIKE_SHARE", "-log", "front, %", box=None, title=title)
    for like, told in zip(TRIED, np.swapaxes(likely, 0, 1), strict=True):
        of_truth = told[rows, near[:, SIDE - 1 : SIDE + 2]].mean(1)

        def loss(share: float, of_truth: Array = of_truth) -> float:
            return float(-weight @ np.log((1.0 - share) * of_truth + share / N_YAWS))

        share = float(shares[np.argmin([loss(share) for share in shares])])
        is_front = told[rows, near].sum(1) > told[rows, (near + N_YAWS // 2) % N_YAWS].sum(1)
        table.add_row(
            f"{like:g}", f"{share:.3f}", f"{loss(share):.2f}", f"{100 * (weight @ is_front):.1f}"
        )
    Console().print(table)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("folders", nargs="+", type=Path)
    parser.add_argument("--utd-mhad", type=Path)
    parser.add_argument("--sequences", default="*_s1_t1,*_s2_t1")
    options = parser.parse_args()
    print_fit("recordings in folders", find_folder_recordings(options.folders))
    if options.utd_mhad:
        globs = options.sequences.split(",")
        real = [each for glob in globs for each in find_utd_mhad(options.utd_mhad, glob)]
        print_fit("UTD-MHAD", real)


if __name__ == "__main__":
    main()
