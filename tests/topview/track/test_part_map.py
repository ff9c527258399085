"""Whose each pixel is, and which part of the body."""

from __future__ import annotations

from dataclasses import replace
from zipfile import ZipFile

import cv2
import numpy as np
import pytest

from rendered_bodies import CAMERA, MODEL, render, standing_pose
from topview.body.parts import LEFT_FOREARM, PART_NAMES
from topview.camera.projection import pixel_rays
from topview.camera.pyramid import DepthView
from topview.geometry.quadrics import closed_cylinder_depths
from topview.io.readers import open_recording
from topview.records import Frame, InputError, PartMap
from topview.track import Tracker, TrackerSettings
from topview.track.part_map import part_map_of
from topview.track.pose import FittedBody
from topview.view import PartMaps
from topview_lab.datasets.joints import our_part_name
from topview_lab.sim import scene_by_name, write_scene
from topview_lab.sim.bodies import SIM_PART_NAMES

PERSON = 7
POSE = standing_pose()
BODY = FittedBody(PERSON, MODEL, POSE.transforms(MODEL))
SEEN_M = render(POSE)
ENDS = {"hand": "forearm", "foot": "lower_leg"}


def view_of(depth_m: np.ndarray) -> DepthView:
    return DepthView(depth_m, CAMERA.fx, CAMERA.fy, CAMERA.cx, CAMERA.cy)


def labels_of(depth_m: np.ndarray) -> np.ndarray:
    return np.where(depth_m > 0.0, PERSON, 0).astype(np.int32)


def true_parts() -> np.ndarray:
    """[H, W] 1 + index of the part that is in front."""
    rays = pixel_rays(CAMERA).astype(np.float64)
    depths = [
        closed_cylinder_depths(rays, T, length, rx, rz)
        for T, length, (rx, rz) in zip(
            BODY.Ts_camera_part, MODEL.lengths_m, MODEL.radii_m, strict=True
        )
    ]
    return np.where(SEEN_M > 0.0, 1 + np.argmin(depths, axis=0), 0)


def test_each_pixel_of_a_body_is_of_the_part_that_it_shows() -> None:
    """But for where two of them meet."""
    part_map = part_map_of(view_of(SEEN_M), labels_of(SEEN_M), [BODY])
    np.testing.assert_array_equal(part_map.person_ids, labels_of(SEEN_M))
    np.testing.assert_array_equal(part_map.parts[SEEN_M == 0.0], 0)
    is_right = (part_map.parts == true_parts())[SEEN_M > 0.0]
    assert is_right.mean() > 0.96
    assert set(np.unique(part_map.parts)) == set(range(len(PART_NAMES) + 1))


def test_what_somebody_carries_is_theirs_and_of_no_part() -> None:
    depth_m = SEEN_M.copy()
    depth_m[5:9, 5:9] = 1.5
    part_map = part_map_of(view_of(depth_m), labels_of(depth_m), [BODY])
    assert (part_map.person_ids[5:9, 5:9] == PERSON).all()
    assert not part_map.parts[5:9, 5:9].any()


def test_a_part_that_is_not_tracked_has_no_pixel_and_who_has_no_body_no_part() -> None:
    Ts = BODY.Ts_camera_part.copy()
    Ts[LEFT_FOREARM] = np.nan
    labels = labels_of(SEEN_M)
    labels[:, :20] = PERSON + 1
    part_map = part_map_of(view_of(SEEN_M), labels, [replace(BODY, Ts_camera_part=Ts)])
    assert not (part_map.parts == 1 + LEFT_FOREARM).any()
    assert not part_map.parts[:, :20].any()
    nobody = part_map_of(view_of(SEEN_M), labels, [])
    assert not nobody.parts.any()
    assert (nobody.person_ids == labels).all()


def test_a_zip_holds_two_images_of_each_frame_and_the_same_bytes_each_time(tmp_path) -> None:
    maps = [part_map_of(view_of(SEEN_M), labels_of(SEEN_M), [BODY]), None]
    files = [tmp_path / name for name in ("a.zip", "b.zip")]
    for file in files:
        sheet = PartMaps(tmp_path, iter(maps).__next__)
        assert sheet.is_blank
        frame = open_frame()
        sheet.show(frame, [])
        sheet.show(frame, [])
        assert not sheet.is_blank
        with file.open("wb") as out:
            sheet.write(out)
    assert files[0].read_bytes() == files[1].read_bytes()
    ids, parts = (image_in(files[0], f"{folder}/000012.png") for folder in ("mask", "part"))
    assert (ids.dtype, parts.dtype) == (np.uint16, np.uint8)
    np.testing.assert_array_equal(ids, labels_of(SEEN_M))
    np.testing.assert_array_equal(parts, maps[0].parts if maps[0] else None)


def test_an_id_that_the_images_cannot_hold_is_named(tmp_path) -> None:
    ids = np.full((2, 2), 70_000, np.int32)
    sheet = PartMaps(tmp_path, lambda: PartMap(ids, np.zeros((2, 2), np.uint8)))
    with pytest.raises(InputError, match="has person 70000; part maps hold up to 65535"):
        sheet.show(open_frame(), [])


def open_frame() -> Frame:
    return Frame(12, 0.4, SEEN_M, CAMERA)


def image_in(file, name: str) -> np.ndarray:
    with ZipFile(file) as zipped:
        image = cv2.imdecode(np.frombuffer(zipped.read(name), np.uint8), cv2.IMREAD_UNCHANGED)
    assert image is not None
    return image


def test_simulated_people_are_told_as_they_truly_are(topview, tmp_path) -> None:
    """By the command and by the library; hands belong to forearms, feet to lower legs."""
    folder, out = tmp_path / "room", tmp_path / "out"
    write_scene(scene_by_name("two_users", seed=3, frames=4), folder)
    ended = topview("track", folder, "--out", out, "--part-map", "--proposals", "none")
    assert (ended.status, ended.complaints) == (0, [])
    tracker = Tracker(TrackerSettings(proposals="none"))
    assert tracker.part_map() is None
    for frame in open_recording(folder):
        tracker.update(frame)
    told = tracker.part_map()
    assert told is not None
    ids = image_in(out / "part_maps.zip", "mask/000003.png")
    parts = image_in(out / "part_maps.zip", "part/000003.png")
    np.testing.assert_array_equal(parts, told.parts)
    np.testing.assert_array_equal(ids, told.person_ids)
    part_of = np.array([0, *(1 + PART_NAMES.index(ours(name)) for name in SIM_PART_NAMES)])
    true_part = np.array(cv2.imread(str(folder / "part" / "000003.png"), cv2.IMREAD_UNCHANGED))
    is_somebody = (ids > 0) & (true_part > 0)
    assert is_somebody.sum() > 0.9 * (true_part > 0).sum()
    assert (parts == part_of[true_part])[is_somebody].mean() > 0.8


def ours(name: str) -> str:
    for end, part in ENDS.items():
        name = name.replace(end, part)
    own = our_part_name(name)
    assert own is not None
    return own
