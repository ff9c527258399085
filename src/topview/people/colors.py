"""What a frame's colours tell of the users that are known: hands, and who looks at the camera."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from topview.detect.beliefs import Kind
from topview.detect.faces_and_hands import SkinDetections
from topview.detect.heads import HEAD_RADIUS_M
from topview.kernels.skin import count_levels
from topview.people.users import HandCandidate
from topview.records import Frame

Vector = NDArray[np.float64]

# All ours. P(s|c) in 1/255 from which a pixel of a head counts as skin.
SKIN_LEVEL = 100
# A head is taken as this much higher than broad, and less of it than `DISC` of its breadth is
# looked at: beside it is hair, or the room.
HIGHER, DISC = 1.25, 0.9
# Fewer pixels tell nothing.
LEAST_HEAD_PIXELS = 6
# Skin on this share of a head is a face's: of simulated faces that look at the camera 0.5 to 0.95
# is skin, in profile 0.3 to 0.9, of the backs of heads 0 to 0.5; of one real face 0.4, in profile
# 0.2 and behind 0 to 0.1. So the share counts against what this user's face has shown.
FACE_SHOWS = 0.33
# Of a face that a detector of faces finds so much is enough: its skin is hard to see.
LEAST_SHOWN = 0.1
FACES_AWAY, FACES_CAMERA = 0.25, 0.75
# A face that was found looks at the camera for so long.
FRONTAL_S = 0.1
# What a face has shown is forgotten, and the share of late is taken, over these times.
FACE_MEMORY_S, SMOOTHING_S = 60.0, 0.2


class FaceMemory:
    """Remembers how much skin a user's face shows, and tells how much of late it is in view."""

    def __init__(self) -> None:
        self._shown = 0.0
        self._share: float | None = None
        self._last_s = 0.0
        self._frontal_s = -np.inf

    @property
    def is_known(self) -> bool:
        """Whether the colour of skin alone tells from now on."""
        return self._shown > 0.0

    def update(self, skin_share: float | None, is_frontal: bool, time_s: float) -> float | None:
        """How much of late the face has looked at the camera, 0..1; None while nobody knows.

        Args:
            skin_share: that of the head's pixels which are skin, None where they are not seen.
            is_frontal: whether a detector of faces finds one there.
            time_s: of the frame.
        """
        elapsed_s, self._last_s = max(time_s - self._last_s, 0.0), time_s
        if is_frontal:
            self._frontal_s = time_s
        least = LEAST_SHOWN if is_frontal else FACE_SHOWS
        shown = self._shown * float(np.exp(-elapsed_s / FACE_MEMORY_S))
        self._shown = max(shown, skin_share if skin_share and skin_share > least else 0.0)
        if time_s - self._frontal_s < FRONTAL_S:
            self._share = 1.0
        elif skin_share is None or not self._shown:
            self._share = None
        else:
            now = (skin_share / self._shown - FACES_AWAY) / (FACES_CAMERA - FACES_AWAY)
            now = min(max(now, 0.0), 1.0)
            before = now if self._share is None else self._share
            self._share = now + float(np.exp(-elapsed_s / SMOOTHING_S)) * (before - now)
        return self._share


def skin_share(
    detections: SkinDetections | None, frame: Frame, head_camera: Vector
) -> float | None:
    """Share of a head's pixels that have the colour of skin; None where that is not known."""
    if detections is None or detections.skin_probability is None:
        return None
    x, y, z = head_camera.tolist()
    if z <= 0.1:
        return None
    stride, camera = detections.stride, frame.camera
    u, v = ((c / stride) for c in (camera.fx * x / z + camera.cx, camera.fy * y / z + camera.cy))
    across, up = (
        DISC * HEAD_RADIUS_M * focal / (stride * z) for focal in (camera.fx, HIGHER * camera.fy)
    )
    seen, skin = count_levels(
        detections.skin_probability, frame.depth_m, stride, (v, u), (up, across), z,
        2 * HEAD_RADIUS_M, SKIN_LEVEL,
    )  # fmt: skip
    return None if seen < LEAST_HEAD_PIXELS else skin / seen


def hands_in(detections: SkinDetections | None) -> tuple[HandCandidate, ...]:
    """The hands that are seen, whosesoever they are."""
    blobs = () if detections is None else detections.blobs
    hands = []
    for blob in blobs:
        left, right = (float(blob.belief[kind]) for kind in (Kind.LEFT_HAND, Kind.RIGHT_HAND))
        if blob.is_seen and blob.palm_camera is not None and left + right > 0.5:
            hands.append(HandCandidate(blob.palm_camera, left + right, left / (left + right)))
    return tuple(hands)
