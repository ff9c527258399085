"""Other programs find everybody within a millimetre of where the tracker has them.

Each format is read by a library that knows it, or by the few lines here that follow its
specification.
"""

from __future__ import annotations

import json
import struct
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from moving_bodies import TILT_RAD, UP_CAMERA, WHO, moving_people, pose, upright
from topview import JOINT_NAMES, PART_NAMES, InputError
from topview.body.hierarchy import NODES, articulated
from topview.io.writers import extras
from topview.io.writers.registry import FORMATS, format_named, write_format
from topview.skeletons import SkeletonSequence
from topview_lab.datasets.bvh import read_bvh

MM = 1e-3
SEQUENCE = moving_people()
EVEN_ROWS = [0, 1, 2, -1, 3, 4]  # the frame of each tenth of a second; none at 0.3 s


def written(name: str, folder: Path, sequence: SkeletonSequence = SEQUENCE) -> list[Path]:
    return write_format(format_named(name), sequence, folder / f"out.{name}")


def joints_of(person_id: int, rows: list[int]) -> NDArray[np.float64]:
    """[len(rows), J, 3] upright; NaN where the person is not."""
    return upright(SEQUENCE.of_person(person_id).joints_camera[rows, 0])


def test_rotations_and_bones_give_the_joints():
    """Also where bones are told from other frames; a body that grows is off by its growth."""
    rows, slots = SEQUENCE.slots_of(3)
    joints, Ts = SEQUENCE.joints_camera[rows, slots], SEQUENCE.Ts_camera_part[rows, slots]
    body = articulated(joints, Ts)
    np.testing.assert_allclose(body.joints_camera(), joints, atol=1e-9)
    assert body.known.all()
    small, large = (pose(np.zeros((11, 3)), stature_m) for stature_m in (1.7, 1.8))
    joints, Ts = (np.stack(pair) for pair in zip(small, large, strict=True))
    off = np.abs(articulated(joints, Ts).joints_camera() - joints)
    assert 5 * MM < off.max() < 50 * MM


def test_nothing_is_turned_in_who_stands_upright_with_hanging_arms():
    joints, Ts = pose(np.zeros((11, 3)))
    body = articulated(joints[None], Ts[None])
    np.testing.assert_allclose(
        body.Rs_parent_node[:, 1:], np.tile(np.eye(3), (1, 20, 1, 1)), atol=1e-12
    )
    lengths = dict(zip([node.name for node in NODES], body.offsets_m.tolist(), strict=True))
    assert lengths["left_knee"][1] == pytest.approx(0.245 * 1.8)


def test_the_legs_of_an_upper_body_are_unknown_and_left_out(tmp_path):
    joints, Ts = SEQUENCE.joints_camera.copy(), SEQUENCE.Ts_camera_part.copy()
    joints[:, :, [n.endswith(("hip", "knee", "ankle", "foot")) for n in JOINT_NAMES]] = np.nan
    Ts[:, :, [name.endswith("leg") for name in PART_NAMES]] = np.nan
    half = _with(joints_camera=joints, Ts_camera_part=Ts)
    motion = read_bvh(written("bvh", tmp_path, half)[0])
    found = motion.positions(np.arange(1))
    assert not [name for name in found if "hip" in name or "ankle" in name]
    hand = joints_of(1, [0])[0, JOINT_NAMES.index("left_hand")]
    np.testing.assert_allclose(found["left_hand"][0] / 100, hand, atol=MM)
    assert "hip_flexion_l" not in (written("mot", tmp_path, half)[0]).read_text()


def test_bvh(tmp_path):
    first, second = written("bvh", tmp_path)
    assert (first.name, second.name) == ("out_person1.bvh", "out_person3.bvh")
    # From the first frame with them to the last; who is away stays as seen last.
    for path, person_id, rows in ((first, 1, [0, 1, 2, 2, 3]), (second, 3, [1, 1, 1, 3, 4])):
        motion = read_bvh(path)
        assert motion.frame_time_s == pytest.approx(0.1)
        assert len(motion) == len(rows)
        found = motion.positions(np.arange(len(rows)))
        told = np.stack([found[name] for name in JOINT_NAMES], 1) / 100
        np.testing.assert_allclose(told, joints_of(person_id, rows), atol=MM)


