"""MCAP and rerun: rerun's readers, which share nothing with rosbags, find everybody's joints."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from moving_bodies import WHO, moving_people
from topview import JOINT_NAMES, PART_NAMES, Camera, InputError, T_world_camera
from topview.body.hierarchy import NODES
from topview.io.writers.registry import format_named, write_format
from topview.io.writers.ros4hri import frame_name, joint_turns

MM = 1e-3
CAMERA = Camera(285.63, 285.63, 159.0, 120.0, 320, 240)
SEQUENCE = replace(moving_people(), camera=CAMERA)
TIMES_S = list(WHO)
KEYS = "child_frame", "parent_frame", "quaternion", "translation"
for library in ("rosbags", "rerun"):
    pytest.importorskip(library, reason="needs the extras ros and view")


def written(name: str, folder: Path, sequence: Any = SEQUENCE) -> Path:
    return write_format(format_named(name), sequence, folder / f"out.{name}")[0]


def rows_of(reader: str, path: Path, entity: str) -> list[dict[str, Any]]:
    """What rerun reads of an entity, row by row."""
    from rerun import chunk

    found = [c.to_record_batch() for c in getattr(chunk, reader)(str(path)).stream()
             if c.entity_path == entity]  # fmt: skip
    return [row for batch in found for row in batch.to_pylist()]


def messages_of(path: Path, topic: str, kind: str) -> list[dict[str, Any]]:
    column = f"{kind}:message"
    return [row[column][0] for row in rows_of("McapReader", path, topic) if column in row]


def world(points_camera: NDArray[np.float64]) -> NDArray[np.float64]:
    T = T_world_camera(SEQUENCE)
    return points_camera @ T[:3, :3].T + T[:3, 3]


class Transforms:
    """A tree of frames, from what rerun reads of transforms."""

    def __init__(self, path: Path, time_s: float) -> None:
        self._to: dict[str, tuple[str, Rotation, NDArray[np.float64]]] = {}
        for entity in ("/tf_static", "/tf"):
            for row in rows_of("McapReader", path, entity):
                if "Transform3D:quaternion" in row and (
                    entity == "/tf_static" or _seconds(row) == pytest.approx(time_s)
                ):
                    child, parent, turn, way = (row[f"Transform3D:{key}"][0] for key in KEYS)
                    self._to[child] = parent, Rotation.from_quat(turn), np.array(way)

    @property
    def frames(self) -> set[str]:
        return {*self._to}

    def of(self, frame: str) -> tuple[str, Rotation, NDArray[np.float64]]:
        """Its parent, and how it stands in it."""
        return self._to[frame]

    def pose(self, frame: str) -> tuple[Rotation, NDArray[np.float64]]:
        """In the world."""
        if frame == "world":
            return Rotation.identity(), np.zeros(3)
        parent, turn, way = self._to[frame]
        R, origin = self.pose(parent)
        return R * turn, R.apply(way) + origin


def _seconds(row: dict[str, Any]) -> float:
    return row["message_log_time"].timestamp()


@pytest.mark.parametrize("row", [1, 4])
def test_mcap_has_every_joint_as_a_frame_of_ros4hri(tmp_path, row):
    path = written("mcap", tmp_path)
    tree = Transforms(path, TIMES_S[row])
    people = WHO[TIMES_S[row]]
    assert {f"body_p{person}" for person in (1, 3)} & tree.frames == {f"body_p{p}" for p in people}
    for person in people:
        joints = world(SEQUENCE.of_person(person).joints_camera[row, 0])
        told = [tree.pose(frame_name(name, f"p{person}"))[1] for name in JOINT_NAMES]
        np.testing.assert_allclose(told, joints, atol=MM)
        names = {
            "torso",
            "head",
            "l_wrist",
            "r_shoulder",
            "r_knee",
            "waist",
            "l_ankle",
            "r_hand",
            "l_foot",
        }
        assert {f"{name}_p{person}" for name in names} <= tree.frames


def test_a_frame_of_mcap_looks_along_x_and_has_z_up(tmp_path):
    tree = Transforms(written("mcap", tmp_path), TIMES_S[0])
    turn, _ = tree.pose("l_elbow_p1")
    Ts = SEQUENCE.of_person(1).Ts_camera_part[0, 0, PART_NAMES.index("left_forearm")]
    towards = T_world_camera(SEQUENCE)[:3, :3] @ Ts[:3, :3]
    np.testing.assert_allclose(turn.apply([1, 0, 0]), towards[:, 2], atol=1e-6)
    np.testing.assert_allclose(turn.apply([0, 0, 1]), -towards[:, 1], atol=1e-6)


def test_mcap_tells_who_is_tracked_and_shows_them(tmp_path):
    path = written("mcap", tmp_path)
    messages = messages_of(path, "/humans/bodies/tracked", "hri_msgs.msg.IdsList")
    assert [m["ids"] for m in messages] == [[f"p{p}" for p in people] for people in WHO.values()]
    kind = "visualization_msgs.msg.MarkerArray"
    shown = [m["markers"] for m in messages_of(path, "/humans/bodies/p3/markers", kind)]
    # Person 3 is there, away, and there again twice.
    assert [[m["action"] for m in markers] for markers in shown] == [[0, 0], [3], [0, 0], [0, 0]]
    points = [[p[axis] for axis in "xyz"] for p in shown[0][0]["points"]]
    np.testing.assert_allclose(points, SEQUENCE.of_person(3).joints_camera[1, 0], atol=1e-9)
    assert shown[0][0]["header"]["frame_id"] == "camera_depth_optical_frame"


# Frame: the joints of `human_description`'s URDF that turn it in its parent, and their axes.
URDF = {
    "neck": {"r_head": (1, 0, 0), "y_head": (0, 0, 1), "p_head": (0, -1, 0)},
    "l_shoulder": {
        "l_y_shoulder": (0, 0, -1), "l_p_shoulder": (1, 0, 0), "l_r_shoulder": (0, 0, 1),
    },
    "r_shoulder": {
        "r_y_shoulder": (0, 0, 1), "r_p_shoulder": (-1, 0, 0), "r_r_shoulder": (0, 0, -1),
    },
    "l_elbow": {"l_elbow": (0, -1, 0)},
    "r_elbow": {"r_elbow": (0, -1, 0)},
    "l_hip": {"l_y_hip": (0, 0, -1), "l_p_hip": (1, 0, 0), "l_r_hip": (0, -1, 0)},
    "r_hip": {"r_y_hip": (0, 0, -1), "r_p_hip": (-1, 0, 0), "r_r_hip": (0, -1, 0)},
    "l_knee": {"l_knee": (0, -1, 0)},
    "r_knee": {"r_knee": (0, -1, 0)},
}  # fmt: skip


def test_joint_states_of_mcap_turn_the_urdf_as_the_frames_are_turned(tmp_path):
    path = written("mcap", tmp_path)
    told = rows_of("McapReader", path, "/humans/bodies/p3/joint_states/position")
    assert [_seconds(row) for row in told] == pytest.approx([0.1, 0.4, 0.5])
    tree = Transforms(path, TIMES_S[1])
    turns = dict(zip(told[0]["SeriesLines:names"], told[0]["Scalars:scalars"], strict=True))
    assert "waist_p3" in turns
    for frame, joints in URDF.items():
        turn = Rotation.identity()
        for name, axis in joints.items():
            turn *= Rotation.from_rotvec(turns[f"{name}_p3"] * np.array(axis))
        _, parents_turn, _ = tree.of(f"{frame}_p3")
        assert (turn * parents_turn.inv()).magnitude() < 1e-6, frame
    assert turns["r_elbow_p3"] >= 0.0 >= turns["l_knee_p3"]  # as the limits of the URDF
    assert turns["l_p_shoulder_p3"] >= 0.0 <= turns["r_p_shoulder_p3"]


def test_whoever_stands_upright_with_hanging_arms_has_no_turns():
    turns = joint_turns(np.broadcast_to(np.eye(3), (len(NODES), 3, 3)))
    assert len(turns) == 20  # the joints of the URDF that move
    np.testing.assert_allclose([*turns.values()], 0.0, atol=1e-9)


def test_skeleton2d_of_mcap_is_where_the_camera_sees_the_joints(tmp_path):
    path = written("mcap", tmp_path)
    told = messages_of(path, "/humans/bodies/p3/skeleton2d", "hri_msgs.msg.Skeleton2D")
    points = np.array([[point[axis] for axis in "xyc"] for point in told[0]["skeleton"]])
    joints = SEQUENCE.of_person(3).joints_camera[1, 0]
    for code, name in {1: "neck", 4: "right_wrist", 13: "left_ankle"}.items():  # OpenPose's codes
        x, y, z = joints[JOINT_NAMES.index(name)]
        u, v = CAMERA.fx * x / z + CAMERA.cx, CAMERA.fy * y / z + CAMERA.cy
        is_inside = -0.5 <= u <= CAMERA.width - 0.5 and -0.5 <= v <= CAMERA.height - 0.5
        expected = ((u + 0.5) / CAMERA.width, (v + 0.5) / CAMERA.height, 0.5)
        np.testing.assert_allclose(points[code], expected if is_inside else 0.0, atol=1e-6)
    assert points[1, 2] == 0.5
    assert not points[[0, *range(14, 18)]].any()  # nose, eyes and ears are not tracked


def test_mcap_is_the_same_each_time_and_times_before_zero_are_refused(tmp_path):
    first = written("mcap", tmp_path).read_bytes()
    assert written("mcap", tmp_path).read_bytes() == first
    early = replace(SEQUENCE, timestamps_s=SEQUENCE.timestamps_s - 1.0)
    with pytest.raises(InputError, match=r"out\.mcap: timestamps_s begins at -1; times of ROS"):
        written("mcap", tmp_path, early)
    assert [path.name for path in tmp_path.iterdir()] == ["out.mcap"]


def test_rrd(tmp_path):
    path = written("rrd", tmp_path)
    assert [made.name for made in tmp_path.iterdir()] == ["out.rrd"]
    rows = rows_of("RrdReader", path, "/world/camera/person_3/joints")
    assert [row["time"].total_seconds() for row in rows] == pytest.approx([0.1, 0.4, 0.5])
    assert [row["frame"] for row in rows] == [1, 3, 4]
    for row in rows:
        expected = SEQUENCE.of_person(3).joints_camera[row["frame"], 0]
        np.testing.assert_allclose(row["Points3D:positions"], expected, atol=MM)
        assert row["state"] == ["visible"] * len(JOINT_NAMES)
    (placed,) = rows_of("RrdReader", path, "/world/camera")
    T = T_world_camera(SEQUENCE)
    np.testing.assert_allclose(placed["Transform3D:translation"][0], T[:3, 3], atol=1e-6)
    columns = np.reshape(placed["Transform3D:mat3x3"][0], (3, 3))
    np.testing.assert_allclose(columns.T, T[:3, :3], atol=1e-6)
    gone = rows_of("RrdReader", path, "/world/camera/person_3")
    assert [row["frame"] for row in gone] == [2]
