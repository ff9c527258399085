from __future__ import annotations

import cv2
import numpy as np
import pytest

from topview.records import InputError, JointState
from topview.view import ContactSheet, Viewers
from topview.view.contact_sheet import (
    CAPTION_PX,
    EVEN_TILES,
    MOST_EVEN_TILES,
    OCCLUSION_TILES,
    Stage,
    paint_tile,
)


def shown(sheet: ContactSheet) -> list[int]:
    return [moment.frame.index for moment in sheet.moments]


def test_frames_are_chosen_evenly_from_first_to_last(make_frame, make_person):
    sheet = ContactSheet("evenly", 71)
    for index in range(71):
        sheet.show(make_frame(index), [make_person()])
    assert shown(sheet) == list(range(0, 71, 10))


def test_frames_in_which_people_hide_each_other_are_added(make_frame, make_person):
    sheet = ContactSheet("hidden", 71)
    for index in range(71):
        state = JointState.OCCLUDED_BY_PERSON if index == 25 else JointState.VISIBLE
        sheet.show(make_frame(index), [make_person(state=state)])
    assert 25 in shown(sheet)
    assert len(shown(sheet)) == EVEN_TILES + 1


@pytest.mark.parametrize("promised", [None, 100, 500])
def test_longer_recordings_get_more_tiles_and_the_sheet_can_be_read(
    make_frame, make_person, promised
):
    sheet = ContactSheet("long", promised)
    for index in range(600):  # more than were promised
        state = JointState(index % len(JointState))
        sheet.show(make_frame(index, 8, 6), [make_person(state=state)])
    even = MOST_EVEN_TILES if promised == 500 else EVEN_TILES * (1 if promised else 2)
    assert even // 2 <= len(sheet.moments) <= even + OCCLUSION_TILES
    assert sheet.paint().shape[0] <= 1600


@pytest.mark.parametrize("frames", [1, 2, 3])
def test_short_recordings_show_every_frame_once(make_frame, make_person, frames):
    sheet = ContactSheet("short", frames)
    for index in range(frames):
        sheet.show(make_frame(index), [make_person()])
    assert shown(sheet) == list(range(frames))


def test_the_png_is_the_painting(make_frame, make_person):
    sheet = ContactSheet("png", 1)
    sheet.show(make_frame(), [make_person()])
    decoded = cv2.imdecode(np.frombuffer(sheet.png(), np.uint8), cv2.IMREAD_COLOR_RGB)
    np.testing.assert_array_equal(decoded, sheet.paint())


def test_a_sheet_can_be_painted_of_frames_without_people_or_readings(make_frame):
    sheet = ContactSheet("empty", 2)
    sheet.show(make_frame(0), [])
    sheet.show(make_frame(1, wall_m=0.0), [])
    assert sheet.paint().any()


def test_a_sheet_of_nothing_is_refused():
    with pytest.raises(InputError, match="nothing: no frame was read"):
        ContactSheet("nothing", 10).paint()


def test_a_tile_has_the_promised_size(make_frame, make_person):
    sheet = ContactSheet("tile", 1)
    person = make_person()
    sheet.show(make_frame(), [person])
    stage = Stage.around(person.joints_camera, np.array([0.0, -1.0, 0.0]), 1.0)
    tile = paint_tile(sheet.moments[0], stage, (200, 150))
    assert tile.shape == (150 + CAPTION_PX, 400, 3)


def test_several_viewers_see_the_same_and_none_is_no_harm(make_frame, make_person):
    sheets = [ContactSheet("any", 1), ContactSheet("any", 1)]
    assert all(sheet.is_blank for sheet in sheets)
    for viewers in (Viewers(), Viewers(sheets)):
        viewers.show(make_frame(), [make_person()])
    assert not any(sheet.is_blank for sheet in sheets)
    assert sheets[0].png() == sheets[1].png()
