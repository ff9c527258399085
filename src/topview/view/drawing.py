"""Anti-aliased primitives in images, and the skeleton over a frame.

Images are [H, W, 3] uint8 RGB and are drawn into; places are pixels (x right, y down), pixel
centres at integers, and may fall between pixels.
"""

from __future__ import annotations

from typing import Any, Literal

import cv2
import numpy as np
from numpy.typing import NDArray

from topview.body import OUTPUT_JOINTS
from topview.camera import project
from topview.records import Camera, JointState, Person
from topview.view.palette import OUTLINE, Color, mix, person_color

Image = NDArray[np.uint8]
Align = Literal["left", "centre", "right"]

# The look of the drawings: all ours.
FONT = cv2.FONT_HERSHEY_SIMPLEX
TEXT_OVERSAMPLING = 4  # OpenCV's stroke fonts look ragged at reading size, clean when reduced
DASHES_PX = 12.0  # from dash to dash of a dashed line
DASH = (0.3, 0.7)  # where one begins and ends, as shares of that; its ends are round
MOST_DASHED_PX = 5000.0  # a longer line leaves the picture, and is not worth its dashes
SUBPIXEL_BITS = 4  # fractional bits of the places that OpenCV draws at

SEEN = (JointState.VISIBLE, JointState.OUT_OF_VIEW)


def resized(image: Image, size_px: tuple[int, int]) -> Image:
    """The image at (width, height): averaged when it shrinks, interpolated when it grows."""
    shrinks = size_px[0] < image.shape[1]
    how = cv2.INTER_AREA if shrinks else cv2.INTER_LINEAR
    return np.asarray(cv2.resize(image, size_px, interpolation=how), np.uint8)


def draw_line(
    image: Image, start: NDArray[Any], end: NDArray[Any], color: Color, width_px: int = 1
) -> None:
    """A straight line; not drawn where an end is NaN."""
    if np.isfinite(start).all() and np.isfinite(end).all():
        cv2.line(image, _fixed(start), _fixed(end), color, width_px, cv2.LINE_AA, SUBPIXEL_BITS)


