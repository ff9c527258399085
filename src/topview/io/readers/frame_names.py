"""The numbers of frames, by the names of their images.

The last number in a name is that of its frame; what is around it is the same in all names, or they
are of two cameras. A time stamp is no frame number: taken for one, its seconds would be lost, and
frames put out of order. It is told by a dot between two numbers, or by being as great as the
seconds, milliseconds or nanoseconds since 1970.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import PurePath
from typing import Final

from topview.records import InputError

MOST_FRAME_NUMBER: Final = 10**9  # ours; a year at 30 frames a second; 10^9 seconds ended in 2001
MAX_NAME_LINES: Final = 5  # names that are left out beyond these share one line
_LAST_NUMBER: Final = re.compile(r"(.*?)([0-9]+)([^0-9]*)", re.DOTALL)
_SECONDS: Final = re.compile(r"[0-9]+\.[0-9]+|.*[0-9]{9,}\.[0-9]+", re.DOTALL)
_RIGHT: Final = "it must be numbered from the first frame on, as 000000.png is"


def by_number(names: Iterable[str]) -> tuple[dict[int, str], list[str]]:
    """The names by their frames' numbers, in order, and what is wrong with those left out, a line
    each, the first few.

    Args:
        names: of image files, with their suffixes.

    Raises:
        InputError: most of them are time stamps, or they are of more than one camera.
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
    if len(around) > 1:
        first, second = list(around.values())[:2]
        raise InputError(
            f"{first} and {second}: differ in more than their last number, that of the frame; all "
            "names must be alike around it, and images of one camera only"
        )
    problems += [
        f"{name}: seems to be named by a time stamp; {_RIGHT}; left out" for name in stamps
    ]
    if len(problems) > MAX_NAME_LINES:
        more = len(problems) - MAX_NAME_LINES
        problems = [*problems[:MAX_NAME_LINES], f"{more} more names are left out, too"]
    return dict(sorted(numbered.items())), problems
