"""One picture of how people were found in a recording: masks, skin, blobs, heads, the overview."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from topview.camera.pyramid import Pyramid
from topview.people.existence import TOO_NEAR
from topview.people.finder import Found
from topview.people.scene import Scene
from topview.people.users import User
from topview.records import Frame, InputError, Person
from topview.view.detections import draw_blob, draw_heads, draw_mask, probability_picture
from topview.view.drawing import (
    Image,
    draw_label,
    draw_line,
    draw_text,
    frame_picture,
    pixels_of,
    png_of,
    resized,
    resized_mask,
)
from topview.view.even_choice import EvenChoice
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

# The look of the sheet: all ours.
EVEN_MOMENTS: Final = 5
CHANGED_MOMENTS: Final = 5  # at most: when somebody comes or goes
FOUND_PANEL_PX: Final = (400, 300)
MOST_PANEL_HEIGHT_PX: Final = 1200  # of a picture three times as high as it is wide
TITLE_PX: Final = 26
GAP_PX: Final = 6
FOUND_CAPTION_PX: Final = 30
FOUND_HEADER_PX: Final = 56
TINT: Final = 0.45
LETTER_PX: Final = 7.0  # of a label, on average
OVERVIEW_FROM_M: Final = 0.5  # from the camera to the nearest floor that the overview shows


class PeopleSheet:
    """A viewer that keeps pictures of how people were found, and joins them when it is painted.

    Args:
        title: the recording's name.
        frame_count: how many frames the recording should have; None if nobody knows.
        found: gives what was found in the frame that is shown.
    """

    def __init__(
        self, title: str, frame_count: int | None, found: Callable[[], Found | None]
    ) -> None:
        self.title = title
        self._found = found
        self._even: EvenChoice[tuple[int, Image]] = EvenChoice(EVEN_MOMENTS, frame_count)
        self._changes: list[tuple[int, Image]] = []
        self._ids: set[int] = set()
        self._shown = 0

    def show(self, frame: Frame, people: Sequence[Person]) -> None:
        """Keep a picture if the frame's turn has come, or if somebody has come or gone."""
        found = self._found()
        if found is None:
            return
        ids = {user.id for user in found.users}
        has_changed = self._shown > 0 and ids != self._ids and len(self._changes) < CHANGED_MOMENTS
        if self._even.next_is_due():
            self._even.keep((self._shown, paint_found(found)))
        elif has_changed:
            self._changes.append((self._shown, paint_found(found)))
        self._ids = ids
        self._shown += 1

    @property
    def tiles(self) -> list[Image]:
        """The pictures, in the order of the recording."""
        kept = sorted([*self._even.kept, *self._changes], key=lambda shown: shown[0])
        return [picture for _, picture in kept]

    @property
    def is_blank(self) -> bool:
        return not self.tiles

    def paint(self) -> Image:
        """The sheet as [H, W, 3] RGB.

        Raises:
            InputError: no frame was shown.
        """
        if not self.tiles:
            raise InputError(f"{self.title}: no frame was read, so there is nothing to picture")
        header = np.full((FOUND_HEADER_PX, self.tiles[0].shape[1], 3), GROUND, np.uint8)
        used = draw_text(header, self.title, (14, 36), 15, TEXT)
        draw_text(header, "how people were found", (14 + used + 16, 36), 10, MUTED)
        return np.vstack([header, *self.tiles])

    def png(self) -> bytes:
        """The sheet as a PNG file.

        Raises:
            InputError: no frame was shown.
        """
        return png_of(self.paint())


