"""`.bvh`: one person as a skeleton with rotations, for Blender, MotionBuilder and the like.

M. Meredith and S. Maddock, "Motion capture file formats explained", University of Sheffield,
Department of Computer Science CS-01-11 (2001). Centimetres, y up; rotations in degrees, about z,
then x, then y of the turned axes. With all at zero the person stands upright with the arms hanging
and looks along z.
"""

from __future__ import annotations

from os import PathLike
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.geometry.rotations import zxy_from_rotations
from topview.io.writers.levelled import BodyMotion, EvenTimes
from topview.io.writers.output import write_made
from topview.skeletons import Skeletons, SkeletonSequence, in_memory

CM_PER_M: Final = 100.0
END_SHARE: Final = 0.3  # ours: of its last bone, by which a limb is drawn beyond its last joint
_ROTATIONS: Final = "Zrotation Xrotation Yrotation"


def write_skeletons_bvh(skeletons: Skeletons, path: str | PathLike[str]) -> None:
    """One person from the first frame to the last with them, at a constant rate.

    The format has no word for nobody: while the person is away the last pose stays. Bones have one
    length each, the median over the frames.

    Raises:
        InputError: there is not just one person, no frame has a pelvis, times do not grow, or it
            cannot be written; the old file, if any, is then unharmed.
    """
    sequence = in_memory(skeletons)
    write_made(Path(path), lambda: _text(sequence).encode("ascii"))


def _text(sequence: SkeletonSequence) -> str:
    motion = BodyMotion.of(sequence, "BVH")
    even = EvenTimes.of(motion.timestamps_s)
    held = even.rows[np.maximum.accumulate(np.where(even.rows >= 0, np.arange(len(even.rows)), 0))]
    angles_rad = np.unwrap(zxy_from_rotations(motion.Rs_parent_node)[held], axis=0)
    numbers = np.concatenate(
        [motion.root_m[held] * CM_PER_M, np.rad2deg(angles_rad).reshape(len(held), -1)], axis=1
    )
    order = _order(motion, 0)
    columns = [0, 1, 2, *(3 + 3 * node + axis for node in order for axis in range(3))]
    lines = [
        "HIERARCHY",
        *_hierarchy(motion, 0, ""),
        "MOTION",
        f"Frames: {len(held)}",
        f"Frame Time: {1.0 / even.rate_hz:.9g}",
        *(" ".join(f"{number:.6f}" for number in row) for row in numbers[:, columns].tolist()),
    ]
    return "\n".join(lines) + "\n"


def _children(motion: BodyMotion, node: int) -> list[int]:
    return [child for child, parent in enumerate(motion.parents) if parent == node]


def _order(motion: BodyMotion, node: int) -> list[int]:
    """The node and all below it, as the hierarchy lists them."""
    return [node, *(n for child in _children(motion, node) for n in _order(motion, child))]


def _hierarchy(motion: BodyMotion, node: int, indent: str) -> list[str]:
    is_root = motion.parents[node] < 0
    inner = indent + "  "
    channels = f"6 Xposition Yposition Zposition {_ROTATIONS}" if is_root else f"3 {_ROTATIONS}"
    below = [line for child in _children(motion, node) for line in _hierarchy(motion, child, inner)]
    end = motion.offsets_m[node] * END_SHARE
    return [
        f"{indent}{'ROOT' if is_root else 'JOINT'} {motion.names[node]}",
        f"{indent}{{",
        f"{inner}{_offset(motion.offsets_m[node])}",
        f"{inner}CHANNELS {channels}",
        *(below or [f"{inner}End Site", f"{inner}{{", f"{inner}  {_offset(end)}", f"{inner}}}"]),
        f"{indent}}}",
    ]


def _offset(offset_m: NDArray[np.float64]) -> str:
    return "OFFSET " + " ".join(f"{number:.6f}" for number in offset_m * CM_PER_M)
