"""Strips of frames with the skeletons that were tracked, as the thesis's Figs. 5.5 to 6.7 show."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.body import JOINTS, PARTS
from topview.body.model import BodyModel
from topview.body.proportions import THESIS
from topview.camera import undistorted
from topview.geometry.rotations import transform
from topview.io.writers import write_atomically
from topview.records import Frame, Person
from topview.view.contact_sheet import Moment, stage_of
from topview.view.drawing import Image, draw_text, png_of
from topview.view.frame_picture import frame_with_skeletons
from topview.view.palette import GROUND, MUTED, PANEL, TEXT
from topview.view.scene3d import Stage, paint_scene
from topview_lab.datasets import EvaluatedRecording
from topview_lab.metrics import Samples
from topview_lab.reproduce.context import Context
from topview_lab.reproduce.runs import Measured, Run
from topview_lab.reproduce.section import Picture

# The look of the strips: all ours.
TILES, QUICK_TILES = 8, 4
TILE_COLUMNS: Final = 4
VIEW_PX: Final = (400, 300)
TILE_CAPTION_PX: Final = 40
TILE_MARGIN_PX: Final = 14
TEXT_PX: Final = 15
STRIP_LEGEND: Final = (
    "Skeletons over the picture, and the bodies in 3D, seen from the side and from above, on a "
    "floor of square metres with the distance from the camera. Open markers and thin bones: joints "
    "hidden by the own body (ring), another person (diamond) or an object (square). A colour is a "
    "true person; tracks that match nobody are not drawn."
)

_JOINT_OF_PART: Final = [
    next(j for j, joint in enumerate(JOINTS) if joint.part == part) for part in range(len(PARTS))
]
Note = Callable[[Samples, int], str]
"""What to write of a frame of these samples."""


@dataclass(frozen=True, slots=True)
class Tile:
    """A tracked frame, and what is written below it: its name, and a note."""

    moment: Moment
    caption: tuple[str, str]


def people_of(samples: Samples, frame: int) -> tuple[Person, ...]:
    """The tracked people of a frame; each has the number of the true person as its id."""
    return tuple(
        _person(samples, int(row))
        for row in np.flatnonzero((samples.frame == frame) & samples.found)
    )


def _person(samples: Samples, row: int) -> Person:
    stature_m = float(samples.stature_m[row])
    joints_camera, Rs = samples.predicted_camera[row], samples.Rs_camera_part[row]
    confidence = np.append(samples.joint_confidence[row], samples.end_confidence[row])
    joints_part = BodyModel.of(stature_m, THESIS).joints_part[_JOINT_OF_PART]
    origins = joints_camera[_JOINT_OF_PART] - np.einsum("pab,pb->pa", Rs, joints_part)
    return Person(
        id=int(samples.person[row]) + 1,
        height_m=stature_m,
        joints_camera=np.concatenate([joints_camera, samples.predicted_ends_camera[row]]),
        joint_state=np.append(samples.joint_state[row], samples.end_state[row]),
        joint_confidence=confidence.astype(np.float32),
        Ts_camera_part=transform(Rs, origins),
    )


@dataclass(frozen=True, slots=True)
class Shown:
    """What a strip shows of a tracked recording.

    Attributes:
        tiles: how many frames, evenly over those in which somebody is there.
        subject_alone: True to draw the first person alone; others only hide that one.
        note: what is written beside a frame's time.
    """

    tiles: int = TILES
    subject_alone: bool = False
    note: Note = lambda samples, frame: ""


EVEN: Final = Shown()


def tiles_of(run: Run, measured: Measured, shown: Shown = EVEN) -> list[Tile]:
    """Frames of a run that was measured; none if it was not."""
    tiles = []
    for errors in measured.of([run]).sequences:
        samples = errors.samples
        chosen = _evenly(np.unique(samples.frame), shown.tiles)
        for frame in frames_of(run.recording, chosen):
            people = people_of(samples, frame.index)
            if shown.subject_alone:
                people = tuple(person for person in people if person.id == 1)
            caption = f"{frame.timestamp_s:.1f} s", shown.note(samples, frame.index)
            tiles.append(Tile(Moment(frame, people, len(tiles)), caption))
    return tiles


def _evenly(frames: NDArray[np.int64], count: int) -> list[int]:
    """The middle ones of `count` equal spans."""
    return frames[np.unique((np.arange(count) + 0.5) * len(frames) // count).astype(int)].tolist()


def frames_of(recording: EvaluatedRecording, indices: Sequence[int]) -> list[Frame]:
    """The frames with these indices, undistorted; what is behind the last one is not read."""
    wanted = set(indices)
    frames = (frame for frame in recording.open() if frame.index in wanted)
    return [undistorted(frame) for frame in islice(frames, len(wanted))]


def strip(
    context: Context, measured: Measured, run: Run, name: str, told: str, shown: Shown = EVEN
) -> Picture:
    """The strip of a run, drawn into the report's folder, shorter in its quick form; `told` is what
    it shows."""
    shown = replace(shown, tiles=context.size(TILES, QUICK_TILES))
    return picture_of(context, name, told, tiles_of(run, measured, shown))


def picture_of(context: Context, name: str, told: str, tiles: Sequence[Tile]) -> Picture:
    """The strip of these tiles, drawn into the report's folder; `told` is what it shows."""
    path = context.picture(f"{name}.png")
    draw_strip(path, tiles)
    return Picture(path, f"{told} {STRIP_LEGEND}")


def draw_strip(path: Path, tiles: Sequence[Tile]) -> None:
    """Tiles from left to right, then from top to bottom: the picture with the skeletons, below it
    the same in 3D, below that the caption."""
    width, height = VIEW_PX
    step_x, step_y = width + TILE_MARGIN_PX, 2 * height + TILE_CAPTION_PX + TILE_MARGIN_PX
    rows, columns = -(-len(tiles) // TILE_COLUMNS), min(TILE_COLUMNS, len(tiles))
    picture = np.full(
        (TILE_MARGIN_PX + rows * step_y, TILE_MARGIN_PX + columns * step_x, 3), GROUND, np.uint8
    )
    stage = stage_of([tile.moment for tile in tiles])
    for number, tile in enumerate(tiles):
        row, column = divmod(number, columns)
        top, left = TILE_MARGIN_PX + row * step_y, TILE_MARGIN_PX + column * step_x
        picture[top : top + step_y - TILE_MARGIN_PX, left : left + width] = _painted(tile, stage)
    path.parent.mkdir(parents=True, exist_ok=True)
    write_atomically(path, png_of(picture))


def _painted(tile: Tile, stage: Stage) -> Image:
    width, height = VIEW_PX
    frame, people = tile.moment.frame, tile.moment.people
    image = np.full((2 * height + TILE_CAPTION_PX, width, 3), PANEL, np.uint8)
    image[:height] = frame_with_skeletons(frame, people, VIEW_PX)
    image[height : 2 * height] = paint_scene(frame, people, stage, VIEW_PX)
    baseline = image.shape[0] - (TILE_CAPTION_PX - TEXT_PX) // 2
    used = draw_text(image, tile.caption[0], (12, baseline), TEXT_PX, TEXT)
    draw_text(image, tile.caption[1], (12 + used + 16, baseline), TEXT_PX, MUTED)
    return image
