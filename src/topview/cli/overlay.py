"""Skeletons over the images that they were tracked in, as a video."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Final

from topview.camera import undistorted
from topview.cli.progress import progress_bar, warn
from topview.io import MirroredRecording, open_recording
from topview.io.writers.output import written_atomically
from topview.records import Camera, InputError, Recording
from topview.skeletons import SkeletonSequence
from topview.view import OverlayVideo

VIDEO: Final = "mp4"


def write_overlay(sequence: SkeletonSequence, source: Path, path: Path) -> None:
    """Draw the skeletons over each frame of the recording that they were tracked in.

    Raises:
        InputError: it is another recording, PyAV is missing, or the video cannot be written.
    """
    recording = _recording_of(sequence, source)
    rows = {index: row for row, index in enumerate(sequence.frame_index.tolist())}
    video = OverlayVideo(path.parent)
    with progress_bar() as progress:
        bar = progress.add_task(f"drawing {recording.name}", total=len(rows))
        for frame in map(undistorted, recording):
            row = rows.get(frame.index)
            if row is not None and sequence.timestamps_s[row] == frame.timestamp_s:
                video.show(frame, sequence.people_in(row))
                progress.advance(bar)
    warn(*recording.problems)
    if video.is_blank:
        raise InputError(f"{source}: has none of the frames of the skeletons; it must be theirs")
    with written_atomically(path) as file:
        video.write(file)


def _recording_of(sequence: SkeletonSequence, source: Path) -> Recording:
    """As it was tracked: flipped back, if it was."""
    recording = open_recording(source)
    if sequence.settings.get("mirrored"):
        recording = MirroredRecording(recording)
    if sequence.camera is not None and _lens(sequence.camera) != _lens(recording.camera):
        raise InputError(f"{source}: has another camera than the skeletons; it must be theirs")
    return recording


def _lens(camera: Camera) -> Camera:
    """What an image of it depends on."""
    return replace(camera, gravity_camera=None, T_world_camera=None)
