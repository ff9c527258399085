"""What rerun is told, and what its web viewer then shows."""

from __future__ import annotations

from pathlib import Path
from urllib.parse import parse_qs, urlsplit

import cv2
import numpy as np
import pytest

from browser import Browser, find_chromium
from moving_bodies import moving_people
from tiny_recordings import CAMERA, HEIGHT, WIDTH, wall
from topview.cli import view as command
from topview.cli.view import people_of
from topview.io import write_skeletons_npz
from topview.io.writers import extras
from topview.records import Camera, Frame
from topview.view.palette import person_color
from topview.view.rerun_view import RerunView, bones_of, cloud_of

rerun = pytest.importorskip("rerun", reason="needs rerun-sdk")


def frame(index: int) -> Frame:
    color = np.full((HEIGHT, WIDTH, 3), (10, 120, 200), np.uint8)
    depth_m = np.full((HEIGHT, WIDTH), 3.0, np.float32)
    depth_m[:, 0] = 0.0
    return Frame(index, index / 30, depth_m, Camera(**CAMERA), color)


def labelled(shown: Frame) -> np.ndarray:
    return np.full(shown.depth_m.shape, 3, np.int32)


@pytest.fixture
def told(tmp_path) -> dict[str, int]:
    """How many rows rerun was told of each entity, of two frames with people and one without."""
    view = RerunView("made", labelled)
    path = tmp_path / "made.rrd"
    view.stream.save(path)
    everybody = list(people_of(moving_people()))
    for index, people in enumerate([everybody[0], everybody[1], []]):
        view.show(frame(index), people)
    view.stream.flush()
    view.stream.disconnect()
    rows: dict[str, int] = {}
    for chunk in rerun.chunk.RrdReader(path).stream():
        rows[chunk.entity_path] = rows.get(chunk.entity_path, 0) + chunk.num_rows
    return rows


def test_every_entity_is_told_in_each_frame_that_has_it(told):
    of_frames = {f"/world/{what}": 3 for what in ("cloud", "camera/image", "camera/areas")}
    of_people = {
        f"/world/{what}": 2 for what in ("skeletons/1/left", "skeletons/1/right", "bodies/1")
    }
    of_person_3 = {"/world/skeletons/3/joints": 1, "/world/bodies/3": 2}  # and is then removed
    expected = of_frames | of_people | {"/world/skeletons/1/joints": 2} | of_person_3
    expected["/world/bodies/1"] = 3
    assert {place: told.get(place) for place in expected} == expected
    assert told["/world/skeletons/1"] == 1  # removed where nobody is


def test_left_and_right_are_the_bones_of_their_side():
    (person,) = next(people_of(moving_people()))
    sides = {side: bones_of(person, side) for side in ("middle", "left", "right")}
    assert {side: len(bones) for side, bones in sides.items()} == {
        "middle": 3,
        "left": 8,
        "right": 8,
    }
    np.testing.assert_array_equal(sides["left"][0][0], person.joints_camera[1])


def test_a_cloud_is_what_has_a_reading():
    points, colors = cloud_of(frame(0))
    assert len(points) == len(colors) == (WIDTH - 1) * HEIGHT
    np.testing.assert_allclose(points[:, 2], 3.0)
    assert set(map(tuple, colors.tolist())) == {(10, 120, 200)}


def test_a_result_is_shown_with_the_images_of_its_recording(
    topview, make_recording, tmp_path, monkeypatch
):
    source = make_recording([wall()] * 6)
    (source / "depth" / "000003.png").unlink()
    write_skeletons_npz(moving_people(), tmp_path / "skeletons.npz")  # frames 0 to 4
    shown: dict[str, list[int]] = {"show": [], "show_skeletons": []}
    monkeypatch.setattr(command, "tell_address", lambda viewer: None)
    monkeypatch.setattr(RerunView, "show", lambda _, f, people: shown["show"].append(f.index))
    monkeypatch.setattr(
        RerunView, "show_skeletons", lambda _, n, time_s, people: shown["show_skeletons"].append(n)
    )
    assert topview("view", tmp_path, "--recording", source, "--once").status == 0
    assert shown == {"show": [0, 1, 2, 4], "show_skeletons": [3]}


def test_without_rerun_one_line_says_how_to_get_it(topview, tmp_path, monkeypatch):
    def missing(name):
        raise ImportError(name)

    monkeypatch.setattr(extras, "import_module", missing)
    for words in (["view", tmp_path], ["track", tmp_path, "--out", tmp_path, "--view"]):
        ended = topview(*words)
        assert ended.status == 2
        (line,) = ended.complaints
        assert line.endswith("install it with: pip install 'topview[view]'")


@pytest.mark.skipif(not Path("/proc/net/tcp").exists(), reason="needs Linux's list of sockets")
def test_the_viewer_listens_on_this_machine_alone():
    view = RerunView("made")
    address = urlsplit(view.serve(open_browser=False))
    data = urlsplit(parse_qs(address.query)["url"][0])
    assert listening_at(address.port) == listening_at(data.port) == {"0100007F"}  # 127.0.0.1


def listening_at(port: int | None) -> set[str]:
    """Addresses of this machine, hexadecimal, at which a program listens on a port."""
    lists = Path("/proc/net/tcp"), Path("/proc/net/tcp6")
    sockets = [line.split()[1:4] for each in lists for line in each.read_text().splitlines()]
    return {
        at.partition(":")[0]
        for at, _, state in sockets
        if (at[-5:], state) == (f":{port:04X}", "0A")
    }


@pytest.mark.slow
def test_the_web_viewer_shows_it(topview, tmp_path):
    """In a real Chromium: both people's colours are there, and the page is not blank."""
    find_chromium()
    both_last = moving_people({0.0: [1], 0.1: [1, 3]})
    write_skeletons_npz(both_last, tmp_path / "skeletons.npz")
    shown = []

    def serve(viewer: RerunView) -> None:
        shown.append((viewer, viewer.serve(open_browser=False)))

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(command, "tell_address", serve)
        assert topview("view", tmp_path, "--once").status == 0
    browser = Browser(tmp_path / "browser")
    browser.open(shown[0][1])
    browser.until("document.querySelector('canvas') !== null")
    path = tmp_path / "viewer.png"
    colors = [np.array(person_color(person)) for person in (1, 3)]
    seen = [0]
    for _ in range(300):
        browser.screenshot(path)
        picture = np.asarray(cv2.imread(str(path)), int)[..., ::-1]
        seen = [int((np.abs(picture - color).max(-1) < 25).sum()) for color in colors]
        if min(seen) > 20:
            break
    browser.close()
    assert min(seen) > 20, f"see {path}"
    assert browser.errors == []
