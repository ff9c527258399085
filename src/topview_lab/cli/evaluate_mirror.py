"""`topview evaluate mirror`: are left and right treated alike?"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from topview.records import InputError
from topview_lab.cli.tracked import TRACKED_OPTIONS, Told, TrackedOptions, measure_all
from topview_lab.datasets.base import select_by_name
from topview_lab.evaluate.mirror import (
    MirrorJob,
    MirrorOutcome,
    apart_by_joint,
    apart_by_sequence,
    apart_table,
)
from topview_lab.evaluate.tables import rows_as_json
from topview_lab.metrics.mirror import pooled_apart


def mirror(
    *paths: Path,
    frames: int | None = None,
    other_seed: int | None = None,
    options: TrackedOptions = TRACKED_OPTIONS,
) -> int:
    """Measure how far skeletons are from those that are tracked in the mirror.

    Each recording is tracked as it is and with its images flipped left-right; the second skeletons
    are flipped back, their sides exchanged. Told of each joint: the median distance, that of 95 %,
    and the share within 3 cm, in frames in which both have the person.

    Args:
        paths: recordings, whatever `topview track` reads; no truth is needed.
        frames: of each recording, from its first on; all if not given.
        other_seed: compare with another seed of the random numbers, too, in place of the mirror:
            these are not mirrored, so the first cannot be nearer.
    """
    if not paths:
        raise InputError("evaluate mirror: no recording given; give at least one")
    if frames is not None and frames < 1:
        raise InputError(f"--frames is {frames}; it must be 1 or more")
    other = None if other_seed is None else replace(options.settings, seed=other_seed)
    jobs = [MirrorJob(path, options.settings, frames, other) for path in paths]
    chosen = select_by_name(jobs, options.sequences, ", ".join(map(str, paths)))
    return measure_all(chosen, options, told_of_mirrors)


def told_of_mirrors(outcomes: Sequence[MirrorOutcome]) -> Told:
    """By joint, from the mirror image and from the other seed."""
    mirrored = [(o.name, o.mirrored) for o in outcomes if o.mirrored is not None]
    reseeded = [o.reseeded for o in outcomes if o.reseeded is not None]
    if not mirrored:
        return Told(0, (), (), {})
    rows = {"from the mirror image": apart_by_joint(pooled_apart([own for _, own in mirrored]))}
    if reseeded:
        rows["from another seed"] = apart_by_joint(pooled_apart(reseeded))
    return Told(
        len(mirrored),
        [apart_table(f"distance {title}", "joint", own) for title, own in rows.items()],
        [apart_table("per sequence, worst first", "sequence", apart_by_sequence(mirrored))],
        {title: rows_as_json(own) for title, own in rows.items()},
    )
