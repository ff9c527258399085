"""Which recordings a batch is of, and what each result is called."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from glob import glob
from pathlib import Path
from typing import Final

from topview.files import naming, read_text
from topview.records import InputError

LIST_SUFFIX: Final = ".txt"


def expanded(sources: Sequence[str]) -> list[Path]:
    """The recordings that words name: a path, a pattern such as `data/*`, or a `.txt` with a path
    in each line, relative to its folder; `#` begins a comment. In the order of the words; those of
    a pattern are sorted, and none comes twice.

    Raises:
        InputError: a word names nothing, or a list cannot be read.
    """
    paths: dict[Path, Path] = {}
    for source in sources:
        for path in _named_by(source):
            paths.setdefault(path.resolve(), path)
    return list(paths.values())


def _named_by(source: str) -> list[Path]:
    path = Path(source)
    if path.suffix == LIST_SUFFIX and path.is_file():
        return _listed_in(path)
    if path.exists():
        return [path]
    found = sorted(map(Path, glob(source, recursive=True)))
    if not found:
        raise InputError(
            f"{source}: nothing is there; it must be a recording, a pattern that some match, "
            f"or a {LIST_SUFFIX} with one in each line"
        )
    return found


def _listed_in(path: Path) -> list[Path]:
    with naming(path):
        lines = read_text(path, "utf-8", "it must be a list of recordings").splitlines()
        named = [line.strip() for line in lines if line.partition("#")[0].strip()]
        if not named:
            raise InputError("names no recording; it must have one in each line")
    return [path.parent / line for line in named]


def named(paths: Sequence[Path]) -> dict[str, Path]:
    """A name for each: its file's or folder's; where that is not one alone, as many of the folders
    above it as tell all of them apart, as in `monday-room1`."""
    whole = [path.resolve() for path in paths]
    depth_of = dict.fromkeys(whole, 1)
    while True:
        names = {path: "-".join(path.parts[-depth:]) for path, depth in depth_of.items()}
        count = Counter(names.values())
        clashing = [
            path
            for path, name in names.items()
            if count[name] > 1 and depth_of[path] < len(path.parts)
        ]
        if not clashing:
            return {names[own]: path for own, path in zip(whole, paths, strict=True)}
        for path in clashing:
            depth_of[path] += 1
