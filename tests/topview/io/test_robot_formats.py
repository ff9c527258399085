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
from topview import Camera, InputError, T_world_camera
from topview.body import JOINT_NAMES, PART_NAMES
from topview.io.writers.mcap import frame_name
from topview.io.writers.registry import format_named, write_format

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
        names = {"torso", "head", "l_wrist", "r_shoulder", "r_knee", "waist", "l_ankle"}
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
    messages = [
        row["hri_msgs.msg.IdsList:message"][0]
        for row in rows_of("McapReader", path, "/humans/bodies/tracked")
        if "hri_msgs.msg.IdsList:message" in row
    ]
    assert [m["ids"] for m in messages] == [[f"p{p}" for p in people] for people in WHO.values()]
    shown = [
        row["visualization_msgs.msg.MarkerArray:message"][0]["markers"]
        for row in rows_of("McapReader", path, "/humans/bodies/p3/markers")
        if "visualization_msgs.msg.MarkerArray:message" in row
    ]
    # Person 3 is there, away, and there again twice.
    assert [[m["action"] for m in markers] for markers in shown] == [[0, 0], [3], [0, 0], [0, 0]]
    points = [[p[axis] for axis in "xyz"] for p in shown[0][0]["points"]]
    np.testing.assert_allclose(points, SEQUENCE.of_person(3).joints_camera[1, 0], atol=1e-9)
    assert shown[0][0]["header"]["frame_id"] == "camera_depth_optical_frame"


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
