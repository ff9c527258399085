"""What is written is read; files appear whole or not at all; errors are one line."""

from __future__ import annotations

import csv
import errno
import json
import math
import os
import resource
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from lenses import LENSES, camera_with
from moving_bodies import moving_people
from topview import JOINT_NAMES, PART_NAMES, InputError, SkeletonSequence
from topview.io.writers import (
    SkeletonFile,
    prepare_output_folder,
    read_skeletons_npz,
    write_skeletons_csv,
    write_skeletons_npz,
)
from topview.io.writers.joint_frames import bone_lengths_m
from topview.io.writers.npz import OF_FRAMES
from topview.records import JOINT_STATE_NAMES, JointState

COLUMN_KEYS = {
    "frame_index",
    "timestamps_s",
    "person_ids",
    "joint_names",
    "joints_camera",
    "joint_state",
    "joint_state_names",
    "joint_confidence",
    "part_names",
    "Ts_camera_part",
    "heights_m",
    "settings",
}
KEYS_SINCE_2 = {"format_version", "frame_names", "camera", "topview_version"}
DERIVED = {
    "T_world_camera",
    "Rs_parent_joint",
    "offsets_parent_joint_m",
    "parents",
    "bone_lengths_m",
}
TABLE = {"people_ids", "heights_m", "first_frame", "last_frame"}
ARRAYS = (
    COLUMN_KEYS - {"joint_names", "joint_state_names", "part_names", "settings"}
    | {"floor_camera", "gravity_camera", "joint_covariance_m2"}
    | TABLE
)
KEYS = COLUMN_KEYS | ARRAYS | KEYS_SINCE_2 | DERIVED
CAMERAS = [
    None,
    camera_with(None),
    *(camera_with(lens, sensor="tof", T_world_camera=np.eye(4)) for lens in LENSES.values()),
]


@st.composite
def sequences(draw: st.DrawFn) -> SkeletonSequence:
    F, S, P, J, B = (draw(st.integers(0, most)) for most in (4, 3, 3, 4, 3))
    names = st.text(st.characters(codec="utf-8", exclude_characters="\0"), min_size=1)
    reals = st.floats(width=64)
    json_values = st.recursive(
        st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | st.text(),
        lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(), inner, max_size=3),
        max_leaves=5,
    )
    return SkeletonSequence(
        frame_index=draw(hnp.arrays(np.int64, F)),
        timestamps_s=draw(hnp.arrays(np.float64, F, elements=reals)),
        person_ids=draw(hnp.arrays(np.int64, (F, S))),
        joint_names=tuple(draw(st.lists(names, min_size=J, max_size=J))),
        joints_camera=draw(hnp.arrays(np.float64, (F, S, J, 3), elements=reals)),
        joint_state=draw(hnp.arrays(np.uint8, (F, S, J), elements=st.integers(0, 5))),
        joint_confidence=draw(
            hnp.arrays(np.float32, (F, S, J), elements=st.floats(0, 1, width=32))
        ),
        part_names=tuple(draw(st.lists(names, min_size=B, max_size=B))),
        Ts_camera_part=draw(hnp.arrays(np.float64, (F, S, B, 4, 4), elements=reals)),
        people_ids=draw(hnp.arrays(np.int64, P)),
        heights_m=draw(hnp.arrays(np.float64, P, elements=reals)),
        first_frame=draw(hnp.arrays(np.int64, P)),
        last_frame=draw(hnp.arrays(np.int64, P)),
        settings=draw(st.dictionaries(st.text(), json_values, max_size=3)),
        frame_names=tuple(draw(st.lists(names, min_size=F, max_size=F))),
        camera=draw(st.sampled_from(CAMERAS)),
        floor_camera=draw(hnp.arrays(np.float64, 4, elements=reals)),
        gravity_camera=draw(hnp.arrays(np.float64, 3, elements=reals)),
        topview_version=draw(names | st.just("")),
        joint_covariance_m2=draw(
            hnp.arrays(np.float32, (F, S, J, 3, 3), elements=st.floats(width=32))
        ),
    )


