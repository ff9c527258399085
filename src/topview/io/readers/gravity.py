"""Where down is, by an accelerometer at rest."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.records import Camera, InputError

GRAVITY_M_S2: Final = 9.80665  # standard gravity, ISO 80000-3
STILL_M_S2: Final = 0.5  # ours; so far from it the length may be of what is at rest
BEGINNING_S: Final = 1.0  # ours; of the beginning of a recording that is looked at
MOST_SAMPLES: Final = 2000  # ours; somewhat more than the fastest of these sensors gives in that


def levelled_by(
    camera: Camera,
    accelerations_imu: Sequence[NDArray[np.float64]],
    R_camera_imu: NDArray[np.float64],
    problems: list[str],
) -> Camera:
    """The camera with its gravity, if that is told; a problem is added where it is not.

    Args:
        camera: as it is known without.
        accelerations_imu: N of [3], m/s^2, in the sensor's own frame; at rest they point up.
        R_camera_imu: [3, 3].
        problems: of the recording.
    """
    if not len(accelerations_imu):
        return camera
    with np.errstate(all="ignore"):  # a damaged file may hold any numbers
        up_imu = np.median(np.array(accelerations_imu, np.float64), axis=0)
        length = float(np.linalg.norm(up_imu))
    if not abs(length - GRAVITY_M_S2) < STILL_M_S2:
        problems.append(
            f"the accelerometer tells {length:.1f} m/s^2, and {GRAVITY_M_S2:.1f} at rest; gravity "
            "is left to the floor"
        )
        return camera
    try:
        return replace(camera, gravity_camera=-R_camera_imu @ up_imu)
    except InputError:
        problems.append(
            "by the accelerometer the camera is tilted by more than 60 degrees; gravity is left to "
            "the floor"
        )
        return camera
