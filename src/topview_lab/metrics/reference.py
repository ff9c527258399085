"""Reference skeletons that a tracked sequence is measured against."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from topview.records import InputError, read_only

SHARE_FIELDS: Final = ("occluded_by_person", "occluded_by_object", "occluded_by_self", "outside")
SHARE_ROUNDING: Final = 1e-3  # ours: shares are written in single precision, or in thousandths


@dataclass(frozen=True, slots=True, eq=False)
class ReferenceSequence:
    """The reference skeletons of a recording: F frames, R people, K joints, B parts.

    Frames without a reference are left out of `frame_index` and not evaluated. A field that is None
    is unknown in the whole recording.

    Attributes:
        frame_index: [F] int64, numbers of the recording's frames, rising.
        person_ids: [R] int64.
        joint_names: K names, all of them in `topview.body.OUTPUT_JOINT_NAMES`.
        joints_camera: [F, R, K, 3] float64 metres, NaN where unknown.
        present: [F, R] bool, True where the person is in view.
        occluded_by_person: [F, R, K] share 0..1 of the joint that another person hides, NaN where
            unknown; or None.
        statures_m: [R] metres, NaN where unknown; or None.
        occluded_by_object: [F, R, K] share that furniture or another object hides, as above.
        occluded_by_self: [F, R, K] share that the person's own body hides, as above.
        outside: [F, R, K] share that lies outside the image, as above.
        actions: [F, R] str, what the person does, "" where unknown; or None.
        bodies: R descriptions of the people's bodies, such as "woman 1.62 m"; or None.
        part_names: B names, all of them in `topview.body.PART_NAMES`.
        Rs_camera_part: [F, R, B, 3, 3] orientation of the parts, axes as in
            `topview.records.Person`, NaN where unknown; or None.

    Raises:
        InputError: a shape or a share does not fit, or a person is present without a single known
            joint.
    """

    frame_index: NDArray[np.int64]
    person_ids: NDArray[np.int64]
    joint_names: tuple[str, ...]
    joints_camera: NDArray[np.float64]
    present: NDArray[np.bool_]
    occluded_by_person: NDArray[np.float64] | None = None
    statures_m: NDArray[np.float64] | None = None
    occluded_by_object: NDArray[np.float64] | None = None
    occluded_by_self: NDArray[np.float64] | None = None
    outside: NDArray[np.float64] | None = None
    actions: NDArray[np.str_] | None = None
    bodies: tuple[str, ...] | None = None
    part_names: tuple[str, ...] = ()
    Rs_camera_part: NDArray[np.float64] | None = None

    def __post_init__(self) -> None:
        F, R, K = len(self.frame_index), len(self.person_ids), len(self.joint_names)
        expected: dict[str, tuple[int, ...]] = {
            "joints_camera": (F, R, K, 3),
            "present": (F, R),
            "statures_m": (R,),
            "actions": (F, R),
            "Rs_camera_part": (F, R, len(self.part_names), 3, 3),
            **dict.fromkeys(SHARE_FIELDS, (F, R, K)),
        }
        for name, shape in expected.items():
            array = getattr(self, name)
            if array is None:
                continue
            if array.shape != shape:
                raise InputError(f"reference {name} has shape {array.shape}; it must be {shape}")
            read_only(array)
        for name in SHARE_FIELDS:
            if (shares := getattr(self, name)) is not None:
                _check_shares(name, shares)
        if self.bodies is not None and len(self.bodies) != R:
            raise InputError(
                f"reference bodies describes {len(self.bodies)} people; it must be {R}, "
                "as many as person_ids"
            )
        if np.any(np.diff(self.frame_index) <= 0):
            raise InputError("reference frame_index does not rise; each frame must be given once")
        unknown = self.present & ~np.isfinite(self.joints_camera).all(-1).any(-1)
        if unknown.any():
            f, r = np.argwhere(unknown)[0]
            raise InputError(
                f"reference person {self.person_ids[r]} is present in frame {self.frame_index[f]} "
                "but all joints are NaN; at least one must be known"
            )


def _check_shares(name: str, shares: NDArray[Any]) -> None:
    beyond = shares[(shares < -SHARE_ROUNDING) | (shares > 1.0 + SHARE_ROUNDING)]
    if beyond.size:
        raise InputError(f"reference {name} has the share {beyond[0]:g}; it must be 0 to 1, or NaN")
