"""Faces by OpenCV's cascade of Haar-like features.

P. Viola and M. Jones, Rapid object detection using a boosted cascade of simple features
(CVPR 2001); the trained frontal cascade comes with OpenCV (R. Lienhart). It is learnt, but asks
for no training here, and finds faces that look at the camera, more or less upright, in grey
images too.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from topview.detect.cloud import Cloud
from topview.detect.heads import (
    CENTER_BEHIND_SURFACE_M,
    HEAD_HALF_HEIGHT_M,
    NO_HINTS,
    HeadCandidate,
    Hints,
)
from topview.records import Frame, InputError

Vector = NDArray[np.float64]

CASCADE: Final = "haarcascade_frontalface_alt2.xml"
# The cascade's training faces are 20 x 20 pixels, brow to chin and cheek to cheek: 0.16 m (ours).
LEAST_PX: Final = 20
FACE_M: Final = 0.16
# All ours: each scale's step; overlapping hits that make a face; and how much larger or smaller
# than a head's true size a hit may be.
SCALE_STEP: Final = 1.15
NEIGHBOURS: Final = 3
SIZE_FACTOR: Final = 1.6
# Ours: a hit's confidence, as a head's: frontal cascades seldom err where the size fits too.
CONFIDENCE: Final = 0.8
# Ours: a known head is looked for a face in a window of this half width, at most so many pixels.
WINDOW_M: Final = 0.22
WINDOW_PX: Final = 96


@dataclass(frozen=True, slots=True)
class Face:
    """A face that looks at the camera: left, top and side of its square in full pixels, and the
    centre of the head, [3] metres, where its depth is known."""

    left: float
    top: float
    side: float
    head_camera: Vector | None


class CascadeFaces:
    """A `HeadDetector` of faces; also looks at known heads alone, which costs a tenth."""

    def __init__(self) -> None:
        path = Path(cv2.__file__).parent / "data" / CASCADE
        if not path.is_file():
            raise InputError(f"{path}: no such file; OpenCV 4 (not 5) must be installed, with it")
        self._cascade = cv2.CascadeClassifier(str(path))

    def detect(
        self, cloud: Cloud, up_camera: Vector, hints: Hints = NO_HINTS
    ) -> list[HeadCandidate]:
        """Heads whose faces look at the camera, nearest first; nothing else is needed."""
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
        return self._faces_in(frame, grey, 0, 0, 1.0, LEAST_PX)

    def faces_of(self, frame: Frame, heads_camera: Sequence[Vector]) -> list[Face | None]:
        """The face of each of the heads ([3] centres), None where it is not seen."""
        if frame.color is None:
            return [None] * len(heads_camera)
        return [self._face_of(frame, head) for head in heads_camera]

    def _face_of(self, frame: Frame, head_camera: Vector) -> Face | None:
        assert frame.color is not None
        camera = frame.camera
        x, y, z = head_camera.tolist()
        if z <= 0.1:
            return None
        u, v, reach = camera.fx * x / z + camera.cx, camera.fy * y / z + camera.cy, WINDOW_M
        half = reach * camera.fx / z
        left, top = max(round(u - half), 0), max(round(v - half), 0)
        right, bottom = max(round(u + half), 0), max(round(v + half), 0)
        window = frame.color[top:bottom, left:right]
        if min(window.shape[:2]) < LEAST_PX // 2:
            return None
        grey = cv2.cvtColor(np.ascontiguousarray(window), cv2.COLOR_RGB2GRAY)
        scale = WINDOW_PX / (2.0 * half)
        size = max(round(grey.shape[1] * scale), 1), max(round(grey.shape[0] * scale), 1)
        grey = cv2.resize(grey, size, interpolation=cv2.INTER_AREA if scale < 1 else 1)
        least = max(int(WINDOW_PX * FACE_M / SIZE_FACTOR / (2.0 * WINDOW_M)), LEAST_PX)
        faces = self._faces_in(frame, grey, left, top, scale, least)
        return faces[0] if faces else None

    def _faces_in(
        self, frame: Frame, grey: object, left: int, top: int, scale: float, least_px: int
    ) -> list[Face]:
        squares = self._cascade.detectMultiScale(
            np.asarray(grey, np.uint8), SCALE_STEP, NEIGHBOURS, minSize=(least_px, least_px)
        )
        faces = []
        for x, y, side, _ in np.asarray(squares).reshape(-1, 4).tolist():
            at = left + x / scale, top + y / scale, side / scale
            if (face := _in_space(frame, *at)) is not None:
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
