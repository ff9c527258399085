"""Which formats skeletons are written in, and which one a file's name asks for."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Final

from topview.io.writers.bvh import write_skeletons_bvh
from topview.io.writers.c3d import write_skeletons_c3d
from topview.io.writers.csv import write_skeletons_csv
from topview.io.writers.extras import needed
from topview.io.writers.gltf import write_skeletons_gltf
from topview.io.writers.jsonl import write_skeletons_jsonl
from topview.io.writers.mcap import write_skeletons_mcap
from topview.io.writers.npz import write_skeletons_npz
from topview.io.writers.opensim import write_skeletons_mot, write_skeletons_trc
from topview.io.writers.parquet import write_skeletons_parquet
from topview.io.writers.rrd import write_skeletons_rrd
from topview.records import InputError
from topview.skeletons import Skeletons, in_memory


@dataclass(frozen=True, slots=True)
class SkeletonFormat:
    """A format: its name, which is its ending too, and how to write it.

    Attributes:
        name: on the command line.
        write: skeletons, and where to.
        is_of_one: a file holds one person.
        has_bones: it tells of rigid bones, not of the joints themselves.
        needs: the module and the extra of topview that it comes with; empty if none is needed.
        endings: others that mean the same.
    """

    name: str
    write: Callable[[Skeletons, Path], None]
    is_of_one: bool = False
    has_bones: bool = False
    needs: tuple[str, str] | None = None
    endings: tuple[str, ...] = ()


FORMATS: Final[dict[str, SkeletonFormat]] = {
    made.name: made
    for made in (
        SkeletonFormat("npz", write_skeletons_npz),
        SkeletonFormat("csv", write_skeletons_csv),
        SkeletonFormat("jsonl", write_skeletons_jsonl),
        SkeletonFormat("parquet", write_skeletons_parquet, needs=("pyarrow", "parquet")),
        SkeletonFormat("bvh", write_skeletons_bvh, is_of_one=True, has_bones=True),
        SkeletonFormat("trc", write_skeletons_trc, is_of_one=True),
        SkeletonFormat("mot", write_skeletons_mot, is_of_one=True, has_bones=True),
        SkeletonFormat("c3d", write_skeletons_c3d, needs=("ezc3d", "c3d")),
        SkeletonFormat(
            "glb",
            write_skeletons_gltf,
            has_bones=True,
            needs=("pygltflib", "gltf"),
            endings=("gltf",),
        ),
        SkeletonFormat("mcap", write_skeletons_mcap, needs=("rosbags", "ros")),
        SkeletonFormat("rrd", write_skeletons_rrd, needs=("rerun", "view")),
    )
}


def format_named(name: str) -> SkeletonFormat:
    """The format of a name or of a file's ending, with what it needs installed.

    Raises:
        InputError: there is no such format, or its library is missing.
    """
    word = name.lower()
    for made in FORMATS.values():
        if word in (made.name, *made.endings):
            if made.needs is not None:
                needed(made.needs[0], made.name, made.needs[1])
            return made
    raise InputError(f"format is {name!r}; it must be one of {', '.join(FORMATS)}")


def files_of(made: SkeletonFormat, path: Path, people: list[int]) -> dict[Path, int | None]:
    """Where these people are written to, and who is in each file; None for all of them.

    Several people in a format of one have files of their own, with `_person3` before the ending.
    """
    if not made.is_of_one:
        return {path: None}
    if len(people) == 1:
        return {path: people[0]}
    return {path.with_stem(f"{path.stem}_person{person}"): person for person in people}


def write_skeletons(
    skeletons: Skeletons, path: str | PathLike[str], format: str | None = None
) -> list[Path]:
    """Write skeletons; the format is told from the ending of the path unless it is named.

    A format of one person takes several people in files of their own: for `out.bvh` these are
    `out_person1.bvh` and so on.

    Returns:
        The files.

    Raises:
        InputError: a format that is not known or whose library is missing, skeletons that it cannot
            tell, or a file that cannot be written.
    """
    path = Path(path)
    return write_format(format_named(format or path.suffix.removeprefix(".")), skeletons, path)


def write_format(made: SkeletonFormat, skeletons: Skeletons, path: Path) -> list[Path]:
    """Write everybody; the files.

    Raises:
        InputError: they cannot be told in this format, or not be written.
    """
    if not made.is_of_one:
        made.write(skeletons, path)
        return [path]
    sequence = in_memory(skeletons)
    files = files_of(made, path, sequence.people_ids.tolist())
    for file, person in files.items():
        if person is not None:
            made.write(sequence.of_person(person), file)
    return list(files)
