"""The tracker from outside: who is given, and the same answer on every run."""

from __future__ import annotations

import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_array_equal

import topview
from patience import HANGS_S
from topview import JOINT_NAMES, PART_NAMES
from topview.records import Camera, Frame, JointState, Person
from topview.track.run import track_recording
from topview.track.settings import TrackerSettings
from topview.track.tracker import Tracker
from topview_lab.sim import SimulatedRecording, scene_by_name

CAMERA = Camera(fx=262.5, fy=262.5, cx=159.5, cy=119.5, width=320, height=240)

TRACK = """
import sys
from pathlib import Path
import topview
from topview.io import write_skeletons_npz
from topview_lab.sim import SimulatedRecording, scene_by_name
from topview.track.run import track_recording
source, out, threads = sys.argv[1:]
settings = topview.TrackerSettings(threads=int(threads))
write_skeletons_npz(track_recording(topview.open(source), settings).skeletons, Path(out))
"""


def frame_of(depth_m: np.ndarray, index: int = 0, camera: Camera = CAMERA) -> Frame:
    return Frame(index, index / 30.0, depth_m.astype(np.float32), camera)


def first_frames(folder: Path, count: int) -> list[Frame]:
    return [frame for frame, _ in zip(topview.open(folder), range(count), strict=False)]


def as_arrays(people: list[Person]) -> list[np.ndarray]:
    return [array for p in people for array in (p.joints_camera, p.Ts_camera_part, p.joint_state,
                                                p.joint_confidence)]  # fmt: skip


def tracked_elsewhere(source: Path, out: Path, cores: int, threads: int) -> bytes:
    """`skeletons.npz` made by a process that may use so many threads."""
    environment = {**os.environ, "NUMBA_NUM_THREADS": str(cores)}
    command = [sys.executable, "-c", TRACK, str(source), str(out), str(threads)]
    subprocess.run(command, env=environment, check=True, timeout=HANGS_S)
    return out.read_bytes()


@pytest.mark.slow
def test_one_thread_and_two_give_the_same_bytes(wave_folder, tmp_path):
    one = tracked_elsewhere(wave_folder, tmp_path / "one.npz", cores=1, threads=0)
    two = tracked_elsewhere(wave_folder, tmp_path / "two.npz", cores=2, threads=0)
    asked = tracked_elsewhere(wave_folder, tmp_path / "asked.npz", cores=2, threads=1)
    assert one == two == asked
    with np.load(tmp_path / "one.npz") as skeletons:
        assert skeletons["joints_camera"].shape == (15, 1, len(JOINT_NAMES), 3)


@pytest.mark.parametrize("settings", [TrackerSettings(), TrackerSettings("btvr", smoothing_s=0.1)])
def test_turns_and_bones_of_a_file_give_its_joints_in_every_frame(settings, wave_folder, tmp_path):
    """Forward kinematics by nothing but the file; of `btvr`, which has no legs, those there are."""
    tracked = track_recording(topview.open(wave_folder), settings).skeletons
    topview.write_skeletons(tracked, tmp_path / "skeletons.npz")
    with np.load(tmp_path / "skeletons.npz") as file:
        told = {key: file[key] for key in file.files}
    parents, Rs, places = (
        told[key] for key in ("parents", "Rs_parent_joint", "offsets_parent_joint_m")
    )

    def placed(joint: int) -> tuple[np.ndarray, np.ndarray]:
        """[F, S, 3, 3] turn and [F, S, 3] place of a joint in the camera's frame."""
        own = Rs[:, :, joint], places[:, :, joint]
        if parents[joint] < 0:
            return own
        R, place = placed(parents[joint])
        return R @ own[0], place + (R @ own[1][..., None])[..., 0]

    for joint in range(len(JOINT_NAMES)):
        expected = tracked.joints_camera[:, :, joint]
        if np.isfinite(expected).all():
            assert np.abs(placed(joint)[1] - expected).max() < 0.001
        else:
            assert settings.method == "btvr"
            assert JOINT_NAMES[joint].endswith(("hip", "knee", "ankle", "foot"))
    assert np.isfinite(told["bone_lengths_m"]).all() == (settings.method != "btvr")


