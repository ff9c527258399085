"""`topview convert`: skeletons in another format."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from topview.cli.outputs import prepare_output_file
from topview.cli.overlay import VIDEO, write_overlay
from topview.cli.results import RESULT
from topview.files import naming
from topview.io import read_skeletons_npz
from topview.io.writers.levelled import rigidity_m
from topview.io.writers.registry import FORMATS, files_of, format_named, write_format
from topview.records import InputError
from topview.skeletons import SkeletonSequence


def convert(
    skeletons: Path,
    out: Path,
    /,
    *,
    format: str | None = None,
    person: int | None = None,
    source: Path | None = None,
    force: Annotated[bool, Parameter(negative="")] = False,
) -> int:
    """Write skeletons in another format.

    npz, csv, jsonl, parquet, c3d, glb, mcap and rrd hold everybody. So does mp4, a video with the
    skeletons over the images of the recording, which --source names. A bvh, trc or mot holds one
    person; of several people, OUT_person1.bvh, OUT_person2.bvh and so on are written.

    Args:
        skeletons: a skeletons.npz, or the folder that holds it.
        out: the file to write; its ending says the format.
        format: one of npz, csv, jsonl, parquet, bvh, trc, mot, c3d, glb, mcap, rrd, mp4, whatever
            the ending is.
        person: write this one alone.
        source: the recording that was tracked, for mp4.
        force: replace the files that are there.
    """
    name = (format or out.suffix.removeprefix(".")).lower()
    if not name:
        known = "|".join([*FORMATS, VIDEO])
        raise InputError(f"{out}: has no ending; give one, or --format {known}")
    if (source is not None) != (name == VIDEO):
        told = "missing" if source is None else f"{source}"
        raise InputError(
            f"--source is {told}; it must name the recording for {VIDEO}, and only for that"
        )
    made = None if source is not None else format_named(name)
    sequence = _people(skeletons, person)
    people = sequence.people_ids.tolist()
    for file in [out] if made is None else files_of(made, out, people):
        prepare_output_file("OUT", file, force)
    if source is not None:
        write_overlay(sequence, source, out)
    files = [out] if made is None else write_format(made, sequence, out)
    for file in files:
        print(f"written to {file}")
    for one in people if made is not None and made.has_bones else ():
        off_mm = 1e3 * rigidity_m(sequence, one)
        print(f"person {one}: joints lie up to {off_mm:.1f} mm from those of rigid bones")
    return 0


def _people(skeletons: Path, person: int | None) -> SkeletonSequence:
    """Everybody in a file or the folder that holds it, or one person alone."""
    file = skeletons / RESULT if skeletons.is_dir() else skeletons
    sequence = read_skeletons_npz(file)
    if person is not None:
        with naming(file):
            return sequence.of_person(person)
    if not len(sequence.people_ids):
        raise InputError(f"{file}: holds nobody; there is nothing to convert")
    return sequence
