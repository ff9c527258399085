"""Windows: what a frame shows round each person, in a box that is as large as the person needs.

A window is axis-aligned in the image, so that cutting it out only picks pixels; its box has the
same size in metres whatever the person's distance. Places in a window have no unit: the box reaches
from -1 to 1 to the right, down, and in depth.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil, floor
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.camera.pyramid import DepthView
from topview.kernels.windows import (
    count_own,
    distances_to_cover,
    fill_window,
    middle_and_reach,
)
from topview.records import read_only

Array = NDArray[np.float64]

# All ours.
WINDOW_PIXELS: Final = 128  # on each side
HALF_BOX_M: Final = 1.2  # from a box's middle to its sides, front and back, at the most
LEAST_HALF_BOX_M: Final = 0.72  # and at the least, for children and whoever sits
BOX_MARGIN_M: Final = 0.08  # from the person's outermost columns and rows to the box's sides
OUTERMOST_SHARE: Final = 0.0025  # of the person's pixels that lie beyond those on each side
LEAST_WINDOW_PIXELS: Final = 40  # of a person; with fewer there is nothing to look at
NEAREST_MIDDLE_M: Final = 0.3  # a box's middle is no nearer to the camera
FARTHEST_MIDDLE_M: Final = 60.0  # and no farther
DEPTH, OWN, OTHER = range(3)  # the channels
TIMES_ASIDE: Final = 4.0  # that ways to the side of what may hide a joint count
NO_READING: Final = 1.0  # the depth where nothing was read, as of what is far behind

# From a box's middle to the middles of its pixels on one side, in halves of the box.
_STEPS = (np.arange(WINDOW_PIXELS // 2) + 0.5) * 2.0 / WINDOW_PIXELS


@dataclass(frozen=True, slots=True, eq=False)
class Windows:
    """What P people's windows show, and where these lie.

    Attributes:
        images: [P, 3, 128, 128] float32: depth less the middle's, -1 to 1, 1 where there is no
            reading; the person's own pixels; those of other people.
        middles: [P, 3] column, row and depth in metres of each box's middle.
        halves_m: [P] from each box's middle to its sides, front and back.
        is_used: [P] whether there was enough to look at; the images of others are zeros.
        fx, fy, cx, cy: intrinsics of the image they were cut from, pixels.
        is_mirrored: [P] whether a proposer had better look at the image mirrored. Whoever
            looks both ways by turns errs another way each time, so that errors average out.
    """

    images: NDArray[np.float32]
    middles: Array
    halves_m: Array
    is_used: NDArray[np.bool_]
    fx: float
    fy: float
    cx: float
    cy: float
    is_mirrored: NDArray[np.bool_]

    def __post_init__(self) -> None:
        for values in (self.images, self.middles, self.halves_m, self.is_used, self.is_mirrored):
            read_only(values)

    @property
    def looked_at(self) -> NDArray[np.float32]:
        """[P, 3, 128, 128] the images as a proposer is to see them."""
        if not self.is_mirrored.any():
            return self.images
        seen = self.images.copy()
        seen[self.is_mirrored] = seen[self.is_mirrored, ..., ::-1]
        return seen

    def to_camera(self, places: Array) -> Array:
        """[P, ..., 3] places in the boxes to metres in the camera's frame."""
        focal = np.array([self.fx, self.fy])
        middles, halves_m = self._for_each_place(places.ndim)
        rays = (middles[..., :2] - [self.cx, self.cy]) / focal
        rays = rays + places[..., :2] * halves_m / middles[..., 2:]
        depth_m = middles[..., 2] + places[..., 2] * halves_m[..., 0]
        return np.concatenate([rays * depth_m[..., None], depth_m[..., None]], axis=-1)

    def from_camera(self, points_camera: Array) -> Array:
        """Inverse of `to_camera`."""
        focal = np.array([self.fx, self.fy])
        middles, halves_m = self._for_each_place(points_camera.ndim)
        rays = points_camera[..., :2] / points_camera[..., 2:]
        rays = rays - (middles[..., :2] - [self.cx, self.cy]) / focal
        across = rays * middles[..., 2:] / halves_m
        along = (points_camera[..., 2:] - middles[..., 2:]) / halves_m
        return np.concatenate([across, along], axis=-1)

    def to_cover_m(self, points_camera: Array) -> Array:
        """[P, ...] metres from each of [P, ..., 3] points to the nearest of what each window shows
        of other people before it, ways to the side counted `TIMES_ASIDE` times; infinite where it
        shows none."""
        distances_m = np.empty(points_camera.shape[:-1])
        intrinsics = self.fx, self.fy, self.cx, self.cy
        for index, points in enumerate(points_camera):
            distances_to_cover(
                self.images[index], self.middles[index], self.halves_m[index], intrinsics,
                np.ascontiguousarray(points).reshape(-1, 3), TIMES_ASIDE,
                distances_m[index].reshape(-1),
            )  # fmt: skip
        return distances_m

    def _for_each_place(self, dimensions: int) -> tuple[Array, Array]:
        shape = -1, *(1,) * (dimensions - 2)
        return self.middles.reshape(*shape, 3), self.halves_m.reshape(*shape, 1)