def test_tracking_again_gives_the_same_and_another_seed_another():
    """Of somebody who walks: who is in plain view is found alike whatever is drawn. Without
    proposed joints: where they lead the search, nothing is drawn."""
    recording = SimulatedRecording(scene_by_name("walk", seed=2, frames=40))
    runs = [
        track_recording(recording, TrackerSettings(seed=seed, proposals="none")).skeletons
        for seed in (0, 0, 1)
    ]
    assert runs[0].Ts_camera_part.tobytes() == runs[1].Ts_camera_part.tobytes()
    assert runs[0].Ts_camera_part.tobytes() != runs[2].Ts_camera_part.tobytes()
    # other random numbers, but not another person
    assert_array_equal(runs[0].present, runs[2].present)
    assert np.nanmean(np.abs(runs[0].joints_camera - runs[2].joints_camera)) < 0.05


def test_a_person_is_given_whole(wave_folder):
    tracker = Tracker()
    for frame in first_frames(wave_folder, 4):
        (person,) = tracker.update(frame)
        assert person.joints_camera.shape == (len(JOINT_NAMES), 3)
        assert person.Ts_camera_part.shape == (len(PART_NAMES), 4, 4)
        assert np.isfinite(person.Ts_camera_part).all()
        assert (person.joint_state != JointState.ABSENT).all()
        assert ((person.joint_confidence >= 0) & (person.joint_confidence <= 1)).all()
        assert 1.2 < person.height_m < 2.1
        Rs = person.Ts_camera_part[:, :3, :3]
        assert np.abs(Rs @ np.swapaxes(Rs, 1, 2) - np.eye(3)).max() < 1e-9


def test_a_frame_is_not_remembered_by_its_arrays(wave_folder):
    """What comes after does not change what was given before."""
    tracker = Tracker()
    frames = first_frames(wave_folder, 4)
    given = tracker.update(frames[0])
    before = [array.copy() for array in as_arrays(given)]
    for frame in frames[1:]:
        tracker.update(frame)
    for array, copy in zip(as_arrays(given), before, strict=True):
        assert_array_equal(array, copy)


@pytest.mark.parametrize("depth", [0.0, 2.0])
def test_in_front_of_nothing_or_a_wall_nobody_is_found(depth):
    tracker = Tracker()
    for index in range(3):
        assert tracker.update(frame_of(np.full((240, 320), depth), index)) == []


def test_a_person_who_vanishes_and_comes_back(wave_folder):
    frames = first_frames(wave_folder, 8)
    nothing = [
        replace(frame, index=6 + k, timestamp_s=(6 + k) / 30, depth_m=np.zeros_like(frame.depth_m))
        for k, frame in enumerate(frames[:6])
    ]
    back = [replace(f, index=12 + k, timestamp_s=(12 + k) / 30) for k, f in enumerate(frames)]
    tracker = Tracker()
    (seen,) = [tracker.update(frame) for frame in frames[:6]][-1]
    surest = seen.joint_confidence
    for frame in nothing:
        for person in tracker.update(frame):  # who may be kept for a while
            assert np.isfinite(person.joints_camera).all()
            assert (person.joint_confidence < surest).all()
            surest = person.joint_confidence
    last = [tracker.update(frame) for frame in back][-1]
    assert len(last) == 1


def test_somebody_hidden_by_a_wall_that_comes_close(wave_folder):
    frames = first_frames(wave_folder, 6)
    tracker = Tracker()
    (seen,) = [tracker.update(frame) for frame in frames[:4]][-1]
    surest = seen.joint_confidence
    wall = np.full_like(frames[0].depth_m, 0.8)
    for k in (4, 5):
        (person,) = tracker.update(frame_of(wall, k, frames[0].camera))
        in_view = person.joint_state != JointState.OUT_OF_VIEW
        assert (person.joint_state[in_view] == JointState.OCCLUDED_BY_OBJECT).all()
        assert (person.joint_confidence < surest).all()
        surest = person.joint_confidence