@pytest.fixture
def sequence() -> SkeletonSequence:
    """3 frames, people 1 and 4; person 4 is absent from the first frame."""
    rng = np.random.default_rng(5)
    F, S, J, B = 3, 2, len(JOINT_NAMES), len(PART_NAMES)
    joints, poses = rng.normal(size=(F, S, J, 3)), rng.normal(size=(F, S, B, 4, 4))
    states = rng.integers(1, 6, (F, S, J)).astype(np.uint8)
    confidence = rng.random((F, S, J), np.float32)
    joints[0, 1], poses[0, 1], states[0, 1], confidence[0, 1] = np.nan, np.nan, 0, 0.0
    joints[1, 0, 3], states[1, 0, 3] = np.nan, 0
    return SkeletonSequence(
        frame_index=np.array([0, 1, 3]),
        timestamps_s=np.array([0.0, 1 / 30, 0.1]),
        person_ids=np.array([[1, 0], [1, 4], [1, 4]]),
        joint_names=JOINT_NAMES,
        joints_camera=joints,
        joint_state=states,
        joint_confidence=confidence,
        part_names=PART_NAMES,
        Ts_camera_part=poses,
        people_ids=np.array([1, 4]),
        heights_m=np.array([1.75, 1.8]),
        first_frame=np.array([0, 1]),
        last_frame=np.array([3, 3]),
        settings={"seed": 7, "method": "utvr"},
        frame_names=("a.png", "b.png", "d.png"),
        camera=camera_with(LENSES["rational"], sensor="stereo"),
        floor_camera=np.array([0.0, -0.8, -0.6, 1.5]),
        gravity_camera=np.array([0.0, 0.8, 0.6]),
        topview_version="0.1.0",
    )


