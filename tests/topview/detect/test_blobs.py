"""Blobs keep their identities: association, prediction, crossing, creation and elimination."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from detect_scenes import CAMERA, frame_of, regions_of, view_of
from topview.detect.blobs import BlobTracker
from topview.records import Frame

ROWS, COLUMNS = np.mgrid[:120, :160]


def disc(x: float, y: float, radius: float) -> NDArray[np.bool_]:
    return np.hypot(COLUMNS - x, ROWS - y) <= radius


def step(tracker: BlobTracker, index: int, mask: NDArray[np.bool_], depth_m: NDArray | None = None):
    """The blobs after a frame in which skin is where `mask` says, by their identities."""
    if depth_m is None:
        depth_m = np.full(mask.shape, 2.0)
    frame = Frame(index, index / 30.0, depth_m.astype(np.float32), CAMERA, frame_of().color)
    return {blob.id: blob for blob in tracker.update(view_of(frame), regions_of(mask, 2.0))}


def test_a_region_makes_one_blob_that_follows_it() -> None:
    tracker, blobs = BlobTracker(), {}
    for index in range(20):
        blobs = step(tracker, index, disc(30 + 4 * index, 60, 8))
    assert list(blobs) == [1]
    assert blobs[1].ellipse.center == pytest.approx((106, 60), abs=0.5)
    assert blobs[1].velocity_px_s == pytest.approx((120, 0), abs=6)
    assert blobs[1].depth_m == pytest.approx(2.0)


def test_two_hands_that_cross_keep_their_identities() -> None:
    tracker, blobs = BlobTracker(), {}
    for index in range(31):
        x = 20 + 4 * index
        blobs = step(tracker, index, disc(x, 58, 8) | disc(160 - x, 62, 8))
    assert sorted(blobs) == [1, 2]
    left, right = (blobs[i].ellipse.x for i in (1, 2))
    assert left == pytest.approx(140, abs=2)
    assert right == pytest.approx(20, abs=2)
    assert all(blob.overlap == 0.0 for blob in blobs.values())


def test_a_hand_before_the_face_is_told_by_depth() -> None:
    tracker, blobs = BlobTracker(), {}
    for index in range(40):
        x = 20.0 + 3.0 * min(index, 20)  # stops before the face
        face, hand = disc(80, 60, 16), disc(x, 60, 7)
        depth_m = np.where(hand, 1.6, 2.0)
        blobs = step(tracker, index, face | hand, depth_m)
    assert sorted(blobs) == [1, 2]
    by_size = sorted(blobs.values(), key=lambda blob: blob.ellipse.major)
    assert [blob.depth_m for blob in by_size] == pytest.approx([1.6, 2.0], abs=0.01)
    assert by_size[0].ellipse.major == pytest.approx(7, abs=1.5)


def test_a_region_apart_from_all_ellipses_is_new() -> None:
    tracker = BlobTracker()
    step(tracker, 0, disc(40, 60, 8))
    blobs = step(tracker, 1, disc(40, 60, 8) | disc(120, 60, 8))
    assert sorted(blobs) == [1, 2]


def test_a_region_that_breaks_up_keeps_one_blob_on_the_larger_piece() -> None:
    tracker, blobs = BlobTracker(), {}
    for index in range(5):
        step(tracker, index, disc(80, 60, 12))
    broken = disc(80, 60, 12) & (np.abs(COLUMNS - 86) > 1)
    blobs = step(tracker, 5, broken)
    assert blobs[1].ellipse.x < 80


def test_a_blob_without_support_goes_after_a_grace_time() -> None:
    tracker, blobs = BlobTracker(), {}
    nothing = np.zeros((120, 160), np.bool_)
    for index in range(15):
        step(tracker, index, disc(40 + 2 * index, 60, 8))
    for index in range(15, 20):
        blobs = step(tracker, index, nothing)
    assert blobs[1].region is None
    assert blobs[1].ellipse.x > 70  # it moves on
    back = step(tracker, 20, disc(80, 60, 8))
    assert list(back) == [1]
    for index in range(21, 40):
        blobs = step(tracker, index, nothing)
    assert not blobs


def test_a_flicker_does_not_live_on() -> None:
    tracker = BlobTracker()
    step(tracker, 0, disc(40, 60, 8))
    assert not step(tracker, 1, np.zeros((120, 160), np.bool_))


def test_two_blobs_that_became_one_do_not_stay_two() -> None:
    tracker, blobs = BlobTracker(), {}
    for index in range(12):
        step(tracker, index, disc(60 + index, 60, 8) | disc(100 - 2 * index, 60, 8))
    for index in range(12, 150):
        blobs = step(tracker, index, disc(74, 60, 9))
    assert list(blobs) == [1]
