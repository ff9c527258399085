"""What a tracked sequence is measured against."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from topview.records import InputError, read_only


@dataclass(frozen=True, slots=True, eq=False)
class ReferenceSequence:
    """The reference skeletons of a recording: F frames, R people, K joints.

    Frames without a reference are left out of `frame_index`, and then are not evaluated.

    Attributes:
        frame_index: [F] int64, numbers of the recording's frames, rising.
        person_ids: [R] int64.
        joint_names: K names, all of them in `topview.body.JOINT_NAMES`.
        joints_camera: [F, R, K, 3] float64 metres, NaN where unknown.
        present: [F, R] bool, True where the person is in view.
        occluded_by_person: [F, R, K] share 0..1 of the joint that another person hides, NaN where
            unknown; or None.
        statures_m: [R] metres, NaN where unknown; or None.

    Raises:
        InputError: a shape does not fit, or a person is present without a single known joint.
    """

    frame_index: NDArray[np.int64]
    person_ids: NDArray[np.int64]
    joint_names: tuple[str, ...]
    joints_camera: NDArray[np.float64]
    present: NDArray[np.bool_]
    occluded_by_person: NDArray[np.float64] | None = None
    statures_m: NDArray[np.float64] | None = None

    def __post_init__(self) -> None:
        F, R, K = len(self.frame_index), len(self.person_ids), len(self.joint_names)
        expected = {
            "joints_camera": (F, R, K, 3),
            "present": (F, R),
            "occluded_by_person": (F, R, K),
            "statures_m": (R,),
        }
        for name, shape in expected.items():
            array = getattr(self, name)
            if array is None:
                continue
            if array.shape != shape:
                raise InputError(f"reference {name} has shape {array.shape}; it must be {shape}")
            read_only(array)
        if np.any(np.diff(self.frame_index) <= 0):
            raise InputError("reference frame_index does not rise; each frame must be given once")
        unknown = self.present & ~np.isfinite(self.joints_camera).all(-1).any(-1)
        if unknown.any():
            f, r = np.argwhere(unknown)[0]
            raise InputError(
                f"reference person {self.person_ids[r]} is present in frame {self.frame_index[f]} "
                "but all joints are NaN; at least one must be known"
            )
