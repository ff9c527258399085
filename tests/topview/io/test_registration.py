"""Colour of a camera of its own: each depth pixel gets the colour of the point that it shows."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.ndimage import binary_dilation

import topview
from lenses import LENSES
from topview import InputError
from topview.camera import undistort
from topview.geometry.rotations import rotations_from_vectors, transform
from topview.io.readers.camera_json import read_camera_json
from topview.io.readers.registration import ColorCamera, register_color
from topview.records import Camera

DEPTH_CAMERA = Camera(fx=100.0, fy=101.0, cx=39.2, cy=30.1, width=80, height=60)
# Wider, finer, beside and a little turned, as a sensor's colour camera is.
COLOR_CAMERA = ColorCamera(
    Camera(fx=250.0, fy=252.0, cx=130.3, cy=97.6, width=260, height=200),
    transform(
        rotations_from_vectors(np.array([0.01, -0.02, 0.015])), np.array([0.06, -0.01, 0.004])
    ),
)
T_DEPTH_COLOR = np.asarray(np.linalg.inv(COLOR_CAMERA.T_color_depth), np.float64)
WALL_M, BOX_M = 3.0, 1.2
BOX_RIGHT_M, BOX_DOWN_M = (-0.15, 0.12), (-0.2, 0.25)  # in the depth camera's frame
WALL_RGB, BOX_RGB, HIDDEN_RGB = (40, 180, 90), (200, 30, 60), (0, 0, 0)


def box_and_wall(
    camera: Camera, T_depth_camera: NDArray[np.float64]
) -> tuple[NDArray[np.bool_], NDArray[np.float32], NDArray[np.uint8]]:
    """What a camera sees: [H, W] where the box is, the depth along its axis, and the colour."""
    u, v = np.meshgrid(np.arange(camera.width), np.arange(camera.height))
    rays = np.stack([(u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, np.ones(u.shape)], 2)
    rays = rays @ T_depth_camera[:3, :3].T
    start = T_depth_camera[:3, 3]
    to_box, to_wall = ((z - start[2]) / rays[..., 2] for z in (BOX_M, WALL_M))
    right, down = (start[i] + to_box * rays[..., i] for i in (0, 1))
    is_box = is_on_box(right, down)
    depth_m = np.where(is_box, to_box, to_wall).astype(np.float32)
    return is_box, depth_m, np.where(is_box[..., None], BOX_RGB, WALL_RGB).astype(np.uint8)


def wall_hidden_by_box() -> NDArray[np.bool_]:
    """[H, W] pixels of the depth image whose point on the wall the colour camera cannot see."""
    camera = DEPTH_CAMERA
    is_box, depth_m, _ = box_and_wall(camera, np.eye(4))
    u, v = np.meshgrid(np.arange(camera.width), np.arange(camera.height))
    x, y = (u - camera.cx) / camera.fx * depth_m, (v - camera.cy) / camera.fy * depth_m
    points = np.stack([x, y, depth_m], 2)
    eye = T_DEPTH_COLOR[:3, 3]
    share = ((BOX_M - eye[2]) / (points[..., 2] - eye[2]))[..., None]
    at_box = eye + share * (points - eye)
    is_seen_through = is_on_box(at_box[..., 0], at_box[..., 1])
    return np.logical_and(is_seen_through, ~is_box)


def is_on_box(right_m: NDArray[np.float64], down_m: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Where points of the box's plane are the box."""
    low, high = np.transpose([BOX_RIGHT_M, BOX_DOWN_M])
    place = np.stack([right_m, down_m], -1)
    return ((low < place) & (place < high)).all(-1)


def edges(mask: NDArray[np.bool_]) -> NDArray[np.bool_]:
    around = np.ones((3, 3))
    return np.logical_and(binary_dilation(mask, around), binary_dilation(~mask, around))


