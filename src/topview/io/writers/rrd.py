"""`.rrd`: everybody for the viewer of rerun, https://rerun.io, by its own library.

The world has z up; the camera stands in it. Times are those of the frames, on the timeline `time`;
`frame` has their numbers.
"""

from __future__ import annotations

from os import PathLike
from pathlib import Path
from typing import Any, Final

import numpy as np

from topview.body import OUTPUT_JOINT_NAMES, OUTPUT_JOINTS
from topview.io.writers.extras import needed
from topview.io.writers.levelled import (
    ROS_FROM_STAGE,
    T_upright_camera,
    T_world_camera,
    check_times_grow,
    joints_and_parts,
)
from topview.io.writers.output import written_atomically
from topview.records import JOINT_STATE_NAMES
from topview.skeletons import Skeletons, SkeletonSequence

CAMERA_PLACE: Final = "world/camera"
RECORDING_ID: Final = "topview"  # the same each time, as rerun would draw one
JOINT_RADIUS_M: Final = 0.025  # ours: as drawn
PART_AXIS_M: Final = 0.1  # ours: as drawn


def write_skeletons_rrd(skeletons: Skeletons, path: str | PathLike[str]) -> None:
    """Joints of all people with their bones, names, states and confidences, and the poses of their
    parts; whoever is not there is cleared.

    Raises:
        InputError: rerun-sdk is not installed, the joints or parts are not topview's, times do not
            grow, or it cannot be written; the old file, if any, is then unharmed.
    """
    rr = needed("rerun", "rrd", "view")
    stream = _Stream(rr)
    with written_atomically(Path(path)) as file:
        for block in skeletons.blocks():
            stream.add(block)
            file.write(stream.read())


class _Stream:
    """A recording of rerun's, as the bytes of its file."""

    def __init__(self, rr: Any) -> None:
        self._rr = rr
        self._to: Any = rr.RecordingStream(
            "topview", recording_id=RECORDING_ID, send_properties=False
        )
        self._to.set_log_time_enabled(False)  # when it was written is no part of a result
        self._bytes: Any = self._to.binary_stream()
        self._shown: set[int] = set()
        self._last_s: float | None = None

    def add(self, block: SkeletonSequence) -> None:
        """The next frames."""
        if self._last_s is None:
            self._add_world(block)
        before = [] if self._last_s is None else [self._last_s]
        check_times_grow(np.array([*before, *block.timestamps_s.tolist()]))
        for row, time_s in enumerate(block.timestamps_s.tolist()):
            self._add_frame(block, row)
            self._last_s = time_s

    def read(self) -> bytes:
        """What has not been read yet."""
        return self._bytes.read() or b""

    def _add_world(self, block: SkeletonSequence) -> None:
        rr, camera = self._rr, block.camera
        T = T_world_camera(block)
        if not np.isfinite(T).all():
            T = T_upright_camera(block, ROS_FROM_STAGE)
        bones = [(joint.bone_to, j) for j, joint in enumerate(OUTPUT_JOINTS) if joint.bone_to >= 0]
        names = [rr.AnnotationInfo(id=j, label=name) for j, name in enumerate(OUTPUT_JOINT_NAMES)]
        skeleton = rr.ClassDescription(
            info=rr.AnnotationInfo(id=0, label="person"),
            keypoint_annotations=names,
            keypoint_connections=bones,
        )
        self._log("world", rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
        self._log("world", rr.AnnotationContext(skeleton), static=True)
        placed = rr.Transform3D(translation=T[:3, 3], mat3x3=T[:3, :3])
        self._log(CAMERA_PLACE, placed, static=True)
        if camera is not None:
            lens = rr.Pinhole(
                focal_length=[camera.fx, camera.fy],
                principal_point=[camera.cx + 0.5, camera.cy + 0.5],  # its pixels' corners are whole
                resolution=[camera.width, camera.height],
                camera_xyz=rr.ViewCoordinates.RDF,
            )
            self._log(f"{CAMERA_PLACE}/image", lens, static=True)

    def _add_frame(self, block: SkeletonSequence, row: int) -> None:
        rr = self._rr
        self._to.set_time("time", duration=float(block.timestamps_s[row]))
        self._to.set_time("frame", sequence=int(block.frame_index[row]))
        slots = np.flatnonzero(block.present[row])
        people = block.person_ids[row, slots].tolist()
        joints, Ts = joints_and_parts(block, np.full(len(slots), row), slots)
        for k, (person, slot) in enumerate(zip(people, slots.tolist(), strict=True)):
            known = np.flatnonzero(np.isfinite(joints[k]).all(-1))
            stored = [block.joint_names.index(OUTPUT_JOINT_NAMES[j]) for j in known]
            states = [JOINT_STATE_NAMES[state] for state in block.joint_state[row, slot, stored]]
            points = rr.Points3D(
                joints[k, known],
                radii=JOINT_RADIUS_M,
                class_ids=0,
                keypoint_ids=known,
                show_labels=False,
            )
            own = rr.AnyValues(state=states, confidence=block.joint_confidence[row, slot, stored])
            self._log(f"{_place(person)}/joints", points, own)
            parts = np.isfinite(Ts[k]).all((-1, -2))
            axes = rr.Arrows3D(
                origins=Ts[k, parts, :3, 3], vectors=PART_AXIS_M * Ts[k, parts, :3, 2]
            )
            self._log(f"{_place(person)}/fronts_of_parts", axes)
        for person in sorted(self._shown - set(people)):
            self._log(_place(person), rr.Clear(recursive=True))
        self._shown = set(people)

    def _log(self, place: str, *what: Any, static: bool = False) -> None:
        self._to.log(place, *what, static=static)


def _place(person_id: int) -> str:
    return f"{CAMERA_PLACE}/person_{person_id}"