@dataclass(frozen=True, slots=True, eq=False)
class Box:
    """What a window is to show.

    Attributes:
        middle: [3] column, row and depth in metres of the middle of somebody's pixels, medians all
            three, the depth's of whole millimetres.
        reach_m: from there to the outermost of these pixels, to a side or up or down.
    """

    middle: Array
    reach_m: float

    def half_m(self, scale: float = 1.0) -> float:
        """From the middle to the box's sides, were the person this many times as large."""
        half_m = self.reach_m * scale + BOX_MARGIN_M
        return min(max(half_m, LEAST_HALF_BOX_M), HALF_BOX_M)


def box_of(view: DepthView, labels: NDArray[np.int32], person: int) -> Box | None:
    """The box round somebody's pixels; None where there is too little to look at. Arguments as in
    `cut_windows`."""
    height, width = labels.shape
    in_columns, in_rows = np.zeros(width, np.int32), np.zeros(height, np.int32)
    depth_mm = count_own(view.depth_m, labels, person, FARTHEST_MIDDLE_M, in_columns, in_rows)
    if in_columns.sum() < LEAST_WINDOW_PIXELS:
        return None
    column, across = middle_and_reach(in_columns, OUTERMOST_SHARE)
    row, down = middle_and_reach(in_rows, OUTERMOST_SHARE)
    middle_m = max(depth_mm / 1000.0, NEAREST_MIDDLE_M)
    reach_m = max(across / view.fx, down / view.fy) * middle_m
    return Box(np.array([column, row, middle_m]), reach_m)


def cut_windows(
    view: DepthView,
    labels: NDArray[np.int32],
    people: tuple[int, ...] | list[int],
    is_mirrored: Sequence[bool] | None = None,
) -> Windows:
    """Windows round people.

    Args:
        view: the depth of the whole image.
        labels: [H, W] id of the person that each pixel belongs to, 0 for nobody.
        people: [P] ids.
        is_mirrored: as in `Windows`; of nobody if None.
    """
    images = np.zeros((len(people), 3, WINDOW_PIXELS, WINDOW_PIXELS), np.float32)
    middles = np.full((len(people), 3), (view.cx, view.cy, 1.0))
    halves_m = np.full(len(people), HALF_BOX_M)
    is_used = np.zeros(len(people), np.bool_)
    for index, person in enumerate(people):
        box = box_of(view, labels, person)
        if box is not None:
            middle, half_m = box.middle, box.half_m()
            rows, columns = window_pixels(view, middle, half_m)
            fill_window(
                view.depth_m, labels, rows.ravel(), columns.ravel(), person, middle[2], half_m,
                NO_READING, images[index],
            )  # fmt: skip
            middles[index], halves_m[index], is_used[index] = middle, half_m, True
    mirrored = np.zeros(len(people), np.bool_) if is_mirrored is None else np.array(is_mirrored)
    return Windows(images, middles, halves_m, is_used, view.fx, view.fy, view.cx, view.cy, mirrored)


def window_pixels(
    view: DepthView, middle: Array, half_m: float
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """[128, 1] rows and [1, 128] columns of the image that a window shows; they may lie outside of
    it."""
    pixels = half_m / middle[2]
    rows, columns = _picked(middle[1], pixels * view.fy), _picked(middle[0], pixels * view.fx)
    return rows[:, None], columns[None]


def _picked(middle: float, half: float) -> NDArray[np.intp]:
    """[128] whole pixels from `middle - half` to `middle + half`.

    They are rounded as seen from the middle, which is whole or halfway between two, so that they
    are the same in a mirrored image and in one that is shifted by whole pixels.
    """
    first = ceil(middle)
    away = np.rint(_STEPS * half - (first - middle)).astype(np.intp)
    return np.concatenate([(floor(middle) - away)[::-1], first + away])


def picked_pixels(
    depth_m: NDArray[np.float32],
    labels: NDArray[np.integer],
    rows: NDArray[np.intp],
    columns: NDArray[np.intp],
) -> tuple[NDArray[np.float32], NDArray[np.integer]]:
    """[128, 128] readings, 0 for none, and whose they are; outside of the image is nothing.

    Args:
        depth_m, labels: [H, W] of the whole image.
        rows, columns: of the picked pixels; together they have the window's shape.
    """
    height, width = depth_m.shape
    is_inside = (rows >= 0) & (rows < height) & (columns >= 0) & (columns < width)
    picked = np.clip(rows, 0, height - 1), np.clip(columns, 0, width - 1)
    return np.where(is_inside, depth_m[picked], np.float32(0.0)), np.where(
        is_inside, labels[picked], 0
    )


def encode(
    seen_m: NDArray[np.float32],
    owners: NDArray[np.integer],
    person: int,
    middle_m: float,
    half_m: float,
    image: NDArray[np.float32],
) -> None:
    """Fill one [3, 128, 128] image with what it shows of a box round a person.

    Args:
        seen_m, owners: as `picked_pixels` gives them.
        person: id.
        middle_m: depth of the box's middle.
        half_m: from there to the box's front and back.
        image: is filled.
    """
    is_read = seen_m > 0.0
    offset = np.clip((seen_m.astype(np.float64) - middle_m) / half_m, -1.0, 1.0)
    image[DEPTH] = np.where(is_read, offset, NO_READING)
    image[OWN] = is_read & (owners == person)
    image[OTHER] = is_read & (owners != person) & (owners != 0)
