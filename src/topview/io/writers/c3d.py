"""`.c3d`: everybody's joints as labelled points, for programs of motion capture and gait.

"The C3D File Format", Motion Lab Systems. Millimetres, z up: x right, y away from the camera,
origin on the floor below it.
"""

from __future__ import annotations

from os import PathLike
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Final

import numpy as np

from topview.io.writers.extras import needed
from topview.io.writers.levelled import Z_UP_FROM_STAGE, EvenTimes, T_upright_camera, placed
from topview.io.writers.opensim import MM_PER_M
from topview.io.writers.output import write_made
from topview.records import InputError
from topview.skeletons import Skeletons, SkeletonSequence, in_memory

UNKNOWN_RESIDUAL: Final = -1.0  # the format's residual of a point that is not known
MOST_C3D_FRAMES: Final = 65_535  # that the format counts


def write_skeletons_c3d(skeletons: Skeletons, path: str | PathLike[str]) -> None:
    """Points `person1:head`, `person1:neck` ... of everybody in all frames, at a constant rate; a
    point that is not known, or whose person is not there, has a residual of -1.

    Raises:
        InputError: ezc3d is not installed, nobody is there, there are too many frames, times do not
            grow, or it cannot be written; the old file, if any, is then unharmed.
    """
    ezc3d = needed("ezc3d", "C3D", "c3d")
    sequence = in_memory(skeletons)
    write_made(Path(path), lambda: _file(sequence, ezc3d))


def _file(sequence: SkeletonSequence, ezc3d: Any) -> bytes:
    if not len(sequence.people_ids):
        raise InputError("has no person; C3D needs points")
    even = EvenTimes.of(sequence.timestamps_s)
    if len(even.rows) > MOST_C3D_FRAMES:
        raise InputError(f"would have {len(even.rows)} frames; C3D has at most {MOST_C3D_FRAMES}")
    T = T_upright_camera(sequence, Z_UP_FROM_STAGE)
    people = sequence.people_ids.tolist()
    joints_camera = np.concatenate([sequence.of_person(p).joints_camera[:, 0] for p in people], 1)
    points_mm = even.values(placed(joints_camera, T) * MM_PER_M).T
    known = np.isfinite(points_mm).all(0)

    file = ezc3d.c3d()
    points = file["parameters"]["POINT"]
    points["UNITS"]["value"] = ["mm"]
    points["RATE"]["value"] = [even.rate_hz]
    points["LABELS"]["value"] = [
        f"person{p}:{name}" for p in people for name in sequence.joint_names
    ]
    file.add_parameter("POINT", "X_SCREEN", ["+X"])
    file.add_parameter("POINT", "Y_SCREEN", ["+Z"])
    file["data"]["points"] = np.concatenate([points_mm, np.ones((1, *known.shape))])
    file["data"]["meta_points"]["residuals"] = np.where(known, 0.0, UNKNOWN_RESIDUAL)[None]
    with TemporaryDirectory(prefix="topview-c3d-") as folder:  # it writes to paths only
        made = Path(folder) / "made.c3d"
        file.write(str(made))
        return made.read_bytes()
