"""The automatic part: from two recordings and a colour to named markers in both views."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.detect.cloud import Cloud
from topview.io.readers.folder import FolderRecording
from topview.records import Frame, InputError
from topview.room.floor import FloorPlane, FloorSettings, find_floor
from topview_lab.annotate.blobs import Blobs, MarkerAppearance, find_blobs
from topview_lab.annotate.boards import Board, board_extrinsics
from topview_lab.annotate.cameras import (
    Extrinsics,
    refined_extrinsics,
    remaining_offset_frames,
    rough_extrinsics,
    time_offset_frames,
)
from topview_lab.annotate.joints import marker_points
from topview_lab.annotate.starting import NamedPerson, start_of_view
from topview_lab.annotate.tracks import Tracks, View, follow

OnProgress = Callable[[str, int, int], None]
"""Progress callback: what is being done, how much is done, and of how much."""

EARLY_S: Final = 3.0
"""At the start of the recording, during which people stand facing the front camera (ours)."""
CAMERA_ROUNDS: Final = 3
"""Alternations of following the markers and placing the rear camera by them (ours)."""
FLOOR_TRIES: Final = 8


@dataclass(frozen=True, slots=True)
class FindOptions:
    """What the user knows of the recordings.

    Attributes:
        people: number of people who wear markers.
        board: the board that both cameras see, or None to place the rear camera by the markers.
        offset_s: delay of the rear recording; None to estimate it.
    """

    people: int = 1
    board: Board | None = None
    offset_s: float | None = None


@dataclass(frozen=True, slots=True, eq=False)
class FoundMarkers:
    """What the automatic part found; both views over the front recording's F frames.

    Attributes:
        blobs: of the front and the rear view.
        rear_frames: [F] the rear recording's frame of the same moment, -1 for none.
        start_frame: the frame in which the markers were first named.
        starts: the people in that frame.
        offset_frames: delay of the rear recording.
        extrinsics: pose of the rear camera.
        tracks: the marker of each spot.
    """

    blobs: tuple[Sequence[Blobs], Sequence[Blobs]]
    rear_frames: NDArray[np.intp]
    start_frame: int
    starts: Sequence[NamedPerson]
    offset_frames: int
    extrinsics: Extrinsics
    tracks: Tracks

    def views(self) -> list[View]:
        front, rear = self.blobs
        return [View(front, np.eye(4)), View(rear, self.extrinsics.T_front_rear)]

    @property
    def eyes_front(self) -> NDArray[np.float64]:
        """[2, 3] positions of the cameras in the front camera's frame."""
        return np.stack([np.zeros(3), self.extrinsics.T_front_rear[:3, 3]])

    @property
    def statures_m(self) -> NDArray[np.float64]:
        """[P] of the people."""
        return np.array([start.stature_m for start in self.starts])


def find_markers(
    front: FolderRecording,
    rear: FolderRecording,
    looks: Sequence[MarkerAppearance],
    wishes: FindOptions,
    report: OnProgress,
) -> FoundMarkers:
    """Find, name and follow the markers, and place the rear camera in space and time.

    Raises:
        InputError: people cannot be named, the cameras are not in step or see too little together.
    """
    fps = front.fps
    spots = [_all_blobs(recording, looks, report) for recording in (front, rear)]
    report("placing the cameras", 0, 1)
    floors = [_floor(front), _floor(rear)]
    same_rate = _resampled(spots[1], rear.fps, fps)
    early = round(EARLY_S * fps)
    alone = []
    for blobs, name in ((spots[0], "front"), (same_rate, "rear")):
        start_frame, starts = start_of_view(blobs, wishes.people, name == "rear", name, early)
        track = follow([View(blobs, np.eye(4))], start_frame, starts, np.eye(4), fps)
        alone.append((start_frame, starts, track))
    (start_frame, starts, of_front), (_, _, of_rear) = alone
    offset = _offset(of_front, of_rear, floors, wishes, fps)
    T = np.eye(4)
    if wishes.board is None:
        T = rough_extrinsics(of_front, _shifted(of_rear, offset, len(spots[0])))
    found = FoundMarkers(
        blobs=(spots[0], ()),
        rear_frames=np.zeros(0, np.intp),
        start_frame=start_frame,
        starts=starts,
        offset_frames=offset,
        extrinsics=Extrinsics(T, np.inf, 0),
        tracks=of_front,
    )
    found = _with_offset(found, front, rear, spots[1], offset)
    if wishes.board is not None:
        pairs = _pairs(front, rear, found.rear_frames)
        found = replace(found, extrinsics=board_extrinsics(pairs, wishes.board))
    for k in range(CAMERA_ROUNDS):
        report("following the markers", k, CAMERA_ROUNDS)
        found = follow_again(found, fps)
        if wishes.board is None:
            extrinsics = refined_extrinsics(found.views(), found.tracks, found.statures_m, floors)
            found = replace(found, extrinsics=extrinsics)
        if wishes.offset_s is None:
            more = remaining_offset_frames(marker_points(found.views(), found.tracks.spots), fps)
            found = _with_offset(found, front, rear, spots[1], found.offset_frames + more)
    return follow_again(found, fps)


