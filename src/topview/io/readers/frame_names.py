"""The numbers of frames, or their times, by the names of their images.

The last number in a name is that of its frame; what is around it is the same in all names, or they
are of two cameras. A time stamp is no frame number: taken for one, its seconds would be lost, and
frames put out of order. It is told by a dot between two numbers, which are then seconds, or by
being as great as the seconds, milliseconds, microseconds or nanoseconds since 1970.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from itertools import pairwise
from pathlib import PurePath
from statistics import median
from typing import Final

from topview.records import InputError

MOST_FRAME_NUMBER: Final = 10**9  # ours; a year at 30 frames a second; 10^9 seconds ended in 2001
MAX_NAME_LINES: Final = 5  # names that are left out beyond these share one line
MAX_GAP_LINES: Final = 5  # more gaps than this share one line
LIKELY_STEP: Final = 15
"""Frames numbered in greater steps, in the middle, are probably numbered by time (ours)."""
PAUSE_STEPS: Final = 5.0
"""A pause is longer than so many times the time between frames in the middle (ours)."""
_LAST_NUMBER: Final = re.compile(r"(.*?)([0-9]+)([^0-9]*)", re.DOTALL)
_SECONDS: Final = re.compile(r"([0-9]+\.[0-9]+)|.*?([0-9]{9,}\.[0-9]+)", re.DOTALL)
_DIGITS_PER_UNIT: Final = {10: 0, 13: 3, 16: 6, 19: 9}  # of the time since 1970: s, ms, us, ns
_RIGHT: Final = "it must be numbered from the first frame on, as 000000.png is"


def _time_stamp(name: str) -> tuple[float, tuple[str, str]] | None:
    """The seconds that an image file is named by, and what is around them; None without any."""
    stem = PurePath(name).stem
    if (match := _SECONDS.fullmatch(stem)) is not None:
        return float(match[1] or match[2]), (stem[: match.start(match.lastindex or 0)], "")
    if (match := _LAST_NUMBER.fullmatch(stem)) is None:
        return None
    number = match[2].lstrip("0")
    decimals = _DIGITS_PER_UNIT.get(len(number))
    return None if decimals is None else (int(number) / 10**decimals, (match[1], match[3]))


def by_time(names: Iterable[str]) -> tuple[dict[str, float], list[str]] | None:
    """Seconds by name, in order, and what is wrong with the names left out; None unless most names
    are time stamps.

    Args:
        names: of image files, with their suffixes.

    Raises:
        InputError: they are of more than one camera.
    """
    names = sorted(names)
    stamps = {name: stamp for name in names if (stamp := _time_stamp(name)) is not None}
    if 2 * len(stamps) <= len(names):
        return None
    _refuse_several({around: name for name, (_, around) in reversed(stamps.items())})
    problems = [
        f"{name}: is not named by a time stamp, as most are; left out"
        for name in names
        if name not in stamps
    ]
    seconds = {name: time_s for name, (time_s, _) in stamps.items()}
    return dict(sorted(seconds.items(), key=lambda item: item[1])), few(problems)


def _refuse_several(around: Mapping[tuple[str, str], str]) -> None:
    """Raises InputError where names differ in what is around their numbers; one name for each."""
    if len(around) > 1:
        first, second = sorted(around.values())[:2]
        raise InputError(
            f"{first} and {second}: differ in more than their last number, that of the frame; all "
            "names must be alike around it, and images of one camera only"
        )


def by_number(names: Iterable[str]) -> tuple[dict[int, str], list[str]]:
    """The names by their frames' numbers, in order, and what is wrong with those left out, a line
    each, the first few.

    Args:
        names: of image files, with their suffixes.

    Raises:
        InputError: they are of more than one camera, or most have numbers too great for a frame.
    """
    numbered: dict[int, str] = {}
    around: dict[tuple[str, str], str] = {}
    stamps: list[str] = []
    problems: list[str] = []
    for name in sorted(names):
        stem = PurePath(name).stem
        if (match := _LAST_NUMBER.fullmatch(stem)) is None:
            problems.append(f"{name}: has no frame number; it must be like 000000.png")
            continue
        before, number, after = match[1], match[2].lstrip("0") or "0", match[3]
        if _SECONDS.fullmatch(stem) or len(number) > len(str(MOST_FRAME_NUMBER - 1)):
            stamps.append(name)
            continue
        around.setdefault((before, after), name)
        if (taken := numbered.setdefault(int(number), name)) is not name:
            problems.append(f"{name}: has the same frame number as {taken}; left out")
    if len(stamps) > len(numbered):
        raise InputError(f"{stamps[0]}: seems to be named by a time stamp; {_RIGHT}")
    _refuse_several(around)
    problems += [
        f"{name}: seems to be named by a time stamp; {_RIGHT}; left out" for name in stamps
    ]
    return dict(sorted(numbered.items())), few(problems)


def few(problems: Sequence[str]) -> list[str]:
    """The first of the names that are left out, and how many more there are."""
    if len(problems) <= MAX_NAME_LINES:
        return list(problems)
    more = len(problems) - MAX_NAME_LINES
    return [*problems[:MAX_NAME_LINES], f"{more} more names are left out, too"]


def gaps_between(names: dict[int, str], fps: float) -> list[str]:
    """What is missing in the numbers of frames, a line each or one for all.

    Args:
        names: of the frames' images, by number, in order.
        fps: frames per second that the numbers are taken to count.
    """
    gaps = [(before, after) for before, after in pairwise(names) if after > before + 1]
    if len(gaps) > MAX_GAP_LINES:
        missing = sum(after - before - 1 for before, after in gaps)
        first, last = gaps[0][0], gaps[-1][1]
        line = f"{missing} frames are missing in {len(gaps)} gaps between"
        line = f"{line} {names[first]} and {names[last]}"
        if median(after - before for before, after in pairwise(names)) > LIKELY_STEP:
            line += (
                f"; at {fps:g} frames/s they last {(last - first) / fps:.0f} s. If the numbers are "
                "times, name images by seconds, as 12.345678.png"
            )
        return [line]
    return [
        (
            f"frame {before + 1} is"
            if after == before + 2
            else f"frames {before + 1}-{after - 1} are"
        )
        + f" missing between {names[before]} and {names[after]}"
        for before, after in gaps
    ]


def pauses_between(names: Sequence[str], times_s: Sequence[float]) -> list[str]:
    """One line on pauses between frames that come at these times, which rise; none without any."""
    steps = [after - before for before, after in pairwise(times_s)]
    limit = PAUSE_STEPS * median(steps) if steps else 0.0
    pauses = [k for k, step in enumerate(steps) if step > limit]
    if not pauses:
        return []
    longest = max(pauses, key=lambda k: steps[k])
    return [
        f"pauses between frames: {len(pauses)}, the longest {steps[longest]:.2f} s after "
        f"{names[longest]}; frames come every {median(steps):.3f} s"
    ]
