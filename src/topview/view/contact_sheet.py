"""One picture of a whole recording: chosen frames with their skeletons, beside a view in 3D."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import BinaryIO

import numpy as np

from topview.body import OUTPUT_JOINT_NAMES
from topview.body.ends import ANKLES
from topview.detect.cloud import Cloud
from topview.records import Frame, InputError, JointState, Person
from topview.room.floor import CAMERA_UP, FloorTracker
from topview.view.drawing import Image, draw_bone, draw_joint, draw_text, png_of
from topview.view.even_choice import EvenChoice
from topview.view.frame_picture import frame_with_skeletons
from topview.view.palette import GROUND, MUTED, PANEL, TEXT, person_color
from topview.view.scene3d import Stage, paint_scene

# The look of the sheet: all ours.
EVEN_TILES = 8
MOST_EVEN_TILES = 16  # of recordings of half a thousand frames and more
FRAMES_PER_TILE = 30
OCCLUSION_TILES = 4  # at most: the frame of each quarter with the most joints behind a person
MARGIN_PX = 16
CAPTION_PX = 32
HEADER_PX = 92
# Most tiles, columns and size of a panel: the sheet is at most 1600 pixels high.
LAYOUTS = (
    (1, 1, (640, 480)),
    (2, 1, (480, 360)),
    (6, 2, (480, 360)),
    (12, 3, (360, 270)),
    (MOST_EVEN_TILES + OCCLUSION_TILES, 4, (320, 240)),
)

LEGEND = (
    (JointState.VISIBLE, "visible"),
    (JointState.SELF_OCCLUDED, "behind the own body"),
    (JointState.OCCLUDED_BY_PERSON, "behind a person"),
    (JointState.OCCLUDED_BY_OBJECT, "behind an object"),
)
ANKLE_HEIGHT_M = 0.07  # 3.9 % of the stature, Drillis and Contini (1966)
HIPS_HEIGHT_M = 0.9  # 53 % of the stature, same source; of upper bodies, which have no ankles
# Joints of no people.
EMPTY_SCENE_CAMERA = np.linspace([-0.5, -0.7, 2.0], [0.5, 1.0, 4.0], len(OUTPUT_JOINT_NAMES))


@dataclass(frozen=True, slots=True, eq=False)
class Moment:
    """A frame that is kept for the sheet."""

    frame: Frame
    people: tuple[Person, ...]
    number: int  # of those that were shown, from 0


class ContactSheet:
    """A viewer that keeps up to twenty frames while tracking runs, and paints them at the end.

    Args:
        title: the recording's name.
        frame_count: how many frames the recording should have; None if nobody knows.
    """

    def __init__(self, title: str, frame_count: int | None) -> None:
        self.title = title
        self._frame_count = frame_count
        wanted = min(max((frame_count or 0) // FRAMES_PER_TILE, EVEN_TILES), MOST_EVEN_TILES)
        self._even: EvenChoice[Moment] = EvenChoice(wanted, frame_count)
        self._occluded: dict[int, tuple[int, Moment]] = {}
        self._shown = 0

    def show(self, frame: Frame, people: Sequence[Person]) -> None:
        """Keep the frame if its turn has come, or if it has the most joints behind a person."""
        moment = Moment(frame, tuple(people), self._shown)
        if self._even.next_is_due():
            self._even.keep(moment)
        share = self._shown / self._frame_count if self._frame_count else 0.0
        quarter = min(int(OCCLUSION_TILES * share), OCCLUSION_TILES - 1)
        hidden = sum(
            int((person.joint_state == JointState.OCCLUDED_BY_PERSON).sum()) for person in people
        )
        if hidden > self._occluded.get(quarter, (0, None))[0]:
            self._occluded[quarter] = hidden, moment
        self._shown += 1

    @property
    def is_blank(self) -> bool:
        return not self._even.kept

    @property
    def moments(self) -> list[Moment]:
        """What the sheet will show, in the order of the recording."""
        near = self._shown / (4 * max(len(self._even.kept), EVEN_TILES))
        even = [moment.number for moment in self._even.kept]
        occluded = [
            moment
            for _, moment in self._occluded.values()
            if all(abs(moment.number - number) > near for number in even)
        ]
        return sorted([*self._even.kept, *occluded], key=lambda moment: moment.number)

    def paint(self) -> Image:
        """The sheet as [H, W, 3] RGB.

        Raises:
            InputError: no frame was shown.
        """
        moments = self.moments
        if not moments:
            raise InputError(f"{self.title}: no frame was read, so there is nothing to picture")
        _, columns, panel = next(made for made in LAYOUTS if len(moments) <= made[0])
        rows = -(-len(moments) // columns)
        tile_width, tile_height = 2 * panel[0], panel[1] + CAPTION_PX
        sheet = np.full(
            (
                HEADER_PX + rows * (tile_height + MARGIN_PX),
                MARGIN_PX + columns * (tile_width + MARGIN_PX),
                3,
            ),
            GROUND,
            np.uint8,
        )
        self._paint_header(sheet, moments)
        stage = stage_of(moments)
        for number, moment in enumerate(moments):
            row, column = divmod(number, columns)
            top = HEADER_PX + row * (tile_height + MARGIN_PX)
            left = MARGIN_PX + column * (tile_width + MARGIN_PX)
            sheet[top : top + tile_height, left : left + tile_width] = paint_tile(
                moment, stage, panel
            )
        return sheet

    def png(self) -> bytes:
        """The sheet as a PNG file.

        Raises:
            InputError: no frame was shown.
        """
        return png_of(self.paint())

    def write(self, file: BinaryIO) -> None:
        """Write the PNG file. Errors as of `png`."""
        file.write(self.png())

    def _paint_header(self, sheet: Image, moments: Sequence[Moment]) -> None:
        x = float(MARGIN_PX) + 2
        draw_text(sheet, self.title, (x, 40), 17, TEXT)
        x = float(MARGIN_PX) + 2
        for state, meaning in LEGEND:
            draw_joint(sheet, np.array([x + 6, 70.0]), state, TEXT, 5.0)
            x += 18 + draw_text(sheet, meaning, (x + 18, 75), 10, MUTED) + 22
        for meaning, is_dashed in (("left", False), ("right (lighter in 3D)", True)):
            ends = np.array([x, 70.0]), np.array([x + 34, 70.0])
            draw_bone(sheet, ends, TEXT, 3, is_dashed)
            x += 42 + draw_text(sheet, meaning, (x + 42, 75), 10, MUTED) + 22
        draw_text(sheet, "dark in 3D: not visible", (x, 75), 10, MUTED)
        x = float(sheet.shape[1] - MARGIN_PX - 2)
        ids = sorted({person.id for moment in moments for person in moment.people})
        for person_id in reversed(ids):
            color = person_color(person_id)
            x -= draw_text(sheet, f"person {person_id}", (x, 40), 10, color, "right") + 22


def paint_tile(moment: Moment, stage: Stage, panel_px: tuple[int, int]) -> Image:
    """The frame with its skeletons, the view in 3D at its right, the frame's number and time below:
    twice as wide as a panel, and `CAPTION_PX` higher."""
    width, height = panel_px
    tile = np.full((height + CAPTION_PX, 2 * width, 3), PANEL, np.uint8)
    tile[:height, :width] = frame_with_skeletons(moment.frame, moment.people, panel_px)
    tile[:height, width:] = paint_scene(moment.frame, moment.people, stage, panel_px)
    baseline = height + CAPTION_PX - 11
    used = draw_text(tile, f"frame {moment.frame.index}", (12, baseline), 10, TEXT)
    time = f"{moment.frame.timestamp_s:.2f} s"
    draw_text(tile, time, (12 + used + 14, baseline), 10, MUTED)
    return tile


def stage_of(moments: Sequence[Moment]) -> Stage:
    """A stage that holds everyone in all pictures, on the floor where it is seen, and else on the
    level of the lowest ankles; below the hips of upper bodies, which end there."""
    people = [person for moment in moments for person in moment.people]
    joints = np.array([person.joints_camera for person in people] or [EMPTY_SCENE_CAMERA])
    floor = FloorTracker()
    for moment in moments:
        floor.update(Cloud.from_frame(moment.frame))
    if floor.plane is not None:
        up, height_m = floor.plane.normal_camera, floor.plane.distance_m
    else:
        up = CAMERA_UP
        has_ankles = bool(np.isfinite(joints[:, ANKLES]).any())
        lowest, above_floor_m = (
            (joints[:, ANKLES], ANKLE_HEIGHT_M) if has_ankles else (joints, HIPS_HEIGHT_M)
        )
        height_m = -float(np.nanpercentile(lowest @ up, 10.0)) + above_floor_m
    joints = joints.reshape(-1, 3)
    return Stage.around(joints[np.isfinite(joints).all(axis=-1)], up, height_m)
