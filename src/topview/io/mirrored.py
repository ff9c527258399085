"""Recordings whose images are flipped left-right, as OpenNI and the Kinect SDK give by default."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Final

import numpy as np

from topview.records import Camera, Distortion, Frame, InputError, Recording

FLIP: Final = np.diag([-1.0, 1.0, 1.0, 1.0])


class MirroredRecording:
    """A recording flipped back, so that left is the person's left: what the camera really saw.

    The given recording's camera describes its images as they are stored: its lens and its pose,
    too, are those of a mirrored world, and are flipped with them.

    Raises:
        InputError: its reader has flipped it back already.
    """

    is_mirrored: Final = True
    """A run's settings say so."""

    def __init__(self, recording: Recording) -> None:
        if getattr(recording, "is_flipped_back", False):
            raise InputError(
                f"--mirrored: {recording.name} is flipped back by its reader already; leave it out"
            )
        self._recording = recording
        self.name = recording.name
        self.camera = _flipped_camera(recording.camera)
        self.problems = recording.problems

    @property
    def frame_count(self) -> int | None:
        return self._recording.frame_count

    def __iter__(self) -> Iterator[Frame]:
        for frame in self._recording:
            yield replace(
                frame,
                depth_m=np.ascontiguousarray(frame.depth_m[:, ::-1]),
                camera=_flipped_camera(frame.camera),
                color=None if frame.color is None else np.ascontiguousarray(frame.color[:, ::-1]),
            )


def _flipped_camera(camera: Camera) -> Camera:
    """The camera in a world that is mirrored as its images are: x becomes -x, in the camera frame
    and in the world's."""
    return replace(
        camera,
        cx=camera.width - 1 - camera.cx,
        distortion=None if camera.distortion is None else _flipped_lens(camera.distortion),
        T_world_camera=None
        if camera.T_world_camera is None
        else FLIP @ camera.T_world_camera @ FLIP,
        gravity_camera=None
        if camera.gravity_camera is None
        else FLIP[:3, :3] @ camera.gravity_camera,
    )


def _flipped_lens(lens: Distortion) -> Distortion:
    """Of the coefficients only p2, the fourth, bends left and right differently."""
    k1_k2_p1, p2, others = lens.coefficients[:3], lens.coefficients[3:4], lens.coefficients[4:]
    return replace(lens, coefficients=(*k1_k2_p1, *(-p for p in p2), *others))
