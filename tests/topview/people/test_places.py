"""Where a head may be that is not seen."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace
from numpy.typing import NDArray

from dressed_scenes import FLOOR, GROUND_Y, ROOM, scene_of
from people_scenes import box, head_of, render
from topview.people.motion import Motion
from topview.people.places import ALIKE_S, SAMPLES, Places, repeated_m
from topview.room.background import Background
from topview.room.scene import Scene

FPS = 30
HEAD = head_of(0.0, 3.2, GROUND_Y)
FREE = render([], ROOM)
COVERED = render([], [*ROOM, box((-1.4, GROUND_Y - 2.2, 1.8), (1.4, GROUND_Y, 2.0))])
NO_READING = render([], [FLOOR])


def watched(
    depth_m: NDArray[np.float32],
    seconds: float,
    key: int = 1,
    others_camera: Sequence[NDArray[np.float64]] = (),
) -> tuple[Places, Scene]:
    """Of a head that stood still, after so long in the same picture, beside heads of others."""
    scene = scene_of(depth_m, None, 0)
    places = Places.around(scene, Motion.starting_at(HEAD), key)
    for index in range(1, round(FPS * seconds) + 1):
        scene = scene_of(depth_m, None, index)
        places = places.seen(scene, 1 / FPS, key, others_camera)
        assert places.weights.sum() == pytest.approx(1.0)
        assert (places.weights >= 0.0).all()
    return places, scene


def test_who_would_be_seen_and_is_not_has_gone() -> None:
    assert watched(FREE, 0.1)[0].presence > 0.1
    assert watched(FREE, 1.0)[0].presence < 0.01


def test_who_stands_behind_cover_is_still_there() -> None:
    places, scene = watched(COVERED, 2.0)
    assert places.presence > 0.9
    place_camera, certainty = places.best(scene)
    assert scene.is_hidden_at(place_camera)
    assert scene.height_of(place_camera) == pytest.approx(scene.height_of(HEAD))
    assert 0.0 < certainty <= 1.0


def test_where_another_s_head_is_nobody_is_hidden() -> None:
    places, scene = watched(COVERED, 0.5, 1, [HEAD])
    is_there = np.linalg.norm(places.overview_m - scene.overview_of(HEAD), axis=1) < 0.1
    assert places.presence < 0.8
    assert places.weights[is_there].sum() < 0.05
    far = HEAD + np.array([1.5, 0.0, 0.0])
    assert watched(COVERED, 0.5, 1, [far])[0].presence > 0.9


def test_who_is_held_by_somebody_taller_is_still_there() -> None:
    over = HEAD - np.array([0.0, 0.3, 0.0])
    places, scene = watched(COVERED, 1.0, 1, [over])
    assert places.presence > 0.9
    assert scene.overview_of(places.best(scene)[0]) == pytest.approx(
        scene.overview_of(HEAD), abs=0.2
    )


def test_beside_cover_a_part_of_the_head_is_hidden() -> None:
    """There it is missed, and there is the shadow that depth cameras see beside what is near."""
    edge_m = float(HEAD[0]) * 2.0 / float(HEAD[2]) - 0.03
    beside = render([], [*ROOM, box((-1.4, GROUND_Y - 2.2, 1.8), (edge_m, GROUND_Y, 2.0))])
    presence = watched(beside, 0.5)[0].presence
    assert watched(FREE, 0.5)[0].presence < 0.3 < presence


def test_nobody_is_behind_the_room_s_end() -> None:
    behind = HEAD * 2.0
    scene = scene_of(FREE, None, 1)
    steady = Background(np.inf)
    for index in range(2 * FPS):
        steady.update(
            scene.cloud.depth_m, np.zeros(scene.cloud.depth_m.shape, np.bool_), index / FPS,
            scene.cloud.camera.noise,
        )  # fmt: skip
    ends = replace(scene, steady=steady)
    assert ends.room_ends_m == pytest.approx(4.9, abs=0.2)
    hidden, gone = (
        Places.around(each, Motion.starting_at(behind), 1).seen(each, 0.3, 1)
        for each in (scene, ends)
    )
    assert gone.presence < 0.7 < hidden.presence


def test_what_is_not_read_hides_nobody_for_certain() -> None:
    """Without a reading somebody may be there, but less surely than behind cover."""
    presence = watched(NO_READING, 0.5)[0].presence
    assert presence < watched(COVERED, 0.5)[0].presence


def test_the_samples_belong_to_a_track_and_a_moment() -> None:
    first, again, other = (watched(COVERED, 0.2, key)[0] for key in (1, 1, 2))
    np.testing.assert_array_equal(first.overview_m, again.overview_m)
    np.testing.assert_array_equal(first.weights, again.weights)
    assert not np.array_equal(first.overview_m, other.overview_m)
    later, _ = watched(COVERED, 0.3)
    assert not np.array_equal(first.velocity, later.velocity)


def test_the_head_is_over_a_body_where_there_is_no_sample() -> None:
    """Half a metre from the middle of all; the nearest sample is 20 cm off."""
    places, scene = watched(COVERED, 0.5)
    body_m = scene.overview_of(HEAD) + np.array([0.5, 0.0])
    nearest_m = np.linalg.norm(places.overview_m - body_m, axis=1).min()
    for _ in range(60):
        places = places.drawn_to(body_m, 1.4, 0.17, 1 / FPS)
    away_m = np.linalg.norm(places.weights @ places.overview_m - body_m)
    assert away_m < 0.8 * nearest_m


@pytest.mark.parametrize("offset_m", [0.2, 5.0])
def test_a_body_that_is_seen_draws_the_head_over_it(offset_m: float) -> None:
    """Even if that is far away from all of the samples."""
    places, scene = watched(COVERED, 1.0)
    body_m = scene.overview_of(HEAD) + np.array([offset_m, 0.0])
    drawn = places.drawn_to(body_m, 1.4, 0.1, 1 / FPS)
    for _ in range(5):
        drawn = drawn.drawn_to(body_m, 1.4, 0.1, 1 / FPS)
    away_m, before_m = (
        float(np.linalg.norm(each.weights @ each.overview_m - body_m)) for each in (drawn, places)
    )
    assert away_m < 0.5 * before_m
    assert drawn.weights.sum() == pytest.approx(1.0)
    known, told = places.height_sigma_m**-2, 6 / FPS / ALIKE_S * 0.1**-2
    between_m = (known * places.height_m + told * 1.4) / (known + told)
    assert drawn.height_m == pytest.approx(between_m)
    assert drawn.height_sigma_m == pytest.approx((known + told) ** -0.5)
    assert drawn.presence > 0.9


def test_the_height_is_between_what_was_known_and_what_is_told() -> None:
    """As much nearer to either as that is more exact; after a while in which nothing tells of it,
    it is known less well."""
    places, scene = watched(COVERED, 0.5)
    body_m = scene.overview_of(HEAD)
    told_m = places.height_m - 0.4
    as_sure = places.drawn_to(body_m, told_m, places.height_sigma_m, ALIKE_S)
    assert as_sure.height_m == pytest.approx(places.height_m - 0.2)
    assert as_sure.height_sigma_m == pytest.approx(places.height_sigma_m / 2.0**0.5)
    surely = places.drawn_to(body_m, told_m, 0.001, ALIKE_S)
    assert surely.height_m == pytest.approx(told_m, abs=0.01)
    assert watched(COVERED, 1.0)[0].height_sigma_m > places.height_sigma_m


@given(st.integers(1, 20), st.floats(0.001, 1.0))
def test_several_frames_of_one_error_know_no_more_than_one(frames: int, sigma_m: float) -> None:
    elapsed_s = ALIKE_S / frames
    information = frames / repeated_m(sigma_m, elapsed_s) ** 2
    assert information == pytest.approx(1.0 / sigma_m**2)
    assert repeated_m(sigma_m, 10.0) == sigma_m


def test_a_head_comes_back_where_it_may_be() -> None:
    places, scene = watched(COVERED, 0.5)
    place_camera, _ = places.best(scene)
    here, aside, below = (
        places.log_density(scene, place_camera + np.array(offset))
        for offset in ((0.0, 0.0, 0.0), (2.0, 0.0, 0.0), (0.0, 0.5, 0.0))
    )
    assert here > max(aside, below) + 5.0
    assert len(places.weights) == SAMPLES
