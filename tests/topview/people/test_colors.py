from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from topview.detect.beliefs import Kind
from topview.detect.color_view import Light
from topview.detect.ellipses import Ellipse
from topview.detect.faces_and_hands import SkinBlob, SkinDetections
from topview.people.colors import FaceMemory, hands_in, skin_share
from topview.records import Camera, Frame

CAMERA = Camera(262.5, 262.5, 79.5, 59.5, 160, 120)
HEAD = np.array([0.0, 0.0, 2.0])


def frame(depth_m: float = 1.95) -> Frame:
    return Frame(0, 0.0, np.full((120, 160), depth_m, np.float32), CAMERA)


def detections(skin: np.ndarray) -> SkinDetections:
    return SkinDetections(
        Light.USABLE, skin_probability=skin, is_skin=skin > 100, is_foreground=skin >= 0
    )


def test_the_share_of_skin_is_that_of_the_head() -> None:
    everywhere, nowhere = np.full((120, 160), 255, np.uint8), np.zeros((120, 160), np.uint8)
    assert skin_share(detections(everywhere), frame(), HEAD) == 1.0
    assert skin_share(detections(nowhere), frame(), HEAD) == 0.0
    left_half = nowhere.copy()
    left_half[:, :80] = 255
    assert skin_share(detections(left_half), frame(), HEAD) == pytest.approx(0.5, abs=0.05)


def test_without_colours_or_a_head_in_view_nobody_knows() -> None:
    skin = np.full((120, 160), 255, np.uint8)
    assert skin_share(None, frame(), HEAD) is None
    assert skin_share(SkinDetections(Light.GREY), frame(), HEAD) is None
    assert skin_share(detections(skin), frame(1.0), HEAD) is None  # something hides the head
    for place in ([9.0, 0.0, 2.0], [0.0, -9.0, 2.0], [0.0, 0.0, -1.0]):
        assert skin_share(detections(skin), frame(), np.array(place)) is None


@given(st.lists(st.one_of(st.none(), st.floats(0.0, 1.0)), max_size=30))
def test_a_face_share_is_a_share_or_unknown(shares: list[float | None]) -> None:
    memory = FaceMemory()
    for index, share in enumerate(shares):
        told = memory.update(share, False, index / 30)
        assert told is None or 0.0 <= told <= 1.0
        assert share is not None or told is None


def test_who_turns_away_is_known_by_what_the_face_has_shown() -> None:
    memory = FaceMemory()
    assert memory.update(0.1, False, 0.0) is None  # a back, or skin that is not seen for skin
    assert [memory.update(0.6, False, k / 30) for k in range(30)][-1] == pytest.approx(1.0)
    assert [memory.update(0.1, False, 1 + k / 30) for k in range(60)][-1] == pytest.approx(
        0.0, abs=0.01
    )
    assert [memory.update(0.6, False, 3 + k / 30) for k in range(60)][-1] == pytest.approx(
        1.0, abs=0.01
    )


def test_a_face_that_is_found_tells_at_once_and_what_little_skin_shows_then_counts() -> None:
    memory = FaceMemory()
    assert memory.update(0.2, False, 0.0) is None
    assert not memory.is_known
    assert memory.update(0.2, True, 0.1) == 1.0
    assert memory.is_known
    away = [memory.update(0.0, False, 0.3 + k / 30) for k in range(60)]
    assert away[-1] == pytest.approx(0.0, abs=0.01)
    blind = FaceMemory()
    assert blind.update(0.0, True, 0.0) == 1.0
    assert not blind.is_known
    assert blind.update(0.0, False, 1.0) is None


def blob(belief: list[float], is_seen: bool = True, has_depth: bool = True) -> SkinBlob:
    place = np.array([0.1, 0.2, 2.0])
    return SkinBlob(
        id=1,
        belief=np.array(belief),
        ellipse=Ellipse(4.0, 5.0, 2.0, 1.0, 0.8),
        surface_camera=place if has_depth else None,
        palm_camera=place + 0.01 if has_depth else None,
        major_m=0.08,
        minor_m=0.05,
        is_seen=is_seen,
        skin_probability=0.9,
        features={},
    )


def test_hands_are_the_blobs_that_are_seen_and_more_likely_hands_than_not() -> None:
    assert len(Kind) == 4
    left = blob([0.1, 0.6, 0.2, 0.1])
    others = [
        blob([0.9, 0.05, 0.05, 0.0]),
        blob([0.1, 0.6, 0.2, 0.1], is_seen=False),
        blob([0.1, 0.6, 0.2, 0.1], has_depth=False),
    ]
    (hand,) = hands_in(SkinDetections(Light.USABLE, blobs=(*others, left)))
    assert left.palm_camera is not None
    assert np.array_equal(hand.palm_camera, left.palm_camera)
    assert hand.confidence == pytest.approx(0.8)
    assert hand.left_share == pytest.approx(0.75)
    assert hands_in(None) == ()
