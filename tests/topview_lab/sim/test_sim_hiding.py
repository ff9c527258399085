"""Scenes in which somebody is hidden: entirely, for as long as is asked, and well to be seen before
and after."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from topview.records import Camera, InputError
from topview_lab.metrics.returns import HIDDEN_UP_TO
from topview_lab.sim import simulate_truth
from topview_lab.sim.scenes.hiding import HIDERS, WHO_HIDES, hiding_scene

TINY = Camera(fx=131.25, fy=131.25, cx=79.5, cy=59.5, width=160, height=120)
FPS = 5.0


@pytest.mark.parametrize("behind", HIDERS)
@pytest.mark.parametrize(("hidden_s", "seed"), [(2.0, 101), (5.0, 102)])
def test_one_is_hidden_entirely_for_as_long_as_is_asked(behind, hidden_s, seed):
    scene = hiding_scene(behind, hidden_s, seed, TINY)
    truth = simulate_truth(replace(scene, fps=FPS, frames=round(scene.frames / scene.fps * FPS)))
    shares = (1.0 - truth.person_occ_inter) * (1.0 - truth.person_outside)
    to_be_seen = shares[:, WHO_HIDES]
    is_hidden = to_be_seen <= HIDDEN_UP_TO
    assert np.count_nonzero(np.diff(is_hidden)) == 2  # once
    assert is_hidden.sum() / FPS == pytest.approx(hidden_s, abs=0.8)
    assert to_be_seen[[0, 5, -5, -1]].min() > 0.75
    assert 2 <= len(scene.actors) <= 4
    assert shares[:, 1:].min() > 0.5


def test_a_longer_time_shows_the_same_people_in_the_same_room():
    short, long = (hiding_scene("person", hidden_s, 103, TINY) for hidden_s in (2.0, 10.0))
    assert long.frames - short.frames == pytest.approx(8.0 * short.fps, abs=1)
    assert [actor.body.appearance for actor in short.actors] == [
        actor.body.appearance for actor in long.actors
    ]
    assert (short.room, short.furniture) == (long.room, long.furniture)


@pytest.mark.parametrize(
    ("changed", "named"),
    [
        ({"behind": "smoke"}, "behind is 'smoke'; it must be one of furniture, person"),
        ({"hidden_s": 0.0}, "seconds is 0; it must be 1 to 60"),
        ({"seed": -1}, "seed is -1; it must be 0 or more"),
    ],
)
def test_what_cannot_be_staged_is_named(changed, named):
    asked = {"behind": "person", "hidden_s": 2.0, "seed": 1, "camera": TINY}
    with pytest.raises(InputError, match=named):
        hiding_scene(**(asked | changed))
