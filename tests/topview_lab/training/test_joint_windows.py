"""Windows that joints are learnt from: what is seen and what is said of it change together."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from labelled_people import discs, write_recording
from topview.camera.pyramid import DepthView
from topview.detect.joints.proposals import OTHER_SIDES
from topview.detect.joints.windows import DEPTH, OTHER, OWN, WINDOW_PIXELS, cut_windows
from topview.records import InputError
from topview_lab.training.joints.recordings import cached, folders_in, gathered
from topview_lab.training.joints.windows import (
    AS_THEY_ARE,
    WITHOUT_PERSON,
    Variation,
    labelled_window,
)

RECORDING = discs()
SAMPLES = gathered([RECORDING])
WALL_MM = np.where(RECORDING.depth_mm > 0, RECORDING.depth_mm, 3600).astype(np.uint16)
WITH_WALL = gathered([replace(RECORDING, depth_mm=WALL_MM)])
MOVED = replace(
    AS_THEY_ARE, scales=(0.75, 1.25), stretch=(0.12, 0.08, 0.15), turn_rad=(0.2, 0.2, 0.3),
    shift_m=0.1, far_shift_share=0.2, far_shift_m=0.3,
)  # fmt: skip


@given(st.integers(0, len(SAMPLES) - 1), st.integers(0, 2**32))
def test_each_joint_is_where_the_window_shows_it(number: int, seed: int) -> None:
    """However the scene is scaled, stretched, turned, shifted and mirrored, a joint's disc is at
    its place, as deep as the joint."""
    window = labelled_window(SAMPLES, number, np.random.default_rng(seed), MOVED)
    pixels = np.floor((window.places[:, :2] + 1.0) * WINDOW_PIXELS / 2).astype(int)
    is_inside = ((pixels >= 0) & (pixels < WINDOW_PIXELS)).all(axis=1) & window.is_known
    assert window.is_known.all()
    columns, rows = pixels[is_inside].T
    assert (window.image[OWN, rows, columns] == 1.0).all()
    depth = window.places[is_inside, 2]
    seen = window.image[DEPTH, rows, columns]
    # A disc faces the camera as it was: turned, its rim is nearer or farther than its middle.
    np.testing.assert_allclose(seen, np.clip(depth, -1.0, 1.0), atol=0.02)


@given(st.integers(0, len(SAMPLES) - 1), st.integers(0, 2**32))
def test_whoever_the_border_cuts_is_known_where_seen(number: int, seed: int) -> None:
    """Known are the joints that the rest of the image shows, and no others."""
    how = replace(AS_THEY_ARE, border_share=1.0, border_hidden=0.7)
    window = labelled_window(SAMPLES, number, np.random.default_rng(seed), how)
    assert np.count_nonzero(window.image[OWN]) > 0
    pixels = np.floor((window.places[window.is_known, :2] + 1.0) * WINDOW_PIXELS / 2).astype(int)
    pixels = pixels[((pixels >= 0) & (pixels < WINDOW_PIXELS)).all(axis=1)]
    beside = cv2.dilate(window.image[OWN], np.ones((5, 5), np.uint8))  # a joint on the edge
    assert (beside[pixels[:, 1], pixels[:, 0]] == 1.0).all()


def test_the_border_hides_joints() -> None:
    how = replace(AS_THEY_ARE, border_share=1.0, border_hidden=0.7)
    drawn = [labelled_window(SAMPLES, 0, np.random.default_rng(seed), how) for seed in range(8)]
    assert any(not window.is_known.all() and window.is_known.any() for window in drawn)


def test_without_variation_it_is_the_trackers_own_window() -> None:
    recording = SAMPLES.recordings[0]
    for number, (_, frame, person) in enumerate(SAMPLES.index):
        window = labelled_window(SAMPLES, number, np.random.default_rng(0), AS_THEY_ARE)
        view = DepthView(
            recording.depth_mm[frame].astype(np.float32) / np.float32(1000), *recording.intrinsics
        )
        labels = recording.masks[frame].astype(np.int32)
        cut = cut_windows(view, labels, [int(recording.ids[person])])
        np.testing.assert_array_equal(window.image, cut.images[0])
        places = cut.from_camera(recording.joints_camera[frame, person][None].astype(float))[0]
        np.testing.assert_allclose(window.places, places, atol=1e-6)


@given(st.integers(0, len(SAMPLES) - 1), st.integers(0, 2**32))
def test_a_varied_window_stays_one(number: int, seed: int) -> None:
    """All variations at once: what the network takes and is told keeps its range and its sense."""
    window = labelled_window(SAMPLES, number, np.random.default_rng(seed), Variation())
    depth, own, other = window.image[DEPTH], window.image[OWN], window.image[OTHER]
    assert (np.abs(depth) <= 1.0).all()
    assert set(np.unique(window.image[OWN:])) <= {0.0, 1.0}
    assert not (own * other).any()
    assert (window.visible >= 0.0).all()
    assert (window.visible <= 1.0).all()
    assert np.isfinite(window.places).all()
    if not window.is_person:
        assert not window.is_known.any()


def test_what_is_nobody_is_no_person() -> None:
    """Where there is background, a piece of it is looked at in the place of the person."""
    window = labelled_window(WITH_WALL, 0, np.random.default_rng(1), WITHOUT_PERSON)
    assert not window.is_person
    assert window.image[OWN].any()
    assert not window.visible.any()


def test_mirrored_names() -> None:
    assert (OTHER_SIDES[OTHER_SIDES] == np.arange(len(OTHER_SIDES))).all()
    assert (np.arange(len(OTHER_SIDES)) != OTHER_SIDES).sum() == 16


def test_a_recording_comes_back_from_its_cache(tmp_path) -> None:
    recording = discs()
    folder = write_recording(tmp_path / "in" / "a", recording)
    assert list(folders_in([tmp_path / "in"])) == [folder] == list(folders_in([folder]))
    for _ in range(2):
        read = cached(folder, tmp_path / "cache")
        np.testing.assert_array_equal(read.depth_mm, recording.depth_mm)
        np.testing.assert_array_equal(read.masks, recording.masks)
        np.testing.assert_array_equal(read.joints_camera, recording.joints_camera)
        assert np.isnan(read.hidden).all()
        (folder / "camera.json").unlink(missing_ok=True)


@pytest.mark.parametrize(
    ("truth", "says"),
    [
        ({"names": np.array(["tail", *["head"] * 20])}, "unknown joints tail"),
        ({"ids": np.array([7, 8])}, "no mask shows any of the ids 7, 8"),
        ({"joints": np.zeros((3, 2, 5, 3))}, r"joints is \(3, 2, 5, 3\)"),
        ({"joints": np.zeros((2, 2, 21, 3), np.float32)}, "its truth has 2 frames"),
        ({"joint_occ_inter": np.zeros((3, 2))}, r"joint_occ_inter is \(3, 2\)"),
    ],
)
def test_truth_that_does_not_fit_is_named(tmp_path, truth, says) -> None:
    folder = write_recording(tmp_path / "a", discs(), **truth)
    with pytest.raises(InputError, match=says):
        cached(folder, tmp_path / "cache")


def test_missing_masks_and_truth_are_named(tmp_path) -> None:
    folder = write_recording(tmp_path / "a", discs())
    (folder / "mask" / "000001.png").unlink()
    with pytest.raises(InputError, match=r"000001\.png is missing"):
        cached(folder, tmp_path / "cache")
    (folder / "groundtruth.npz").unlink()
    with pytest.raises(InputError, match=r"has no groundtruth\.npz"):
        list(folders_in([tmp_path]))
