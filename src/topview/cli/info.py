"""`topview info`: what is in a recording."""

from __future__ import annotations

import json as json_text
from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from topview.io import Contents, contents_of
from topview.lines import as_line


def info(source: Path, /, *, json: Annotated[bool, Parameter(negative="")] = False) -> int:
    """Tell what is in a recording, by a look at a few of its frames.

    Args:
        source: as for `topview track`.
        json: print all of it as one JSON object.
    """
    contents = contents_of(source)
    if json:
        print(json_text.dumps(asdict(contents)))
        return 0
    for what, told in lines_about(contents):
        print(f"{what:<8}{as_line(told)}")
    return 0


def lines_about(contents: Contents) -> list[tuple[str, str]]:
    """What each line is about, and what it tells."""
    lines = [
        ("name", contents.name),
        ("format", f"{contents.format}: {contents.reads}"),
        ("camera", _camera(contents.camera)),
        ("", f"noise as of {contents.camera['sensor']}, {_lens(contents.camera)}"),
        ("colour", _color(contents)),
    ]
    if contents.color_camera is not None:
        lines.append(("", _camera(contents.color_camera)))
    lines += [("frames", _frames(contents)), ("depth", _depth(contents))]
    if contents.camera.get("T_world_camera") is None:
        is_told = contents.camera.get("gravity_camera") is not None
        lines.append(("world", f"pose of the camera not known{', but gravity' if is_told else ''}"))
    return lines + [("note", problem) for problem in contents.problems]


def _camera(camera: dict[str, Any]) -> str:
    intrinsics = ", ".join(f"{key} {camera[key]:.2f}" for key in ("fx", "fy", "cx", "cy"))
    return f"{camera['width']} x {camera['height']} pixels, {intrinsics}"


def _lens(camera: dict[str, Any]) -> str:
    lens = camera.get("distortion")
    return "no lens distortion" if lens is None else f"lens {lens['model']}, undistorted here"


def _color(contents: Contents) -> str:
    if contents.color == "registered":
        return "registered to the depth"
    if contents.color == "none":
        return "none"
    return "of a camera of its own, registered to the depth here"


def _frames(contents: Contents) -> str:
    count = "an unknown number" if contents.frames is None else f"{contents.frames}"
    rate = "" if contents.frames_per_s is None else f" at {contents.frames_per_s:.1f} per second"
    length = "" if contents.length_s is None else f", {contents.length_s:.1f} s"
    return f"{count}{rate}{length}"


def _depth(contents: Contents) -> str:
    count = contents.frames_looked_at
    looked = "1 frame looked at" if count == 1 else f"{count} frames looked at"
    if contents.nearest_m is None:
        return f"no reading at all, {looked}"
    return (
        f"{contents.nearest_m:.2f} to {contents.farthest_m:.2f} m, median {contents.median_m:.2f}; "
        f"{contents.valid_share:.0%} of pixels have a reading; {looked}"
    )
