"""Whoever is seen from the side, and heads that something comes before."""

from __future__ import annotations

import numpy as np
import pytest

from people_scenes import box, frame, head_of, plane, render, standing_person, with_noise
from topview.camera.pyramid import Pyramid
from topview.detect.cloud import Cloud
from topview.detect.head_template import HeadTemplate, track_head
from topview.detect.heads import upright_confidence
from topview.people.finder import PeopleFinder
from topview.people.settings import PeopleSettings
from topview.room.floor import FloorPlane
from topview.room.scene import Scene, SceneSettings
from topview_lab.sim import SimulatedRecording, scene_by_name
from topview_lab.sim.bodies import SIM_JOINT_NAMES

GROUND_Y = 1.1
UP = np.array([0.0, -1.0, 0.0])
FLOOR = plane(UP, GROUND_Y)
ROOM = [FLOOR, np.full_like(FLOOR, 5.0)]
X, Z = 0.2, 3.2
HEAD = head_of(X, Z, GROUND_Y)


def covered_share(surfaces: list[np.ndarray], head_camera: np.ndarray) -> float:
    depth = render(standing_person(X, Z, GROUND_Y), [*ROOM, *surfaces])
    cloud = Cloud.from_frame(frame(depth))
    nobody = np.zeros(cloud.depth_m.shape, np.bool_)
    scene = Scene.of(cloud, FloorPlane(UP, GROUND_Y), nobody, SceneSettings())
    return scene.covered_share(head_camera)


def test_a_head_is_covered_by_what_is_nearer_and_by_the_border() -> None:
    wall = [box((-1.0, -1.0, 2.0), (1.0, 1.0, 2.2))]
    half = [box((-1.0, -1.0, 2.0), (X * 2.0 / Z, 1.0, 2.05))]
    assert covered_share([], HEAD) == 0.0
    assert covered_share(wall, HEAD) == 1.0
    assert 0.2 < covered_share(half, HEAD) < 0.8
    assert covered_share([], np.array([9.0, 0.0, 3.0])) == 1.0


def test_a_head_does_not_sink_while_something_passes_before_it() -> None:
    finder = PeopleFinder(PeopleSettings(detector="depth"))
    person = standing_person(X, Z, GROUND_Y)
    off_m = np.inf
    for index in range(60):
        x = -1.3 + 0.03 * max(index - 5, 0)
        screen = box((x, -1.4, 2.2), (x + 0.5, GROUND_Y, 2.25))  # too high for a person
        depth = with_noise(render(person, [*ROOM, screen]), index)
        users = finder.update(Pyramid(frame(depth, index)))
        assert [user.id for user in users] == [1]
        assert users[0].head_camera[1] < HEAD[1] + 0.12, index
        off_m = float(np.linalg.norm(users[0].head_camera - HEAD))
    assert off_m < 0.1


@pytest.mark.parametrize("seed", [521, 522, 620, 623])
def test_one_who_walks_in_profile_is_found_by_his_head(seed: int) -> None:
    recording = SimulatedRecording(scene_by_name("walking", seed=seed, frames=30))
    finder = PeopleFinder(PeopleSettings(detector="depth"))
    found = [finder.update(Pyramid(each)) for each in recording]
    head = recording.simulate(29).truth.joints[0, SIM_JOINT_NAMES.index("head")]
    assert [len(users) for users in found[15:]] == [1] * 15  # within half a second
    assert np.linalg.norm(found[-1][0].head_camera - head) < 0.1


def test_a_head_that_hangs_down_is_followed() -> None:
    head = head_of(0.0, 2.5, GROUND_Y)
    hanging = [
        (np.array([x, 2.0 * head[1] - y, z]), radius)
        for (x, y, z), radius in standing_person(0.0, 2.5, GROUND_Y)
    ]
    cloud = Cloud.from_frame(frame(render(hanging, [np.full_like(FLOOR, 4.9)])))
    upright = upright_confidence(cloud, head, UP)
    found = track_head(cloud, HeadTemplate.of(cloud, head), head + 0.02, UP, 1 / 30)
    assert found is not None
    assert np.linalg.norm(found.center_camera - head) < 0.06
    assert found.confidence > upright + 0.2
