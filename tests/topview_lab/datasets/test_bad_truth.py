"""Truth of a wrong kind is named; the other recordings are measured."""

from __future__ import annotations

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