class TestBoxBeforeAWall:
    is_box, depth_m, _ = box_and_wall(DEPTH_CAMERA, np.eye(4))
    color = box_and_wall(COLOR_CAMERA.camera, T_DEPTH_COLOR)[2]
    is_hidden = wall_hidden_by_box()
    is_clear = ~np.logical_or(edges(is_box), edges(is_hidden))

    def test_every_pixel_has_the_colour_of_its_point_or_is_black_where_hidden(self):
        assert self.is_hidden[self.is_clear].sum() > 30
        registered = register_color(self.color, COLOR_CAMERA, self.depth_m, DEPTH_CAMERA)
        expected = np.where(self.is_box[..., None], BOX_RGB, WALL_RGB)
        expected[self.is_hidden] = HIDDEN_RGB
        np.testing.assert_array_equal(registered[self.is_clear], expected[self.is_clear])

    def test_next_to_nothing_of_the_box_is_left_on_the_wall(self):
        """At the edges neither, where half a pixel decides."""
        registered = register_color(self.color, COLOR_CAMERA, self.depth_m, DEPTH_CAMERA)
        left = (registered[~self.is_box] == BOX_RGB).all(-1)
        assert left.sum() <= 0.01 * self.is_hidden.sum()

    def test_holes_beside_the_box_are_taken_for_the_wall(self):
        """And get its colour, though the next reading on one side is the box."""
        around = binary_dilation(self.is_box, np.ones((1, 13)))
        is_hole = np.logical_and(around, ~self.is_box)
        depth_m = np.where(is_hole, 0.0, self.depth_m).astype(np.float32)
        whole = register_color(self.color, COLOR_CAMERA, self.depth_m, DEPTH_CAMERA)
        with_holes = register_color(self.color, COLOR_CAMERA, depth_m, DEPTH_CAMERA)
        np.testing.assert_array_equal(with_holes, whole)
        assert (with_holes[is_hole] == WALL_RGB).all(-1).any()

    def test_a_frame_without_readings_still_has_colour(self):
        depth_m = np.zeros_like(self.depth_m)
        registered = register_color(self.color, COLOR_CAMERA, depth_m, DEPTH_CAMERA)
        assert (registered == WALL_RGB).all(-1).mean() > 0.5

    def test_a_floor_seen_at_a_flat_angle_does_not_hide_itself(self):
        rows = np.arange(DEPTH_CAMERA.height)[:, None] - DEPTH_CAMERA.cy
        depth_m = np.where(rows > 10, DEPTH_CAMERA.fy * 1.0 / np.maximum(rows, 1), WALL_M)
        depth_m = np.broadcast_to(depth_m, self.depth_m.shape).astype(np.float32)
        color = np.full_like(self.color, 200)
        registered = register_color(color, COLOR_CAMERA, depth_m, DEPTH_CAMERA)
        assert (registered == 200).all()


@settings(max_examples=20)
@given(seed=st.integers(0, 2**32 - 1))
def test_the_depth_cameras_own_image_stays_as_it_is(seed):
    """Whatever the depths are, and where there are none."""
    rng = np.random.default_rng(seed)
    shape = DEPTH_CAMERA.height, DEPTH_CAMERA.width
    depth_m = (rng.uniform(0.3, 8.0, shape) * (rng.random(shape) < 0.7)).astype(np.float32)
    color = rng.integers(0, 256, (*shape, 3), np.uint8)
    same = ColorCamera(DEPTH_CAMERA, np.eye(4))
    np.testing.assert_array_equal(register_color(color, same, depth_m, DEPTH_CAMERA), color)


