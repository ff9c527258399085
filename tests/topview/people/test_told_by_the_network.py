"""What the joint network says decides, with the shape, who is somebody."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from numpy.typing import NDArray
from standing_bodies import Standing

from dressed_scenes import GROUND_Y, ROOM
from people_scenes import frame, head_of, render, standing_person, with_noise
from topview.body.parts import JOINT_NAMES
from topview.detect.joints import JointProposals, Windows
from topview.track import Tracker, TrackerSettings

HEAD = head_of(0.2, 3.0, GROUND_Y)
SOMEBODY = render(standing_person(0.2, 3.0, GROUND_Y), ROOM)
NOBODY = render([], ROOM)
FRAMES = 24


@dataclass
class Network:
    """Says of every window that it shows a person, or none, whose head is where it is."""

    p_person: float
    asked: int = 0

    def propose(self, windows: Windows) -> JointProposals:
        self.asked += 1
        P, J = len(windows.is_used), len(JOINT_NAMES)
        return JointProposals(
            np.tile(HEAD, (P, 1, J, 1)),
            np.full((P, 1, J, 3), 0.05),
            windows.is_used[:, None].astype(np.float64),
            np.where(windows.is_used, self.p_person, 0.0).astype(np.float64),
            JOINT_NAMES,
        )


def ids_in(depths: list[NDArray[np.float32]], network: Network) -> list[list[int]]:
    tracker = Tracker(TrackerSettings(threads=1), body=Standing(), proposer=network)
    frames = (frame(with_noise(depth, index), index) for index, depth in enumerate(depths))
    return [[person.id for person in tracker.update(each)] for each in frames]


@pytest.mark.parametrize(("p_person", "is_found"), [(0.001, False), (0.999, True)])
def test_who_appears_is_somebody_if_the_network_says_so(p_person: float, is_found: bool) -> None:
    network = Network(p_person)
    ids = ids_in([NOBODY] + [SOMEBODY] * (FRAMES - 1), network)
    assert network.asked > 0
    assert ids[0] == []
    assert (ids[-1] == [1]) == is_found
    assert {number for each in ids for number in each} == ({1} if is_found else set())


@pytest.mark.parametrize(("p_person", "stays"), [(0.001, False), (0.999, True)])
def test_who_is_there_at_first_stays_if_the_network_says_so(p_person: float, stays: bool) -> None:
    """The first frame's people are told of before the network has been asked."""
    ids = ids_in([SOMEBODY] * FRAMES, Network(p_person))
    assert ids[0] == [1]
    assert ids[-1] == ([1] if stays else [])
    assert all(each in ([1], []) for each in ids)