@pytest.fixture(scope="session")
def scratch(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("written")


@given(sequence=sequences())
def test_what_is_written_is_read(sequence, scratch):
    write_skeletons_npz(sequence, scratch / "law.npz")
    read = read_skeletons_npz(scratch / "law.npz")
    for key in ARRAYS:
        written = getattr(sequence, key)
        assert getattr(read, key).dtype == written.dtype
        np.testing.assert_array_equal(getattr(read, key), written)
    assert read.joint_names == sequence.joint_names
    assert read.part_names == sequence.part_names
    assert read.settings == sequence.settings
    assert read.frame_names == sequence.frame_names
    assert read.camera == sequence.camera
    assert read.topview_version == sequence.topview_version


@pytest.mark.parametrize("version", [1, 2])
def test_files_with_a_column_for_each_person_are_read(sequence, tmp_path, version):
    """Versions 1, which had no version, and 2 keep who the columns are, whether there or not."""
    path = tmp_path / "skeletons.npz"
    write_skeletons_npz(sequence, path)
    keys = COLUMN_KEYS | (KEYS_SINCE_2 | ARRAYS - TABLE if version == 2 else set())
    with np.load(path) as data:
        arrays = {key: data[key] for key in keys}
    arrays["person_ids"] = np.array([1, 4])
    if version == 2:
        arrays["format_version"] = np.array(2)
    np.savez(path, **arrays)
    for read in (read_skeletons_npz(path), *SkeletonFile(path).blocks()):
        for key in ARRAYS - {"floor_camera", "gravity_camera"}:
            np.testing.assert_array_equal(getattr(read, key), getattr(sequence, key))
        if version == 2:
            assert (read.frame_names, read.camera) == (sequence.frame_names, sequence.camera)
        else:
            assert read.frame_names == ("0", "1", "3")
            assert (read.camera, read.topview_version) == (None, "")
            assert np.isnan([*read.floor_camera, *read.gravity_camera]).all()


def with_16_joints(sequence: SkeletonSequence) -> SkeletonSequence:
    return replace(
        sequence,
        joint_names=JOINT_NAMES[:16],
        joints_camera=sequence.joints_camera[:, :, :16].copy(),
        joint_state=sequence.joint_state[:, :, :16].copy(),
        joint_confidence=sequence.joint_confidence[:, :, :16].copy(),
        joint_covariance_m2=sequence.joint_covariance_m2[:, :, :16].copy(),
    )


def test_files_of_16_joints_are_read_with_the_ends_that_follow_from_the_parts(tmp_path):
    """Of bodies whose feet are at rest these are the very same."""
    sequence = moving_people()
    write_skeletons_npz(with_16_joints(sequence), tmp_path / "skeletons.npz")
    for read in (
        read_skeletons_npz(tmp_path / "skeletons.npz"),
        *SkeletonFile(tmp_path / "skeletons.npz").blocks(),
    ):
        assert read.joint_names == JOINT_NAMES
        np.testing.assert_allclose(read.joints_camera, sequence.joints_camera, atol=1e-12)
        hands = [JOINT_NAMES.index(name) for name in ("left_hand", "left_wrist")]
        assert (read.joint_state[..., hands[0]] == read.joint_state[..., hands[1]]).all()
        assert (read.joint_confidence[..., hands[0]] == read.joint_confidence[..., hands[1]]).all()
        assert (read.joint_state[~read.present] == JointState.ABSENT).all()


def test_other_systems_joints_have_no_turns(sequence, tmp_path):
    other = replace(sequence, joint_names=tuple(f"j{j}" for j in range(len(JOINT_NAMES))))
    write_skeletons_npz(other, tmp_path / "skeletons.npz")
    with np.load(tmp_path / "skeletons.npz") as data:
        assert (data["parents"] == -1).all()
        for key in ("Rs_parent_joint", "offsets_parent_joint_m", "bone_lengths_m"):
            assert np.isnan(data[key]).all()


def test_lengths_of_bones_are_those_of_each_person(tmp_path):
    """Also where frames come in blocks: the last that knows somebody counts."""
    sequence = moving_people()

    class Halves:
        def blocks(self):
            for rows in (slice(0, 3), slice(3, None)):
                arrays = {key: getattr(sequence, key)[rows] for key in OF_FRAMES}
                names = sequence.frame_names[rows]
                yield replace(sequence, frame_names=names, **arrays)

    whole = bone_lengths_m(sequence)
    np.testing.assert_allclose(bone_lengths_m(Halves()), whole)
    assert whole.shape == (2, len(JOINT_NAMES))
    np.testing.assert_allclose(whole[0] / 1.8, whole[1] / 1.6, atol=1e-12)
    assert (np.delete(whole, JOINT_NAMES.index("pelvis"), 1) > 0.0).all()


def test_files_without_covariances_are_read(sequence, tmp_path):
    """As version 3 was written at first."""
    path = tmp_path / "skeletons.npz"
    write_skeletons_npz(sequence, path)
    with np.load(path) as data:
        arrays = {key: data[key] for key in data.files if key != "joint_covariance_m2"}
    np.savez(path, **arrays)
    for read in (read_skeletons_npz(path), *SkeletonFile(path).blocks()):
        assert read.joint_covariance_m2.shape == (3, 2, len(JOINT_NAMES), 3, 3)
        assert np.isnan(read.joint_covariance_m2).all()
        np.testing.assert_array_equal(read.joints_camera, sequence.joints_camera)


def test_columns_of_the_same_person_are_refused(sequence, tmp_path):
    path = tmp_path / "skeletons.npz"
    write_skeletons_npz(sequence, path)
    with np.load(path) as data:
        arrays = {key: data[key] for key in COLUMN_KEYS - {"person_ids"}}
    np.savez(path, person_ids=np.array([4, 4]), **arrays)
    with pytest.raises(InputError, match=r"skeletons\.npz: person_ids has 4 twice; each person"):
        read_skeletons_npz(path)


def test_the_file_has_these_keys_and_needs_no_pickle(sequence, tmp_path):
    write_skeletons_npz(sequence, tmp_path / "skeletons.npz")
    with np.load(tmp_path / "skeletons.npz", allow_pickle=False) as data:
        assert set(data.files) == KEYS
        assert data["joint_names"].tolist() == list(JOINT_NAMES)
        assert data["joint_state_names"].tolist() == list(JOINT_STATE_NAMES)
        assert data["part_names"].shape == (11,)
        assert data["Ts_camera_part"].shape == (3, 2, 11, 4, 4)
        assert str(data["settings"]) == '{"method": "utvr", "seed": 7}'
        assert data["format_version"] == 3
        assert data["frame_names"].tolist() == ["a.png", "b.png", "d.png"]
        camera = json.loads(str(data["camera"]))
        assert (camera["fx"], camera["width"], camera["sensor"]) == (210.0, 320, "stereo")
        assert camera["distortion"]["model"] == "rational"
        assert len(camera["distortion"]["coefficients"]) == 8


def test_equal_content_gives_equal_bytes(sequence, tmp_path, monkeypatch):
    write_skeletons_npz(sequence, tmp_path / "a.npz")
    later = replace(sequence, settings=dict(reversed(sequence.settings.items())))
    monkeypatch.setattr("time.time", lambda: 2e9)
    write_skeletons_npz(later, tmp_path / "b.npz")
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()


def test_the_csv_has_a_line_per_frame_person_who_is_there_and_joint(sequence, tmp_path):
    write_skeletons_csv(sequence, tmp_path / "skeletons.csv")
    with (tmp_path / "skeletons.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert ",".join(rows[0]) == (
        "frame_index,timestamp_s,person_id,joint,x_m,y_m,z_m,state,confidence"
    )
    told = [(f, s, j) for f, s in np.argwhere(sequence.person_ids) for j in range(len(JOINT_NAMES))]
    assert len(rows) == len(told) == 5 * len(JOINT_NAMES)
    for row, (f, s, j) in zip(rows, told, strict=True):
        assert int(row["frame_index"]) == sequence.frame_index[f]
        assert float(row["timestamp_s"]) == pytest.approx(sequence.timestamps_s[f], abs=1e-6)
        assert int(row["person_id"]) == sequence.person_ids[f, s]
        assert row["joint"] == JOINT_NAMES[j]
        assert row["state"] == JOINT_STATE_NAMES[sequence.joint_state[f, s, j]]
        position = [float(row[key] or math.nan) for key in ("x_m", "y_m", "z_m")]
        np.testing.assert_allclose(position, sequence.joints_camera[f, s, j], atol=1e-5)
        assert float(row["confidence"]) == pytest.approx(
            sequence.joint_confidence[f, s, j], abs=1e-4
        )
    assert [row["x_m"] for row in rows if row["state"] == "absent"] == [""]


WRITERS = [write_skeletons_npz, write_skeletons_csv]


@pytest.mark.parametrize("write", WRITERS)
def test_a_full_disk_leaves_the_old_file_and_nothing_else(sequence, tmp_path, write, monkeypatch):
    path = tmp_path / "out"
    path.write_bytes(b"old")

    def full(_: int) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(InputError, match=r"out: cannot be written: No space left on device"):
        write(sequence, path)
    assert path.read_bytes() == b"old"
    assert list(tmp_path.iterdir()) == [path]


def test_a_write_that_the_system_cuts_short_leaves_nothing(tmp_path):
    """With a real limit on the size of files, in a process of its own."""
    code = f"""
import resource, sys
from pathlib import Path
from topview.io.writers import write_atomically
from topview import InputError
resource.setrlimit(resource.RLIMIT_FSIZE, (1000, {resource.RLIM_INFINITY}))
try:
    write_atomically(Path(sys.argv[1]), bytes(5000))
except InputError as error:
    print(error)
"""
    path = tmp_path / "out.npz"
    done = subprocess.run(
        [sys.executable, "-c", code, str(path)], capture_output=True, text=True, check=True
    )
    right = "it must be a place with room and leave to write"
    assert done.stdout == f"{path}: cannot be written: File too large; {right}\n"
    assert list(tmp_path.iterdir()) == []


def test_a_stop_in_the_middle_leaves_the_old_file(sequence, tmp_path, monkeypatch):
    path = tmp_path / "out.npz"
    path.write_bytes(b"old")

    def stop(_: int) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(os, "fsync", stop)
    with pytest.raises(KeyboardInterrupt):
        write_skeletons_npz(sequence, path)
    assert path.read_bytes() == b"old"
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("write", WRITERS)
def test_a_place_that_cannot_be_written_is_refused(sequence, tmp_path, write):
    (tmp_path / "file").write_bytes(b"")
    (tmp_path / "folder").mkdir()
    for path, reason in (
        (tmp_path / "file" / "out", "Not a directory"),
        (tmp_path / "gone" / "out", "No such file or directory"),
        (tmp_path / "folder", "Is a directory"),
    ):
        with pytest.raises(InputError, match=rf"{path}: cannot be written: {reason}"):
            write(sequence, path)
    assert {path.name for path in tmp_path.iterdir()} == {"file", "folder"}


def test_written_files_have_the_usual_permissions(sequence, tmp_path):
    write_skeletons_npz(sequence, tmp_path / "out.npz")
    (tmp_path / "usual").write_bytes(b"")
    assert (tmp_path / "out.npz").stat().st_mode == (tmp_path / "usual").stat().st_mode


def test_an_npz_cut_anywhere_is_refused_in_one_line(sequence, tmp_path):
    path = tmp_path / "skeletons.npz"
    write_skeletons_npz(sequence, path)
    whole = path.read_bytes()
    for length in range(0, len(whole) - 1, 97):
        path.write_bytes(whole[:length])
        with pytest.raises(InputError, match=r"skeletons\.npz: ") as error:
            read_skeletons_npz(path)
        assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"heights_m": None}, "has no heights_m; it must be a skeletons.npz"),
        ({"heights_m": np.zeros(7)}, r"heights_m has shape \(7,\); it must be \(2,\)"),
        ({"heights_m": np.array(["tall", "short"])}, "has a damaged value"),
        ({"settings": np.array("{")}, "has a damaged value"),
        ({"camera": np.array("{")}, "has a damaged value"),
        ({"camera": np.array("{}")}, "has a damaged value .camera: has no fx, fy"),
        ({"camera": None}, "has no camera; it must be a skeletons.npz"),
        ({"floor_camera": np.zeros(3)}, r"floor_camera has shape \(3,\); it must be \(4,\)"),
        ({"frame_names": np.array(["a"])}, "has 1 frame_names; it must have 3"),
        ({"format_version": np.array(4)}, "format_version is 4, which a later topview wrote"),
        ({"format_version": np.array(0)}, "format_version is 0; it must be 1 to 3"),
        ({"format_version": np.array("3")}, "format_version is 3; it must be 1 to 3"),
        ({"joint_state_names": np.array(["seen"])}, "joint_state_names are seen; they must be"),
        ({"settings": np.array({}, object)}, "is truncated or damaged"),
    ],
)
def test_an_npz_of_something_else_is_refused(sequence, tmp_path, changed, message):
    path = tmp_path / "skeletons.npz"
    write_skeletons_npz(sequence, path)
    with np.load(path) as data:
        arrays = {**data, **changed}
    np.savez(path, **{key: value for key, value in arrays.items() if value is not None})
    with pytest.raises(InputError, match=rf"skeletons\.npz: {message}"):
        read_skeletons_npz(path)


