"""`topview evaluate facing`: which way one person faces in a real recording."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

from topview_lab.cli.tracked import TRACKED_OPTIONS, Told, TrackedOptions, measure_all
from topview_lab.evaluate.tables import over_time_table
from topview_lab.evaluate.yaws import FacingJob, FacingOutcome, held_rows, read_yaws


def facing(path: Path, /, *, yaws: Path, options: TrackedOptions = TRACKED_OPTIONS) -> int:
    """Measure which way one person faces in a recording without truth.

    Told is the share of frames in which the trunk is within 45 degrees of what was annotated, after
    the first second and over all; between annotated frames the yaw is interpolated.

    Args:
        path: a recording, whatever `topview track` reads, of one person, whose camera is level.
        yaws: a table of comma-separated values with the columns frame and yaw_deg: 0 where the
            trunk faces the camera, 90 the image's right, 180 away from the camera.
    """
    read_yaws(yaws)  # not to find out after tracking
    return measure_all([FacingJob(path, yaws, options.settings)], options, told_of_facing)


def told_of_facing(outcomes: Sequence[FacingOutcome]) -> Told:
    """By recording."""
    scores = {outcome.name: outcome.score for outcome in outcomes if outcome.score is not None}
    return Told(
        len(scores),
        [over_time_table(held_rows(outcomes))],
        (),
        {"facing": {name: asdict(score) for name, score in scores.items()}},
    )
