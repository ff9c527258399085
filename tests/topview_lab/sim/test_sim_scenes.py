"""The scenes that have a name: they render, hide what they promise, take given bodies."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from topview.records import Camera, InputError
from topview_lab.sim import SimulatedRecording, scene_by_name, simulate_truth
from topview_lab.sim.appearance import random_appearance
from topview_lab.sim.scene import Box
from topview_lab.sim.scenes import SCENES


@pytest.mark.parametrize("name", sorted(SCENES))
def test_every_scene_renders_its_people(name: str, tiny_camera: Camera) -> None:
    scene = scene_by_name(name, seed=7, camera=tiny_camera)
    frame = SimulatedRecording(scene).simulate(min(scene.frames - 1, 40))
    seen = set(np.unique(frame.mask).tolist()) - {0}
    assert 1 in seen
    assert frame.depth_mm.any()
    assert seen <= set(range(1, len(scene.actors) + 1))


@pytest.mark.parametrize("name", sorted(SCENES))
def test_every_scene_says_what_happens_in_one_line(name: str) -> None:
    kind = SCENES[name]
    assert kind.about
    assert "\n" not in kind.about
    assert kind.frames >= 100


@pytest.mark.parametrize("seed", [0, 5])
def test_the_dummy_hides_a_third_and_then_two_thirds_of_the_trunk(
    seed: int,
) -> None:
    camera = Camera(131.25, 131.25, 79.5, 59.5, 160, 120)
    scene = replace(scene_by_name("dummy_occluder", seed=seed, camera=camera), fps=1.0, frames=25)
    truth = simulate_truth(scene)
    parts = truth.part_names.tolist()
    trunk = [parts.index("upper_torso"), parts.index("lower_torso")]
    hidden = truth.part_occ_person[:, 0, trunk].mean(-1)
    assert hidden[:4].max() == 0.0
    assert 0.2 < np.median(hidden[7:11]) < 0.4
    assert 0.5 < np.median(hidden[14:19]) < 0.7
    assert hidden[22:].max() == 0.0


def test_given_bodies_take_the_first_places() -> None:
    appearances = [random_appearance(np.random.default_rng(seed)) for seed in (1, 2)]
    scene = scene_by_name("boxing", seed=3, appearances=appearances[:1])
    assert scene.actors[0].body.appearance == appearances[0]
    both = scene_by_name("handshake", seed=3, appearances=appearances)
    assert [actor.body.appearance for actor in both.actors] == appearances
    with pytest.raises(InputError, match="scene boxing: appearances are 2; people are only 1"):
        scene_by_name("boxing", appearances=appearances)


def test_rooms_and_cameras_differ_with_the_seed_and_old_scenes_keep_theirs() -> None:
    mounts = {scene_by_name("boxing", seed=seed).mount for seed in range(4)}
    assert len(mounts) == 4
    assert all(0.9 <= mount.height_m <= 1.6 for mount in mounts)
    assert scene_by_name("wave", seed=1).mount == scene_by_name("wave", seed=2).mount


def test_people_do_not_stand_in_furniture() -> None:
    for name in SCENES:
        scene = scene_by_name(name, seed=1)
        for actor in scene.actors:
            x, y = actor.performance.path.state_at(0.3 * scene.frames / scene.fps).position_room
            for piece in scene.furniture:
                place = piece.center_room if isinstance(piece, Box) else piece.base_room
                assert np.hypot(place[0] - x, place[1] - y) > 0.15, (name, piece)
