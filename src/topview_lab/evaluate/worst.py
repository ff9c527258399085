"""Where bodies were worst, as one picture: the worst recordings, and the worst moments of each."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.body import JOINTS
from topview.records import Camera, Frame, InputError
from topview.view.drawing import (
    Image,
    draw_bone,
    draw_line,
    draw_text,
    pixels_of,
    png_of,
    resized,
)
from topview.view.frame_picture import frame_picture
from topview.view.palette import GROUND, MUTED, PEOPLE, TEXT
from topview_lab.datasets import EvaluatedRecording
from topview_lab.metrics import Evaluation, Offsets
from topview_lab.metrics.errors import pool, position_errors
from topview_lab.metrics.statistics import WITHIN, Statistic, statistic

# The look of the picture, and what it shows: all ours.
WORST_RECORDINGS: Final = 10
WORST_MOMENTS: Final = 3
MOMENTS_APART_S: Final = 1.0  # between two moments of one recording
WORST_JOINTS: Final = 2  # are named below a moment
MOMENT_PX: Final = (300, 300)
WORST_GAP_PX, WORST_TITLE_PX, CAPTION_LINE_PX = 14, 64, 22
ROOM_AROUND: Final = 1.25  # how much larger the part of the image is than who is in it
TRUTH_COLOR, PREDICTED_COLOR, APART_COLOR = TEXT, PEOPLE[0], PEOPLE[4]

Vector = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Moment:
    """One person in one frame.

    Attributes:
        frame: number of the recording's frame.
        reference_camera, predicted_camera: [J, 3] metres.
        errors_cm: [J] with the constant offsets out, NaN where unknown.
    """

    frame: int
    reference_camera: Vector
    predicted_camera: Vector
    errors_cm: Vector

    @property
    def caption(self) -> str:
        """How far the joints are off, and which the most."""
        known = np.flatnonzero(np.isfinite(self.errors_cm))
        worst = known[np.argsort(-self.errors_cm[known])][:WORST_JOINTS]
        named = ", ".join(
            f"{JOINTS[j].name.replace('_', ' ')} {self.errors_cm[j]:.0f}" for j in worst
        )
        return f"frame {self.frame}: {np.nanmean(self.errors_cm):.0f} cm; {named}"


@dataclass(frozen=True, slots=True, eq=False)
class WorstRecording:
    """A recording and its worst moments.

    Attributes:
        name: of the recording.
        joints: errors of all of them, with the constant offsets out.
        moments: the worst ones, in the order of the recording.
    """

    name: str
    joints: Statistic
    moments: tuple[Moment, ...]


def worst_recordings(
    evaluation: Evaluation,
    offsets: Offsets = "set",
    recordings: int = WORST_RECORDINGS,
    moments: int = WORST_MOMENTS,
) -> list[WorstRecording]:
    """Those whose joints are farthest off, the worst first; of each the moments in which somebody's
    are, at least `MOMENTS_APART_S` apart. Recordings in which nobody was found have none."""
    of_all = pool(evaluation, offsets)
    errors_cm, samples = position_errors(of_all).offset_out, of_all.samples
    is_told = np.isfinite(errors_cm).any(axis=1)
    worst = []
    for number, sequence in enumerate(evaluation.sequences):
        rows = np.flatnonzero((of_all.sequence == number) & is_told)
        if not len(rows):
            continue
        own_cm = errors_cm[rows]
        chosen = _apart(samples.time_s[rows], np.nanmean(own_cm, axis=1), moments)
        shown = tuple(
            Moment(
                int(samples.frame[row]),
                samples.reference_camera[row],
                samples.predicted_camera[row],
                errors_cm[row],
            )
            for row in rows[chosen]
        )
        worst.append(WorstRecording(sequence.name, statistic(own_cm), shown))
    worst.sort(key=lambda recording: -recording.joints.mean)
    return worst[:recordings]


def _apart(times_s: Vector, errors_cm: Vector, count: int) -> list[int]:
    """Indices of so many of the largest errors, no two of them at times that are near; in order."""
    chosen: list[int] = []
    for index in np.argsort(-errors_cm, kind="stable").tolist():
        if len(chosen) < count and all(
            abs(times_s[index] - times_s[other]) >= MOMENTS_APART_S for other in chosen
        ):
            chosen.append(index)
    return sorted(chosen)


def worst_png(worst: Sequence[WorstRecording], recordings: Sequence[EvaluatedRecording]) -> bytes:
    """The picture as a PNG file: a row for each of the worst recordings, which are read again.

    Raises:
        InputError: a recording can no longer be read.
    """
    by_name = {recording.name: recording for recording in recordings}
    rows = [_row(each, _frames_of(by_name[each.name], each)) for each in worst]
    header = np.full((WORST_TITLE_PX, _width_px(), 3), GROUND, np.uint8)
    used = draw_text(header, "where bodies are worst", (WORST_GAP_PX, 28), 14, TEXT)
    draw_text(header, "cm with constant offsets out", (WORST_GAP_PX + used + 16, 28), 10, MUTED)
    left = float(WORST_GAP_PX)
    for text, color in (
        ("reference", TRUTH_COLOR),
        ("predicted", PREDICTED_COLOR),
        (f"apart, where more than {WITHIN:.0f} cm", APART_COLOR),
    ):
        left += draw_text(header, text, (left, 52), 9, color) + 18
    return png_of(np.vstack([header, *rows]))


def _width_px() -> int:
    return WORST_GAP_PX + WORST_MOMENTS * (MOMENT_PX[0] + WORST_GAP_PX)


def _frames_of(recording: EvaluatedRecording, worst: WorstRecording) -> Mapping[int, Frame]:
    """The frames of its moments, by their numbers."""
    wanted = {moment.frame for moment in worst.moments}
    found: dict[int, Frame] = {}
    for frame in recording.open():
        if frame.index in wanted:
            found[frame.index] = frame
        if len(found) == len(wanted):
            return found
    raise InputError(f"{worst.name}: frames that were measured can no longer be read")


def _row(worst: WorstRecording, frames: Mapping[int, Frame]) -> Image:
    row = np.full(
        (2 * CAPTION_LINE_PX + MOMENT_PX[1] + WORST_GAP_PX, _width_px(), 3), GROUND, np.uint8
    )
    joints = worst.joints
    title = f"{worst.name}   {joints.mean:.1f} cm, {joints.within_10:.1%} within {WITHIN:.0f} cm"
    draw_text(row, title, (WORST_GAP_PX, 14), 10, TEXT)
    for column, moment in enumerate(worst.moments):
        left = WORST_GAP_PX + column * (MOMENT_PX[0] + WORST_GAP_PX)
        row[CAPTION_LINE_PX : CAPTION_LINE_PX + MOMENT_PX[1], left : left + MOMENT_PX[0]] = (
            moment_picture(frames[moment.frame], moment)
        )
        draw_text(row, moment.caption, (left, CAPTION_LINE_PX + MOMENT_PX[1] + 14), 8, MUTED)
    return row


def moment_picture(frame: Frame, moment: Moment) -> Image:
    """[H, W, 3] the part of a frame in which somebody is, with both skeletons over it."""
    both_camera = np.concatenate([moment.reference_camera, moment.predicted_camera])
    corner, side = _square_around(both_camera[np.isfinite(both_camera).all(axis=1)], frame.camera)
    scale = MOMENT_PX[0] / side
    image = frame_picture(frame)
    height, width = image.shape[:2]
    panel = np.full((side, side, 3), GROUND, np.uint8)
    x, y = corner
    left, top, right, bottom = max(x, 0), max(y, 0), min(x + side, width), min(y + side, height)
    if left < right and top < bottom:
        panel[top - y : bottom - y, left - x : right - x] = image[top:bottom, left:right]
    panel = resized(panel, MOMENT_PX)
    truth_px, predicted_px = (
        pixels_of(joints, frame.camera, scale) - np.array(corner) * scale
        for joints in (moment.reference_camera, moment.predicted_camera)
    )
    for joints_px, color in ((truth_px, TRUTH_COLOR), (predicted_px, PREDICTED_COLOR)):
        for j, joint in enumerate(JOINTS):
            if joint.bone_to >= 0:
                ends_px = joints_px[j], joints_px[joint.bone_to]
                draw_bone(panel, ends_px, color, 2, joint.name.startswith("right_"))
    for j in np.flatnonzero(moment.errors_cm > WITHIN):
        draw_line(panel, truth_px[j], predicted_px[j], APART_COLOR)
    return panel


def _square_around(points_camera: Vector, camera: Camera) -> tuple[tuple[int, int], int]:
    """The first pixel (x, y) and the side of a square of the image around [N, 3] points."""
    places_px = pixels_of(points_camera, camera, 1.0)
    low, high = places_px.min(axis=0), places_px.max(axis=0)
    side = max(int(ROOM_AROUND * (high - low).max()), 1)
    x, y = np.round(0.5 * (low + high - side)).astype(int).tolist()
    return (x, y), side
