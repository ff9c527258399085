"""Motion capture in the Biovision hierarchy format, `.bvh`: skeleton and joint angles as text.

M. Meredith and S. Maddock, "Motion capture file formats explained", University of Sheffield,
Department of Computer Science CS-01-11 (2001). A joint's rotation is the product of its channels'
in the order that they are listed; angles are degrees, lengths have the unit of the recording.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from topview.files import naming, read_text
from topview.records import InputError

END_SITE: Final = " end"
"""Suffix of an end site's name, after its joint's."""
_CHANNELS: Final = tuple(axis + kind for kind in ("position", "rotation") for axis in "XYZ")
_RIGHT: Final = "it must be a BVH file: HIERARCHY, then MOTION"


@dataclass(frozen=True, slots=True)
class Node:
    """A joint or end site: name, index of its parent (-1: root), offset in the parent's frame, and
    its channels' names."""

    name: str
    parent: int
    offset: tuple[float, float, float]
    channels: tuple[str, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Motion:
    """Nodes, parents before children, the [F, C] values of all their channels, and the seconds
    between two frames."""

    nodes: tuple[Node, ...]
    values: NDArray[np.float64]
    frame_time_s: float

    def __len__(self) -> int:
        return len(self.values)

    def positions(self, frames: NDArray[np.integer]) -> dict[str, NDArray[np.float64]]:
        """[len(frames), 3] of every node, in the recording's frame and unit."""
        values = self.values[frames]
        rotations: list[Rotation] = []
        positions: list[NDArray[np.float64]] = []
        column = 0
        for node in self.nodes:
            own = dict(zip(node.channels, values[:, column:].T, strict=False))
            column += len(node.channels)
            shift = np.array(node.offset) + np.stack(
                [own.get(f"{axis}position", np.zeros(len(values))) for axis in "XYZ"], -1
            )
            turn = Rotation.identity(len(values))
            for channel in node.channels:
                if channel.endswith("rotation"):
                    turn = turn * Rotation.from_euler(
                        channel[0], own[channel][:, None], degrees=True
                    )
            if node.parent < 0:
                positions.append(shift)
                rotations.append(turn)
            else:
                around = rotations[node.parent]
                positions.append(positions[node.parent] + around.apply(shift))
                rotations.append(around * turn)
        return {node.name: at for node, at in zip(self.nodes, positions, strict=True)}


def read_bvh(path: Path) -> Motion:
    """A whole `.bvh` file.

    Raises:
        InputError: missing, truncated, or not such a file.
    """
    with naming(path, right=_RIGHT):
        hierarchy, _, motion = read_text(path, "ascii", _RIGHT).partition("MOTION")
        try:
            nodes = _hierarchy(hierarchy.split())
            return _motion(nodes, motion.split())
        except (IndexError, ValueError) as error:
            if isinstance(error, InputError):
                raise
            raise InputError(f"is truncated or damaged ({error}); {_RIGHT}") from None


def _hierarchy(words: list[str]) -> tuple[Node, ...]:
    if words[:1] != ["HIERARCHY"]:
        raise InputError(f"does not begin with HIERARCHY; {_RIGHT}")
    nodes: list[Node] = []
    open_nodes: list[int] = []
    at = 1
    while at < len(words):
        word = words[at]
        if word == "}":
            open_nodes.pop()
            at += 1
            continue
        if word not in ("ROOT", "JOINT", "End"):
            raise InputError(f"has {word!r} where ROOT, JOINT, End Site or }} must be; {_RIGHT}")
        parent = open_nodes[-1] if open_nodes else -1
        name = nodes[parent].name + END_SITE if word == "End" else words[at + 1]
        if words[at + 2 : at + 4] != ["{", "OFFSET"]:
            raise InputError(f"has no OFFSET for {name}; {_RIGHT}")
        x, y, z = (float(number) for number in words[at + 4 : at + 7])
        at += 7
        channels: tuple[str, ...] = ()
        if word != "End" and words[at] == "CHANNELS":
            count = int(words[at + 1])
            channels = tuple(words[at + 2 : at + 2 + count])
            at += 2 + count
            if unknown := [channel for channel in channels if channel not in _CHANNELS]:
                raise InputError(f"has the channel {unknown[0]}; it must be {', '.join(_CHANNELS)}")
        open_nodes.append(len(nodes))
        nodes.append(Node(name, parent, (x, y, z), channels))
    if open_nodes or not nodes:
        raise InputError(f"has a hierarchy that does not end; {_RIGHT}")
    return tuple(nodes)


def _motion(nodes: tuple[Node, ...], words: list[str]) -> Motion:
    if words[:1] != ["Frames:"] or words[2:4] != ["Frame", "Time:"]:
        raise InputError(f"has no MOTION with Frames: and Frame Time:; {_RIGHT}")
    frames, frame_time_s = int(words[1]), float(words[4])
    columns = sum(len(node.channels) for node in nodes)
    values = np.array(words[5:], np.float64)
    if not frames or len(values) != frames * columns or not np.isfinite(values).all():
        raise InputError(
            f"has {len(values)} numbers for {frames} frames of {columns} channels; "
            f"it must have {frames * columns} finite ones"
        )
    return Motion(nodes, values.reshape(frames, columns), frame_time_s)
