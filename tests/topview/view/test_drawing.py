from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from topview.camera import project
from topview.records import JointState
from topview.view.drawing import draw_bone, draw_joint, draw_text, text_width
from topview.view.frame_picture import frame_picture, frame_with_skeletons
from topview.view.labels import Labels
from topview.view.palette import GROUND, OUTLINE, PEOPLE, person_color

SIDE = st.integers(32, 200)
WHITE = (255, 255, 255)


@settings(max_examples=25)
@given(width=SIDE, height=SIDE, panel=st.tuples(SIDE, SIDE))
def test_a_panel_has_the_promised_size(make_frame, make_person, width, height, panel):
    frame = make_frame(width=width, height=height)
    assert frame_with_skeletons(frame, [make_person()], panel).shape == (panel[1], panel[0], 3)


@pytest.mark.parametrize("panel", [(320, 240), (480, 360), (400, 240), (320, 300)])
def test_joints_are_drawn_where_the_camera_sees_them(make_frame, make_person, panel):
    frame, person = make_frame(), make_person(person_id=2)
    picture = frame_with_skeletons(frame, [person], panel)
    scale = min(panel[0] / frame.camera.width, panel[1] / frame.camera.height)
    fitted = scale * np.array([frame.camera.width, frame.camera.height])
    joints = (project(person.joints_camera, frame.camera) + 0.5) * scale - 0.5
    joints += (np.array(panel) - fitted) // 2
    for x, y in joints[4:16]:  # the head's label may lie over the head, hands over wrists
        if 2 <= x < panel[0] - 2 and 2 <= y < panel[1] - 2:
            assert tuple(picture[round(y), round(x)]) == person_color(2)


def test_nothing_is_drawn_of_a_person_behind_the_camera(make_frame, make_person):
    frame, behind = make_frame(), make_person(crown=(0.0, -0.8, -3.0))
    alone = frame_with_skeletons(frame, [], (160, 120))
    np.testing.assert_array_equal(frame_with_skeletons(frame, [behind], (160, 120)), alone)


def test_the_nearer_person_is_drawn_over_the_farther(make_frame, make_person):
    near, far = make_person(1, (0.0, -0.8, 2.5)), make_person(2, (0.0, -0.8, 3.5))
    orders = [
        frame_with_skeletons(make_frame(), people, (320, 240))
        for people in ([near, far], [far, near])
    ]
    np.testing.assert_array_equal(orders[0], orders[1])


@pytest.mark.parametrize("state", list(JointState))
def test_only_visible_joints_are_filled(state):
    image = np.full((21, 21, 3), GROUND, np.uint8)
    draw_joint(image, np.array([10.0, 10.0]), state, WHITE, 5.0)
    centre, changed = tuple(image[10, 10]), (image != GROUND).any()
    assert changed == (state != JointState.ABSENT)
    assert (centre == WHITE) == (state in (JointState.VISIBLE, JointState.OUT_OF_VIEW))
    if state in (JointState.OCCLUDED_BY_PERSON, JointState.OCCLUDED_BY_OBJECT):
        assert centre == OUTLINE


def test_every_state_has_its_own_marker():
    pictures = []
    for state in JointState:
        image = np.zeros((21, 21, 3), np.uint8)
        draw_joint(image, np.array([10.0, 10.0]), state, WHITE, 5.0)
        pictures.append(image.tobytes())
    assert len(set(pictures)) == len(JointState)


@pytest.mark.parametrize(("align", "first", "last"), [("left", 50, 95), ("right", 5, 50)])
def test_text_begins_or_ends_where_it_is_put(align, first, last):
    image = np.zeros((40, 100, 3), np.uint8)
    width = draw_text(image, "1 m", (50.0, 30.0), 12, WHITE, align)
    rows, columns = np.nonzero(image[..., 0] > 64)
    assert first - 2 <= columns.min()
    assert columns.max() <= last + 2
    assert columns.max() - columns.min() <= width + 2
    assert abs(rows.max() - 30) <= 2
    assert abs(rows.max() - rows.min() - 12) <= 2


def test_text_may_reach_over_the_edges():
    image = np.zeros((10, 10, 3), np.uint8)
    for outside in ((-200.0, 5.0), (5.0, -50.0), (9.0, 30.0)):
        draw_text(image, "outside", outside, 12, WHITE)
        assert not image.any()
    draw_text(image, "outside", (-5.0, 8.0), 12, WHITE)
    assert image.any()


def test_depth_pictures_show_missing_readings_as_ground(make_frame):
    frame = make_frame(wall_m=0.0)
    assert (frame_picture(frame) == GROUND).all()


def test_near_is_lighter_than_far(make_frame):
    frame = make_frame()
    depth_m = np.where(np.arange(160) < 80, 2.0, 4.0)[None].repeat(120, 0).astype(np.float32)
    picture = frame_picture(type(frame)(0, 0.0, depth_m, frame.camera))
    assert picture[60, 20].sum() > picture[60, 140].sum() + 50


def test_colours_tell_six_people_apart_and_last():
    assert len(set(PEOPLE)) == len(PEOPLE) == 6
    assert person_color(1) == person_color(7) != person_color(2)


def test_bones_of_the_right_have_gaps_and_those_of_the_left_none():
    ends = np.array([10.0, 20.0]), np.array([90.0, 20.0])
    lines = []
    for is_dashed in (False, True):
        image = np.zeros((40, 100, 3), np.uint8)
        draw_bone(image, ends, WHITE, 3, is_dashed)
        lines.append((image[20, 12:88] == WHITE).all(-1))
    assert lines[0].all()
    assert 0.3 < lines[1].mean() < 0.7


def test_labels_keep_off_each_other_and_in_the_picture():
    picture = np.zeros((100, 120, 3), np.uint8)
    labels, inks = Labels(picture), []
    for at in ((60.0, 50.0), (62.0, 51.0), (58.0, 49.0), (500.0, -40.0)):
        before = picture.copy()
        labels.put("a label", at, WHITE)
        inks.append((picture != before).any(-1))
        assert text_width("a label", 8) - 4 <= np.ptp(np.nonzero(inks[-1].any(0))) < 120
    assert (np.sum(inks, axis=0) <= 1).all()
    assert all(ink[1:-1, 1:-1].any() for ink in inks)
