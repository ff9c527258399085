"""Strips of frames: the people and frames that they show."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import cv2
import numpy as np
import pytest

from skeleton_sequences import STATURE_M, predicted_of, reference_of
from topview.body import OUTPUT_JOINT_NAMES
from topview.body.ends import output_joints
from topview.body.model import BodyModel
from topview.body.proportions import THESIS
from topview.records import Camera, Frame
from topview.room.floor import CAMERA_UP
from topview.track.stances import STANDING, stand
from topview_lab.evaluate.run import Outcome
from topview_lab.metrics import SequenceErrors, measure_sequence
from topview_lab.reproduce.runs import DEFAULT_VARIANT, Measured, Run
from topview_lab.reproduce.strips import Shown, draw_strip, people_of, tiles_of

FRAMES = 40
CAMERA = Camera(fx=30, fy=30, cx=15.5, cy=11.5, width=32, height=24)
MODEL = BodyModel.of(STATURE_M, THESIS)
POSES = [stand(MODEL, np.array([x_m, -0.6, 2.5]), STANDING, 0.3, CAMERA_UP) for x_m in (-0.6, 0.6)]


@dataclass(eq=False)
class Recorded:
    """Empty frames; it keeps which of them were read."""

    name: str = "recorded"
    read: list[int] = field(default_factory=list)

    def open(self) -> Iterator[Frame]:
        for index in range(FRAMES):
            self.read.append(index)
            yield Frame(index, index / 10.0, np.ones((24, 32), np.float32), CAMERA, None)


@pytest.fixture(scope="module")
def errors() -> SequenceErrors:
    """Two people, tracked without an error; the second is not there at first."""
    joints = np.stack([output_joints(MODEL, pose.transforms(MODEL)) for pose in POSES])
    joints = np.tile(joints, (FRAMES, 1, 1, 1))
    joints[:10, 1] = np.nan
    Rs = np.tile([pose.Rs for pose in POSES], (FRAMES, 1, 1, 1, 1))
    names = OUTPUT_JOINT_NAMES
    states = np.ones(joints.shape[:3], np.uint8)
    predicted = predicted_of(
        joints,
        Rs,
        joint_names=names,
        joint_state=states,
        joint_confidence=states.astype(np.float32),
    )
    return measure_sequence(predicted, reference_of(joints, joint_names=names), "recorded")


def test_bodies_are_drawn_where_they_were_tracked(errors):
    for person, pose in zip(people_of(errors.samples, 20), POSES, strict=True):
        Ts = pose.transforms(MODEL)
        np.testing.assert_allclose(person.Ts_camera_part, Ts, atol=1e-9)
        np.testing.assert_allclose(person.joints_camera, output_joints(MODEL, Ts), atol=1e-9)
        assert (person.joint_state == 1).all()
    assert [person.id for person in people_of(errors.samples, 5)] == [1]


def test_frames_are_even_over_the_recording_and_no_more_are_read_than_that(errors):
    recorded = Recorded()
    run = Run(DEFAULT_VARIANT, recorded)  # pyright: ignore[reportArgumentType]
    measured = Measured({run: Outcome(errors, ())})
    shown = Shown(tiles=4, subject_alone=True, note=lambda samples, frame: f"number {frame}")
    tiles = tiles_of(run, measured, shown)
    assert [tile.caption for tile in tiles] == [
        (f"{frame / 10:.1f} s", f"number {frame}") for frame in (5, 15, 25, 35)
    ]
    assert [len(tile.moment.people) for tile in tiles] == [1, 1, 1, 1]
    assert [len(tile.moment.people) for tile in tiles_of(run, measured, Shown(tiles=4))] == [
        1, 2, 2, 2
    ]  # fmt: skip
    assert max(recorded.read) == 35


def test_a_strip_has_a_place_for_every_tile(errors, tmp_path):
    run = Run(DEFAULT_VARIANT, Recorded())  # pyright: ignore[reportArgumentType]
    tiles = tiles_of(run, Measured({run: Outcome(errors, ())}), Shown(tiles=5))
    sizes = []
    for count in (1, 4, 5):
        draw_strip(tmp_path / "strip.png", tiles[:count])
        picture = cv2.imread(str(tmp_path / "strip.png"))
        assert picture is not None
        sizes.append(picture.shape[:2])
    one, four, five = sizes
    assert one[0] == four[0] < five[0]
    assert one[1] < four[1] == five[1]
