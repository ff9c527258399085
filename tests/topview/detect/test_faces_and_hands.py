"""From frames to faces and hands: synthetic, simulated and real ones, and bad light."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from detect_scenes import SHIRT_RGB, SKIN_RGB, Disc, frame_of
from topview.camera.pyramid import Pyramid
from topview.detect.beliefs import BeliefTables, Kind
from topview.detect.cloud import Cloud
from topview.detect.color_view import ColorView, Light
from topview.detect.faces import CascadeFaces
from topview.detect.faces_and_hands import FacesAndHands, SkinDetections
from topview.detect.skin import BackgroundName, SkinSettings
from topview.io import open_recording
from topview.records import Camera, Frame

PERSON: list[Disc] = [
    (80, 70, 26, 2.0, SHIRT_RGB),
    (80, 30, 12, 2.0, SKIN_RGB),
    (45, 80, 7, 2.0, SKIN_RGB),
    (115, 80, 7, 2.0, SKIN_RGB),
]
UP = np.array([0.0, -1.0, 0.0])


def recolored(frame: Frame, color: np.ndarray) -> Frame:
    return Frame(frame.index, frame.timestamp_s, frame.depth_m, frame.camera, color)


def simple_tables() -> BeliefTables:
    """What faces and hands are like whose sizes and places are those of `PERSON`."""
    seen = {
        Kind.FACE: {"major_m": 0.09, "right_of_head_m": 0.0},
        Kind.LEFT_HAND: {"major_m": 0.05, "right_of_head_m": 0.27},
        Kind.RIGHT_HAND: {"major_m": 0.05, "right_of_head_m": -0.27},
        Kind.OTHER: {"major_m": 0.2, "right_of_head_m": 0.0},
    }
    return BeliefTables.learn(list(seen.values()) * 50, list(seen) * 50, "a simple person")


def test_face_and_hands_of_a_simple_person() -> None:
    finder = FacesAndHands(tables=simple_tables())
    head = np.array([(80 - 79.5) / 262.5 * 2.0, (30 - 59.5) / 262.5 * 2.0, 2.06])
    detections = SkinDetections(Light.ABSENT)
    for index in range(10):
        detections = finder.update(Pyramid(frame_of(PERSON, index=index)), [head])
    assert detections.light == Light.USABLE
    assert detections.stride == 1
    assert len(detections.blobs) == 3
    by_kind = {blob.kind: blob for blob in detections.blobs}
    assert set(by_kind) == {Kind.FACE, Kind.LEFT_HAND, Kind.RIGHT_HAND}
    assert by_kind[Kind.LEFT_HAND].ellipse.x == pytest.approx(115, abs=1)
    face = by_kind[Kind.FACE].head_camera
    assert face is not None
    assert np.linalg.norm(face - head) < 0.03
    for blob in detections.blobs:
        assert blob.belief.sum() == pytest.approx(1.0)
        assert blob.is_seen
    assert detections.most_likely(Kind.FACE) == [by_kind[Kind.FACE]]


def test_full_images_are_seen_at_half_size() -> None:
    camera = Camera(525.0, 525.0, 159.5, 119.5, 320, 240)
    discs: list[Disc] = [(2 * x + 0.5, 2 * y + 0.5, 2 * r, z, c) for x, y, r, z, c in PERSON]
    detections = FacesAndHands().update(Pyramid(frame_of(discs, camera=camera)))
    assert detections.stride == 2
    centers = sorted(blob.ellipse.center.tolist() for blob in detections.blobs)
    assert np.allclose(centers, [[90.5, 160.5], [160.5, 60.5], [230.5, 160.5]], atol=1.0)
    surfaces = [blob.surface_camera for blob in detections.blobs if blob.surface_camera is not None]
    assert np.allclose([surface[2] for surface in surfaces], 2.0, atol=0.02)


def test_only_candidates_are_searched() -> None:
    is_candidate = np.zeros((120, 160), np.bool_)
    is_candidate[:, :60] = True
    detections = FacesAndHands().update(Pyramid(frame_of(PERSON)), is_candidate=is_candidate)
    assert [round(blob.ellipse.x) for blob in detections.blobs] == [45]


@pytest.mark.parametrize(("background", "found"), [("mixtures", [45]), ("colors", [45, 105])])
def test_the_mixtures_learn_a_room_of_skins_colour(
    background: BackgroundName, found: list[int]
) -> None:
    """A wall lamp of skin's colour hangs there; then somebody steps before it, and beside it, where
    by the depth nobody can be."""
    finder = FacesAndHands(SkinSettings(background=background), tables=simple_tables())
    nobody, is_candidate = np.zeros((120, 160), np.bool_), np.zeros((120, 160), np.bool_)
    is_candidate[:, :60] = True
    lamp: Disc = (45.0, 90.0, 9.0, 2.95, SKIN_RGB)
    for index in range(40):
        finder.update(Pyramid(frame_of([lamp], index=index)), is_candidate=is_candidate)
        finder.update_background(nobody)
    discs = [lamp, (45.0, 45.0, 9.0, 2.0, SKIN_RGB), (105.0, 45.0, 9.0, 2.0, SKIN_RGB)]
    detections = finder.update(Pyramid(frame_of(discs, index=40)), is_candidate=is_candidate)
    seen = [blob for blob in detections.blobs if blob.is_seen]
    assert sorted(round(blob.ellipse.x) for blob in seen) == found
    assert all(blob.ellipse.y < 60 for blob in seen)


def test_candidates_may_be_of_the_small_size_and_then_the_room_is_not_needed() -> None:
    camera = Camera(525.0, 525.0, 159.5, 119.5, 320, 240)
    discs: list[Disc] = [(2 * x + 0.5, 2 * y + 0.5, 2 * r, z, c) for x, y, r, z, c in PERSON]
    small = np.zeros((120, 160), np.bool_)
    small[:, :60] = True
    large = np.repeat(np.repeat(small, 2, axis=0), 2, axis=1)
    for mask in (small, large):
        finder, updates = FacesAndHands(), 0
        for index in range(12):
            detections = finder.update(
                Pyramid(frame_of(discs, index=index, camera=camera)), (), mask
            )
            updates += finder.background_is_due
            finder.update_background(mask)
            assert [round(blob.ellipse.x) for blob in detections.blobs] == [90]
        assert updates == 6


@pytest.mark.parametrize(
    ("gain", "offset", "saturation", "light"),
    [
        (1.0, 0.0, 1.0, Light.USABLE),
        (1.0, 0.0, 0.0, Light.GREY),
        (0.15, 0.0, 1.0, Light.UNDEREXPOSED),
        (4.0, 100.0, 1.0, Light.OVEREXPOSED),
    ],
)
def test_bad_light_is_told(gain: float, offset: float, saturation: float, light: Light) -> None:
    frame = frame_of(PERSON)
    assert frame.color is not None
    grey = frame.color.mean(axis=-1, keepdims=True)
    color = offset + gain * (grey + saturation * (frame.color - grey))
    frame = recolored(frame, np.clip(color, 0, 255).astype(np.uint8))
    detections = FacesAndHands().update(Pyramid(frame))
    assert detections.light == light
    assert bool(detections.blobs) == (light == Light.USABLE)


def test_frames_without_colour_are_no_harm() -> None:
    finder = FacesAndHands()
    finder.update(Pyramid(frame_of(PERSON)))
    blind = Frame(1, 0.03, frame_of().depth_m, frame_of().camera)
    assert finder.update(Pyramid(blind)).light == Light.ABSENT
    finder.update_background(np.zeros((120, 160), np.bool_))
    assert ColorView.from_frame(blind) is None
    assert len(finder.update(Pyramid(frame_of(PERSON, index=2))).blobs) == 3


def test_the_same_frames_give_the_same_answers() -> None:
    def run() -> list:
        finder = FacesAndHands()
        return [
            [
                (blob.id, blob.belief.tolist())
                for blob in finder.update(Pyramid(frame_of(PERSON, index=i))).blobs
            ]
            for i in range(4)
        ]

    assert run() == run()


def test_the_cascade_finds_the_turning_mans_face_while_it_is_in_view(shared: Path) -> None:
    faces = CascadeFaces()
    frames = list(open_recording(shared / "recordings" / "turning_man"))
    front, back = frames[0], frames[-1]
    (head,) = faces.detect(Cloud.from_frame(front), UP)
    assert 0.5 < head.center_camera[2] < 2.5
    (face,) = faces.faces_at(front, [head.center_camera])
    assert face is not None
    assert face.head_camera is not None
    assert np.linalg.norm(face.head_camera - head.center_camera) < 0.06
    assert not faces.detect(Cloud.from_frame(back), UP)


def test_a_known_head_is_looked_at_alone(shared: Path) -> None:
    faces = CascadeFaces()
    frames = list(open_recording(shared / "recordings" / "turning_man"))
    (head,) = faces.detect(Cloud.from_frame(frames[0]), UP)
    center = head.center_camera
    assert faces.is_frontal(frames[0], center) is True
    assert faces.is_frontal(frames[-1], center) is False
    beside = center + np.array([0.3, 0.0, 0.0])
    assert faces.check_faces_in_turn(frames[0], []) == []
    heads = [center, beside]
    for time_s, told in (
        (0.1, [(0, True), (1, False)]),  # each at most once a frame
        (0.11, []),
        (0.14, [(0, True)]),
        (0.18, [(1, False)]),
    ):
        assert faces.check_faces_in_turn(replace(frames[0], timestamp_s=time_s), heads) == told


def test_heads_that_cannot_be_judged_are_told(shared: Path) -> None:
    faces = CascadeFaces()
    frame = next(iter(open_recording(shared / "recordings" / "turning_man")))
    head = faces.detect(Cloud.from_frame(frame), UP)[0].center_camera
    assert frame.color is not None
    assert faces.is_frontal(recolored(frame, frame.color // 8), head) is None
    assert faces.is_frontal(frame, head + np.array([5.0, 0.0, 0.0])) is None
    assert faces.is_frontal(frame, np.array([0.0, 0.0, 9.0])) is None
    blind = Frame(0, 0.0, frame.depth_m, frame.camera)
    assert faces.is_frontal(blind, head) is None


def test_the_turning_mans_face_is_skin(shared: Path) -> None:
    folder = shared / "recordings" / "turning_man"
    frame = next(iter(open_recording(folder)))
    mask = cv2.imread(str(folder / "mask" / "000000.png"), cv2.IMREAD_GRAYSCALE)
    head = CascadeFaces().detect(Cloud.from_frame(frame), UP)[0].center_camera
    detections = FacesAndHands().update(Pyramid(frame), [head], np.asarray(mask) > 0)
    (face, *_) = detections.most_likely(Kind.FACE)
    assert face.head_camera is not None
    assert np.linalg.norm(face.head_camera - head) < 0.08


def test_no_colour_no_faces() -> None:
    blind = Frame(0, 0.0, frame_of().depth_m, frame_of().camera)
    assert CascadeFaces().faces(blind) == []
    assert CascadeFaces().faces_at(blind, [np.array([0.0, 0.0, 2.0])]) == [None]
