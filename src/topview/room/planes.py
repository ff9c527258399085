"""The room as small planes, one a cell of a coarse image, and the motion that lays one look over
another.

Point-to-plane ICP with projected neighbours, as in R. Newcombe et al., "KinectFusion" (ISMAR 2011),
with the weights of S. Geman and D. McClure, whose scale shrinks from step to step.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_erosion

from topview.camera.pyramid import DepthView, Pyramid
from topview.detect.cloud import stride_of
from topview.geometry.rotations import rotations_from_vectors, transform, unit

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

# All ours. Of the image of cells, pixels: a cell is then 1.6 degrees wide.
CELL_FOCAL_LENGTH_PX: Final = 35.0
# Depths of a cell without an edge differ by no more than this share, as the floor's do 5 m away,
# and 4 standard deviations; and it is seen no flatter than at this cosine.
SLOPE, LEAST_COSINE = 0.1, 0.1
# Metres: nearer than that somebody can fill the image, who is not the room.
FULL_VIEW_M: Final = 1.5
# Metres, beside one standard deviation of a reading: a cell that is so far off loses a half.
OFF_M: Final = 0.015
# Of the weights, one a step, times the above: at first half a metre's motion is within reach.
SCALES: Final = (16.0, 16.0, 8.0, 4.0, 2.0, 1.0)
# Radians and metres: so large is a motion that costs as much as 5 % of the cells off by one scale.
PRIOR_MOTION, PRIOR_SHARE = 0.1, 0.05


@dataclass(frozen=True, slots=True, eq=False)
class RoomPlanes:
    """One look at the room: [h, w] cells.

    Attributes:
        time_s: of the frame.
        points_camera: [h, w, 3] middles of the cells, metres.
        normals_camera: [h, w, 3] units.
        off_m: [h, w] what is off by so much loses a half.
        is_room: [h, w] cells that are nobody's, far enough and without an edge beside them.
        view: the image of cells.
    """

    time_s: float
    points_camera: Array
    normals_camera: Array
    off_m: Array
    is_room: Mask
    view: DepthView

    @classmethod
    def of(cls, image: Pyramid, labels: NDArray[np.int32]) -> RoomPlanes:
        """Of a frame, in which each of [H, W] pixels is somebody's, or 0 for nobody's."""
        stride, noise = stride_of(image.frame.camera), image.frame.camera.noise
        fine = image.smooth_depth_m(stride)
        side_px = max(1, round(image.view(stride).fx / CELL_FOCAL_LENGTH_PX))
        rows, columns = (size // side_px for size in fine.shape)
        cells = rows, side_px, columns, side_px
        inside = slice(rows * side_px), slice(columns * side_px)
        depths_m = fine[inside].reshape(cells)
        owners = labels[::stride, ::stride][inside].reshape(cells)
        nearest_m, farthest_m = depths_m.min(1).min(2), depths_m.max(1).max(2)
        depth_m = depths_m.mean(1).mean(2)
        sigma_m = noise.sigma_m(depth_m)
        is_even = farthest_m - nearest_m < SLOPE * depth_m + 4.0 * sigma_m
        is_room = is_even & (nearest_m > FULL_VIEW_M) & ~owners.any(1).any(-1)
        view = _coarse(image.view(stride), side_px, depth_m)
        points = view.points(*np.indices(depth_m.shape).reshape(2, -1)).reshape(rows, columns, 3)
        normals = _normals(points)
        is_inner = binary_erosion(is_room, np.ones((3, 3), np.bool_))
        is_faced = np.abs(np.einsum("ijk,ijk->ij", normals, unit(points))) > LEAST_COSINE
        off_m = OFF_M + sigma_m.astype(np.float64)
        time_s = image.frame.timestamp_s
        return cls(time_s, points, normals, off_m, is_inner & is_faced, view)


def losses(now: RoomPlanes, then: RoomPlanes, T_then_now: Array) -> tuple[Array, Mask]:
    """[n] of the room's cells of now, 0 (on its plane of then) to 1, under a motion of the camera;
    and which of them saw the room then."""
    _, _, off, is_matched = _matched(now, then, T_then_now)
    return off**2 / (1.0 + off**2), is_matched


def motion_between(now: RoomPlanes, then: RoomPlanes, start_then_now: Array) -> Array:
    """[4, 4] T_then_now of the camera, from a first guess; what the room does not tell stays as
    the guess has it."""
    T_then_now = start_then_now
    for scale in SCALES:
        points, normals, off, is_matched = _matched(now, then, T_then_now)
        weights = is_matched / (1.0 + (off / scale) ** 2) ** 2
        off_m = now.off_m[now.is_room]
        J = np.hstack([np.cross(points, normals), normals]) / off_m[:, None]
        A = J.T @ (J * weights[:, None])
        A += np.eye(6) * (len(off) * PRIOR_SHARE / PRIOR_MOTION**2)
        step = np.linalg.solve(A, J.T @ (weights * off)).astype(np.float64)
        T_then_now = transform(rotations_from_vectors(step[:3]), step[3:]) @ T_then_now
    return T_then_now


def _matched(
    now: RoomPlanes, then: RoomPlanes, T_then_now: Array
) -> tuple[Array, Array, Array, Mask]:
    """Of the room's cells of now: [n, 3] points then, [n, 3] normals of the planes there, [n] how
    far these are in front of the points, over what loses a half, and [n] whether there are any."""
    points = now.points_camera[now.is_room] @ T_then_now[:3, :3].T + T_then_now[:3, 3]
    rows, columns, is_inside = then.view.nearest_pixels(points, FULL_VIEW_M / 2)
    normals = then.normals_camera[rows, columns]
    ahead = then.points_camera[rows, columns] - points
    off = np.einsum("ij,ij->i", normals, ahead) / now.off_m[now.is_room]
    return points, normals, off, is_inside & then.is_room[rows, columns]


def _coarse(fine: DepthView, side_px: int, depth_m: NDArray[np.float32]) -> DepthView:
    """The image of cells, each `side_px` wide, whose middles lie between their pixels."""
    middle = (side_px - 1) / 2
    cx, cy = (fine.cx - middle) / side_px, (fine.cy - middle) / side_px
    return DepthView(depth_m, fine.fx / side_px, fine.fy / side_px, cx, cy)


def _normals(points: Array) -> Array:
    """[h, w, 3] units of [h, w, 3] points, by central differences; 0 at the border."""
    normals = np.zeros_like(points)
    across = points[1:-1, 2:] - points[1:-1, :-2]
    down = points[2:, 1:-1] - points[:-2, 1:-1]
    normals[1:-1, 1:-1] = unit(np.cross(across, down))
    return normals
