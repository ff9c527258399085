"""Detections drawn into images: masks, probabilities, blobs with their beliefs, heads."""

from __future__ import annotations

from collections.abc import Iterable
from types import MappingProxyType
from typing import Any, Final

import cv2
import numpy as np
from numpy.typing import NDArray

from topview.detect.beliefs import Kind
from topview.detect.faces_and_hands import SkinBlob
from topview.records import Frame
from topview.view.drawing import Image, draw_line, pixels_of, resized_mask
from topview.view.labels import Labels
from topview.view.palette import MUTED, OUTLINE, TEXT, Color

KIND_COLORS: Final = MappingProxyType(
    {
        Kind.FACE: (240, 228, 66),
        Kind.LEFT_HAND: (0, 178, 132),
        Kind.RIGHT_HAND: (204, 121, 167),
        Kind.OTHER: MUTED,
    }
)
KIND_LETTERS: Final = MappingProxyType({Kind.FACE: "F", Kind.LEFT_HAND: "L", Kind.RIGHT_HAND: "R"})
DIMMED: Final = 0.3
"""Brightness of what is outside of a mask, as a share (ours)."""


def draw_mask(image: Image, mask: NDArray[np.bool_]) -> None:
    """Dim what is outside of a mask [h, w], which may have fewer pixels than the image."""
    is_out = ~resized_mask(mask, (image.shape[1], image.shape[0]))
    image[is_out] = (image[is_out] * DIMMED).astype(np.uint8)


def probability_picture(probability: NDArray[np.uint8], size_px: tuple[int, int]) -> Image:
    """A [h, w] probability in 1/255 as dark to bright, at (width, height)."""
    levels = cv2.resize(probability, size_px, interpolation=cv2.INTER_NEAREST)
    colored = np.asarray(cv2.applyColorMap(levels, cv2.COLORMAP_INFERNO), np.uint8)
    return np.ascontiguousarray(colored[..., ::-1])


def draw_blob(image: Image, labels: Labels, blob: SkinBlob, scale: float = 1.0) -> None:
    """A blob's ellipse in the colour of its kind, thin where it is only predicted; of faces and
    hands with its number, its kind's letter and the belief in it in percent."""
    kind = blob.kind
    color = KIND_COLORS[kind]
    ellipse = blob.ellipse.scaled(scale, 0.5 * scale - 0.5)
    width_px = 2 if blob.is_seen else 1
    for shade, width in ((OUTLINE, width_px + 2), (color, width_px)):
        _draw_ellipse(image, ellipse.center, (ellipse.major, ellipse.minor), ellipse.angle,
                      shade, width)  # fmt: skip
    if kind == Kind.OTHER:
        return
    label = f"{blob.id} {KIND_LETTERS[kind]} {100 * float(blob.belief[kind]):.0f}"
    above = ellipse.y - max(ellipse.minor, abs(ellipse.major * np.sin(ellipse.angle))) - 3
    labels.put(label, (ellipse.x, above), color)


def draw_heads(image: Image, frame: Frame, heads_camera: Iterable[NDArray[np.float64]]) -> None:
    """A cross at each head ([3] metres)."""
    scale = image.shape[1] / frame.camera.width
    for head in heads_camera:
        if not np.isfinite(head).all() or head[2] <= 0.0:
            continue
        at = pixels_of(head[None], frame.camera, scale)[0]
        for arm in np.array([[5.0, 0.0], [0.0, 5.0]]):
            draw_line(image, at - arm, at + arm, OUTLINE, 4)
            draw_line(image, at - arm, at + arm, TEXT, 2)


def skin_picture(rgb: Image, probability: NDArray[np.uint8], is_skin: NDArray[np.bool_]) -> Image:
    """Three panels side by side, [H, 3 W, 3]: an image, P(skin), and the regions found in it."""
    height, width = rgb.shape[:2]
    found = rgb.copy()
    draw_mask(found, is_skin)
    return np.hstack([rgb, probability_picture(probability, (width, height)), found])


def _draw_ellipse(
    image: Image,
    center: NDArray[Any],
    semi_axes: tuple[float, float],
    angle_rad: float,
    color: Color,
    width_px: int,
) -> None:
    box = (center[0], center[1]), (2 * semi_axes[0], 2 * semi_axes[1]), np.degrees(angle_rad)
    cv2.ellipse(image, box, color, width_px, cv2.LINE_AA)
