from __future__ import annotations

import numpy as np
import pytest

from topview.camera.pyramid import Pyramid
from topview.people.finder import PeopleFinder, PeopleSettings
from topview.records import Camera, Frame, InputError
from topview.view import ContactSheet, PeopleSheet
from topview.view.palette import PANEL, person_color
from topview.view.people_sheet import (
    FOUND_CAPTION_PX,
    FOUND_PANEL_PX,
    GAP_PX,
    MOST_PANEL_HEIGHT_PX,
    TITLE_PX,
    paint_found,
)
from topview_lab.sim import SimulatedRecording, scene_by_name


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


def test_without_colours_the_sheet_says_so(filmed):
    finder = PeopleFinder(PeopleSettings(detector="depth"))
    finder.update(Pyramid(filmed[0]))
    assert finder.found is not None
    assert finder.found.skin_detections is None
    picture = paint_found(finder.found)
    with_colors = PeopleFinder()
    with_colors.update(Pyramid(filmed[0]))
    assert with_colors.found is not None
    assert picture.shape[1] == paint_found(with_colors.found).shape[1]
    below = picture[picture.shape[0] - FOUND_PANEL_PX[1] + TITLE_PX : -20, 20:40]
    assert (below == PANEL).all()


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
        assert rows < 4 * MOST_PANEL_HEIGHT_PX
        assert columns < 4 * FOUND_PANEL_PX[0]


def test_a_picture_is_as_wide_as_a_panel_if_it_is_not_too_high(filmed):
    finder = PeopleFinder()
    finder.update(Pyramid(filmed[0]))
    assert finder.found is not None
    height = FOUND_PANEL_PX[0] * filmed[0].camera.height // filmed[0].camera.width
    rows, columns, _ = paint_found(finder.found).shape
    assert columns == 3 * (FOUND_PANEL_PX[0] + GAP_PX) + GAP_PX
    assert rows == FOUND_CAPTION_PX + 2 * (TITLE_PX + height + GAP_PX)