def _with_offset(
    found: FoundMarkers,
    front: FolderRecording,
    rear: FolderRecording,
    rear_blobs: Sequence[Blobs],
    offset_frames: int,
) -> FoundMarkers:
    """The same with the rear view shifted by a number of frames."""
    rear_frames = _rear_frames(front, rear, offset_frames / front.fps)
    blobs = [rear_blobs[r] if r >= 0 else Blobs.none() for r in rear_frames]
    return replace(
        found,
        blobs=(found.blobs[0], blobs),
        rear_frames=rear_frames,
        offset_frames=offset_frames,
    )


def follow_again(
    found: FoundMarkers, fps: float, views: Sequence[View] | None = None
) -> FoundMarkers:
    """Follow the markers again, in views that may hold the user's decisions."""
    tracks = follow(views or found.views(), found.start_frame, found.starts, np.eye(4), fps)
    return replace(found, tracks=tracks)


def _all_blobs(
    recording: FolderRecording, looks: Sequence[MarkerAppearance], report: OnProgress
) -> list[Blobs]:
    blobs = [Blobs.none()] * (recording.indices[-1] + 1)
    coloured = 0
    for done, frame in enumerate(recording):
        report(f"looking for markers in {recording.name}", done, recording.frame_count)
        blobs[frame.index] = find_blobs(frame, looks)
        coloured += frame.color is not None
    if not coloured:
        raise InputError(f"{recording.name}: has no colour images; it must have rgb/000000.png ...")
    return blobs


def _floor(recording: FolderRecording) -> FloorPlane | None:
    """The floor, from the first of a few frames over the recording that show it."""
    indices = recording.indices
    for k in range(FLOOR_TRIES):
        frame = recording.frame(indices[k * (len(indices) - 1) // FLOOR_TRIES])
        if frame is None:
            continue
        floor = find_floor(Cloud.from_frame(frame), FloorSettings(), seed=k)
        if floor is not None:
            return floor
    return None


def _resampled(blobs: Sequence[Blobs], fps_from: float, fps_to: float) -> list[Blobs]:
    """The nearest frames at another rate."""
    count = max(round(len(blobs) * fps_to / fps_from), 1)
    nearest = np.rint(np.arange(count) * fps_from / fps_to).astype(int)
    return [blobs[min(f, len(blobs) - 1)] for f in nearest]


def _offset(
    of_front: Tracks,
    of_rear: Tracks,
    floors: Sequence[FloorPlane | None],
    wishes: FindOptions,
    fps: float,
) -> int:
    if wishes.offset_s is not None:
        return round(wishes.offset_s * fps)
    return time_offset_frames(of_front, of_rear, floors, fps)


def _shifted(tracks: Tracks, shift: int, frames: int) -> Tracks:
    """Frame f + shift at index f, for a number of frames; empty where there is none."""
    wanted = np.arange(frames) + shift
    inside = (wanted >= 0) & (wanted < len(tracks.joints_front))
    at = np.clip(wanted, 0, len(tracks.joints_front) - 1)
    spots = np.where(inside[None, :, None, None, None], tracks.spots[:, at], -1)
    return Tracks(spots, tracks.joints_front[at], tracks.outwards_front[at], tracks.depths_m)


def _rear_frames(
    front: FolderRecording, rear: FolderRecording, offset_s: float
) -> NDArray[np.intp]:
    times_s = np.arange(front.indices[-1] + 1) / front.fps + offset_s
    frames = np.rint(times_s * rear.fps).astype(np.intp)
    return np.where(np.isin(frames, rear.indices), frames, -1)


def _pairs(
    front: FolderRecording, rear: FolderRecording, rear_frames: NDArray[np.intp]
) -> Iterator[tuple[Frame, Frame]]:
    """Pairs of simultaneous frames, a few over the recording."""
    for f in range(0, len(rear_frames), max(len(rear_frames) // 60, 1)):
        a, b = front.frame(f), rear.frame(int(rear_frames[f]))
        if a is not None and b is not None:
            yield a, b
