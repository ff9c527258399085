"""Who is so near that the head is above the picture."""

from __future__ import annotations

import numpy as np

from dressed_scenes import GROUND_Y, UP
from people_scenes import frame, head_of, plane, render, standing_person, with_noise
from topview.camera.pyramid import Pyramid
from topview.people.finder import PeopleFinder
from topview.people.told import NOTHING_TOLD, Told
from topview.people.told_head import ToldHead
from topview.records import Camera

FAR_M, NEAR_M = 4.2, 1.5
LOOKS_DOWN = Camera(fx=150.0, fy=150.0, cx=160.0, cy=30.0, width=320, height=240)
FLOOR = plane(UP, GROUND_Y, LOOKS_DOWN)
ROOM = [FLOOR, np.full_like(FLOOR, 4.9)]


def test_who_walks_by_keeps_the_body_while_the_network_tells_the_head() -> None:
    """The way over the body to the feet does not grow by the way that is walked."""
    finder, told, empty = PeopleFinder(), NOTHING_TOLD, render([], ROOM, LOOKS_DOWN)
    comes = [(-1.4, z) for z in np.linspace(FAR_M, NEAR_M, 40)]
    walks = [(x, NEAR_M) for x in np.linspace(-1.4, 1.4, 50)]
    are_seen: list[bool] = []
    for index, (x, z) in enumerate([*comes, *walks]):
        depth_m = render(standing_person(x, z, GROUND_Y), ROOM, LOOKS_DOWN)
        image = Pyramid(frame(with_noise(depth_m, index), index, LOOKS_DOWN))
        users = finder.update(image, told)
        told = Told((), {1: ToldHead(0.99, head_of(x, z, GROUND_Y), 0.03)}, True)
        assert [user.id for user in users] == [1]
        are_seen.append(users[0].head_is_seen)
        shown = np.count_nonzero(np.abs(depth_m - empty) > 0.2)
        assert len(users[0].pixels) > 0.9 * shown
    assert are_seen[0]
    assert not are_seen[-1]