def test_trc(tmp_path):
    _, path = written("trc", tmp_path)
    lines = path.read_text().split("\n")
    told = dict(zip(lines[1].split("\t"), lines[2].split("\t"), strict=True))
    assert (told["Units"], told["NumFrames"], told["NumMarkers"]) == ("mm", "4", "20")
    assert float(told["DataRate"]) == pytest.approx(10.0)
    assert lines[3].split("\t")[2::3] == list(JOINT_NAMES)
    rows = [line.split("\t")[: 2 + 3 * 20] for line in lines[6:-1]]
    table = np.array([[float(v or "nan") for v in row] for row in rows])
    np.testing.assert_allclose(table[:, 1], [0.1, 0.2, 0.4, 0.5])
    places = table[:, 2:].reshape(4, -1, 3) / 1000
    np.testing.assert_allclose(places, joints_of(3, [1, 2, 3, 4]), atol=MM)
    assert np.isnan(places[1]).all()


def test_opensim_reads_what_is_written_for_it(tmp_path, monkeypatch):
    """With the wheel of OpenSim, which the project does not ask for."""
    monkeypatch.chdir(tmp_path)  # where it writes its log
    opensim = pytest.importorskip("opensim", reason="needs the wheel of OpenSim")
    for person_id, path in zip((1, 3), written("trc", tmp_path), strict=True):
        table, markers = opensim.TimeSeriesTableVec3(str(path)), opensim.MarkerData(str(path))
        rows = {1: [0, 1, 2, 3], 3: [1, 2, 3, 4]}[person_id]
        assert table.getColumnLabels() == JOINT_NAMES
        assert table.getTableMetaDataString("Units") == "mm"
        assert markers.getDataRate() == pytest.approx(10.0)
        for k, expected in enumerate(1000 * joints_of(person_id, rows)):
            row, frame = table.getRowAtIndex(k), markers.getFrame(k)
            told = [row[j].to_numpy() for j in range(20)]
            np.testing.assert_allclose(told, expected, atol=1.0)
            told = [frame.getMarker(j).to_numpy() for j in range(20)]
            np.testing.assert_allclose(told, expected, atol=1.0)
    path = written("mot", tmp_path)[0]
    table, told = opensim.TimeSeriesTable(str(path)), coordinates(path)
    assert table.getTableMetaDataString("inDegrees") == "yes"
    assert opensim.Storage(str(path)).isInDegrees()
    for name in told.keys() - {"time"}:
        np.testing.assert_allclose(table.getDependentColumn(name).to_numpy(), told[name])
    np.testing.assert_allclose(table.getIndependentColumn(), told["time"])


def coordinates(path: Path) -> dict[str, NDArray[np.float64]]:
    header, _, table = path.read_text().partition("endheader\n")
    assert "inDegrees=yes" in header
    names, *rows = [line.split("\t") for line in table.splitlines()]
    return dict(zip(names, np.array(rows, float).T, strict=True))


def test_mot_rebuilds_the_turn_of_every_part(tmp_path):
    told = coordinates(written("mot", tmp_path)[0])
    rows, slots = SEQUENCE.slots_of(1)
    Ts = SEQUENCE.Ts_camera_part[rows, slots]
    axes = np.array([[0, 0, 1], [0, -1, 0], [1, 0, 0]])  # front, up, right of a part's axes

    def turn(part: str, parent: str) -> NDArray[np.float64]:
        R, Rp = (Ts[:, PART_NAMES.index(name), :3, :3] for name in (part, parent))
        return axes @ np.swapaxes(Rp, -1, -2) @ R @ axes.T

    for name, part, parent, signs in (
        ("lumbar_extension lumbar_bending lumbar_rotation", "upper_torso", "lower_torso", "+++"),
        ("hip_flexion_r hip_adduction_r hip_rotation_r", "right_upper_leg", "lower_torso", "+++"),
        ("hip_flexion_l hip_adduction_l hip_rotation_l", "left_upper_leg", "lower_torso", "+--"),
        ("arm_flex_l arm_add_l arm_rot_l", "left_upper_arm", "upper_torso", "+--"),
        ("knee_angle_r", "right_lower_leg", "right_upper_leg", "-"),
        ("elbow_flex_l", "left_forearm", "left_upper_arm", "+"),
    ):
        angles = [float(f"{s}1") * told[n] for n, s in zip(name.split(), signs, strict=True)]
        angles += [np.zeros(len(rows))] * (3 - len(angles))
        Rs = Rotation.from_euler("ZXY", np.stack(angles, 1), degrees=True).as_matrix()
        np.testing.assert_allclose(Rs, turn(part, parent), atol=1e-5, err_msg=name)
    pelvis = np.stack([told[f"pelvis_t{axis}"] for axis in "xyz"], 1)
    at = joints_of(1, rows.tolist())[:, JOINT_NAMES.index("pelvis")]
    np.testing.assert_allclose(pelvis, at, atol=MM)