def test_the_output_folder_is_made_with_its_parents_and_left_empty(tmp_path):
    for _ in range(2):
        folder = prepare_output_folder(tmp_path / "a" / "b")
        assert list(folder.iterdir()) == []


def test_what_a_killed_process_left_half_written_is_removed(tmp_path):
    ended = subprocess.Popen([sys.executable, "-c", ""])
    ended.wait()
    old, new = (tmp_path / f".skeletons.{end}.{ended.pid}.part" for end in ("npz", "csv"))
    running = tmp_path / f".skeletons.npz.{os.getppid()}.part"
    other = tmp_path / ".my.part"
    for path in (old, new, running, other):
        path.write_bytes(b"half")
    for path in (old, running, other):
        os.utime(path, (1.0, 1.0))
    prepare_output_folder(tmp_path)
    assert set(tmp_path.iterdir()) == {new, running, other}


def test_an_output_folder_that_cannot_be_is_refused(tmp_path):
    (tmp_path / "file").write_bytes(b"")
    for path, reason in (
        (tmp_path / "file", "File exists"),
        (tmp_path / "file" / "out", "Not a directory"),
        (tmp_path / ("x" * 300), "File name too long"),
    ):
        with pytest.raises(
            InputError,
            match=f"{path}: cannot be used for the output: {reason}; it must be a folder",
        ):
            prepare_output_folder(path)


def test_a_full_disk_shows_before_the_work(tmp_path, monkeypatch):
    def full(*_: object) -> int:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(Path, "write_bytes", full)
    with pytest.raises(InputError, match="No space left on device"):
        prepare_output_folder(tmp_path / "out")


def test_settings_are_json_text(sequence, tmp_path):
    write_skeletons_npz(sequence, tmp_path / "out.npz")
    with np.load(tmp_path / "out.npz") as data:
        assert json.loads(str(data["settings"])) == sequence.settings