def paint_found(found: Found) -> Image:
    """Six panels of one frame, three in a row, with a caption."""
    frame = found.scene.cloud.frame
    panels = [
        ("users and their areas; rings: heads refused", _users(found)),
        ("overview", _overview(found)),
        ("depth: neither floor, wall nor room", _masked(frame, found.scene.is_free_standing)),
        *_colors(found, frame),
    ]
    titled = [_titled(title, panel) for title, panel in panels]
    rows = [_beside(titled[start : start + 3]) for start in (0, 3)]
    caption = np.full((FOUND_CAPTION_PX, rows[0].shape[1], 3), GROUND, np.uint8)
    used = draw_text(caption, f"frame {frame.index}", (14, 20), 10, TEXT)
    draw_text(caption, f"{frame.timestamp_s:.2f} s", (14 + used + 14, 20), 10, MUTED)
    return np.vstack([caption, *rows])


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
    for user in found.users:
        _label(picture, frame, user.head_camera, _caption_of(user), person_color(user.id))
    for refusal in found.refusals:
        if refusal.reason == TOO_NEAR:
            continue  # a user's shoulder, mostly
        center = refusal.head.center_camera
        at = _place(picture, frame, center)
        cv2.circle(picture, (round(at[0]), round(at[1])), 7, MUTED, 1, cv2.LINE_AA)
        reason = f"{100 * refusal.head.confidence:.0f} % {refusal.reason}"
        _label(picture, frame, center, reason, MUTED)
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
    for user in reversed(found.users):
        x, y = place(scene.overview_of(user.head_camera)).tolist()
        radius = max(round(0.12 * scale), 4)
        cv2.circle(picture, (round(x), round(y)), radius + 1, OUTLINE, 2, cv2.LINE_AA)
        cv2.circle(picture, (round(x), round(y)), radius, person_color(user.id), 2, cv2.LINE_AA)
        draw_label(picture, str(user.id), (x, y - radius - 4), person_color(user.id))
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


def _colors(found: Found, frame: Frame) -> list[tuple[str, Image]]:
    """What was detected by colour, or why nothing was."""
    detections = found.skin_detections
    if (
        detections is None
        or detections.is_foreground is None
        or detections.skin_probability is None
        or detections.is_skin is None
    ):
        why = "colour is not used" if detections is None else str(detections.light)
        empty = np.full((FOUND_PANEL_PX[1], FOUND_PANEL_PX[0], 3), PANEL, np.uint8)
        draw_label(empty, why, (FOUND_PANEL_PX[0] / 2, FOUND_PANEL_PX[1] / 2), MUTED)
        return [("colour", empty)]
    blobs = _fitted(frame_picture(frame))
    for blob in detections.blobs:
        draw_blob(blobs, blob, blobs.shape[1] / frame.camera.width)
    skin = probability_picture(
        detections.skin_probability, (frame.camera.width, frame.camera.height)
    )
    is_outside = ~resized_mask(detections.is_skin, (frame.camera.width, frame.camera.height))
    skin[is_outside] = skin[is_outside] // 2
    changed = "; the light has changed" if detections.light_changed else ""
    return [
        (f"colour and depth: foreground{changed}", _masked(frame, detections.is_foreground)),
        ("P(skin), bright where it is a region", _fitted(skin)),
        ("F face, L left hand, R right hand, ? other; belief in %", blobs),
    ]


def _fitted(picture: Image) -> Image:
    """As wide as a panel, or narrower where it would be too high."""
    height, width = picture.shape[:2]
    scale = min(FOUND_PANEL_PX[0] / width, MOST_PANEL_HEIGHT_PX / height)
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
    row = np.full((height + GAP_PX, 3 * (FOUND_PANEL_PX[0] + GAP_PX) + GAP_PX, 3), GROUND, np.uint8)
    for column, panel in enumerate(panels):
        left = GAP_PX + column * (FOUND_PANEL_PX[0] + GAP_PX)
        row[: panel.shape[0], left : left + FOUND_PANEL_PX[0]] = panel
    return row


def _place(picture: Image, frame: Frame, point_camera: NDArray[np.float64]) -> NDArray[np.float64]:
    scale = picture.shape[1] / frame.camera.width
    return pixels_of(point_camera[None], frame.camera, scale)[0]


def _label(
    picture: Image, frame: Frame, head_camera: NDArray[np.float64], text: str, color: Color
) -> None:
    if head_camera[2] > 0.0:
        x, y = _place(picture, frame, head_camera).tolist()
        half = LETTER_PX * len(text) / 2
        x = min(max(x, half), max(picture.shape[1] - half, half))
        draw_label(picture, text, (x, max(y - 14.0, 10.0)), color)