def test_mot_says_what_a_physician_would(tmp_path):
    turns = np.zeros((11, 3))
    turns[0, 0] = -TILT_RAD  # who stands upright before a camera that looks down
    for part, axis, degrees in (
        ("right_upper_leg", 0, 40), ("right_lower_leg", 0, -50), ("left_upper_leg", 2, 20),
        ("left_upper_arm", 2, 70), ("right_upper_arm", 0, 90), ("right_forearm", 0, 60),
    ):  # fmt: skip
        turns[PART_NAMES.index(part), axis] = np.radians(degrees)
    joints, Ts = pose(turns)
    assert Ts[2, :3, 1] == pytest.approx(-UP_CAMERA)
    one = moving_people({0.0: [1]})
    one = _with(one, joints_camera=joints[None, None], Ts_camera_part=Ts[None, None])
    told = coordinates(written("mot", tmp_path, one)[0])
    expected = {
        "pelvis_tilt": 0, "pelvis_list": 0, "pelvis_rotation": -90, "lumbar_extension": 0,
        "hip_flexion_r": 40, "knee_angle_r": 50, "hip_adduction_l": -20, "arm_add_l": -70,
        "arm_flex_r": 90, "elbow_flex_r": 60, "knee_angle_l": 0, "hip_flexion_l": 0,
    }  # fmt: skip
    assert {name: told[name][0] for name in expected} == pytest.approx(expected, abs=1e-4)


def test_c3d(tmp_path):
    pytest.importorskip("ezc3d", reason="needs the extra c3d")
    data = written("c3d", tmp_path)[0].read_bytes()
    points, _, first, last, _, scale, start, _, rate = struct.unpack("<HHHHHfHHf", data[2:24])
    assert (points, last - first + 1) == (2 * 20, 6)
    assert scale < 0  # real numbers
    assert rate == pytest.approx(10.0)
    count = 6 * points * 4
    values = np.frombuffer(data, "<f4", count, 512 * (start - 1)).reshape(6, 2, 20, 4)
    for p, person_id in enumerate((1, 3)):
        expected = joints_of(person_id, EVEN_ROWS)
        expected[EVEN_ROWS.index(-1)] = np.nan
        known = np.isfinite(expected).all((1, 2))
        x, y, z = np.moveaxis(expected[known], -1, 0)
        told = values[known, p, :, :3] / 1000
        np.testing.assert_allclose(told, np.stack([x, -z, y], -1), atol=MM)
        assert (values[known, p, :, 3] >= 0).all()
        assert (values[~known, p, :, 3] == -1).all()


def test_c3d_tells_names_and_units(tmp_path):
    ezc3d = pytest.importorskip("ezc3d", reason="needs the extra c3d")
    points = ezc3d.c3d(str(written("c3d", tmp_path)[0]))["parameters"]["POINT"]
    assert points["UNITS"]["value"] == ["mm"]
    labels = points["LABELS"]["value"]
    assert (labels[0], labels[-1], len(labels)) == ("person1:head", "person3:right_foot", 40)
    assert (points["X_SCREEN"]["value"], points["Y_SCREEN"]["value"]) == (["+X"], ["+Z"])


