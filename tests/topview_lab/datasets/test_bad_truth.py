"""Truth of a wrong kind is named; the other recordings are measured."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from topview.records import InputError
from topview_lab.datasets import read_groundtruth

GOOD = {
    "names": np.array(["head", "pelvis"]),
    "joints": np.ones((2, 1, 2, 3)),
    "present": np.ones((2, 1), bool),
}


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("joints", np.full((2, 1, 2, 3), "x")),
        ("joints", np.full((2, 1, 2, 3), np.nan)),
        ("joints", np.ones((2, 1, 2, 3), complex)),
        ("present", np.full((2, 1), "maybe")),
        ("stature", np.array(["tall"])),
        ("ids", np.array(["one"])),
        ("joint_occ_person", np.full((2, 1, 2), "half")),
    ],
)
def test_truth_of_a_wrong_kind_is_one_line(tmp_path, key, value):
    path = tmp_path / "groundtruth.npz"
    np.savez(path, **(GOOD | {key: value}))
    with pytest.raises(InputError, match=r"groundtruth\.npz") as raised:
        read_groundtruth(path)
    assert str(raised.value).count("groundtruth.npz") == 1


TWO = {
    "names": np.array(["head", "pelvis"]),
    "joints": np.ones((2, 2, 2, 3)),
    "present": np.ones((2, 2), bool),
    "ids": np.array([4, 7]),
    "stature": np.array([1.6, 1.8]),
    "part_names": np.array(["head"]),
    "Ts_camera_part": np.tile(np.eye(4), (2, 2, 1, 1, 1)),
}


def test_good_truth_of_two(tmp_path):
    np.savez(tmp_path / "groundtruth.npz", **TWO)
    truth = read_groundtruth(tmp_path / "groundtruth.npz")
    assert truth.person_ids.tolist() == [4, 7]


def test_the_absent_may_be_anywhere(tmp_path):
    joints = np.ones((2, 2, 2, 3))
    joints[0, 1] = 1e300
    joints[1, 0] = np.nan
    present = np.eye(2, dtype=bool)
    np.savez(tmp_path / "groundtruth.npz", **(TWO | {"joints": joints, "present": present}))
    assert read_groundtruth(tmp_path / "groundtruth.npz").present.sum() == 2


@pytest.mark.parametrize(
    ("key", "value", "said"),
    [
        ("ids", [4, 4], "ids has 4 twice"),
        ("ids", [4, np.nan], "ids are real numbers, such as [4.]; ids are whole numbers"),
        ("ids", [4, 7.5], "ids are real numbers, such as [4.]; ids are whole numbers"),
        ("ids", [4, -1], "ids has -1"),
        ("ids", np.array([4, 2**64 - 1], np.uint64), "ids has 18446744073709551615"),
        ("stature", [1.6, np.nan], "stature has nan; it must be metres, 0.4 to 2.8"),
        ("stature", [1.6, np.inf], "stature has inf"),
        ("stature", [1.6, 0.0], "stature has 0"),
        ("stature", [1.6, -1.8], "stature has -1.8"),
        ("stature", [1.6, 180], "stature has 180"),
        ("joints", np.full((2, 2, 2, 3), 1e300), "joints has [1.e+300 1.e+300 1.e+300] for head"),
        ("joints", np.full((2, 2, 2, 3), 1800.0), "at most 100 from the camera"),
        ("joints", np.full((2, 2, 2, 3), -np.inf), "must be finite metres"),
        ("present", np.full((2, 2), 7), "present has 7"),
        ("Ts_camera_part", np.full((2, 2, 1, 4, 4), 2.0), "turns by no rotation"),
        ("Ts_camera_part", np.full((2, 2, 1, 4, 4), 1e300), "turns by no rotation"),
        ("Ts_camera_part", np.full((2, 2, 1, 4, 4), np.inf), "turns by no rotation"),
    ],
)
def test_truth_that_no_people_have_is_one_line(tmp_path, key, value, said):
    path = tmp_path / "groundtruth.npz"
    arrays: dict[str, Any] = TWO | {key: np.asarray(value)}
    np.savez(path, **arrays)
    with pytest.raises(InputError) as raised:
        read_groundtruth(path)
    assert str(raised.value).startswith(f"{path}: ")
    assert said in str(raised.value)
