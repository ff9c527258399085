"""The forest of body parts: its features, its trees, its file, and the joints it proposes."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from topview.body.parts import JOINT_NAMES
from topview.kernels.threads import use_threads
from topview.records import Camera, InputError
from topview_lab.kernels import forest as kernel
from topview_lab.rivals.forest import Forest, default_forest, propose_joints
from topview_lab.rivals.forest.classes import CLASS_INDEX, CLASSES, VOTES
from topview_lab.rivals.forest.growing import (
    NO_CLASS,
    GrowingSettings,
    LabelledBody,
    draw_offsets,
    grow_forest,
)
from topview_lab.rivals.forest.model import Trees, person_depth
from topview_lab.rivals.forest.proposals import SurfaceVotes, surface_modes

LENS = Camera(260.0, 260.0, 59.5, 79.5, 120, 160)
TOY = GrowingSettings(trees=2, depth=6, candidates=64, pixels=200)
HEAD, FOOT = CLASS_INDEX["head"], CLASS_INDEX["left_foot"]


def differences(
    depth_m: NDArray[np.float32], pixels: NDArray[np.int32], focal_px: float, offsets_m: NDArray
) -> NDArray[np.float32]:
    """What the kernel makes of every pixel [2, S] with every offset [C, 4]: [S, C]."""
    S, C = pixels.shape[1], len(offsets_m)
    u, v = np.repeat(pixels, C, axis=1)
    crops = np.array([[0, depth_m.shape[1], depth_m.shape[0]]], np.int64)
    out = np.empty(S * C, np.float32)
    kernel.differences(
        depth_m.ravel(), crops, np.zeros(S * C, np.int32), u, v,
        np.tile(np.arange(C, dtype=np.int32), S), offsets_m.astype(np.float32),
        np.float32(focal_px), np.float32(focal_px), out,
    )  # fmt: skip
    return out.reshape(S, C)


def bumpy_body(seed: int, z_m: float = 2.0) -> NDArray[np.float32]:
    """[160, 120] a body of blocks."""
    rng = np.random.default_rng(seed)
    relief = np.kron(rng.uniform(-0.2, 0.2, (16, 12)), np.ones((10, 10)))
    is_body = np.zeros((160, 120), np.bool_)
    is_body[20:140, 30:90] = True
    return person_depth((z_m + relief).astype(np.float32), is_body)


def definition(depth_m: NDArray, u: int, v: int, focal_px: float, offset: NDArray) -> float:
    """Eq. 1 of Shotton et al., offsets in metres."""

    def look(x_m: float, y_m: float) -> float:
        d = depth_m[v, u]
        column = int(np.floor(u + x_m * focal_px / d + 0.5))
        row = int(np.floor(v + y_m * focal_px / d + 0.5))
        inside = 0 <= row < depth_m.shape[0] and 0 <= column < depth_m.shape[1]
        return float(depth_m[row, column]) if inside else float(kernel.BACKGROUND_M)

    return look(*offset[:2]) - look(*offset[2:])


def test_the_kernel_computes_the_defined_feature() -> None:
    depth_m = bumpy_body(1)
    pixels = np.stack(np.nonzero(depth_m < 9.0)[::-1]).astype(np.int32)[:, ::97]
    offsets = draw_offsets(TOY, np.random.default_rng(0))[:20]
    got = differences(depth_m, pixels, 260.0, offsets)
    for s, (u, v) in enumerate(pixels.T):
        for c, offset in enumerate(offsets):
            # a place between two pixels may be rounded either way
            x = np.array([u, v, u, v]) + offset * 260.0 / depth_m[v, u] + 0.5
            if np.abs(x - np.rint(x)).min() > 1e-3:
                assert got[s, c] == pytest.approx(definition(depth_m, u, v, 260.0, offset))


@settings(max_examples=20)
@given(st.integers(0, 100), st.floats(0.5, 2.0))
def test_features_do_not_change_with_distance_if_the_image_stays_as_large(
    seed: int, scale: float
) -> None:
    """Moved away, and seen with a focal length that makes up for it, only the relief counts."""
    near = bumpy_body(seed)
    is_body = near < 9.0
    far = person_depth(np.where(is_body, near + np.float32(scale), 0.0), is_body)
    pixels = np.stack(np.nonzero(is_body)[::-1]).astype(np.int32)[:, ::331]
    offsets = draw_offsets(TOY, np.random.default_rng(seed))[:10]
    for u, v in pixels.T:
        focal_far = 260.0 * float(far[v, u] / near[v, u])
        at = np.array([[u], [v]], np.int32)
        a = differences(near, at, 260.0, offsets)
        b = differences(far, at, focal_far, offsets)
        told_a, told_b = (np.clip(told, -1.0, 1.0) for told in (a, b))  # beyond is background
        # a place just between two pixels may be rounded either way
        assert np.isclose(told_a, told_b, atol=1e-4).mean() >= 0.9


def toy_bodies(count: int) -> list[LabelledBody]:
    """Blocks whose upper half is head, the lower half foot: the outline alone tells them apart."""
    bodies = []
    for seed in range(count):
        depth_m = bumpy_body(seed)
        label = np.full(depth_m.shape, NO_CLASS, np.uint8)
        label[depth_m < 9.0] = FOOT
        label[:80][depth_m[:80] < 9.0] = HEAD
        bodies.append(LabelledBody(depth_m, label))
    return bodies


@pytest.fixture(scope="module")
def toy_trees() -> Trees:
    return grow_forest(toy_bodies(6), LENS, TOY, seed=3)


def shares(trees: Trees, body: LabelledBody) -> tuple[NDArray[np.float32], NDArray[np.uint8]]:
    is_body = body.label != NO_CLASS
    pixels = np.stack(np.nonzero(is_body)[::-1]).astype(np.int32)
    return trees.classify(body.depth_m, pixels, (LENS.fx, LENS.fy)), body.label[is_body]


def test_trees_learn_what_the_outline_tells(toy_trees: Trees) -> None:
    told, label = shares(toy_trees, toy_bodies(8)[-1])
    assert (told.argmax(1) == label).mean() > 0.9


def test_what_trees_say_sums_to_one(toy_trees: Trees) -> None:
    told, _ = shares(toy_trees, toy_bodies(1)[0])
    assert told.sum(1) == pytest.approx(1.0, abs=len(CLASSES) / 255)
    assert told[:, [k for k in range(len(CLASSES)) if k not in (HEAD, FOOT)]].max() == 0.0


def test_trees_do_not_depend_on_the_number_of_threads(toy_trees: Trees) -> None:
    use_threads(1)
    try:
        alone = grow_forest(toy_bodies(6), LENS, TOY, seed=3)
    finally:
        use_threads(0)
    for name in Trees.__dataclass_fields__:
        assert np.array_equal(getattr(alone, name), getattr(toy_trees, name)), name


def test_another_seed_grows_other_trees(toy_trees: Trees) -> None:
    other = grow_forest(toy_bodies(6), LENS, TOY, seed=4)
    assert not np.array_equal(other.offsets, toy_trees.offsets)


@pytest.fixture
def toy_forest(toy_trees: Trees) -> Forest:
    J = len(JOINT_NAMES)
    return Forest(toy_trees, np.full(J, 0.05, np.float32), np.full(J, 0.01, np.float32), "blocks")


def test_a_forest_comes_back_from_its_file(toy_forest: Forest, tmp_path: Path) -> None:
    (tmp_path / "forest.npz").write_bytes(toy_forest.npz())
    again = Forest.load(tmp_path / "forest.npz")
    for name in Trees.__dataclass_fields__:
        assert np.array_equal(getattr(again.trees, name), getattr(toy_forest.trees, name)), name
    assert np.array_equal(again.depths_m, toy_forest.depths_m)
    assert again.trained_on == "blocks"


def rewritten(data: bytes, path: Path, **changed: object) -> Path:
    path.write_bytes(data)
    with np.load(path) as file:
        arrays: dict[str, Any] = dict(file) | {
            name: np.asarray(value) for name, value in changed.items()
        }
    np.savez(path, **arrays)
    return path


@pytest.mark.parametrize(
    ("changed", "complaint"),
    [
        ({"version": 0}, "version 0, not 1; it must be written by `topview train-forest`, again"),
        ({"classes": np.array(["tail"])}, "other body parts.*train-forest"),
        ({"version": "x"}, "holds no forest"),
        ({"roots": np.array([10**6])}, "whole file"),
        ({"children": np.zeros(5, np.int32)}, "whole file"),
        ({"depths_m": np.zeros(3, np.float32)}, "depths_m.*16 joints"),
    ],
)
def test_a_file_that_is_another_gets_one_clear_line(
    toy_forest: Forest, tmp_path: Path, changed: dict[str, object], complaint: str
) -> None:
    path = rewritten(toy_forest.npz(), tmp_path / "other.npz", **changed)
    with pytest.raises(InputError, match=complaint) as caught:
        Forest.load(path)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("cut", [0, 10, 1000])
def test_a_broken_file_gets_one_clear_line(toy_forest: Forest, tmp_path: Path, cut: int) -> None:
    path = tmp_path / "broken.npz"
    path.write_bytes(toy_forest.npz()[:cut])
    with pytest.raises(InputError, match=r"is truncated or damaged.*train-forest") as caught:
        Forest.load(path)
    assert "\n" not in str(caught.value)


def test_a_missing_file_gets_one_clear_line(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"No such file.*train-forest"):
        Forest.load(tmp_path / "none.npz")


@given(st.integers(0, 1000))
def test_the_mode_of_a_blob_is_its_middle(seed: int) -> None:
    rng = np.random.default_rng(seed)
    middle = rng.uniform((-1.0, -1.0, 2.0), (1.0, 1.0, 4.0))
    points = (middle + rng.normal(0.0, 0.03, (500, 3))).astype(np.float32)
    votes = np.zeros((500, len(VOTES)), np.float32)
    votes[:, 4] = 0.7
    seen = SurfaceVotes(points, np.full(500, 1e-4, np.float32), votes)
    modes = surface_modes(seen)
    assert np.linalg.norm(modes[4][0, :3] - middle) < 0.015
    assert all(not len(modes[j]) for j in range(len(VOTES)) if j != 4)


def test_two_blobs_have_two_modes_the_larger_one_first() -> None:
    rng = np.random.default_rng(1)
    middles = np.repeat([[0.0, 0.0, 2.0], [0.5, 0.0, 2.0]], [100, 300], axis=0)
    points = (middles + rng.normal(0.0, 0.02, (400, 3))).astype(np.float32)
    votes = np.full((400, len(VOTES)), 0.5, np.float32)
    modes = surface_modes(SurfaceVotes(points, np.full(400, 1e-4, np.float32), votes))[0]
    assert modes[:, 0] == pytest.approx([0.5, 0.0], abs=0.02)
    assert modes[0, 3] == pytest.approx(3.0 * modes[1, 3], rel=0.1)


def test_proposals_lie_behind_the_surface(toy_forest: Forest) -> None:
    depth_m = np.full((160, 120), 2.0, np.float32)
    is_body = bumpy_body(0) < 9.0
    near, deep = (
        propose_joints(depth_m, is_body, LENS, replace(toy_forest, depths_m=depths.copy()))
        for depths in np.array([[0.0], [0.1]], np.float32).repeat(len(JOINT_NAMES), 1)
    )
    assert [candidate.joint for candidate in near] == [candidate.joint for candidate in deep]
    assert "head" in {candidate.joint for candidate in near}
    for a, b in zip(near, deep, strict=True):
        ray = a.place_camera / np.linalg.norm(a.place_camera)
        assert b.place_camera - a.place_camera == pytest.approx(0.1 * ray, abs=1e-5)
        assert a.place_camera[2] == pytest.approx(2.0, abs=1e-3)
        assert 0.0 < a.confidence < 1.0


def test_nobody_has_no_joints(toy_forest: Forest) -> None:
    depth_m = np.full((160, 120), 2.0, np.float32)
    assert propose_joints(depth_m, np.zeros(depth_m.shape, np.bool_), LENS, toy_forest) == []


def test_the_forest_that_comes_along_is_small_and_says_what_it_was_trained_on() -> None:
    forest = default_forest()
    assert len(forest.npz()) < 5e6
    assert "simulator" in forest.trained_on
