"""What the forest is trained on, and the command that trains it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from topview.body.parts import JOINT_NAMES
from topview.records import InputError
from topview_lab.cli import train_forest as command
from topview_lab.kernels.forest import BACKGROUND_M
from topview_lab.rivals.forest import Forest
from topview_lab.rivals.forest.classes import CLASS_INDEX, CLASSES
from topview_lab.rivals.forest.growing import NO_CLASS
from topview_lab.training.body_parts import RenderedBody, simulated_bodies


@pytest.fixture(scope="module")
def bodies() -> list[RenderedBody]:
    return [known for of_image in simulated_bodies(12, seed=2951) for known in of_image]


def points_of(known: RenderedBody, name: str) -> np.ndarray:
    """[S, 3] points of a class, camera frame."""
    v, u = np.nonzero(known.body.label == CLASS_INDEX[name])
    z, view = known.body.depth_m[v, u].astype(np.float64), known.view
    return np.stack([(u - view.cx) * z / view.fx, (v - view.cy) * z / view.fy, z], axis=1)


def test_the_same_seed_gives_the_same_people(bodies: list[RenderedBody]) -> None:
    again = [known for of_image in simulated_bodies(12, seed=2951) for known in of_image]
    assert len(again) == len(bodies) >= 12
    for a, b in zip(bodies, again, strict=True):
        assert np.array_equal(a.body.depth_m, b.body.depth_m)
        assert np.array_equal(a.body.label, b.body.label)


def test_a_body_is_labelled_and_nothing_else_is(bodies: list[RenderedBody]) -> None:
    for known in bodies:
        is_body = known.body.depth_m < BACKGROUND_M
        assert np.array_equal(known.body.label != NO_CLASS, is_body)
        assert known.body.label[is_body].max() < len(CLASSES)


def test_every_class_is_seen_on_somebody(bodies: list[RenderedBody]) -> None:
    seen = np.unique(np.concatenate([known.body.label.ravel() for known in bodies]))
    assert set(seen) == {*range(len(CLASSES)), NO_CLASS}


def test_a_class_lies_around_its_joint_on_the_right_side(bodies: list[RenderedBody]) -> None:
    for known in bodies:
        for joint in ("elbow", "hand", "knee", "ankle", "shoulder"):
            left, right = (
                known.joints_camera[JOINT_NAMES.index(f"{side}_{joint}")]
                for side in ("left", "right")
            )
            points = points_of(known, f"left_{joint}")
            if len(points) < 5 or np.linalg.norm(left - right) < 0.3:
                continue
            middle = np.median(points, axis=0)
            assert np.linalg.norm(middle - left) < np.linalg.norm(middle - right)
            assert np.linalg.norm(middle - left) < 0.2


@pytest.mark.parametrize(
    ("wrong", "complaint"),
    [
        ({"images": 0}, "--images is 0"),
        ({"trees": 0}, "--trees is 0"),
        ({"depth": -1}, "--depth is -1"),
        ({"candidates": 100}, "multiple of 64"),
        ({"seed": 1000}, "--seed is 1000"),
    ],
)
def test_numbers_that_cannot_be_get_one_clear_line(wrong: dict[str, Any], complaint: str) -> None:
    with pytest.raises(InputError, match=complaint):
        command.train_forest(**wrong)


def test_the_command_trains_writes_and_scores(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(command, "CALIBRATION_IMAGES", 4)
    monkeypatch.setattr(command, "HELD_OUT_IMAGES", 4)
    out = tmp_path / "forest.npz"
    command.train_forest(out=out, images=8, trees=1, depth=6, candidates=64)
    forest = Forest.load(out)
    assert "8 renders" in forest.trained_on
    printed = capsys.readouterr().out
    assert "MB written" in printed
    assert "within 10 cm" in printed
    assert "left_hand" in printed
