"""What the tracker is told of each person in a frame (Sec. 5.3.1)."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from topview.kernels.pieces import fill_at
from topview.records import read_only


@dataclass(frozen=True, slots=True, eq=False)
class HandCandidate:
    """A hand as a detector of skin sees it, whosesoever it is.

    Attributes:
        palm_camera: [3] metres, on the skin.
        confidence: 0..1, that it is a hand.
        left_share: 0..1, that it is somebody's own left one, if it is a hand.
    """

    palm_camera: NDArray[np.float64]
    confidence: float
    left_share: float = 0.5


@dataclass(frozen=True, slots=True, eq=False)
class User:
    """A person found in one frame.

    Attributes:
        id: identity that lasts, counted from 1.
        head_camera: [3] metres, the centre of the head: measured, or predicted while it is hidden.
        head_is_seen: False while `head_camera` is a prediction.
        height_m: stature, the best estimate so far.
        height_is_measured: False while `height_m` is only the mean of all people.
        pixels: [N] int32 flat indices (row * width + column) into the depth image: the pixels that
            belong, or may belong, to this person; users who touch may share some until their
            bodies are tracked. Empty while the person is fully hidden.
        face_share: how much of late the face has been seen to look at the camera, 0..1; None where
            nothing could tell (no colour, too far away, the head hidden).
        head_sigma_m: standard deviation of `head_camera` along each axis.
    """

    id: int
    head_camera: NDArray[np.float64]
    head_is_seen: bool
    height_m: float
    height_is_measured: bool
    pixels: NDArray[np.int32]
    face_share: float | None = None
    head_sigma_m: float = 0.0

    def __post_init__(self) -> None:
        read_only(self.head_camera)
        read_only(self.pixels)


def by_depth(users: Iterable[User]) -> list[User]:
    """Nearest first: who stands in front is fitted before those whom he hides."""
    return sorted(users, key=lambda user: (float(user.head_camera[2]), user.id))


def label_image(users: Sequence[User], shape: tuple[int, int]) -> NDArray[np.int32]:
    """[H, W] id of the user that each pixel belongs to, 0 for nobody; a pixel that several users
    may own is the nearest one's.

    Args:
        users: nearest first.
        shape: of the image.
    """
    labels = np.zeros(shape, np.int32)
    for user in reversed(users):
        fill_at(user.pixels, user.id, labels)
    return labels
