"""`.trc` and `.mot`: one person as OpenSim reads them, markers and joint angles over time.

OpenSim's documentation, "Marker (.trc) files" and "Motion (.mot) files". Ground has y up and its
origin on the floor below the camera: x right, z towards the camera. Segments have the axes that the
ISB recommends (Wu and Cavanagh 1995): x to the front, y up, z to the right.
"""

from __future__ import annotations

from os import PathLike
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.body.hierarchy import NODES, ROOT
from topview.body.limits import angles_rad
from topview.geometry.rotations import zxy_from_rotations
from topview.io.writers.levelled import (
    Y_UP_FROM_STAGE,
    EvenTimes,
    T_upright_camera,
    articulation_of,
    placed,
    the_one,
)
from topview.io.writers.output import write_made
from topview.lines import as_line
from topview.skeletons import Skeletons, SkeletonSequence, in_memory

Array = NDArray[np.float64]

MM_PER_M: Final = 1000.0
ISB_FROM_PART: Final = np.array([[0.0, 0.0, 1.0], [0.0, -1.0, 0.0], [1.0, 0.0, 0.0]])

# Node: names of its turns about z, x and y of ISB's axes, OpenSim's where it has some.
_OF_SPINE: Final = {
    "waist": ("lumbar_extension", "lumbar_bending", "lumbar_rotation"),
    "neck": ("neck_extension", "neck_bending", "neck_rotation"),
}
# The same of limbs; those of hinges have flexion alone.
_OF_LIMBS: Final = {
    "hip": ("hip_flexion", "hip_adduction", "hip_rotation"),
    "knee": ("knee_angle",),
    "shoulder": ("arm_flex", "arm_add", "arm_rot"),
    "elbow": ("elbow_flex",),
}
_PELVIS: Final = ("pelvis_tilt", "pelvis_list", "pelvis_rotation")


def write_skeletons_trc(skeletons: Skeletons, path: str | PathLike[str]) -> None:
    """The joints of one person as markers, millimetres, from the first frame to the last with them;
    those that are not known are empty.

    Raises:
        InputError: there is not just one person, or times do not grow, or it cannot be written; the
            old file, if any, is then unharmed.
    """
    sequence = in_memory(skeletons)
    write_made(Path(path), lambda: _markers(sequence, Path(path).name).encode("utf-8", "replace"))


def _markers(sequence: SkeletonSequence, name: str) -> str:
    person_id = the_one(sequence, "TRC")
    here, _ = sequence.slots_of(person_id)
    rows = slice(here[0], here[-1] + 1)
    T = T_upright_camera(sequence, Y_UP_FROM_STAGE)
    joints_camera = sequence.of_person(person_id).joints_camera[rows, 0]
    markers_mm = placed(joints_camera, T) * MM_PER_M
    timestamps_s = sequence.timestamps_s[rows]
    rate = f"{EvenTimes.of(timestamps_s).rate_hz:.6g}"
    frames, names = len(timestamps_s), sequence.joint_names
    lines = [
        f"PathFileType\t4\t(X/Y/Z)\t{as_line(name)}",
        "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\t"
        "OrigNumFrames",
        f"{rate}\t{rate}\t{frames}\t{len(names)}\tmm\t{rate}\t1\t{frames}",
        "\t".join(["Frame#", "Time", *(f"{name}\t\t" for name in names)]),
        "\t\t" + "\t".join(f"{axis}{n}" for n in range(1, len(names) + 1) for axis in "XYZ"),
        "",
    ]
    for number, (time_s, places) in enumerate(zip(timestamps_s, markers_mm, strict=True), 1):
        values = "\t".join(f"{v:.4f}" if np.isfinite(v) else "" for v in places.ravel().tolist())
        ended = "" if values[-1:].isdigit() else "\t"  # OpenSim drops one empty field at the end
        lines.append(f"{number}\t{time_s:.6f}\t{values}{ended}")
    return "\n".join(lines) + "\n"


def write_skeletons_mot(skeletons: Skeletons, path: str | PathLike[str]) -> None:
    """The joint angles of one person in the frames that have them: degrees, and metres for the
    pelvis. What each angle means is told in the project's table of outputs.

    Raises:
        InputError: there is not just one person, no frame has a pelvis, or it cannot be written;
            the old file, if any, is then unharmed.
    """
    sequence = in_memory(skeletons)
    write_made(Path(path), lambda: _coordinates(sequence).encode("ascii"))


def _coordinates(sequence: SkeletonSequence) -> str:
    timestamps_s, columns = joint_angles(sequence)
    table = np.column_stack([timestamps_s, *columns.values()])
    lines = [
        "Coordinates",
        "version=1",
        f"nRows={len(table)}",
        f"nColumns={table.shape[1]}",
        "inDegrees=yes",
        "endheader",
        "\t".join(["time", *columns]),
        *("\t".join(f"{number:.6f}" for number in row) for row in table.tolist()),
    ]
    return "\n".join(lines) + "\n"


def joint_angles(sequence: SkeletonSequence) -> tuple[Array, dict[str, Array]]:
    """[N] seconds of the frames that have the one person, and [N] of every coordinate by name:
    angles in degrees, `pelvis_tx`, `_ty` and `_tz` in metres.

    Raises:
        InputError: there is not just one person, or no frame has a pelvis.
    """
    rows, body = articulation_of(sequence, the_one(sequence, "MOT"))
    T = T_upright_camera(sequence, Y_UP_FROM_STAGE)
    R_ground_pelvis = T[:3, :3] @ body.Rs_parent_node[:, ROOT] @ ISB_FROM_PART.T
    columns = _turns(_PELVIS, zxy_from_rotations(R_ground_pelvis))
    for axis, along in zip("xyz", placed(body.root_camera, T).T, strict=True):
        columns[f"pelvis_t{axis}"] = along
    for n, node in enumerate(NODES):
        R = body.Rs_parent_node[:, n]
        side, _, kind = node.name.partition("_")
        if not body.known[n]:
            continue
        if node.name in _OF_SPINE:
            turns = zxy_from_rotations(ISB_FROM_PART @ R @ ISB_FROM_PART.T)
            columns |= _turns(_OF_SPINE[node.name], turns)
        elif kind in _OF_LIMBS:
            names = [f"{name}_{side[0]}" for name in _OF_LIMBS[kind]]
            columns |= _turns(names, _limb_turns(node.part, R, kind, side))
    return sequence.timestamps_s[rows], columns


def _limb_turns(part: int, R: Array, kind: str, side: str) -> Array:
    """[N, 3] flexion, adduction and inward turn; the table of parts has them about its x, z and
    (pointing down) y, and a knee's flexion as a negative turn."""
    x, y, z = np.moveaxis(angles_rad(part, R), -1, 0)
    inwards = 1.0 if side == "right" else -1.0
    flexion = -x if kind == "knee" else x
    return np.stack([flexion, inwards * z, -inwards * y], -1)


def _turns(names: tuple[str, ...] | list[str], turns_rad: Array) -> dict[str, Array]:
    """By name, without jumps of a full turn, degrees."""
    turns_deg = np.rad2deg(np.unwrap(turns_rad, axis=0))
    return {name: turns_deg[:, k] for k, name in enumerate(names)}