def draw_text(
    image: Image,
    text: str,
    at: tuple[float, float],
    height_px: float,
    color: Color,
    align: Align = "left",
) -> float:
    """Text whose capitals are `height_px` high, on a baseline that starts, is centred or ends at
    `at`; returns its width in pixels."""
    height, thickness, scale = _pen(height_px)
    (width, _), below = cv2.getTextSize(text, FONT, scale, thickness)
    margin = 2 * thickness
    ink = np.zeros((height + below + 2 * margin, width + 2 * margin), np.uint8)
    cv2.putText(ink, text, (margin, margin + height), FONT, scale, 255, thickness, cv2.LINE_AA)
    rows, columns = (-(-side // TEXT_OVERSAMPLING) for side in ink.shape)
    reduced = resized(ink, (columns, rows))
    width_px = width / TEXT_OVERSAMPLING
    left = at[0] - {"left": 0.0, "centre": 0.5, "right": 1.0}[align] * width_px
    corner = (
        round(left - margin / TEXT_OVERSAMPLING),
        round(at[1] - (height + margin) / TEXT_OVERSAMPLING),
    )
    _blend(image, reduced, corner, color)
    return width_px


def text_width(text: str, height_px: float) -> float:
    """Pixels that `draw_text` takes."""
    _, thickness, scale = _pen(height_px)
    return cv2.getTextSize(text, FONT, scale, thickness)[0][0] / TEXT_OVERSAMPLING


def _pen(height_px: float) -> tuple[int, int, float]:
    """Height and thickness in oversampled pixels, and OpenCV's scale, of a text."""
    height = round(height_px * TEXT_OVERSAMPLING)
    thickness = max(1, round(height * 0.13))
    return height, thickness, cv2.getFontScaleFromHeight(FONT, height, thickness)


def draw_label(
    image: Image, text: str, at: tuple[float, float], color: Color, height_px: float = 8
) -> None:
    """Text centred on a place, with an outline."""
    for dx, dy in ((-1, 0), (1, 0), (0, -1), (0, 1)):
        draw_text(image, text, (at[0] + dx, at[1] + dy), height_px, OUTLINE, "centre")
    draw_text(image, text, at, height_px, color, "centre")


def draw_joint(
    image: Image, at: NDArray[Any], state: JointState, color: Color, radius_px: float = 4.0
) -> None:
    """The marker of a joint's state: a disc where it is visible, a ring behind the own
    body, a diamond behind another person, a square behind an object, a cross out of view."""
    if not np.isfinite(at).all():
        return
    if state == JointState.VISIBLE:
        cv2.circle(
            image, _fixed(at), _length(radius_px + 1), OUTLINE, -1, cv2.LINE_AA, SUBPIXEL_BITS
        )
        cv2.circle(image, _fixed(at), _length(radius_px), color, -1, cv2.LINE_AA, SUBPIXEL_BITS)
    elif state == JointState.SELF_OCCLUDED:
        cv2.circle(image, _fixed(at), _length(radius_px), OUTLINE, -1, cv2.LINE_AA, SUBPIXEL_BITS)
        cv2.circle(image, _fixed(at), _length(radius_px), color, 1, cv2.LINE_AA, SUBPIXEL_BITS)
    elif state in (JointState.OCCLUDED_BY_PERSON, JointState.OCCLUDED_BY_OBJECT):
        turn = 0.0 if state == JointState.OCCLUDED_BY_PERSON else np.pi / 4
        angles = turn + np.arange(4) * np.pi / 2
        corners = at + 1.25 * radius_px * np.stack([np.cos(angles), np.sin(angles)], axis=-1)
        fixed = np.round(corners * 2**SUBPIXEL_BITS).astype(np.int32)
        cv2.fillPoly(image, [fixed], OUTLINE, cv2.LINE_AA, SUBPIXEL_BITS)
        cv2.polylines(image, [fixed], True, color, 1, cv2.LINE_AA, SUBPIXEL_BITS)
    elif state == JointState.OUT_OF_VIEW:
        for dx, dy in ((1, 1), (1, -1)):
            arm = 0.8 * radius_px * np.array([dx, dy])
            draw_line(image, at - arm, at + arm, color)


def draw_bone(
    image: Image,
    ends_px: tuple[NDArray[Any], NDArray[Any]],
    color: Color,
    width_px: int,
    is_dashed: bool,
) -> None:
    """A line with an outline, dashed for a bone of the person's right; not drawn where an end is
    NaN."""
    start, end = ends_px
    draw_line(image, start, end, OUTLINE, width_px + 2)
    length_px = float(np.linalg.norm(end - start))
    if not is_dashed or not DASHES_PX < length_px < MOST_DASHED_PX:
        draw_line(image, start, end, color, width_px)
        return
    dashes = round(length_px / DASHES_PX)
    for k in range(dashes):
        a, b = (start + (end - start) * (k + side) / dashes for side in DASH)
        draw_line(image, a, b, color, width_px)


def draw_skeleton(image: Image, person: Person, joints_px: NDArray[np.floating]) -> None:
    """The bones and joints of a person at the pixels [J, 2]; bones to hidden joints are thin, those
    of the person's right dashed."""
    color = person_color(person.id)
    bones = [(j, joint.bone_to) for j, joint in enumerate(OUTPUT_JOINTS) if joint.bone_to >= 0]
    hidden = [state not in SEEN for state in person.joint_state]
    for j, towards_root in bones:
        ends = joints_px[j], joints_px[towards_root]
        is_dashed = OUTPUT_JOINTS[j].name.startswith("right_")
        if hidden[j] or hidden[towards_root]:
            draw_bone(image, ends, mix(color, OUTLINE, 0.25), 1, is_dashed)
        else:
            draw_bone(image, ends, color, 3, is_dashed)
    for j in reversed(range(len(OUTPUT_JOINTS))):  # hands over wrists, which are near
        draw_joint(image, joints_px[j], JointState(int(person.joint_state[j])), color)


def png_of(picture: Image) -> bytes:
    """A PNG file's bytes."""
    _, encoded = cv2.imencode(".png", cv2.cvtColor(picture, cv2.COLOR_RGB2BGR))
    return encoded.tobytes()


def pixels_of(
    points_camera: NDArray[np.float64], camera: Camera, scale: float
) -> NDArray[np.float64]:
    """[N, 2] pixels of [N, 3] points in a camera's image that is drawn `scale` times as large."""
    return (project(points_camera, camera) + 0.5) * scale - 0.5


def resized_mask(mask: NDArray[np.bool_], size_px: tuple[int, int]) -> NDArray[np.bool_]:
    """[height, width] of a [h, w] mask."""
    if mask.shape == size_px[::-1]:
        return mask
    large = cv2.resize(mask.view(np.uint8), size_px, interpolation=cv2.INTER_NEAREST)
    return np.asarray(large, np.uint8) > 0


def _blend(image: Image, ink: Image, corner: tuple[int, int], color: Color) -> None:
    """Blend `color` into the image by the coverage `ink`, which may reach over the edges."""
    left, top = corner
    height, width = image.shape[:2]
    x0, x1 = max(left, 0), min(left + ink.shape[1], width)
    y0, y1 = max(top, 0), min(top + ink.shape[0], height)
    if x0 >= x1 or y0 >= y1:
        return
    share = ink[y0 - top : y1 - top, x0 - left : x1 - left, None] / 255.0
    under = image[y0:y1, x0:x1]
    image[y0:y1, x0:x1] = np.round(under + share * (np.array(color) - under)).astype(np.uint8)


def _fixed(place: NDArray[Any]) -> tuple[int, int]:
    """In OpenCV's fixed point, kept to where its 32-bit integers hold."""
    x, y = np.clip(np.round(np.asarray(place, float) * 2**SUBPIXEL_BITS), -(2**24), 2**24)
    return int(x), int(y)


def _length(radius_px: float) -> int:
    return round(radius_px * 2**SUBPIXEL_BITS)
