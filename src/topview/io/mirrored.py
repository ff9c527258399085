"""Recordings whose images are flipped left-right, as OpenNI and the Kinect SDK give by default."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from topview.records import Camera, Frame, Recording


class MirroredRecording:
    """A recording flipped back, so that left is the person's left: what the camera really saw.

    The given recording's camera describes its images as they are stored.
    """

    def __init__(self, recording: Recording) -> None:
        self._recording = recording
        self.name = recording.name
        self.camera = _flipped_camera(recording.camera)
        self.problems = recording.problems

    def __len__(self) -> int:
        return len(self._recording)

    def __iter__(self) -> Iterator[Frame]:
        for frame in self._recording:
            yield replace(
                frame,
                depth_m=np.ascontiguousarray(frame.depth_m[:, ::-1]),
                camera=self.camera,
                color=None if frame.color is None else np.ascontiguousarray(frame.color[:, ::-1]),
            )


def _flipped_camera(camera: Camera) -> Camera:
    return replace(camera, cx=camera.width - 1 - camera.cx)
