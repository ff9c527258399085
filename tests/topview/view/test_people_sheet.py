from __future__ import annotations

import numpy as np
import pytest

from topview.camera.pyramid import Pyramid
from topview.people.finder import PeopleFinder, PeopleSettings
from topview.records import Camera, Frame, InputError
from topview.view import ContactSheet, PeopleSheet
from topview.view.found_panels import (
    FOUND_CAPTION_PX,
    FOUND_PANEL_PX,
    GAP_PX,
    TITLE_PX,
    paint_found,
)
from topview.view.palette import GROUND, person_color
from topview.view.people_sheet import MOST_ROWS, PANELS
from topview_lab.sim import SimulatedRecording, scene_by_name

MOST_SHEET_PX = 1600


@pytest.fixture(scope="module")
def filmed() -> list[Frame]:
    return list(SimulatedRecording(scene_by_name("two_users", seed=3, frames=4)))


def test_the_first_panel_shows_the_users_in_their_colours(filmed):
    finder = PeopleFinder()
    users = finder.update(Pyramid(filmed[0]))
    assert finder.found is not None
    picture = paint_found(finder.found).astype(int)
    panel = picture[:, : FOUND_PANEL_PX[0]]
    for user in users:
        aside = np.abs(panel - np.array(person_color(user.id))).sum(-1)
        assert (aside < 3).any()  # the label


def test_without_colours_a_row_has_room_for_two_moments(filmed):
    finder = PeopleFinder(PeopleSettings(detector="depth"))
    finder.update(Pyramid(filmed[0]))
    assert finder.found is not None
    assert finder.found.skin_detections is None
    with_colors = PeopleFinder()
    with_colors.update(Pyramid(filmed[0]))
    assert with_colors.found is not None
    width = paint_found(finder.found).shape[1]
    assert 2 * (width - GAP_PX) + GAP_PX == paint_found(with_colors.found).shape[1]
    sheets = []
    for count in (1, 2):
        sheet = PeopleSheet("any", count, lambda: finder.found)
        for _ in range(count):
            sheet.show(filmed[0], [])
        sheets.append(sheet.paint())
    assert sheets[0].shape == sheets[1].shape
    assert (sheets[0][:, width:] == GROUND).all()
    assert (sheets[1][:, : width - GAP_PX] == sheets[0][:, : width - GAP_PX]).all()


def test_moments_are_kept_evenly_and_when_somebody_comes(filmed):
    finder = PeopleFinder()
    sheet = PeopleSheet("any", 100, lambda: finder.found)
    assert sheet.is_blank
    with pytest.raises(InputError, match="any: no frame was read"):
        sheet.png()
    nobody = Frame(0, 0.0, np.full_like(filmed[0].depth_m, 4.0), filmed[0].camera)
    for frame in (nobody, nobody, filmed[1]):
        finder.found = None
        finder.update(Pyramid(frame))
        sheet.show(frame, [])
    assert len(sheet.tiles) == 1
    for frame in filmed[1:]:
        finder.update(Pyramid(frame))
        sheet.show(frame, [])
    assert len(sheet.tiles) == 2
    assert sheet.png().startswith(b"\x89PNG")


@pytest.mark.parametrize(("width", "height"), [(4000, 3), (4, 2000), (1, 16000), (16000, 1)])
def test_pictures_of_very_long_images_are_bounded(width, height):
    camera = Camera(0.9 * width, 0.9 * height, width / 2, height / 2, width, height)
    frame = Frame(0, 0.0, np.full((height, width), 3.0, np.float32), camera)
    finder = PeopleFinder()
    finder.update(Pyramid(frame))
    people_sheet = PeopleSheet("long", 1, lambda: finder.found)
    contact_sheet = ContactSheet("long", 1)
    for sheet in (people_sheet, contact_sheet):
        sheet.show(frame, [])
        rows, columns, _ = sheet.paint().shape
        assert rows <= MOST_SHEET_PX
        assert columns < 2 * MOST_SHEET_PX


def test_however_many_moments_there_are_the_sheet_can_be_read(filmed):
    finder = PeopleFinder()
    finder.update(Pyramid(filmed[0]))
    sheet = PeopleSheet("many", None, lambda: finder.found)
    for _ in range(9):
        sheet.show(filmed[0], [])
    assert len(sheet.tiles) > MOST_ROWS
    assert sheet.paint().shape[0] <= MOST_SHEET_PX


def test_a_picture_is_as_wide_as_a_panel_if_it_is_not_too_high(filmed):
    finder = PeopleFinder()
    finder.update(Pyramid(filmed[0]))
    assert finder.found is not None
    rows, columns, _ = paint_found(finder.found).shape
    assert columns == PANELS * (FOUND_PANEL_PX[0] + GAP_PX) + GAP_PX
    assert rows == FOUND_CAPTION_PX + TITLE_PX + FOUND_PANEL_PX[1] + GAP_PX
