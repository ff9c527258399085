"""Users found in simulated scenes: what is special about a case, and what its rows tell."""

from __future__ import annotations

import numpy as np
import pytest

from topview_lab.metrics.heads import PeopleFound, PersonFound
from topview_lab.reproduce.finding import (
    AUTO,
    SPECIAL,
    WITH_NETWORK,
    Case,
    Finding,
    Search,
    altered_color,
)
from topview_lab.reproduce.tally import HEADER, Tally

COLOR = np.random.default_rng(0).integers(0, 256, (6, 8, 3), np.uint8)


def finding(tone: str, errors_m: list[float], frames: int = 10) -> Finding:
    person = PersonFound(frames, np.array(errors_m), 0.2, 1, 0, 1, 1)
    return Finding((tone,), {"auto": PeopleFound(frames, 3, (person,))})


@pytest.mark.parametrize("colour", ["as it is", "none", "grey", "dark", "bright"])
def test_a_changed_picture_is_a_picture_or_none(colour):
    image = altered_color(COLOR, colour)
    if colour == "none":
        assert image is None
    else:
        assert image is not None
        assert image.shape == COLOR.shape
        assert image.dtype == np.uint8
        assert np.array_equal(image, COLOR) == (colour == "as it is")


def test_grey_has_no_colour_and_exposure_goes_its_way():
    grey, dark, bright = (altered_color(COLOR, c) for c in ("grey", "dark", "bright"))
    assert grey is not None
    assert dark is not None
    assert bright is not None
    assert np.ptp(grey, axis=-1).max() == 0
    assert (dark <= COLOR).all()
    assert (bright >= COLOR).all()


@pytest.mark.parametrize("conditions", SPECIAL, ids=lambda conditions: conditions.name)
def test_a_special_case_differs_in_its_conditions_alone(conditions):
    usual, special = (
        Case("enter_and_leave", 1, 5, conditions=each).make() for each in (SPECIAL[0], conditions)
    )
    assert special.mount == (conditions.mount or usual.mount)
    assert special.light == (conditions.light or usual.light)
    assert [actor.body.appearance for actor in special.actors] == [
        actor.body.appearance for actor in usual.actors
    ]


def test_a_row_counts_people_and_recordings():
    both = [finding("light", [0.01] * 10), finding("dark", [0.08] * 5)]
    tally = Tally.of(both)
    assert (tally.person_frames, tally.recall, tally.false_per_1000) == (20, 0.75, 300.0)
    assert (tally.near, tally.soon, tally.exchanges) == (10 / 15, 1.0, 2)
    assert (tally.kept, tally.returns) == (2, 2)
    dark = Tally.of(both, tone="dark")
    assert (dark.person_frames, dark.recall, dark.near) == (10, 0.5, 0.0)
    assert dark.row("dark").cells[4:6] == ("–", "–")
    assert len(dark.row("dark").cells) == len(HEADER) + 1


def test_nobody_is_no_number_and_no_error():
    assert Tally.of([]).row("nobody").cells[3] == "–"


def test_the_whole_tracker_is_counted_as_the_finder_is():
    found = Search(Case("walking", 1, 12), (AUTO, WITH_NETWORK))().found
    assert set(found) == {AUTO, WITH_NETWORK}
    (by_finder,), (by_tracker,) = (found[name].people for name in (AUTO, WITH_NETWORK))
    assert all((each.frames, each.false, each.exchanges) == (12, 0, 0) for each in found.values())
    assert len(by_finder.errors_m) == len(by_tracker.errors_m) == by_finder.frames == 12
    assert not np.array_equal(by_finder.errors_m, by_tracker.errors_m)
