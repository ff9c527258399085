"""Skin: Bayes' law, thresholds, sizes, adaptation, and light and dark skin alike."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from detect_scenes import SHIRT_RGB, SKIN_RGB, frame_of, view_of
from topview.detect.skin import (
    BINS,
    WINDOW_S,
    SkinColor,
    SkinHistograms,
    SkinSettings,
    count_colors,
    skin_regions,
)
from topview.records import InputError
from topview_lab.training.skin import (
    IS_SKIN,
    NOT_SKIN,
    UNKNOWN,
    LabelledImage,
    corrected,
    learn_skin,
)

EVERYWHERE = np.ones((120, 160), np.bool_)


def test_probability_is_bayes_law() -> None:
    skin, all_ = np.zeros((BINS, BINS)), np.zeros((BINS, BINS))
    all_[:] = 1.0 / BINS**2
    skin[:, : BINS // 2] = 0.5 / BINS**2
    probability = SkinHistograms(skin, all_, "a law").probability
    assert probability[20, 5] == pytest.approx(0.5, rel=0.01)
    assert probability[20, -5] == pytest.approx(0.0, abs=1e-6)
    assert ((probability >= 0.0) & (probability <= 1.0)).all()


@given(st.tuples(*[st.integers(0, 255)] * 3))
def test_brightness_does_not_matter(yuv: tuple[int, int, int]) -> None:
    y, u, v = yuv
    pixels = np.array([[[y, u, v], [255 - y, u, v]]], np.uint8)
    counts = count_colors(pixels, np.ones((1, 2), np.bool_))
    assert counts.max() == counts.sum() == 2.0


def test_counts_are_of_the_pixels_asked_for() -> None:
    view = view_of(frame_of([(80, 60, 10, 2.0, SKIN_RGB)]))
    where = view.depth_m < 2.5
    assert count_colors(view.yuv, where).sum() == where.sum()


def test_default_finds_skin_and_leaves_shirt_and_wall() -> None:
    frame = frame_of([(60, 60, 12, 2.0, SKIN_RGB), (110, 60, 25, 2.0, SHIRT_RGB)])
    view = view_of(frame)
    color = SkinColor()
    regions, is_skin = skin_regions(view, color.look(view, EVERYWHERE).probability, SkinSettings())
    assert len(regions) == 1
    assert regions[0].pixels.mean(axis=0) == pytest.approx((60, 60), abs=1)
    assert regions[0].depth_m == pytest.approx(2.0, abs=0.02)
    assert regions[0].area_m2 == pytest.approx(np.pi * (12 * 2.0 / 262.5) ** 2, rel=0.1)
    assert is_skin.sum() == len(regions[0].pixels)


def test_regions_need_a_seed_and_grow_from_it() -> None:
    view = view_of(frame_of())
    settings = SkinSettings(seed_probability=0.6, growth_probability=0.3)
    probability = np.zeros((120, 160), np.uint8)
    probability[10:20, 10:30] = 100  # above T_min alone
    probability[50:60, 10:30] = 100
    probability[55, 15] = 200
    regions, is_skin = skin_regions(view, probability, settings)
    assert len(regions) == 1
    assert is_skin[50:60, 10:30].all()
    assert is_skin.sum() == 200


@pytest.mark.parametrize(("radius_px", "is_found"), [(1, False), (6, True), (50, False)])
def test_regions_have_the_size_of_hands_and_faces(radius_px: int, is_found: bool) -> None:
    view = view_of(frame_of([(80, 60, radius_px, 2.5, SKIN_RGB)]))
    regions, _ = skin_regions(view, SkinColor().look(view, EVERYWHERE).probability, SkinSettings())
    assert (len(regions) == 1) == is_found


def test_a_hand_before_a_wall_of_its_colour_is_cut_out_by_depth() -> None:
    view = view_of(frame_of([(80, 60, 70, 3.0, SKIN_RGB), (80, 60, 8, 2.0, SKIN_RGB)]))
    regions, _ = skin_regions(view, SkinColor().look(view, EVERYWHERE).probability, SkinSettings())
    assert [region.depth_m for region in regions] == pytest.approx([2.0], abs=0.02)


def pixels_of(mask: NDArray[np.bool_]) -> NDArray[np.float32]:
    """[N, 2] (x, y)."""
    return np.argwhere(mask)[:, ::-1].astype(np.float32)


def test_skin_follows_a_change_of_light() -> None:
    tinted = (170, 150, 118)  # greener than any skin that was learnt
    view = view_of(frame_of([(80, 60, 14, 2.0, tinted)]))
    is_hand = view.depth_m < 2.5
    color = SkinColor()
    before = color.look(view, EVERYWHERE).probability[is_hand].mean()
    for _ in range(5):
        look = color.look(view, EVERYWHERE)
        color.adapt(look, [pixels_of(is_hand)], view.frame.timestamp_s)  # all at the same time
    after = color.look(view, EVERYWHERE).probability
    assert after[is_hand].mean() > before + 25
    assert after[~is_hand].mean() < 5
    later = view_of(frame_of([(80, 60, 14, 2.0, tinted)], index=round(30 * WINDOW_S) + 1))
    color.adapt(color.look(later, EVERYWHERE), [], later.frame.timestamp_s)
    assert color.look(view, EVERYWHERE).probability[is_hand].mean() == pytest.approx(before)


def _labelled() -> LabelledImage:
    view = view_of(frame_of([(80, 60, 20, 2.0, SHIRT_RGB)]))
    label = np.where(view.depth_m < 2.5, IS_SKIN, NOT_SKIN).astype(np.uint8)
    label[:, :40] = UNKNOWN
    return LabelledImage(view.rgb, label)


def test_histograms_are_learnt_from_masks_and_written(tmp_path: Path) -> None:
    learnt = learn_skin([_labelled()], "a blue hand")
    assert learnt.all.sum() == pytest.approx(1.0)
    file = tmp_path / "skin.npz"
    file.write_bytes(learnt.npz())
    read = SkinHistograms.load(file)
    assert read.trained_on == "a blue hand"
    view = view_of(frame_of([(80, 60, 20, 2.0, SHIRT_RGB)]))
    probability = SkinColor(read).look(view, EVERYWHERE).probability
    is_hand = view.depth_m < 2.5
    assert np.median(probability[is_hand]) > 200
    assert np.median(probability[~is_hand]) == 0


def test_a_correction_wins_colours_and_takes_them_away() -> None:
    default = SkinHistograms.load()
    better = corrected(default, learn_skin([_labelled()], "a blue hand"), 0.3)
    view = view_of(frame_of([(80, 60, 20, 2.0, SHIRT_RGB)]))
    is_hand = view.depth_m < 2.5
    assert SkinColor(default).look(view, EVERYWHERE).probability[is_hand].max() < 25
    assert np.median(SkinColor(better).look(view, EVERYWHERE).probability[is_hand]) > 128
    no_skin = LabelledImage(_labelled().rgb, np.full((120, 160), NOT_SKIN, np.uint8))
    worse = corrected(better, learn_skin([no_skin], "no hand"), 0.9)
    assert np.median(SkinColor(worse).look(view, EVERYWHERE).probability[is_hand]) < 60


def test_files_that_hold_something_else_are_refused(tmp_path: Path) -> None:
    file = tmp_path / "skin.npz"
    with pytest.raises(InputError, match="No such file"):
        SkinHistograms.load(file)
    np.savez(file, something=np.zeros(3))
    with pytest.raises(InputError, match="train-skin"):
        SkinHistograms.load(file)
    file.write_bytes(b"no archive")
    with pytest.raises(InputError, match="train-skin"):
        SkinHistograms.load(file)
    with pytest.raises(InputError, match="skin histogram all"):
        SkinHistograms(np.zeros((BINS, BINS)), np.zeros((3, 3)), "")
