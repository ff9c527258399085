"""`topview batch`: many recordings in, skeletons of each out."""

from __future__ import annotations

import json
import os
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Annotated, Any, Final
from uuid import uuid4

from cyclopts import Parameter

from topview.batch.job import Job, remove_unfinished
from topview.batch.record import Outcome, write_manifest
from topview.batch.schedulers import DASK, PROCESSES, scheduler_named
from topview.batch.sources import expanded, named
from topview.cli.progress import compile_kernels, progress_bar, warn
from topview.cli.results import RESULT
from topview.cli.status import UNUSABLE_INPUT
from topview.cli.track import NobodyFoundError, track
from topview.io import SkeletonFile, prepare_output_folder
from topview.io.writers.registry import format_named
from topview.records import InputError
from topview.track import TrackerSettings

DEFAULTS: Final = TrackerSettings()
MANIFEST: Final = "manifest.json"


def batch(
    *sources: str,
    out: Path,
    workers: int = 0,
    scheduler: str = PROCESSES,
    pictures: Annotated[bool, Parameter(negative="")] = False,
    format: str = "",
    mirrored: Annotated[bool, Parameter(negative="")] = False,
    offline: Annotated[bool, Parameter(negative="")] = False,
    force: Annotated[bool, Parameter(negative="")] = False,
    settings: Annotated[TrackerSettings, Parameter(name="*")] = DEFAULTS,
) -> int:
    """Track everyone in many recordings.

    Writes DIR/NAME/skeletons.npz and so on for each recording, as `topview track` does, and
    DIR/manifest.json, which says what became of each, with checksums. A recording's folder appears
    when it is whole. The same command again goes on where a run ended: what is done is not done
    again. A recording that cannot be tracked is told, and the others go on.

    Args:
        sources: recordings, patterns such as "data/*", or .txt files with one in each line.
        out: folder for the results, made if it is missing.
        workers: recordings at a time, 0 for half as many as there are cores.
        scheduler: who does the work: processes; dask, a cluster of processes of this machine; or
            dask:tcp://HOST:PORT, one that runs already and sees the same folders.
        pictures: as of `topview track`, for each.
        format: as of `topview track`, for each.
        mirrored: as of `topview track`, for all.
        offline: as of `topview track`, for all.
        force: track again what is done, and replace results with other options.
    """
    if not sources:
        raise InputError("no recordings are named; name some, or a pattern, or a .txt with a list")
    if workers < 0:
        raise InputError(f"workers is {workers}; it must be 0 (half of the cores) or more")
    for name in filter(None, format.split(",")):
        format_named(name)
    workers = workers or max(1, (os.cpu_count() or 1) // 2)
    schedule = scheduler_named(scheduler, workers)
    options: dict[str, Any] = {"pictures": pictures, "format": format, "mirrored": mirrored}
    if offline:  # results without it stay what they were before there was such an option
        options["offline"] = True
    if scheduler in (PROCESSES, DASK) and not settings.threads:  # all workers are here
        settings = replace(settings, threads=max(1, (os.cpu_count() or 1) // workers))
    if settings.weights is not None:  # a worker may have started elsewhere
        settings = replace(settings, weights=settings.weights.resolve())
    if settings.body is not None:
        settings = replace(settings, body=settings.body.resolve())
    told = json.loads(json.dumps(options | settings.as_json()))
    run = uuid4().hex
    make = partial(track_into, options=options, settings=settings)
    jobs = [
        Job(name, path.resolve(), out.resolve(), told, run, force, make)
        for name, path in named(expanded(sources)).items()
    ]
    prepare_output_folder(out)
    remove_unfinished(out)
    for job in jobs:
        job.check_free()
    outcomes = {job.name: job.finished() or job.outcome() for job in jobs}
    waiting = [job for job in jobs if outcomes[job.name].state == "waiting"]
    if len(waiting) < len(jobs):
        print(f"{len(jobs) - len(waiting)} of {len(jobs)} recordings are done already")
    manifest = out / MANIFEST
    write_manifest(manifest, list(outcomes.values()))
    if waiting:
        compile_kernels()
    with progress_bar() as progress:
        bar = progress.add_task("recordings", total=len(jobs), completed=len(jobs) - len(waiting))
        for outcome in schedule(waiting) if waiting else ():
            outcomes[outcome.name] = outcome
            write_manifest(manifest, list(outcomes.values()))
            _tell(outcome)
            progress.update(bar, advance=1)
    failed = sum(outcome.state == "failed" for outcome in outcomes.values())
    print(f"{len(jobs) - failed} of {len(jobs)} recordings are done; {manifest} tells of each")
    return UNUSABLE_INPUT if failed else 0


def track_into(
    source: Path, out: Path, options: dict[str, Any], settings: TrackerSettings
) -> tuple[int, int]:
    """`topview track` of one recording; how many frames were tracked and people found.

    Raises:
        InputError: it cannot be tracked to its end.
    """
    try:
        status = track(source, out=out, settings=settings, **options)
    except NobodyFoundError:
        status = 0
    if status:
        raise InputError("interrupted")
    counts = [(len(b.frame_index), len(b.people_ids)) for b in SkeletonFile(out / RESULT).blocks()]
    return sum(frames for frames, _ in counts), counts[0][1]


def _tell(outcome: Outcome) -> None:
    if outcome.state == "failed":
        warn(f"{outcome.name}: {outcome.error}")
    else:
        found = f"{outcome.people} people" if outcome.people else outcome.error
        print(f"{outcome.name}: {outcome.frames} frames, {found}")
