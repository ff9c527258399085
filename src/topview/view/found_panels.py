"""How people were found in a frame, in panels: masks, skin, blobs, heads, the overview."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from topview.camera.pyramid import Pyramid
from topview.people.existence import TOO_NEAR
from topview.people.output import Found
from topview.people.users import User
from topview.records import Frame
from topview.room.scene import Scene
from topview.view.detections import draw_blob, draw_heads, draw_mask, probability_picture
from topview.view.drawing import (
    Image,
    draw_line,
    draw_text,
    pixels_of,
    resized,
    resized_mask,
)
from topview.view.frame_picture import frame_picture
from topview.view.labels import Labels
from topview.view.palette import (
    GRID_LINE,
    GRID_LINE_STRONG,
    GROUND,
    MUTED,
    OUTLINE,
    PANEL,
    TEXT,
    Color,
    mix,
    person_color,
)

# The look of the panels: all ours.
FOUND_PANEL_PX: Final = (272, 204)  # six rows of them are not quite 1600 pixels high
TITLE_PX: Final = 20
GAP_PX: Final = 6
FOUND_CAPTION_PX: Final = 26
TINT: Final = 0.45
HEAD_PX: Final = 7  # radius of what marks a head
REFUSAL_LINES: Final = 2  # by which a refusal's label may move, before it is left out
OVERVIEW_FROM_M: Final = 0.5  # from the camera to the nearest floor that the overview shows


def paint_found(found: Found) -> Image:
    """Six panels of one frame in a row, or three without colours, with a caption."""
    frame = found.scene.cloud.frame
    colors, why = _colors(found, frame)
    panels = [
        ("users and their areas; rings: heads refused", _users(found)),
        ("overview", _overview(found)),
        ("depth: neither floor, wall nor room", _masked(frame, found.scene.is_free_standing)),
        *colors,
    ]
    row = _beside([_titled(title, panel) for title, panel in panels])
    caption = np.full((FOUND_CAPTION_PX, row.shape[1], 3), GROUND, np.uint8)
    used = draw_text(caption, f"frame {frame.index}", (14, 18), 10, TEXT)
    used += draw_text(caption, f"{frame.timestamp_s:.2f} s", (14 + used + 14, 18), 10, MUTED)
    draw_text(caption, why, (14 + used + 36, 18), 8, MUTED)
    return np.vstack([caption, row])


def _users(found: Found) -> Image:
    scene = found.scene
    frame = scene.cloud.frame
    picture = frame_picture(frame)
    height, width = picture.shape[:2]
    for user in reversed(found.users):
        is_users = np.zeros(height * width, np.bool_)
        is_users[user.pixels] = True
        area = is_users.reshape(height, width)
        color = np.array(person_color(user.id))
        picture[area] = np.round(picture[area] * (1.0 - TINT) + TINT * color).astype(np.uint8)
    picture = _fitted(picture)
    draw_heads(picture, frame, [user.head_camera for user in found.users])
    # Those too near to a user are a shoulder, mostly.
    refusals = [refusal for refusal in found.refusals if refusal.reason != TOO_NEAR]
    refused = [refusal.head.center_camera for refusal in refusals]
    labels = Labels(picture)
    for center in refused:
        at = _place(picture, frame, center)
        cv2.circle(picture, (round(at[0]), round(at[1])), HEAD_PX, MUTED, 1, cv2.LINE_AA)
    for center in (*(user.head_camera for user in found.users), *refused):
        labels.avoid(_place(picture, frame, center), HEAD_PX)
    for user in found.users:
        place = _place(picture, frame, user.head_camera)
        _label(labels, user.head_camera, place, _caption_of(user), person_color(user.id))
    for refusal, center in zip(refusals, refused, strict=True):
        reason = f"{100 * refusal.head.confidence:.0f} % {refusal.reason}"
        place = _place(picture, frame, center)
        _label(labels, center, place, reason, MUTED, most_lines=REFUSAL_LINES)
    return picture


def _caption_of(user: User) -> str:
    caption = f"{user.id}: {user.height_m:.2f} m" if user.height_is_measured else f"{user.id}"
    if not user.head_is_seen:
        caption += ", head not seen"
    if user.face_share is not None:
        caption += f", face {100 * user.face_share:.0f} %"
    return caption


def _overview(found: Found) -> Image:
    """The scene from above, the camera at the bottom, a grid of metres."""
    scene = found.scene
    width, height = FOUND_PANEL_PX
    picture = np.full((height, width, 3), PANEL, np.uint8)
    is_seen = scene.cloud.has_reading
    ahead_m = scene.overview_m[is_seen][:, 1]
    farthest_m = max(float(np.quantile(ahead_m, 0.98)), 2.0) if len(ahead_m) else 2.0
    scale = min((height - 16) / (farthest_m - OVERVIEW_FROM_M + 0.3), width / (0.9 * farthest_m))

    def place(right_forward_m: NDArray[np.floating]) -> NDArray[np.float64]:
        right, forward = np.moveaxis(np.asarray(right_forward_m, np.float64), -1, 0)
        return np.stack(
            [width / 2 + scale * right, height - 8 - scale * (forward - OVERVIEW_FROM_M)], axis=-1
        )

    for metre in range(-8, 12):
        strength = GRID_LINE_STRONG if metre == 0 else GRID_LINE
        ahead, across = [[metre, 0.0], [metre, 12.0]], [[-8.0, metre], [8.0, metre]]
        for ends, color in ((ahead, strength), (across, GRID_LINE)):
            start, end = place(np.array(ends))
            draw_line(picture, start, end, color)
        if metre > 0:
            draw_text(picture, f"{metre} m", (6, place(np.array([0.0, metre]))[1] - 3), 7, MUTED)
    _draw_points(picture, place(scene.overview_m[scene.is_free_standing]), MUTED)
    for user in reversed(found.users):
        color = person_color(user.id)
        _draw_points(picture, place(_overview_of_user(scene, user)), mix(color, PANEL, 0.35))
    labels = Labels(picture)
    for user in reversed(found.users):
        x, y = place(scene.overview_of(user.head_camera)).tolist()
        radius = max(round(0.12 * scale), 4)
        cv2.circle(picture, (round(x), round(y)), radius + 1, OUTLINE, 2, cv2.LINE_AA)
        cv2.circle(picture, (round(x), round(y)), radius, person_color(user.id), 2, cv2.LINE_AA)
        labels.put(str(user.id), (x, y - radius - 4), person_color(user.id))
    return picture


def _overview_of_user(scene: Scene, user: User) -> NDArray[np.float64]:
    frame = scene.cloud.frame
    rows, columns = np.divmod(user.pixels[::4], frame.camera.width)
    return scene.overview_of(Pyramid(frame).full.points(rows, columns))


def _draw_points(picture: Image, places: NDArray[np.float64], color: Color) -> None:
    columns, rows = np.round(places).astype(int).T
    is_in = (rows >= 0) & (rows < picture.shape[0]) & (columns >= 0) & (columns < picture.shape[1])
    picture[rows[is_in], columns[is_in]] = color


def _masked(frame: Frame, mask: NDArray[np.bool_]) -> Image:
    picture = frame_picture(frame)
    draw_mask(picture, mask)
    return _fitted(picture)


def _colors(found: Found, frame: Frame) -> tuple[list[tuple[str, Image]], str]:
    """What was detected by colour, or nothing, and why."""
    detections = found.skin_detections
    if (
        detections is None
        or detections.is_foreground is None
        or detections.skin_probability is None
        or detections.is_skin is None
    ):
        return [], "colour is not used" if detections is None else str(detections.light)
    blobs = _fitted(frame_picture(frame))
    labels = Labels(blobs)
    for blob in detections.blobs:
        draw_blob(blobs, labels, blob, blobs.shape[1] / frame.camera.width)
    skin = probability_picture(
        detections.skin_probability, (frame.camera.width, frame.camera.height)
    )
    is_outside = ~resized_mask(detections.is_skin, (frame.camera.width, frame.camera.height))
    skin[is_outside] = skin[is_outside] // 2
    panels = [
        ("colour and depth: foreground", _masked(frame, detections.is_foreground)),
        ("P(skin), bright where it is a region", _fitted(skin)),
        ("Face, Left, Right hand; belief in %", blobs),
    ]
    return panels, "the light has changed" if detections.light_changed else ""


def _fitted(picture: Image) -> Image:
    """As wide as a panel, or narrower where it would be too high."""
    height, width = picture.shape[:2]
    scale = min(FOUND_PANEL_PX[0] / width, FOUND_PANEL_PX[1] / height)
    return resized(picture, (max(round(scale * width), 1), max(round(scale * height), 1)))


def _titled(title: str, picture: Image) -> Image:
    """As wide as a panel."""
    height, width = picture.shape[:2]
    panel = np.full((TITLE_PX + height, FOUND_PANEL_PX[0], 3), GROUND, np.uint8)
    draw_text(panel[:TITLE_PX], title, (2, TITLE_PX - 8), 8, MUTED)
    panel[TITLE_PX:, :width] = picture
    return panel


def _beside(panels: Sequence[Image]) -> Image:
    height = max(panel.shape[0] for panel in panels)
    row = np.full((height + GAP_PX, row_px(len(panels)), 3), GROUND, np.uint8)
    for column, panel in enumerate(panels):
        left = GAP_PX + column * (FOUND_PANEL_PX[0] + GAP_PX)
        row[: panel.shape[0], left : left + FOUND_PANEL_PX[0]] = panel
    return row


def row_px(panels: int) -> int:
    """Pixels from the left to the right of so many panels."""
    return panels * (FOUND_PANEL_PX[0] + GAP_PX) + GAP_PX


def _place(picture: Image, frame: Frame, point_camera: NDArray[np.float64]) -> NDArray[np.float64]:
    scale = picture.shape[1] / frame.camera.width
    return pixels_of(point_camera[None], frame.camera, scale)[0]


def _label(
    labels: Labels,
    head_camera: NDArray[np.float64],
    at: NDArray[np.float64],
    text: str,
    color: Color,
    most_lines: int | None = None,
) -> None:
    if head_camera[2] > 0.0:
        labels.put(text, (float(at[0]), float(at[1]) - 14.0), color, most_lines=most_lines)
