"""`.mcap`: everybody as ROS 2 tells of people, for RViz, Foxglove and `ros2 bag play`, by rosbags.

Topics and frames are those of ROS4HRI (REP 155), axes those of REP 103: x to the person's front, y
left, z up. Frames of the body hang from the camera's, whose place in the world is static.
"""

from __future__ import annotations

import shutil
from colorsys import hsv_to_rgb
from contextlib import ExitStack
from os import PathLike
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from topview.body.hierarchy import NODES, ROOT, WAIST, nodes_of
from topview.body.parts import OUTPUT_JOINT_NAMES, OUTPUT_JOINTS
from topview.files import naming
from topview.geometry.rotations import are_rotations
from topview.io.readers.ros_messages import TRANSFORMS_TYPE, standard_types
from topview.io.writers.extras import needed
from topview.io.writers.levelled import (
    ROS_FROM_STAGE,
    T_upright_camera,
    T_world_camera,
    check_times_grow,
    joints_and_parts,
)
from topview.io.writers.output import HAS_ROOM, written_atomically
from topview.io.writers.ros4hri import (
    DEFINITIONS,
    IDS_TYPE,
    POINT_TYPE,
    ROS_FROM_PART,
    SKELETON_TYPE,
    body_id,
    frame_name,
    joint_turns,
    keypoints,
)
from topview.io.writers.ros_made import (
    CAMERA_FRAME,
    LINES,
    REMOVE_ALL,
    SPHERES,
    Messages,
    nanoseconds,
    offered_qos,
)
from topview.records import InputError, JointState
from topview.skeletons import Skeletons, SkeletonSequence

Array = NDArray[np.float64]

WORLD_FRAME: Final = "world"
JOINTS_TYPE: Final = "sensor_msgs/msg/JointState"
MARKERS_TYPE: Final = "visualization_msgs/msg/MarkerArray"
MARKER_JOINT_M, MARKER_BONE_M = 0.05, 0.02  # ours: as thick as markers are drawn
HIDDEN_ALPHA: Final = 0.35  # ours: of what is not visible


def write_skeletons_mcap(skeletons: Skeletons, path: str | PathLike[str]) -> None:
    """Transforms and markers of all people, at the times of the frames.

    Raises:
        InputError: rosbags is not installed, the joints or parts are not topview's, times do not
            grow from 0 on, or it cannot be written; the old file, if any, is then unharmed.
    """
    needed("rosbags", "mcap", "ros")
    path = Path(path)
    with ExitStack() as stack:
        with naming(path, "written", HAS_ROOM):
            beside = TemporaryDirectory(prefix=".topview-", dir=path.parent)
            folder = Path(stack.enter_context(beside)) / "bag"
            with _Bag(folder) as bag:
                for block in skeletons.blocks():
                    bag.add(block)
        with written_atomically(path) as file, (folder / "bag.mcap").open("rb") as made:
            shutil.copyfileobj(made, file)


