"""How far is a head before the trunk, and are feet before the shins, seen from above? What
`HEAD_FORWARD` and `FEET_FORWARD` of `topview.track.methods.btvr.yaw_cues` are taken from.

    python scripts/fit_head_before.py FOLDER... [--every N]

Finds the people in recordings with a `groundtruth.npz`, asks of every N-th frame how far the
measured head is before the ellipse of the true yaw, and the feet before the shins; fits a line over
the cosine of that yaw.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar, Final

import numpy as np
from numpy.typing import NDArray

from topview.body import JOINT_NAMES
from topview.body.model import BodyModel
from topview.body.proportions import THESIS
from topview.camera import undistorted
from topview.geometry.rotations import unit
from topview.people.height import PRIOR_HEIGHT_M
from topview.track import Tracker, TrackerSettings
from topview.track.body_tracker import Needs, Subject
from topview.track.evidence import Evidence
from topview.track.methods.btvr.yaw import YAWS_RAD
from topview.track.methods.btvr.yaw_cues import feet_before, head_before
from topview.track.pose import Pose
from topview.track.stances import STANDING, heading, stand
from topview_lab.datasets import FolderRecording

Array = NDArray[np.float64]

NEAR_M: Final = 0.3
"""From a true head to a measured one of the same person; ours."""


MEASURES: Final = {"head": head_before, "feet": feet_before}


class Standing:
    """Tracks nothing: keeps what the frame shows, and lets everybody stand."""

    def __init__(self, seen: list[tuple[Evidence, float]]) -> None:
        self.model = BodyModel.of(PRIOR_HEIGHT_M, THESIS)
        self._seen = seen

    def update(self, evidence: Evidence) -> Pose:
        if evidence.stature_m is not None:
            self.model = BodyModel.of(evidence.stature_m, THESIS)
        self._seen.append((evidence, self.model.stature_m))
        return stand(self.model, evidence.head_camera, STANDING, 0.0, evidence.up_camera)


@dataclass(frozen=True)
class StandingSettings:
    seen: list[tuple[Evidence, float]]

    needs: ClassVar[Needs] = Needs()

    @property
    def name(self) -> str:
        return "utvr"

    def tracker(self, subject: Subject) -> Standing:
        return Standing(self.seen)


def true_yaw_rad(joints_camera: Array, up_camera: Array) -> float:
    """Of a trunk with these [16, 3] joints."""
    neck, pelvis, *sides = (
        joints_camera[JOINT_NAMES.index(name)]
        for name in ("neck", "pelvis", "left_shoulder", "right_shoulder", "left_hip", "right_hip")
    )
    x = unit(sides[1] - sides[0] + sides[3] - sides[2])
    y = unit(pelvis - neck - x * (x @ (pelvis - neck)))
    return heading(np.stack([x, y, np.cross(x, y)], axis=1), up_camera)


def measured(folder: Path, every: int) -> list[tuple[str, float, float]]:
    """What is before something, cosine of the true yaw, and share of the stature, of each person in
    each frame."""
    recording = FolderRecording(folder)
    truth = recording.reference()
    order = [truth.joint_names.index(name) for name in JOINT_NAMES]
    seen: list[tuple[Evidence, float]] = []
    tracker = Tracker(TrackerSettings(method="utvr"), body=StandingSettings(seen))
    told: list[tuple[str, float, float]] = []
    for number, frame in enumerate(map(undistorted, recording.open())):
        seen.clear()
        tracker.update(frame)
        if number % every:
            continue
        people = truth.joints_camera[number][:, order]
        for evidence, stature_m in seen:
            away_m = np.linalg.norm(people[:, 0] - evidence.head_camera, axis=1)
            if not away_m.min() < NEAR_M:
                continue
            yaw_rad = true_yaw_rad(people[away_m.argmin()], evidence.up_camera)
            for what, measure in MEASURES.items():
                before = measure(evidence, stature_m)
                if before is not None:
                    share = before[np.cos(YAWS_RAD - yaw_rad).argmax()]
                    told.append((what, np.cos(yaw_rad), share))
    return told


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("folders", nargs="+", type=Path)
    parser.add_argument("--every", type=int, default=2)
    options = parser.parse_args()
    told = [each for folder in options.folders for each in measured(folder, options.every)]
    for what in MEASURES:
        cosines, before = np.array([each[1:] for each in told if each[0] == what]).T
        line = np.stack([np.ones(len(cosines)), -cosines], axis=1)
        found = np.linalg.lstsq(line, before, rcond=None)[0]
        off = float((before - line @ found).std())
        print(f"{len(before)} frames: {what} {found[0]:.3f} of the stature before,")
        print(f"{found[1]:.3f} less of who faces the camera; standard deviation {off:.3f}")


if __name__ == "__main__":
    main()
