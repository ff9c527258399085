"""The kernel's counts are the definition's counts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_array_equal
from score_scenes import SHAPE, TOLERANCE_M, Scene, placed_rows, random_scene, view_of

from topview.kernels.utvr import N_COUNTS, count_hypotheses, take_inside

# The kernel counts in float32: a point or pixel within about a micrometre of a border may fall on
# the other side. In 60 such scenes 15 of 5040 counts differed, by one each.
BORDER_CASES = 1


def counted(
    scene: Scene,
    chunks: int = 1,
    own: np.ndarray | None = None,
    layers: np.ndarray | None = None,
) -> np.ndarray:
    """[M, 7] counts of the kernel."""
    Ts = np.array([h.T_camera_part for h in scene.hypotheses]).astype(np.float32)
    view, f4 = scene.view, np.float32
    counts = np.full((len(Ts), N_COUNTS), -1, np.int32)
    count_hypotheses(
        view.depth_m,
        scene.observed.own if own is None else own,
        f4(view.fx),
        f4(view.fy),
        f4(view.cx),
        f4(view.cy),
        np.ascontiguousarray(Ts[:, :3, :3]),
        np.ascontiguousarray(Ts[:, :3, 3]),
        np.full(len(Ts), 1, np.uint8) if layers is None else layers,
        f4(scene.hypotheses[0].length_m),
        f4(scene.hypotheses[0].radii_m[0]),
        f4(scene.hypotheses[0].radii_m[1]),
        f4(view.cell_m(float(Ts[:, 2, 3].mean()))),
        f4(TOLERANCE_M),
        placed_rows(scene.placed),
        chunks,
        counts,
    )
    return counts


@pytest.mark.parametrize("seed", range(1, 13))  # in scene 0 the true pose is hidden
def test_kernel_counts_what_the_definition_counts(seed):
    scene = random_scene(seed)
    expected, actual = scene.defined(), counted(scene)
    assert expected[0].min() >= 0
    assert expected[0, 0] > 30  # the true pose has its points
    assert np.abs(actual - expected).max() <= BORDER_CASES
    assert (actual != expected).mean() < 0.05


def test_scoring_goes_through_the_same_counts():
    scene = random_scene(3)
    terms, counts = scene.scored(), counted(scene)
    assert_array_equal(terms.n_points, counts[:, 0])
    assert_array_equal(terms.n_pixels, counts[:, 2])
    assert_array_equal(terms.n_outliers, counts[:, 5])
    assert terms.score.argmin() == 0  # the true pose


@pytest.mark.parametrize("chunks", [2, 5, 40])
def test_counts_do_not_depend_on_how_the_work_is_dealt(chunks):
    scene = random_scene(4, hypotheses=17)
    assert_array_equal(counted(scene, chunks), counted(scene))


def test_counts_do_not_depend_on_the_hypotheses_beside():
    scene = random_scene(5)
    alone = Scene(scene.hypotheses[3:4], scene.is_own, scene.view, scene.placed)
    assert_array_equal(counted(alone)[0, 2:], counted(scene)[3, 2:])
    assert_array_equal(counted(alone)[0, 0], counted(scene)[3, 0])


def test_no_points_no_parts_and_an_empty_image_are_fine():
    scene = random_scene(6)
    bare = Scene(scene.hypotheses, np.zeros(SHAPE, bool), view_of(np.zeros(SHAPE)), [])
    counts = counted(bare)
    assert_array_equal(counts[:, [0, 1, 3, 4, 6]], 0)
    assert_array_equal(counts[:, 2], counts[:, 5])
    assert not bare.scored().has_evidence.any()


def test_each_hypothesis_has_the_points_of_its_layer():
    scene = random_scene(7)
    rng = np.random.default_rng(7)
    first, second = scene.is_own & (rng.random((2, *SHAPE)) < 0.6)
    of_second = np.arange(len(scene.hypotheses)) % 2 == 1
    both = first.astype(np.uint8) + 4 * second.astype(np.uint8)
    counts = counted(scene, own=both, layers=np.where(of_second, 4, 1).astype(np.uint8))
    alone = [replace(scene, is_own=layer) for layer in (first, second)]
    expected = np.where(of_second[:, None], counted(alone[1]), counted(alone[0]))
    assert_array_equal(counts, expected)
    assert (counted(alone[0])[:, 0] != counted(alone[1])[:, 0]).any()


def test_each_cylinder_takes_the_points_inside_out_of_its_layer():
    scene = random_scene(8, hypotheses=3)
    Ts = np.array([h.T_camera_part for h in scene.hypotheses]).astype(np.float32)
    view, f4 = scene.view, np.float32
    own = 7 * scene.observed.own
    rx, rz = scene.hypotheses[0].radii_m
    take_inside(
        view.depth_m, f4(view.fx), f4(view.fy), f4(view.cx), f4(view.cy),
        np.ascontiguousarray(Ts[:, :3, :3]), np.ascontiguousarray(Ts[:, :3, 3]),
        f4(scene.hypotheses[0].length_m), f4(rx), f4(rz), own,
    )  # fmt: skip
    rows, columns = np.nonzero(scene.is_own & (view.depth_m > 0))
    for layer, hypothesis in enumerate(scene.hypotheses):
        is_inside = hypothesis.contains(view.points(rows, columns))
        is_left = own[rows, columns] & (1 << layer) > 0
        assert (is_left == is_inside).sum() <= BORDER_CASES
    assert counted(scene, own=own & 1)[0, 0] <= BORDER_CASES  # the true pose has taken its points