class _Bag:
    """A bag that grows frame by frame."""

    def __init__(self, folder: Path) -> None:
        from rosbags import rosbag2
        from rosbags.typesys import get_types_from_msg

        self._store = standard_types(False)
        for name, definition in DEFINITIONS.items():
            if name not in self._store.types:
                self._store.register(get_types_from_msg(definition, name))
        plugin = rosbag2.StoragePlugin.MCAP
        self._writer: Any = rosbag2.Writer(folder, version=9, storage_plugin=plugin)
        self._made = Messages(self._store.types)
        self._topics: dict[str, Any] = {}
        self._shown: set[int] = set()
        self._last_s = -np.inf

    def __enter__(self) -> _Bag:
        self._writer.open()
        return self

    def __exit__(self, *_: object) -> None:
        self._writer.close()

    def add(self, block: SkeletonSequence) -> None:
        """The next frames."""
        times_s = block.timestamps_s
        check_times_grow(np.concatenate([[self._last_s], times_s]))
        if len(times_s) and times_s[0] < 0.0:
            raise InputError(f"timestamps_s begins at {times_s[0]:g}; times of ROS are 0 or more")
        if len(times_s) and not self._topics:
            self._add_world(block, float(times_s[0]))
        for row, time_s in enumerate(times_s.tolist()):
            self._add_frame(block, row, time_s)
            self._last_s = time_s

    def _add_world(self, block: SkeletonSequence, time_s: float) -> None:
        T = T_world_camera(block)
        if not np.isfinite(T).all():
            T = T_upright_camera(block, ROS_FROM_STAGE)
        placed = self._made.transform(WORLD_FRAME, CAMERA_FRAME, T[:3, :3], T[:3, 3], time_s)
        self._write("/tf_static", TRANSFORMS_TYPE, time_s, transforms=[placed])

    def _add_frame(self, block: SkeletonSequence, row: int, time_s: float) -> None:
        slots = np.flatnonzero(block.present[row])
        people = block.person_ids[row, slots].tolist()
        joints, Ts = joints_and_parts(block, np.full(len(slots), row), slots)
        transforms = [
            transform
            for person, own_joints, own_Ts in zip(people, joints, Ts, strict=True)
            for transform in self._body(body_id(person), own_joints, own_Ts, time_s)
        ]
        self._write("/tf", TRANSFORMS_TYPE, time_s, transforms=transforms)
        header, ids = self._made.header(CAMERA_FRAME, time_s), list(map(body_id, people))
        self._write("/humans/bodies/tracked", IDS_TYPE, time_s, header=header, ids=ids)
        order = [block.joint_names.index(name) for name in OUTPUT_JOINT_NAMES]
        for k, (person, slot) in enumerate(zip(people, slots.tolist(), strict=True)):
            is_seen = block.joint_state[row, slot, order] == JointState.VISIBLE
            markers = self._markers(person, joints[k], is_seen, time_s)
            self._write(_topic(person, "markers"), MARKERS_TYPE, time_s, markers=markers)
            self._write_turns(person, joints[k], Ts[k], time_s)
            if block.camera is not None:
                confidence = block.joint_confidence[row, slot, order]
                points = keypoints(joints[k], confidence, block.camera)
                self._write_places(person, points, time_s)
        for person in sorted(self._shown - set(people)):
            markers = [self._made.marker(0, REMOVE_ALL, 0.0, 0, time_s, [], [])]
            self._write(_topic(person, "markers"), MARKERS_TYPE, time_s, markers=markers)
        self._shown = set(people)

    def _body(self, body: str, joints_camera: Array, Ts_camera_part: Array, time_s: float) -> Any:
        """The known frames of one person."""
        offsets_m, Rs = (made[0] for made in nodes_of(joints_camera[None], Ts_camera_part[None]))
        is_known = np.isfinite(offsets_m).all(-1) & are_rotations(Rs)
        for n, node in enumerate(NODES):
            if not is_known[n]:
                continue
            own = frame_name(node.name, body)
            if n == ROOT:
                R = Rs[n] @ ROS_FROM_PART.T
                yield self._made.transform(CAMERA_FRAME, own, R, offsets_m[n], time_s)
                continue
            parent = frame_name(NODES[node.parent].name, body)
            R, offset_m = ROS_FROM_PART @ Rs[n] @ ROS_FROM_PART.T, ROS_FROM_PART @ offsets_m[n]
            yield self._made.transform(parent, own, R, offset_m, time_s)
            if node.name == WAIST:  # REP 155 has the torso fixed to it
                yield self._made.transform(own, f"torso_{body}", np.eye(3), np.zeros(3), time_s)

    def _markers(
        self, person: int, joints_camera: Array, is_seen: NDArray[np.bool_], time_s: float
    ) -> list[Any]:
        """Joints as spheres and bones as lines; what is not visible is faint."""
        is_known = np.array(np.isfinite(joints_camera).all(-1))
        bones = [(j, joint.bone_to) for j, joint in enumerate(OUTPUT_JOINTS) if joint.bone_to >= 0]
        ends = [end for a, b in bones if is_known[a] and is_known[b] for end in (a, b)]
        make = self._store.types
        r, g, b = hsv_to_rgb(0.618 * person % 1.0, 0.8, 0.95)
        point, color = make["geometry_msgs/msg/Point"], make["std_msgs/msg/ColorRGBA"]

        def marker(number: int, kind: int, width_m: float, joints: list[int]) -> Any:
            points = [point(*joints_camera[j].tolist()) for j in joints]
            colors = [color(r, g, b, 1.0 if is_seen[j] else HIDDEN_ALPHA) for j in joints]
            return self._made.marker(number, 0, width_m, kind, time_s, points, colors)

        return [
            marker(0, SPHERES, MARKER_JOINT_M, np.flatnonzero(is_known).tolist()),
            marker(1, LINES, MARKER_BONE_M, ends),
        ]

    def _write_turns(
        self, person: int, joints_camera: Array, Ts_camera_part: Array, time_s: float
    ) -> None:
        _, Rs = nodes_of(joints_camera[None], Ts_camera_part[None])
        turns = joint_turns(Rs[0])
        fields: dict[str, Any] = {
            "header": self._made.header(f"body_{body_id(person)}", time_s),
            "name": [f"{name}_{body_id(person)}" for name in turns],
            "position": np.array(list(turns.values())),
        }
        nothing = {"velocity": np.zeros(0), "effort": np.zeros(0)}
        self._write(_topic(person, "joint_states"), JOINTS_TYPE, time_s, **fields, **nothing)

    def _write_places(self, person: int, points: Array, time_s: float) -> None:
        point = self._store.types[POINT_TYPE]
        header = self._made.header(CAMERA_FRAME, time_s)
        skeleton = [point(*values) for values in points.tolist()]
        topic = _topic(person, "skeleton2d")
        self._write(topic, SKELETON_TYPE, time_s, header=header, skeleton=skeleton)

    def _write(self, topic: str, kind: str, time_s: float, **fields: Any) -> None:
        if topic not in self._topics:
            self._topics[topic] = self._writer.add_connection(
                topic, kind, typestore=self._store, offered_qos_profiles=offered_qos(topic)
            )
        data = self._store.serialize_cdr(self._store.types[kind](**fields), kind)
        self._writer.write(self._topics[topic], nanoseconds(time_s), data)


def _topic(person_id: int, what: str) -> str:
    return f"/humans/bodies/{body_id(person_id)}/{what}"
