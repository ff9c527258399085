"""A curtain or a wall that hangs together with somebody: only what stands right under the head is
the body, where the network knows no person in the whole."""

from __future__ import annotations

import numpy as np
import pytest
from msgspec.structs import replace
from numpy.typing import NDArray

from dressed_scenes import GROUND_Y, ROOM, scene_of, track_at
from people_scenes import box, head_of, render, standing_person
from topview.people.bodies import SHOWN_M2, UNDER_HEAD_M, area_m2, body_of
from topview.people.likelihood import EVIDENCE_MEMORY_S
from topview.people.segmentation import SegmentationSettings
from topview.people.settings import PeopleSettings
from topview.people.step import Step
from topview.people.told import Told
from topview.people.told_head import ToldHead
from topview.people.track import Track
from topview.room.scene import Scene

Z = 2.5
PLACE = head_of(0.0, Z, GROUND_Y)
CURTAIN = box((0.15, GROUND_Y - 1.9, Z), (0.6, GROUND_Y, Z + 0.1))
ALONE_M2, WITH_CURTAIN_M2 = 0.8, 1.2
KNOWN, UNKNOWN = 0.97, 0.02


def scene_at(time_s: float, *things: NDArray[np.float32]) -> Scene:
    depth_m = render(standing_person(0.0, Z, GROUND_Y), [*ROOM, *things])
    return scene_of(depth_m, None, round(30 * time_s))


def answered(track: Track, scene: Scene, p_person: float) -> Track:
    """The track, its body grown anew, after the network has said this of what was its body."""
    grown = replace(track, body_m=body_of(scene, track, SegmentationSettings(), None))
    sigma_m = 0.02 if p_person > 0.5 else np.inf
    told = Told((), {track.told_as: ToldHead(p_person, PLACE, sigma_m)}, True)
    [after] = Step(scene, scene, told, PeopleSettings()).with_evidence([grown], {track.key})
    return after


def with_curtain(id: int) -> Track:
    return replace(track_at(scene_at(0.0, CURTAIN), PLACE), id=id)


@pytest.mark.parametrize("id", [0, 1])
def test_who_is_not_known_with_the_curtain_is_asked_about_without_it(id: int) -> None:
    track, scene = with_curtain(id), scene_at(0.1, CURTAIN)
    assert area_m2(scene, track) > WITH_CURTAIN_M2
    narrow = answered(track, scene, UNKNOWN)
    assert narrow.is_narrow
    assert narrow.evidence.asked_s == 0.0  # what was said was said of the curtain, too
    assert narrow.body_m is not None
    assert not (np.isfinite(narrow.body_m) & ~scene.is_under(PLACE, UNDER_HEAD_M)).any()
    assert SHOWN_M2 < area_m2(scene, narrow) < ALONE_M2
    known = answered(narrow, scene_at(0.2, CURTAIN), KNOWN)
    assert known.is_narrow
    assert area_m2(scene, known) < ALONE_M2
    assert known.evidence.network > 0.0


def test_what_is_no_person_either_way_is_refused_and_not_tried_again_at_once() -> None:
    track = answered(with_curtain(0), scene_at(0.1, CURTAIN), UNKNOWN)
    for time_s in (0.2, 0.3, 1.0):
        track = answered(track, scene_at(time_s, CURTAIN), UNKNOWN)
        assert not track.is_narrow
        assert track.evidence.network < 0.0
    assert area_m2(scene_at(1.0, CURTAIN), track) > WITH_CURTAIN_M2
    later = answered(track, scene_at(0.2 + EVIDENCE_MEMORY_S, CURTAIN), UNKNOWN)
    assert later.is_narrow


def test_after_a_while_the_whole_body_is_looked_at_again() -> None:
    track = answered(with_curtain(1), scene_at(0.1, CURTAIN), UNKNOWN)
    end_s = 0.1 + EVIDENCE_MEMORY_S
    assert answered(track, scene_at(end_s - 0.1, CURTAIN), KNOWN).is_narrow
    assert not answered(track, scene_at(end_s + 0.1, CURTAIN), KNOWN).is_narrow


def test_who_is_known_with_the_curtain_keeps_all_of_it() -> None:
    after = answered(with_curtain(1), scene_at(0.1, CURTAIN), KNOWN)
    assert not after.is_narrow
    assert area_m2(scene_at(0.1, CURTAIN), after) > WITH_CURTAIN_M2
