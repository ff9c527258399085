"""Which cases there are: every file broken in every way, every option, names that are odd."""

from __future__ import annotations

import os
import shutil
import zlib
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from typing import Final

import numpy as np
from numpy.random import Generator

from fuzz.bases import BASES, Base
from fuzz.spoiling import ANY, BY_SUFFIX, NO_FILE, NUMBERS, WORDS, Spoil

Arguments = list[str]
Prepare = Callable[[Path, Path, Generator], Arguments]
"""Makes a case in a folder, of the whole bases in another; gives the command's arguments."""


@dataclass(frozen=True, slots=True)
class Case:
    """What says all of a case; `str` of it is what a failure tells."""

    family: str
    seed: int

    def __str__(self) -> str:
        return f"{self.family} (seed {self.seed})"

    def prepare(self, folder: Path, bases: Path) -> Arguments:
        """Write its files into the folder; the command's arguments."""
        rng = np.random.default_rng([self.seed, zlib.crc32(self.family.encode())])
        return families()[self.family](folder, bases, rng)


def cases(count: int, seed: int) -> Iterator[Case]:
    """So many, of each family one before any has two; in an order that the seed decides."""
    names = sorted(families())
    np.random.default_rng(seed).shuffle(names)
    for number in range(count):
        yield Case(names[number % len(names)], seed + number // len(names))


def write_bases(folder: Path) -> None:
    """All that is whole, once."""
    for name, base in BASES.items():
        (folder / name).mkdir(parents=True)
        base.write(folder / name)


def _spoiled(
    name: str, base: Base, file: str, spoil: Spoil, folder: Path, bases: Path, rng: Generator
) -> Arguments:
    shutil.copytree(bases / name, folder, dirs_exist_ok=True)
    spoil(folder / file, rng)
    return list(base.arguments)


# Command, and options of it. What is heavy asks for something else that is refused, and is given
# what no such option takes.
_EVALUATED: Final = ("evaluate", "folder", "recording", "--predictions", "predictions.npz")
_OPTIONS: Final[dict[tuple[str, ...], tuple[str, ...]]] = {
    ("track", "recording", "--out", "OUT"): (
        "method", "detector", "seed", "threads", "stature", "body", "out",
    ),
    _EVALUATED: (
        "sequences", "method", "detector", "seed", "json", "workers", "offsets", "predictions",
        "map",
    ),
    ("evaluate", "simulated", "walk", "--frames", "2", "--predictions", "predictions.npz"): (
        "seeds", "people", "size", "sequences",
    ),
    ("evaluate", "itop", "recording", "--predictions", "predictions.npz"): ("split", "sequences"),
    ("simulate", "walk", "--frames", "1", "--out", "OUT"): ("people", "seed", "size", "out"),
    ("bench", "recording", "--frames", "1"): ("json",),
    ("annotate", "recording", "recording", "--automatic", "--out", "OUT"): (
        "people", "board", "offset", "pick", "port",
    ),
    ("train-skin", "camera.json"): ("weight", "start", "skin", "not-skin", "masks", "out", "show"),
    ("train-people", "camera.json"): ("every", "measure", "simulated", "workers", "out"),
    ("train-confidence", "camera.json", "--out", "OUT/errors.json"): ("workers",),
    ("train-bias", "camera.json", "--out", "OUT/bias.npz"): ("workers",),
    ("train-unseen-limbs", "camera.json", "--out", "OUT/limbs.npz"): ("workers",),
    ("train-hands", "recording", "--out", "OUT/hands.npz"): ("test", "skin"),
}  # fmt: skip
_HEAVY: Final[dict[tuple[str, ...], tuple[str, ...]]] = {
    ("demo", "--out", "OUT"): ("seed", "frames"),
    ("simulate", "walk", "--out", "OUT"): ("frames",),
    ("bench", "recording"): ("frames",),
    ("reproduce", "x", "--out", "OUT"): ("seed", "workers"),
    ("train-forest", "--images", "0", "--out", "OUT/forest.npz"): (
        "trees", "depth", "candidates", "pixels", "seed", "threads",
    ),
}  # fmt: skip
_NO_NUMBERS: Final = ("-1", "x", "nan", "9" * 400, "9" * 5000, "-" + "9" * 5000, "[/x]", "a\nb")


def _of_shell(texts: tuple[str, ...]) -> list[str]:
    """Those that a shell can give as an argument."""
    return [text[:3000] for text in texts if "\x00" not in text and "\ud800" not in text]


def _option(
    command: tuple[str, ...],
    option: str,
    values: Sequence[str],
    folder: Path,
    bases: Path,
    rng: Generator,
) -> Arguments:
    shutil.copytree(bases / "truth", folder, dirs_exist_ok=True)
    value = values[int(rng.integers(len(values)))]
    return [*command, f"--{option}={value}"] if value else [*command, f"--{option}", value]


def _odd_name(rng: Generator) -> str:
    names = (
        "[/x]", "[bold]", "[", "a\nb", os.fsdecode(b"\xff\xfe"), "é", "名前", " ", "-x", "--out",
        "..",
        "%s{0}", "x" * 255, "x" * 256, "a\tb", "\x1b[31m", "*", "~", "$HOME", "a,b=c",
        ".hidden", "x.npz", "x.mat", "x.pcd", "x_sdepth.bin", "\u202e", "a b", '"', "\\",
    )  # fmt: skip
    return names[rng.integers(len(names))]


def _named(what: str, folder: Path, bases: Path, rng: Generator) -> Arguments:
    """A command whose input or output has an odd name; what cannot have it keeps its own."""
    name = _odd_name(rng)
    shutil.copytree(bases / "truth", folder, dirs_exist_ok=True)
    moved = "predictions.npz" if what == "predictions" else "recording"
    if what in ("track", "evaluate", "predictions") and name != "..":
        with suppress(OSError):  # too long
            (folder / moved).rename(folder / name)
    match what:
        case "track":
            return ["track", f"./{name}", "--out", "OUT"]
        case "bare":
            return ["track", name, "--out", "OUT"]
        case "out":
            return ["track", "recording", "--out", f"OUT/{name}"]
        case "evaluate":
            return ["evaluate", "folder", f"./{name}", *_EVALUATED[3:], "--per-sequence"]
        case "predictions":
            return [*_EVALUATED[:3], "--predictions", f"./{name}"]
        case "json":
            return [*_EVALUATED, "--json", f"OUT/{name}"]
        case _:
            return [what, name]


def _frame_name(folder: Path, bases: Path, rng: Generator) -> Arguments:
    """An image whose name is odd."""
    shutil.copytree(bases / "folder", folder, dirs_exist_ok=True)
    names = (
        "1305031102.933333", "1403636579763555584", "9" * 200, str(2**63), "000000_cam2", "[x]7",
        os.fsdecode(b"7\xff"), "a\nb7", "-1", "7", "0007", "٣", "x", "1e5", "00000" * 20, ".7", "²",
    )  # fmt: skip
    kind = ("depth", "rgb")[rng.integers(2)]
    for number in range(2) if rng.random() < 0.3 else (1,):
        image = folder / kind / f"{number:06d}.png"
        if image.exists():
            name = names[rng.integers(len(names))]
            image.rename(image.with_name(f"{name}.png"))
    return list(BASES["folder"].arguments)


def _arguments(folder: Path, bases: Path, rng: Generator) -> Arguments:
    """Words that are no command line."""
    words = (
        "track", "evaluate", "folder", "-", "--", "--out", "--help=1", "-h1", "[/x]", "é", "\n",
        "--no-force", "--seed",
    )  # fmt: skip
    return [words[n] for n in rng.integers(0, len(words), int(rng.integers(1, 5))).tolist()]


@cache
def families() -> dict[str, Prepare]:
    """Every family by its name."""
    found: dict[str, Prepare] = {}
    for name, base in BASES.items():
        for short, file in base.files.items():
            ways = {**ANY, **NO_FILE, **BY_SUFFIX.get(Path(file).suffix, {})}
            for way, spoil in ways.items():
                found[f"{short} | {way}"] = partial(_spoiled, name, base, file, spoil)
    values = _of_shell((*NUMBERS, *WORDS))
    for commands, pool in ((_OPTIONS, values), (_HEAVY, _NO_NUMBERS)):
        for command, options in commands.items():
            for option in options:
                family = f"{' '.join(command[:2])} | --{option}"
                found[family] = partial(_option, command, option, pool)
    for what in ("track", "bare", "out", "evaluate", "predictions", "json", "simulate", "evaluate"):
        found[f"a name | {what}"] = partial(_named, what)
    for n in range(4):
        found[f"a frame's name | {n}"] = _frame_name
        found[f"words | {n}"] = _arguments
    return found
