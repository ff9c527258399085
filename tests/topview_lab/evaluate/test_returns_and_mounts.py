"""`topview evaluate returns` and `mounts`: from the scene to the table."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from skeleton_sequences import predicted_of
from topview.records import Camera, Recording
from topview.track.run import TrackingResult
from topview.track.settings import TrackerSettings
from topview_lab.cli import evaluate_people as command
from topview_lab.datasets.hiding import SimulatedHiding, make_hidings
from topview_lab.datasets.mounts import MOUNTS, MountedScene, make_mounted
from topview_lab.datasets.simulated import RecordingWithTruth
from topview_lab.evaluate.people import PeopleJob
from topview_lab.evaluate.returns import ReturnJob, returns_by_cover
from topview_lab.sim.room import render_room

SMALL = Camera(fx=65.6, fy=65.6, cx=39.5, cy=29.5, width=80, height=60)


def track_truth(recording: Recording, settings: TrackerSettings) -> TrackingResult:
    """A tracker that knows everything, but for who it is after `settings.seed` frames."""
    assert isinstance(recording, RecordingWithTruth)
    times_s = [frame.timestamp_s for frame in recording]
    reference = recording.reference()
    names = predicted_of(np.zeros((1, 1, 16, 3))).joint_names
    columns = [reference.joint_names.index(name) for name in names]
    joints = reference.joints_camera[:, :, columns]
    skeletons = predicted_of(joints, timestamps_s=np.array(times_s))
    ids = skeletons.person_ids.copy()
    if settings.seed:
        ids[settings.seed :] += 10
    people = np.unique(ids)
    where = {"person_ids": ids, "people_ids": people, "heights_m": np.full(len(people), 1.7)}
    ends = {"first_frame": people * 0, "last_frame": people * 0}
    return TrackingResult(replace(skeletons, **where, **ends), 1.0, False)


def test_who_is_known_all_the_time_keeps_the_identity_and_who_is_renamed_does_not():
    hiding = SimulatedHiding("person", 1.0, 101, SMALL)
    kept, renamed = (
        ReturnJob(hiding, TrackerSettings(seed=seed), track_truth)() for seed in (0, 120)
    )
    assert kept.score is not None
    assert renamed.score is not None
    assert (kept.score.kept, renamed.score.kept) == (True, False)
    assert kept.score.wait_s == 0.0
    rows = returns_by_cover([kept, renamed])
    assert rows["person, 1 s"].kept == rows["all"].kept == 0.5


@pytest.mark.slow
def test_who_was_hidden_behind_somebody_is_the_same_afterwards():
    """Seen to go there and to come out again; a scene that was looked at."""
    outcome = ReturnJob(SimulatedHiding("person", 2.0, 2), TrackerSettings(threads=1))()
    assert outcome.score is not None
    assert outcome.score.kept


def test_every_cover_time_and_seed_is_made():
    made = make_hidings(seeds=(1, 2))
    assert len({hiding.name for hiding in made}) == 2 * 3 * 2
    assert made[0].name == made[0].make().name == "furniture_2s_1"


@pytest.mark.parametrize("mount", MOUNTS)
def test_mounts_see_what_they_say(mount):
    """Whose floor is in view; from 2.6 m down at 45 degrees the horizon is not."""
    scene = MountedScene(mount, "crossing", 101, 1, SMALL).make()
    room = render_room(scene.room, (), scene.camera, scene.mount)
    down = np.linalg.inv(scene.mount.T_camera_room())[:3, :3] @ [0.0, 0.0, 1.0]
    is_floor = (room.normals @ scene.mount.T_camera_room()[:3, 2]) > 0.9
    assert is_floor.any() == (mount != "no-floor")
    assert down[2] == pytest.approx(-np.sin(scene.mount.tilt_rad))


@pytest.mark.parametrize("mount", MOUNTS)
def test_who_is_found_under_a_mount_is_counted(mount):
    outcome = PeopleJob(
        MountedScene(mount, "crossing", 101, 40, SMALL), TrackerSettings(), track_truth
    )()
    assert outcome.problems == ()
    assert outcome.found is not None
    assert (outcome.found.recall, outcome.found.false, outcome.found.exchanges) == (1.0, 0, 0)
    assert outcome.found.due > 40  # most of two people in most of 40 frames


def test_names_begin_with_the_mount():
    made = make_mounted(seeds=(1, 2))
    assert [mounted.name.partition("_")[0] for mounted in made[::2]] == list(MOUNTS)


@pytest.mark.parametrize(
    ("words", "named"),
    [
        (("returns", "--behind", "smoke"), "behind is 'smoke'; it must be one of"),
        (("returns", "--seconds", "90"), "seconds is 90; it must be 1 to 60"),
        (("returns", "--seconds", "x"), "--seconds is 'x'"),
        (("returns", "--seeds", "5-1"), "--seeds has '5-1'; a range must go up"),
        (("mounts", "flying"), "scene 'flying' is not known"),
        (("mounts", "--sequences", "z*"), "no sequence matches 'z*'"),
    ],
)
def test_what_there_is_not_is_one_line(topview, words, named):
    ended = topview("evaluate", *words)
    assert (ended.status, len(ended.complaints)) == (2, 1)
    assert named in ended.complaints[0]


def test_the_commands_tell_and_write_what_was_measured(topview, tmp_path, monkeypatch):
    for job in (ReturnJob, PeopleJob):
        monkeypatch.setattr(command, job.__name__, partial(job, track=track_truth))
    words = ("--workers", "1", "--per-sequence", "--json", tmp_path / "a.json")
    ended = topview("evaluate", "returns", "--behind", "person", "--seconds", 1, *words)
    assert (ended.status, ended.complaints) == (0, [])
    assert "person_1s_1" in ended.out
    told = json.loads((tmp_path / "a.json").read_text())["returns"]
    assert told["person, 1 s"]["kept"] == 1.0
    ended = topview("evaluate", "mounts", "--seeds", 1, "--frames", 2, *words, "--force")
    assert (ended.status, ended.complaints) == (0, [])
    assert list(json.loads((tmp_path / "a.json").read_text())["counts"]) == [*sorted(MOUNTS), "all"]
