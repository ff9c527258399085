from __future__ import annotations

import cv2
import numpy as np
import pytest


@pytest.mark.slow
def test_the_demo_simulates_tracks_measures_and_pictures(topview, tmp_path):
    ended = topview("demo", "--frames", "12", "--out", tmp_path / "demo")
    assert ended.status == 0
    assert ended.complaints == []
    for told in ("simulated truth", "cm", "frames per second", "contact_sheet.png"):
        assert told in ended.out
    lines = ended.out.splitlines()
    assert len(lines) <= 12
    assert max(map(len, lines)) <= 80 or str(tmp_path) in max(lines, key=len)
    assert {file.name for file in (tmp_path / "demo").iterdir()} == {
        "contact_sheet.png",
        "skeletons.csv",
        "skeletons.npz",
    }
    with np.load(tmp_path / "demo" / "skeletons.npz") as skeletons:
        assert skeletons["frame_index"].tolist() == list(range(12))
    assert cv2.imread(str(tmp_path / "demo" / "contact_sheet.png")) is not None
