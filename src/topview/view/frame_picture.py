"""A frame as a picture: its colours or its depth, with everybody's skeleton over it."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from topview.records import Frame, Person
from topview.view.drawing import Image, draw_skeleton, pixels_of, resized
from topview.view.labels import Labels
from topview.view.palette import GROUND, MUTED, PANEL, person_color


def frame_picture(frame: Frame) -> Image:
    """The colour image, a little dimmed, or else the depth as grey: near is light."""
    if frame.color is not None:
        return np.round(frame.color * 0.8).astype(np.uint8)
    known = frame.depth_m > 0.0
    if not known.any():
        return np.full((*known.shape, 3), GROUND, np.uint8)
    light = _relief(frame) * (1.0 - 0.75 * _rank(frame.depth_m, known))
    lightest, darkest = np.array(MUTED), np.array(PANEL)
    picture = darkest + light[..., None] * (lightest - darkest)
    return np.where(known[..., None], picture, GROUND).astype(np.uint8)


def _rank(depth_m: NDArray[np.float32], known: NDArray[np.bool_]) -> NDArray[np.float64]:
    """[H, W] rank of each depth: 0 for the nearest pixel, 1 for the farthest."""
    edges = np.quantile(depth_m[known], np.linspace(0.0, 1.0, 65))
    return np.interp(depth_m, edges, np.linspace(0.0, 1.0, 65))


def _relief(frame: Frame) -> NDArray[np.float64]:
    """[H, W] 0..1, how much each surface faces the camera."""
    smooth = cv2.GaussianBlur(frame.depth_m, (0, 0), 1.5)
    step_m = np.maximum(smooth, 1e-3) / frame.camera.fx
    slope_x, slope_y = (cv2.Sobel(smooth, cv2.CV_32F, *d, ksize=3) / 8.0 for d in ((1, 0), (0, 1)))
    return 1.0 / np.sqrt(1.0 + 0.15 * (slope_x**2 + slope_y**2) / step_m**2)


def frame_with_skeletons(frame: Frame, people: Sequence[Person], size_px: tuple[int, int]) -> Image:
    """The frame fitted into (width, height) with every person's skeleton over it, nearest last.

    A joint is drawn where the camera sees it: at `project(joint)`, scaled as the image is.
    """
    width, height = size_px
    camera = frame.camera
    scale = min(width / camera.width, height / camera.height)
    fitted = max(round(camera.width * scale), 1), max(round(camera.height * scale), 1)
    picture = resized(frame_picture(frame), fitted)
    labels = Labels(picture)
    for person in sorted(people, key=lambda person: -float(person.joints_camera[0, 2])):
        joints_px = pixels_of(person.joints_camera, camera, scale)
        draw_skeleton(picture, person, joints_px)
        _label_head(labels, person, joints_px)
    panel = np.full((height, width, 3), GROUND, np.uint8)
    left, top = (width - fitted[0]) // 2, (height - fitted[1]) // 2
    panel[top : top + fitted[1], left : left + fitted[0]] = picture
    return panel


def _label_head(labels: Labels, person: Person, joints_px: NDArray[np.floating]) -> None:
    head, neck = joints_px[0], joints_px[1]
    if np.isfinite(head).all() and np.isfinite(neck).all():
        above = head[1] - 1.2 * abs(neck[1] - head[1]) - 6
        labels.put(str(person.id), (float(head[0]), float(above)), person_color(person.id), 10)