def painted_wall(camera: Camera, T_depth_camera: NDArray[np.float64]) -> NDArray[np.uint8]:
    """What a camera sees of a wall whose red tells how far right one is, its green how far down."""
    v, u = np.mgrid[: camera.height, : camera.width]
    seen = np.stack([(u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy], 2)
    rays = np.dstack([undistort(seen, camera.distortion), np.ones(u.shape)])
    rays, start = rays @ T_depth_camera[:3, :3].T, T_depth_camera[:3, 3]
    points = start + ((WALL_M - start[2]) / rays[..., 2])[..., None] * rays
    red, green = 125.0 + 100.0 * np.moveaxis(points[..., :2], -1, 0)
    return np.rint(np.stack([red, green, np.full_like(red, 50.0)], 2)).clip(1, 254).astype(np.uint8)


@pytest.mark.parametrize("lens", LENSES.values(), ids=list(LENSES))
def test_a_colour_camera_with_a_lens_gives_each_pixel_its_points_colour(lens):
    camera = replace(COLOR_CAMERA.camera, distortion=lens)
    color = painted_wall(camera, T_DEPTH_COLOR)
    depth_m = np.full((DEPTH_CAMERA.height, DEPTH_CAMERA.width), WALL_M, np.float32)
    expected = painted_wall(DEPTH_CAMERA, np.eye(4)).astype(int)
    registered, untold = (
        register_color(
            color, ColorCamera(each, COLOR_CAMERA.T_color_depth), depth_m, DEPTH_CAMERA
        ).astype(int)
        for each in (camera, COLOR_CAMERA.camera)
    )
    is_seen = registered.any(-1) & untold.any(-1)
    assert is_seen.mean() > 0.9
    off, untold_off = (np.abs(each - expected)[is_seen] for each in (registered, untold))
    assert off.max() <= 1  # of rounding
    assert untold_off.max() > 1


@pytest.mark.parametrize("shift_px", [-3, 5])
def test_parallax_shifts_a_plane(shift_px):
    camera, depth_m = DEPTH_CAMERA, np.full((60, 80), 2.0, np.float32)
    T = transform(np.eye(3), np.array([shift_px * 2.0 / camera.fx, 0.0, 0.0]))
    color = np.random.default_rng(0).integers(1, 256, (60, 80, 3), np.uint8)
    registered = register_color(color, ColorCamera(camera, T), depth_m, camera)
    expected = np.roll(color, -shift_px, axis=1)
    expected[:, slice(80 - shift_px, None) if shift_px > 0 else slice(0, -shift_px)] = HIDDEN_RGB
    np.testing.assert_array_equal(registered, expected)


def test_a_camera_that_looks_the_other_way_sees_nothing():
    T = transform(rotations_from_vectors(np.array([0.0, np.pi, 0.0])), np.zeros(3))
    color = np.full((60, 80, 3), 255, np.uint8)
    turned = ColorCamera(DEPTH_CAMERA, T)
    depth_m = np.full((60, 80), 2.0, np.float32)
    assert not register_color(color, turned, depth_m, DEPTH_CAMERA).any()


# Twice as fine as the depth images of the folders, with pixel centres that lie on theirs.
COLOR = {
    "fx": 18.0,
    "fy": 19.0,
    "cx": 7.0,
    "cy": 5.0,
    "width": 16,
    "height": 12,
    "T_color_depth": np.eye(4).tolist(),
}


class TestInAFolder:
    def test_it_is_registered_as_it_is_read(self, write_folder, depths):
        color = np.random.default_rng(0).integers(0, 256, (12, 16, 3), np.uint8)
        images = {f"{i:06d}.png": color for i in depths}
        root = self.folder_with(write_folder, COLOR, images)
        recording = topview.open(root)
        for frame in recording:
            np.testing.assert_array_equal(frame.color, color[::2, ::2])
        assert recording.problems == []

    def test_images_of_another_size_than_told_are_named_once(self, write_folder, depths):
        small = np.zeros((6, 8, 3), np.uint8)
        root = self.folder_with(write_folder, COLOR, {f"{i:06d}.png": small for i in depths})
        recording = topview.open(root)
        assert [frame.color for frame in recording] == [None] * 4
        assert recording.problems == [
            'rgb/: images are 8 x 6 pixels; they must be 16 x 12, as "color" in camera.json says; '
            "going on without colour"
        ]

    @pytest.mark.parametrize(
        ("color", "message"),
        [
            (True, r"is true; it must be \{fx, fy, .*T_color_depth\}"),
            ({}, "has no fx, fy, cx, cy, width, height, T_color_depth; it must have"),
            ({**COLOR, "fx": -1}, "camera fx is -1.0; it must be a focal length in pixels, 0.75"),
            ({**COLOR, "cy": "1"}, 'cy is "1"; it must be a number'),
            ({**COLOR, "T_color_depth": None}, "T_color_depth must be 4 x 4 numbers"),
            ({**COLOR, "T_color_depth": np.eye(3).tolist()}, "must be 4 x 4 numbers"),
            ({**COLOR, "T_color_depth": [[1, 0, 0, "0"]] * 4}, "must be 4 x 4 numbers"),
            ({**COLOR, "T_color_depth": [[1, 0], [1], 3, 4]}, "must be 4 x 4 numbers"),
            ({**COLOR, "T_color_depth": (2 * np.eye(4)).tolist()}, "is no rotation"),
            ({**COLOR, "T_color_depth": np.diag([-1, 1, 1, 1]).tolist()}, "no rotation.*handed"),
            ({**COLOR, "T_color_depth": np.full((4, 4), 1e300).tolist()}, "is no rotation"),
            ({**COLOR, "T_color_depth": np.full((4, 4), np.nan).tolist()}, "is no rotation"),
            ({**COLOR, "T_color_depth": np.eye(4)[:, [0, 1, 2, 2]].tolist()}, "the last row"),
            (
                {
                    **COLOR,
                    "T_color_depth": [[1, 0, 0, 25], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]],
                },
                "25 m apart; its last column must be metres",
            ),
        ],
    )
    def test_a_camera_that_cannot_be_is_refused_in_one_line(self, write_folder, color, message):
        root = self.folder_with(write_folder, color)
        with pytest.raises(InputError, match=rf"camera\.json: color: .*{message}") as error:
            topview.open(root)
        assert "\n" not in str(error.value)

    def test_a_rotation_written_with_few_digits_will_do(self, write_folder):
        T = np.round(COLOR_CAMERA.T_color_depth, 3).tolist()
        root = self.folder_with(write_folder, {**COLOR, "T_color_depth": T})
        camera = read_camera_json(root / "camera.json").color
        assert camera is not None
        np.testing.assert_allclose(camera.T_color_depth, COLOR_CAMERA.T_color_depth, atol=5e-4)
        assert camera.camera == Camera(fx=18.0, fy=19.0, cx=7.0, cy=5.0, width=16, height=12)

    def folder_with(self, write_folder, color, images=None) -> Path:
        root = write_folder(color=images)
        camera_json = json.loads((root / "camera.json").read_text())
        (root / "camera.json").write_text(json.dumps({**camera_json, "color": color}))
        return root
