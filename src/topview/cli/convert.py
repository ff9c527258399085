"""`topview convert`: skeletons in another format."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from topview.cli.outputs import prepare_output_file
from topview.cli.results import RESULT
from topview.files import naming
from topview.io import read_skeletons_npz
from topview.io.writers.levelled import rigidity_m
from topview.io.writers.registry import FORMATS, files_of, format_named, write_format
from topview.records import InputError


def convert(
    skeletons: Path,
    out: Path,
    /,
    *,
    format: str | None = None,
    person: int | None = None,
    force: Annotated[bool, Parameter(negative="")] = False,
) -> int:
    """Write skeletons in another format.

    npz, csv, jsonl, parquet, c3d and glb hold everybody. A bvh, trc or mot holds one person; of
    several people, OUT_person1.bvh, OUT_person2.bvh and so on are written.

    Args:
        skeletons: a skeletons.npz, or the folder that holds it.
        out: the file to write; its ending says the format.
        format: one of npz, csv, jsonl, parquet, bvh, trc, mot, c3d, glb, whatever the ending is.
        person: write this one alone.
        force: replace the files that are there.
    """
    name = format or out.suffix.removeprefix(".")
    if not name:
        raise InputError(f"{out}: has no ending; give one, or --format {'|'.join(FORMATS)}")
    made = format_named(name)
    source = skeletons / RESULT if skeletons.is_dir() else skeletons
    sequence = read_skeletons_npz(source)
    if person is not None:
        with naming(source):
            sequence = sequence.of_person(person)
    elif not len(sequence.people_ids):
        raise InputError(f"{source}: holds nobody; there is nothing to convert")
    for file in files_of(made, out, sequence.people_ids.tolist()):
        prepare_output_file("OUT", file, force)
    for file in write_format(made, sequence, out):
        print(f"written to {file}")
    for one in sequence.people_ids.tolist() if made.has_bones else ():
        off_mm = 1e3 * rigidity_m(sequence, one)
        print(f"person {one}: joints lie up to {off_mm:.1f} mm from those of rigid bones")
    return 0