class Gltf:
    """A binary glTF, by the specification."""

    def __init__(self, data: bytes) -> None:
        magic, version, length, json_length, _ = struct.unpack("<4sIII4s", data[:20])
        assert (magic, version, length) == (b"glTF", 2, len(data))
        self.told: dict[str, Any] = json.loads(data[20 : 20 + json_length])
        self._bytes = data[28 + json_length :]
        self.nodes = self.told["nodes"]
        self.parents = {c: n for n, node in enumerate(self.nodes) for c in node.get("children", [])}
        animation = self.told["animations"][0]
        self.channels = {
            (c["target"]["node"], c["target"]["path"]): animation["samplers"][c["sampler"]]
            for c in animation["channels"]
        }

    def numbers(self, accessor: int) -> NDArray[np.float64]:
        told = self.told["accessors"][accessor]
        width = {"SCALAR": 1, "VEC3": 3, "VEC4": 4, "MAT4": 16}[told["type"]]
        dtype = {5126: "<f4", 5123: "<u2"}[told["componentType"]]
        start = self.told["bufferViews"][told["bufferView"]].get("byteOffset", 0)
        flat = np.frombuffer(self._bytes, dtype, told["count"] * width, start)
        return flat.reshape(-1, width).astype(float)

    def value(self, node: int, path: str, time_s: float) -> NDArray[np.float64]:
        """Of a channel at one of its own times, or held since the last one."""
        sampler = self.channels.get((node, path))
        if sampler is None:
            default = {"translation": [0, 0, 0], "rotation": [0, 0, 0, 1], "scale": [1, 1, 1]}
            return np.array(self.nodes[node].get(path, default[path]), float)
        times = self.numbers(sampler["input"])[:, 0]
        k = int(np.searchsorted(times, time_s + 1e-4)) - 1
        return self.numbers(sampler["output"])[max(k, 0)]

    def matrix(self, node: int, time_s: float) -> NDArray[np.float64]:
        local = np.eye(4)
        R = Rotation.from_quat(self.value(node, "rotation", time_s)).as_matrix()
        local[:3, :3] = R * self.value(node, "scale", time_s)
        local[:3, 3] = self.value(node, "translation", time_s)
        parent = self.parents.get(node)
        return local if parent is None else self.matrix(parent, time_s) @ local


def test_gltf(tmp_path):
    pytest.importorskip("pygltflib", reason="needs the extra gltf")
    gltf = Gltf(written("glb", tmp_path)[0].read_bytes())
    for skin, person_id in zip(gltf.told["skins"], (1, 3), strict=True):
        by_name = {gltf.nodes[n]["name"]: n for n in skin["joints"]}
        person = gltf.nodes[gltf.parents[by_name["pelvis"]]]
        assert person["name"] == f"person {person_id}"
        for row, time_s in enumerate(SEQUENCE.timestamps_s):
            if person_id in SEQUENCE.person_ids[row]:
                at = [gltf.matrix(by_name[name], time_s)[:3, 3] for name in JOINT_NAMES]
                np.testing.assert_allclose(at, joints_of(person_id, [row])[0], atol=MM)
            else:
                assert (gltf.value(by_name["pelvis"], "scale", time_s) == 0).all()


def test_the_body_of_a_gltf_rests_on_its_bones(tmp_path):
    pytest.importorskip("pygltflib", reason="needs the extra gltf")
    gltf = Gltf(written("glb", tmp_path)[0].read_bytes())
    skin, mesh = gltf.told["skins"][0], gltf.told["meshes"][0]["primitives"][0]["attributes"]
    to_joints = gltf.numbers(skin["inverseBindMatrices"]).reshape(-1, 4, 4).swapaxes(1, 2)
    corners, owners = gltf.numbers(mesh["POSITION"]), gltf.numbers(mesh["JOINTS_0"])[:, 0]
    own = to_joints[owners.astype(int)]
    corners_joint = np.einsum("nab,nb->na", own[:, :3, :3], corners) + own[:, :3, 3]
    assert (np.abs(corners_joint).max(0) < 0.5).all()  # of the bone's length
    spindles, normals = (a.reshape(-1, 24, 3) for a in (corners, gltf.numbers(mesh["NORMAL"])))
    outwards = spindles - spindles.mean(1, keepdims=True)
    assert (np.einsum("nca,nca->nc", outwards, normals) > 0).all()
    head = [gltf.nodes[n]["name"] for n in skin["joints"]].index("head")
    assert -to_joints[head, 1, 3] == pytest.approx(0.4 * 1.8, abs=0.1)  # above the pelvis


