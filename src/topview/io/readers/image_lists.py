"""Which images a folder holds, in which order, and when they were taken.

Images are numbered, or named by their times, or a list beside the folder says their times, as TUM
RGB-D's `depth.txt` does: lines of seconds and file name, those that begin with # aside.
https://cvg.cit.tum.de/data/datasets/rgbd-dataset/file_formats
"""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise
from math import isfinite
from pathlib import Path, PurePath

from topview.files import naming, read_text
from topview.io.readers.frame_names import by_number, by_time, few
from topview.records import InputError, shown


@dataclass(frozen=True, slots=True)
class ImageList:
    """Images of one camera, in order.

    Attributes:
        paths: by the frame's number: the one in the name, or counted from 0 where there are times.
        times_s: of each, seconds since whatever; None where the frame rate gives them.
        problems: what was left out, or is odd; relative to the recording's folder.
    """

    paths: dict[int, Path] = field(default_factory=dict)
    times_s: dict[int, float] | None = None
    problems: list[str] = field(default_factory=list)


def list_images(root: Path, folder: str, suffixes: tuple[str, ...]) -> ImageList:
    """The images in `root / folder`, with times where `root / folder.txt` or their names tell them.

    Raises:
        InputError: the folder or the list cannot be read, or names are of more than one camera.
    """
    directory = root / folder
    if not directory.is_dir():
        return ImageList()
    with naming(directory):
        names = [path.name for path in directory.iterdir()]
    names = [n for n in names if PurePath(n).suffix.lower() in suffixes and not n.startswith(".")]
    association = root / f"{folder}.txt"
    if names and association.is_file():
        seconds, problems = _associated(association, folder, names)
        return _timed(directory, seconds, problems)
    try:
        if (timed := by_time(names)) is not None:
            seconds, problems = timed
            return _timed(directory, seconds, [f"{folder}/{problem}" for problem in problems])
        numbered, problems = by_number(names)
    except InputError as error:
        raise InputError(f"{directory}/{error}") from None
    paths = {index: directory / name for index, name in numbered.items()}
    return ImageList(paths, problems=[f"{folder}/{problem}" for problem in problems])


def _timed(directory: Path, seconds: dict[str, float], problems: list[str]) -> ImageList:
    """Of names with times that rise; of those with the same time the first is kept."""
    kept: dict[str, float] = {}
    twice: list[str] = []
    before: float | None = None
    for name, time_s in seconds.items():
        if time_s == before:
            twice.append(f"{directory.name}/{name}: has the time of the image before; left out")
        else:
            kept[name] = before = time_s
    return ImageList(
        {index: directory / name for index, name in enumerate(kept)},
        dict(enumerate(kept.values())),
        [*problems, *few(twice)],
    )


def _associated(path: Path, folder: str, names: list[str]) -> tuple[dict[str, float], list[str]]:
    """Seconds by name, in order of time, as a list of times and names says; what is odd in it."""
    right = f"it must hold lines of seconds and file name, as 1305031102.160407 {folder}/000000.png"
    there, listed, missing, wrong = set(names), dict[str, float](), 0, list[str]()
    with naming(path, right=right):
        for number, line in enumerate(read_text(path, right=right).splitlines(), 1):
            words = line.replace(",", " ").split()
            if not words or words[0].startswith("#"):
                continue
            name = PurePath(words[-1]).name
            time_s = _seconds(words[0])
            if len(words) < 2 or time_s is None:
                wrong.append(f"line {number} is {shown(line)}")
            elif name in there:
                listed.setdefault(name, time_s)
            else:
                missing += 1
        if not listed:
            raise InputError(f"{wrong[0] if wrong else f'names no image of {folder}/'}; {right}")
    problems = few([f"{path.name}: {line}; {right}" for line in wrong])
    if missing:
        problems.append(f"{path.name}: images that it names and {folder}/ does not hold: {missing}")
    if unlisted := len(there) - len(listed):
        problems.append(
            f"{path.name}: images of {folder}/ that it does not name, left out: {unlisted}"
        )
    late = sum(after < before for before, after in pairwise(listed.values()))
    if late:
        problems.append(f"{path.name}: times out of order: {late}; frames are read by time")
    return dict(sorted(listed.items(), key=lambda item: item[1])), problems


def _seconds(word: str) -> float | None:
    try:
        seconds = float(word)
    except ValueError:
        return None
    return seconds if isfinite(seconds) else None
