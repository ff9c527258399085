"""The recipes of the documents, each on a small made-up result."""

from __future__ import annotations

import runpy
import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pytest

import topview
from moving_bodies import moving_people
from skeleton_sequences import people_standing, predicted_of
from topview.body import JOINT_NAMES

RECIPES = Path(__file__).parents[2] / "docs" / "recipes"


def recipe(name: str) -> dict[str, Any]:
    return runpy.run_path(str(RECIPES / f"{name}.py"))


@pytest.fixture
def result(tmp_path: Path) -> Path:
    topview.write_skeletons(moving_people(), tmp_path / "skeletons.npz")
    return tmp_path / "skeletons.npz"


def test_the_list_has_them_all():
    told = (RECIPES / "README.md").read_text()
    assert all(f"]({path.name})" in told for path in RECIPES.glob("*.py"))


def test_repetitions_are_counted(tmp_path):
    joints = people_standing(60, -0.5, 0.5)
    hand, shoulder = JOINT_NAMES.index("left_hand"), JOINT_NAMES.index("left_shoulder")
    waves = 0.4 * np.sin(np.arange(60) / 60 * 2 * np.pi * 3)  # three times up and down
    joints[:, 0, hand, 1] = joints[:, 0, shoulder, 1] - waves
    topview.write_skeletons(predicted_of(joints), tmp_path / "s.npz")
    assert recipe("count_repetitions")["main"](str(tmp_path / "s.npz")) == {1: 3, 2: 0}


def test_gait_is_written_for_opensim(result):
    ranges = recipe("gait_to_opensim")["main"](str(result), str(result.with_name("gait.mot")))
    assert set(ranges) == {f"gait_person{p} {side}" for p in (1, 3) for side in "rl"}
    assert max(ranges.values()) > 5.0
    assert result.with_name("gait_person3.trc").exists()


def test_a_pointing_arm_meets_the_floor():
    target = recipe("follow_pointing")["target"]
    arm = {"shoulder": [0.2, -0.2, 2.0], "elbow": [0.2, -0.1, 1.7], "hand": [0.2, 0.0, 1.4]}
    joints = {f"left_{name}": {"camera_m": xyz, "confidence": 0.9} for name, xyz in arm.items()}
    np.testing.assert_allclose(target(joints, "left"), [0.2, 1.2, -2.2], atol=1e-9)
    joints["left_hand"] = {"camera_m": [0.2, -0.3, 1.9], "confidence": 0.9}  # bent
    assert target(joints, "left") is None


def test_a_ros_2_bag_holds_the_joints(result, tmp_path):
    reader = pytest.importorskip("rosbags.highlevel", reason="needs rosbags")
    from rosbags.typesys import Stores, get_typestore

    sequence = topview.read_skeletons(result)
    assert recipe("skeletons_to_ros2")["main"](str(result), str(tmp_path / "bag")) == 7
    store = get_typestore(Stores.ROS2_HUMBLE)
    with reader.AnyReader([tmp_path / "bag"], default_typestore=store) as bag:
        topics = [c for c in bag.connections if c.topic == "/person_3/joints"]
        told = [bag.deserialize(data, c.msgtype) for c, _, data in bag.messages(topics)]
    rows, slots = sequence.slots_of(3)
    for message, row, slot in zip(told, rows, slots, strict=True):
        places = [(p.position.x, p.position.y, p.position.z) for p in message.poses]
        np.testing.assert_allclose(places, sequence.joints_camera[row, slot])
        assert message.header.stamp.nanosec == round(float(sequence.timestamps_s[row]) * 1e9)


def test_blender_imports_the_file(monkeypatch):
    opened = []
    scene = SimpleNamespace(render=SimpleNamespace(fps=0), frame_start=1, frame_end=0)
    bpy: Any = ModuleType("bpy")
    bpy.ops = SimpleNamespace(
        import_scene=SimpleNamespace(gltf=lambda filepath: opened.append(filepath))
    )
    bpy.context = SimpleNamespace(scene=scene)
    bpy.data = SimpleNamespace(actions=[SimpleNamespace(frame_range=(0.0, 41.6))])
    monkeypatch.setitem(sys.modules, "bpy", bpy)
    recipe("into_blender")["main"]("moves.glb")
    assert (opened, scene.render.fps, scene.frame_end) == (["moves.glb"], 30, 42)