def test_gltf_as_text_holds_the_same(tmp_path):
    lib = pytest.importorskip("pygltflib", reason="needs the extra gltf")
    (path,) = write_format(format_named("gltf"), SEQUENCE, tmp_path / "out.gltf")
    read = lib.GLTF2().load(str(path))
    (binary,) = written("glb", tmp_path)
    assert len(read.accessors) == len(Gltf(binary.read_bytes()).told["accessors"])
    assert read.buffers[0].uri.startswith("data:")


def test_json_lines(tmp_path):
    frames = [json.loads(line) for line in written("jsonl", tmp_path)[0].read_text().splitlines()]
    assert [frame["timestamp_s"] for frame in frames] == SEQUENCE.timestamps_s.tolist()
    ids = [[person["id"] for person in frame["people"]] for frame in frames]
    assert ids == list(WHO.values())
    for f, s in np.argwhere(SEQUENCE.present):
        (person,) = [p for p in frames[f]["people"] if p["id"] == SEQUENCE.person_ids[f, s]]
        told = [person["joints"][name]["camera_m"] for name in JOINT_NAMES]
        np.testing.assert_array_equal(told, SEQUENCE.joints_camera[f, s])
        assert person["joints"]["head"]["state"] == "visible"
        for name in ("left_hand", "head", "right_ankle"):
            told = position_of(person["bones"], name)
            np.testing.assert_allclose(told, person["joints"][name]["camera_m"], atol=1e-9)


def position_of(bones: dict[str, Any], name: str) -> NDArray[np.float64]:
    """Of a node, by offsets and turns alone."""
    place = np.zeros(3)
    while name != "camera":
        bone = bones[name]
        place = Rotation.from_quat(bone["turn_xyzw"]).apply(place) + bone["offset_m"]
        name = bone["parent"]
    return place


def test_parquet(tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet", reason="needs the extra parquet")
    joints = SEQUENCE.joints_camera.copy()
    joints[0, 0, 2] = np.nan
    table = parquet.read_table(written("parquet", tmp_path, _with(joints_camera=joints))[0])
    rows = table.to_pylist()
    assert len(rows) == 7 * len(JOINT_NAMES)
    assert [row["joint"] for row in rows[: len(JOINT_NAMES)]] == list(JOINT_NAMES)
    assert rows[2]["x_m"] is None
    by_key = {(row["frame_index"], row["person_id"], row["joint"]): row for row in rows}
    row = by_key[3, 3, "left_hand"]
    at = SEQUENCE.of_person(3).joints_camera[3, 0, JOINT_NAMES.index("left_hand")]
    np.testing.assert_array_equal([row["x_m"], row["y_m"], row["z_m"]], at)
    assert (row["timestamp_s"], row["state"], row["confidence"]) == (0.4, "visible", 0.5)
    assert json.loads(table.schema.metadata[b"settings"]) == SEQUENCE.settings


@pytest.mark.parametrize("name", [name for name, made in FORMATS.items() if made.needs])
def test_a_library_that_is_missing_is_said_in_one_line(name, monkeypatch):
    def missing(module: str) -> None:
        raise ImportError(module)

    monkeypatch.setattr(extras, "import_module", missing)
    with pytest.raises(InputError, match=r"install it with: pip install 'topview\[\w+\]'$"):
        format_named(name)


@pytest.mark.parametrize("name", list(FORMATS))
def test_parts_that_are_not_turned_rigidly_are_left_out_or_one_line(name, tmp_path):
    """A file of skeletons may hold anything."""
    odd = _with(Ts_camera_part=np.ones_like(SEQUENCE.Ts_camera_part))
    with suppress(InputError):
        written(name, tmp_path, odd)


@pytest.mark.parametrize("name", ["bvh", "trc", "c3d", "glb"])
def test_times_that_do_not_grow_are_refused(name, tmp_path):
    still = _with(timestamps_s=np.zeros(5))
    with pytest.raises(InputError, match=rf"out.*\.{name}: timestamps_s goes from 0 to 0; times"):
        written(name, tmp_path, still)
    assert list(tmp_path.iterdir()) == []


def _with(sequence: SkeletonSequence = SEQUENCE, **arrays: NDArray[Any]) -> SkeletonSequence:
    return replace(sequence, **arrays)
