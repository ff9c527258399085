"""The picture of where bodies are worst."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from skeleton_sequences import predicted_of, reference_of, standing, write_rendered
from topview.body import JOINT_NAMES
from topview.records import Camera, Frame, InputError
from topview_lab.cli.evaluate import evaluate
from topview_lab.datasets import FolderRecording
from topview_lab.evaluate.worst import (
    APART_COLOR,
    MOMENT_PX,
    MOMENTS_APART_S,
    WORST_GAP_PX,
    WORST_MOMENTS,
    WORST_RECORDINGS,
    Moment,
    WorstRecording,
    moment_picture,
    worst_png,
    worst_recordings,
)
from topview_lab.metrics import Evaluation, evaluate_sequence
from topview_lab.metrics.statistics import statistic

FRAMES = 120
HAND = JOINT_NAMES.index("left_hand")
CAMERA = Camera(285.0, 285.0, 159.5, 119.5, 320, 240)


def evaluation_of(**hand_off_m: dict[int, float]) -> Evaluation:
    """Of recordings of one person whose left hand is off in some frames."""
    truth = np.tile(standing()[None], (FRAMES, 1, 1, 1))
    evaluations = []
    for name, off_m in hand_off_m.items():
        predicted = truth.copy()
        for frame, by_m in off_m.items():
            predicted[frame, 0, HAND, 0] += by_m
        evaluations.append(evaluate_sequence(predicted_of(predicted), reference_of(truth), name))
    return Evaluation.pooled(evaluations)


def test_the_worst_recording_is_the_first_and_its_moments_are_apart() -> None:
    evaluation = evaluation_of(good={10: 0.15}, bad={50: 0.8, 52: 0.7, 90: 0.3, 10: 0.2})
    worst, better = worst_recordings(evaluation)
    assert (worst.name, better.name) == ("bad", "good")
    assert worst.joints.mean > better.joints.mean
    assert worst.joints.within_10 < better.joints.within_10 < 1.0
    assert [moment.frame for moment in worst.moments] == [10, 50, 90]
    assert len(better.moments) <= WORST_MOMENTS
    times_s = np.array([moment.frame for moment in worst.moments]) / 30.0
    assert (np.diff(times_s) >= MOMENTS_APART_S).all()


def test_a_moment_says_which_joints_are_off() -> None:
    [recording] = worst_recordings(evaluation_of(one={60: 0.8}), moments=1)
    [moment] = recording.moments
    assert moment.caption.startswith("frame 60: 5 cm; left hand 79")
    np.testing.assert_allclose(moment.predicted_camera[HAND, 0] - 0.8, standing()[HAND, 0])


def test_no_more_recordings_than_there_is_room_for_and_nobody_is_no_row() -> None:
    many = evaluation_of(**{f"r{k}": {k: 0.1 * k} for k in range(WORST_RECORDINGS + 3)})
    assert len(worst_recordings(many)) == WORST_RECORDINGS
    truth = np.tile(standing()[None], (FRAMES, 1, 1, 1))
    nobody = evaluate_sequence(predicted_of(np.full_like(truth, np.nan)), reference_of(truth))
    assert worst_recordings(nobody) == []


def flat_frame() -> Frame:
    return Frame(0, 0.0, np.full((240, 320), 3.0, np.float32), CAMERA)


def moment_of(predicted_camera: NDArray[np.float64], errors_cm: float) -> Moment:
    return Moment(0, standing(), predicted_camera, np.full(len(JOINT_NAMES), errors_cm))


@pytest.mark.parametrize(("errors_cm", "is_drawn"), [(2.0, False), (40.0, True)])
def test_what_is_far_apart_is_joined_by_lines(errors_cm: float, is_drawn: bool) -> None:
    picture = moment_picture(flat_frame(), moment_of(standing(0.4), errors_cm))
    assert picture.shape == (MOMENT_PX[1], MOMENT_PX[0], 3)
    assert (np.abs(picture.astype(int) - APART_COLOR).sum(-1) < 60).any() == is_drawn


@pytest.mark.parametrize("x_m", [0.0, -1.4, 40.0])
def test_who_stands_at_the_border_or_beyond_is_drawn_as_well(x_m: float) -> None:
    moment = moment_of(standing(x_m), 1.0)
    moment = Moment(0, standing(x_m), moment.predicted_camera, moment.errors_cm)
    missing = standing(x_m)
    missing[HAND] = np.nan
    for each in (moment, moment_of(missing, np.nan)):
        assert moment_picture(flat_frame(), each).std() > 3.0


def test_the_command_writes_the_picture(tmp_path: Path) -> None:
    """With the skeletons of a file, which are half a metre beside the person."""
    depths_m = [2.0, 2.5, 3.0]
    folder = write_rendered(tmp_path / "a", depths_m)
    joints = np.stack([standing(0.3, z)[None] for z in depths_m])
    np.savez(
        tmp_path / "a.npz",
        frame_index=np.arange(3),
        timestamps_s=np.arange(3) / 30.0,
        person_ids=np.ones((3, 1), np.int64),
        joint_names=np.array(JOINT_NAMES),
        joints_camera=joints,
    )
    picture = tmp_path / "pictures" / "worst.png"
    command = ["folder", str(folder), "--predictions", str(tmp_path / "a.npz")]
    assert evaluate([*command, "--worst", str(picture)], result_action="return_value") == 0
    image = cv2.imread(str(picture))
    assert image is not None
    assert image.shape[1] == WORST_GAP_PX + WORST_MOMENTS * (MOMENT_PX[0] + WORST_GAP_PX)
    assert image.std() > 3.0
    with pytest.raises(InputError, match="--force replaces it"):
        evaluate([*command, "--worst", str(picture)], result_action="return_value")


def test_frames_that_are_gone_are_told(tmp_path: Path) -> None:
    recording = FolderRecording(write_rendered(tmp_path / "a", [2.0]))
    gone = Moment(7, standing(), standing(), np.zeros(len(JOINT_NAMES)))
    with pytest.raises(InputError, match="a: frames that were measured can no longer be read"):
        worst_png([WorstRecording("a", statistic(np.zeros(1)), (gone,))], [recording])
