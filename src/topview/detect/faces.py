"""Faces by OpenCV's cascade of Haar-like features.

P. Viola and M. Jones, Rapid object detection using a boosted cascade of simple features
(CVPR 2001); the trained frontal cascade comes with OpenCV (R. Lienhart). It detects faces that look
at the camera, more or less upright, in grey images too.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import cv2
import numpy as np
from numpy.typing import NDArray

from topview.detect.cloud import Cloud
from topview.detect.color_view import DIM_LEVEL
from topview.detect.heads import (
    CENTER_BEHIND_SURFACE_M,
    HEAD_HALF_HEIGHT_M,
    NO_HINTS,
    HeadCandidate,
    Hints,
)
from topview.filter.over_time import Turns
from topview.records import Frame, InputError

Vector = NDArray[np.float64]

CASCADE: Final = "haarcascade_frontalface_alt2.xml"
# The cascade's training faces are 20 x 20 pixels, brow to chin and cheek to cheek: 0.16 m (ours).
LEAST_PX: Final = 20
FACE_M: Final = 0.16
# All ours: from one scale to the next; overlapping hits that make a face; and the factor by which a
# hit may be larger or smaller than a face's true size.
SCALE_STEP: Final = 1.15
NEIGHBOURS: Final = 3
SIZE_FACTOR: Final = 1.6
# Ours: of a head whose face is detected: the cascade seldom errs where the size fits too.
CONFIDENCE: Final = 0.8
# All ours: the face of a known head is searched in a window of this half width, resized to this
# side, in which it can have few sizes.
FACE_WINDOW_M: Final = 0.18
WINDOW_PX: Final = 60
GREATEST_PX: Final = 40
WINDOW_NEIGHBOURS: Final = 2
# All ours: a face of fewer pixels, or in a window of which less is in view, cannot be detected.
LEAST_SEEN_PX: Final = 14
LEAST_SHARE_IN_VIEW: Final = 0.6
# Ours: seconds from one head that is checked to the next.
FACE_CHECK_S: Final = 1 / 30


@dataclass(frozen=True, slots=True)
class Face:
    """A face that looks at the camera: left, top and side of its square in full pixels, and the
    centre of the head, [3] metres, where its depth is known."""

    left: float
    top: float
    side: float
    head_camera: Vector | None


class CascadeFaces:
    """A `HeadDetector` by frontal faces. It also checks known heads alone, at a hundredth of the
    cost."""

    def __init__(self) -> None:
        path = Path(cv2.__file__).parent / "data" / CASCADE
        if not path.is_file():
            raise InputError(f"{path}: no such file; OpenCV 4 (not 5) must be installed, with it")
        self._cascade = cv2.CascadeClassifier(str(path))
        self._turn = 0
        self._turns = Turns(FACE_CHECK_S)

    @property
    def needs_color(self) -> bool:
        return True

    @property
    def colors(self) -> None:
        """None: it gives no skin detections."""

    def detect(
        self, cloud: Cloud, up_camera: Vector, hints: Hints = NO_HINTS
    ) -> list[HeadCandidate]:
        """Heads whose faces look at the camera, nearest first; the hints are not used."""
        heads = [face.head_camera for face in self.faces(cloud.frame)]
        return sorted(
            (HeadCandidate(head, CONFIDENCE) for head in heads if head is not None),
            key=lambda head: float(head.center_camera[2]),
        )

    def faces(self, frame: Frame) -> list[Face]:
        """All faces in a frame, largest first."""
        if frame.color is None:
            return []
        grey = cv2.cvtColor(frame.color, cv2.COLOR_RGB2GRAY)
        least = LEAST_PX, LEAST_PX
        squares = self._cascade.detectMultiScale(grey, SCALE_STEP, NEIGHBOURS, minSize=least)
        return _faces_of_squares(frame, squares, 0, 0, 1.0)

    def faces_at(self, frame: Frame, heads_camera: Sequence[Vector]) -> list[Face | None]:
        """The face of each of the heads ([3] centres), None where none is detected."""
        windows = [_Window.around(frame, head) for head in heads_camera]
        faces = [[] if window is None else self._faces_at(frame, window) for window in windows]
        return [found[0] if found else None for found in faces]

    def is_frontal(self, frame: Frame, head_camera: Vector) -> bool | None:
        """Whether the face of this head ([3], its centre) looks at the camera; None where it is too
        small, too dark or too little in view, or there is no colour."""
        window = _Window.around(frame, head_camera)
        if window is None or not window.is_usable:
            return None
        return bool(self._faces_at(frame, window))

    def check_faces_in_turn(
        self, frame: Frame, heads_camera: Sequence[Vector]
    ) -> list[tuple[int, bool | None]]:
        """Check the heads in turn, another one every `FACE_CHECK_S`: their indices, and
        `is_frontal` of each."""
        turns = min(self._turns.due(frame.timestamp_s), len(heads_camera))
        indices = [(self._turn + i) % len(heads_camera) for i in range(turns)]
        self._turn += turns
        return [(index, self.is_frontal(frame, heads_camera[index])) for index in indices]

    def _faces_at(self, frame: Frame, window: _Window) -> list[Face]:
        sizes = (LEAST_PX, LEAST_PX), (GREATEST_PX, GREATEST_PX)
        squares = self._cascade.detectMultiScale(
            window.grey, SCALE_STEP, WINDOW_NEIGHBOURS, minSize=sizes[0], maxSize=sizes[1]
        )
        return _faces_of_squares(frame, squares, window.left, window.top, window.scale)


@dataclass(frozen=True, slots=True)
class _Window:
    """The surroundings of a head.

    Attributes:
        grey: [h, w], resized.
        left, top: its first full pixel.
        scale: its pixels per full pixel.
        is_usable: whether a face would be detected in it.
    """

    grey: NDArray[np.uint8]
    left: int
    top: int
    scale: float
    is_usable: bool

    @classmethod
    def around(cls, frame: Frame, head_camera: Vector) -> _Window | None:
        """None where there is nothing in view, or no colour."""
        x, y, z = head_camera.tolist()
        if frame.color is None or z <= 0.1:
            return None
        camera = frame.camera
        u, v = camera.fx * x / z + camera.cx, camera.fy * y / z + camera.cy
        half = FACE_WINDOW_M * camera.fx / z
        left, right = (min(max(round(u + side), 0), camera.width) for side in (-half, half))
        top, bottom = (min(max(round(v + side), 0), camera.height) for side in (-half, half))
        scale = WINDOW_PX / (2.0 * half)
        width, height = round((right - left) * scale), round((bottom - top) * scale)
        if min(width, height) < LEAST_PX:
            return None
        window = frame.color[top:bottom, left:right]
        way = cv2.INTER_AREA if scale < 1.0 else cv2.INTER_LINEAR
        small = cv2.resize(window, (width, height), interpolation=way)
        grey = np.asarray(cv2.cvtColor(small, cv2.COLOR_RGB2GRAY), np.uint8)
        is_usable = (
            FACE_M * camera.fx / z >= LEAST_SEEN_PX
            and width * height >= LEAST_SHARE_IN_VIEW * WINDOW_PX**2
            and float(grey.mean()) >= DIM_LEVEL
        )
        return cls(grey, left, top, scale, is_usable)


def _faces_of_squares(frame: Frame, squares: Any, left: int, top: int, scale: float) -> list[Face]:
    """Hits of a head's size, largest first."""
    faces = []
    for x, y, side, _ in np.asarray(squares).reshape(-1, 4).tolist():
        face = _in_space(frame, left + x / scale, top + y / scale, side / scale)
        if face is not None:
            faces.append(face)
    return sorted(faces, key=lambda face: -face.side)


def _in_space(frame: Frame, left: float, top: float, side: float) -> Face | None:
    """A hit with its head in 3D; None if it is not of a head's true size."""
    quarter = side / 4.0
    rows = slice(int(top + quarter), int(top + 3.0 * quarter) + 1)
    columns = slice(int(left + quarter), int(left + 3.0 * quarter) + 1)
    depths = frame.depth_m[rows, columns]
    depths = depths[depths > 0.0]
    if not len(depths):
        return Face(left, top, side, None)
    depth_m, camera = float(np.median(depths)), frame.camera
    side_m = side * depth_m / camera.fx
    if not FACE_M / SIZE_FACTOR < side_m < FACE_M * SIZE_FACTOR:
        return None
    # A face's square ends at the chin; the head's centre is half a head above that.
    u, v = left + side / 2.0, top + side - HEAD_HALF_HEIGHT_M * camera.fy / depth_m
    surface = depth_m * np.array([(u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, 1.0])
    distance_m = float(np.linalg.norm(surface))
    return Face(left, top, side, surface * (1.0 + CENTER_BEHIND_SURFACE_M / distance_m))
