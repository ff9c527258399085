"""Which points are a track's body."""

from __future__ import annotations

import numpy as np
import pytest
from msgspec.structs import replace

from dressed_scenes import GROUND_Y, ROOM, person_with, scene_of, track_at
from people_scenes import box, head_of, render, standing_person
from topview.body.parts import JOINTS
from topview.people.bodies import OFF_BODY_M, body_of, split
from topview.people.settings import PeopleSettings
from topview.people.told import NOTHING_TOLD, Told

X, Z = -0.4, 2.8
AWAY_M = 2.0 * OFF_BODY_M
PATCH = box((X + AWAY_M, GROUND_Y - 1.6, Z), (X + AWAY_M + 0.3, GROUND_Y - 0.6, Z + 0.1))
SCENE = scene_of(render(standing_person(X, Z, GROUND_Y), [*ROOM, PATCH]), None, 0)
HEAD = head_of(X, Z, GROUND_Y)
FEET = np.array([X, GROUND_Y, Z])


def joints_at(aside_m: float = 0.0) -> np.ndarray:
    """From the head to the feet of one who stands so far aside."""
    shares = np.linspace(0.0, 1.0, len(JOINTS))[:, None]
    return HEAD + shares * (FEET - HEAD) + np.array([aside_m, 0.0, 0.0])


@pytest.mark.parametrize(
    ("told", "keeps"),
    [
        (Told((person_with(joints_at(), 0.9),)), False),
        (Told((person_with(joints_at(aside_m=AWAY_M), 0.9),)), True),
        (NOTHING_TOLD, True),
    ],
    ids=["far from the body", "the head has gone on", "no body is known"],
)
def test_what_is_far_from_the_body_is_no_part_of_it(told: Told, keeps: bool) -> None:
    """As a curtain that somebody has stood before, and left."""
    track = track_at(SCENE, HEAD)
    assert track.body_m is not None
    is_patch = SCENE.is_free_standing & (SCENE.cloud.points_camera[..., 0] > X + AWAY_M - 0.01)
    is_patch &= np.abs(SCENE.cloud.points_camera[..., 2] - Z) < 0.2
    assert is_patch.sum() > 50
    bodies_m = np.where(is_patch, np.float32(1.0), track.body_m)[None]
    split(SCENE, [track], bodies_m, told, PeopleSettings().segmentation)
    assert (bodies_m[0] < np.inf)[is_patch].all() == keeps
    assert (bodies_m[0] < np.inf)[is_patch].any() == keeps
    np.testing.assert_array_equal(bodies_m[0][~is_patch], track.body_m[~is_patch])


@pytest.mark.parametrize(("x", "keeps"), [(0.0, False), (1.5, True)])
def test_who_is_out_of_the_picture_shows_at_its_border_at_most(x: float, keeps: bool) -> None:
    """Somebody else came in as he left, and was taken for what is left of him in the picture."""
    depth_m = render(standing_person(x, Z, GROUND_Y), ROOM)
    before, scene = (scene_of(depth_m, None, index) for index in (0, 1))
    body_m = track_at(before, head_of(x, Z, GROUND_Y)).body_m
    assert body_m is not None
    is_there = np.flatnonzero((body_m < np.inf).any(axis=0))
    assert (is_there.max() == body_m.shape[1] - 1) == keeps
    outside = head_of(2.5, Z, GROUND_Y)
    gone = replace(track_at(before, outside), body_m=body_m).coasted(scene)
    assert gone.places is not None
    assert gone.places.outside > 0.99
    left_m = body_of(scene, gone, PeopleSettings().segmentation, before)
    assert (left_m < np.inf).any() == keeps
