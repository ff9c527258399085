"""Which way one person faces in a real recording, against yaws that somebody annotated."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.body import JOINT_NAMES
from topview.files import naming, read_text
from topview.io import open_recording
from topview.records import InputError, shown
from topview.skeletons import SkeletonSequence
from topview.track.run import track_recording
from topview.track.settings import TrackerSettings
from topview_lab.evaluate.run import Track, tracked_whole
from topview_lab.metrics.facing import FACING_AFTER_S, FACING_DEG, Held, yaws_deg

YAW_COLUMNS: Final = "frame,yaw_deg"
YAWS_RIGHT: Final = (
    f"it must begin with {YAW_COLUMNS} and have two lines or more, numbers of frames that go up, "
    "and degrees: 0 faces the camera, 90 the image's right"
)
LEAST_ANNOTATED: Final = 2


@dataclass(frozen=True, slots=True, eq=False)
class Yaws:
    """Where somebody's trunk faces, annotated in some frames of a recording.

    Attributes:
        frames: [K] numbers of frames, in order.
        yaw_deg: [K] as `topview_lab.metrics.facing.yaws_deg` has them.
    """

    frames: NDArray[np.int64]
    yaw_deg: NDArray[np.float64]

    def of_frames(self, frames: NDArray[np.int64]) -> NDArray[np.float64]:
        """[F] degrees, the shorter way round from one annotated frame to the next; NaN before the
        first and after the last."""
        unwound = np.unwrap(self.yaw_deg, period=360.0)
        return np.interp(frames, self.frames, unwound, left=np.nan, right=np.nan)


def read_yaws(path: Path) -> Yaws:
    """The table of a file.

    Raises:
        InputError: it cannot be read, or holds something else.
    """
    with naming(path):
        head, *lines = read_text(path, "utf-8", YAWS_RIGHT).split("\n")
        if head.strip() != YAW_COLUMNS:
            raise InputError(f"begins with {shown(head)}; {YAWS_RIGHT}")
        rows = [_numbers(line) for line in lines if line.strip()]
        frames, yaws = np.array([row[0] for row in rows]), np.array([row[1] for row in rows])
        if len(rows) < LEAST_ANNOTATED or (np.diff(frames) <= 0).any():
            raise InputError(f"annotates the frames {shown(frames.tolist())}; {YAWS_RIGHT}")
    return Yaws(frames, yaws)


def _numbers(line: str) -> tuple[int, float]:
    if not re.fullmatch(r"\s*[0-9]{1,9}\s*,\s*-?[0-9]{1,3}(\.[0-9]*)?\s*", line):
        raise InputError(f"has the line {shown(line)}; {YAWS_RIGHT}")
    frame, yaw_deg = line.split(",")
    return int(frame), float(yaw_deg)


@dataclass(frozen=True, slots=True)
class FacingScore:
    """Which way somebody was told to face, in the frames whose yaw is known.

    Attributes:
        late: of frames from `FACING_AFTER_S` after the first on in which somebody was found: how
            many, and the share in which the trunk is within `FACING_DEG`.
        whole: of all frames in which somebody was found.
        found: share 0..1 of the frames in which somebody was found.
    """

    late: Held
    whole: Held
    found: float


@dataclass(frozen=True, slots=True)
class FacingOutcome:
    """One recording: its score, or None and why; what could not be read, one line each."""

    name: str
    score: FacingScore | None
    problems: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class FacingJob:
    """One recording of one person to be tracked, in any process.

    Attributes:
        path: of the recording.
        yaws: file with the annotated yaws.
        settings: of the tracker.
        track: the tracker, importable by its name.
    """

    path: Path
    yaws: Path
    settings: TrackerSettings
    track: Track = track_recording

    def __call__(self) -> FacingOutcome:
        name = self.path.resolve().name
        try:
            yaws = read_yaws(self.yaws)
            recording = open_recording(self.path)
            skeletons = tracked_whole(recording, self.settings, self.track).skeletons
        except InputError as error:
            return FacingOutcome(name, None, (f"{name}: {error}",))
        problems = tuple(f"{name}: {problem}" for problem in recording.problems)
        return FacingOutcome(name, score_facing(skeletons, yaws), problems)


def score_facing(skeletons: SkeletonSequence, yaws: Yaws) -> FacingScore:
    """Of the nearest person of each frame."""
    true_deg = yaws.of_frames(skeletons.frame_index)
    found_deg = yaws_deg(_nearest(skeletons))
    off_deg = np.abs((found_deg - true_deg + 180.0) % 360.0 - 180.0)
    counts = np.isfinite(off_deg)
    is_late = skeletons.timestamps_s - skeletons.timestamps_s[0] >= FACING_AFTER_S
    late, whole = (Held.of(off_deg[counts & of] <= FACING_DEG) for of in (is_late, counts))
    known = np.isfinite(true_deg)
    return FacingScore(late, whole, float(counts[known].mean()) if known.any() else float("nan"))


def _nearest(skeletons: SkeletonSequence) -> NDArray[np.float64]:
    """[F, 16, 3] joints of whoever's head is nearest, NaN where nobody is."""
    columns = [skeletons.joint_names.index(name) for name in JOINT_NAMES]
    joints = skeletons.joints_camera[:, :, columns]
    if not joints.shape[1]:
        return np.full((len(joints), *joints.shape[2:]), np.nan)
    away_m = joints[:, :, JOINT_NAMES.index("head"), 2]
    slots = np.where(np.isfinite(away_m), away_m, np.inf).argmin(1)
    return joints[np.arange(len(joints)), slots]


def held_rows(outcomes: Iterable[FacingOutcome]) -> dict[str, Held]:
    """What is told of each recording."""
    rows: dict[str, Held] = {}
    for outcome in outcomes:
        if outcome.score is not None:
            name = f"{outcome.name}: facing within {FACING_DEG:g}°"
            rows[f"{name}, after the first second"] = outcome.score.late
            rows[f"{name}, all frames with somebody"] = outcome.score.whole
    return rows
