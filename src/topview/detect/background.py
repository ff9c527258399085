"""What an image shows besides the room: an adaptive Gaussian mixture per pixel (Sec. 4.1).

C. Stauffer and W. Grimson, Adaptive background mixture models for real-time tracking (CVPR 1999),
as improved by Z. Zivkovic (ICPR 2004) in OpenCV. One mixture is over colour, one over inverse
depth, in which a structured-light sensor's noise is the same near and far.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

import cv2
import numpy as np
from numpy.typing import NDArray

from topview.detect.cloud import NOISE_PER_SQUARE_M
from topview.detect.seeing import ColorView

Mask = NDArray[np.bool_]

# Levels per 1/m: the sensor's noise is then two levels wide, as a colour camera's is.
LEVELS: Final = 2.0 / NOISE_PER_SQUARE_M
# No reading, and a place that somebody stood before since the start: infinitely far away, and a
# colour that nothing has.
NEVER_SEEN_LEVEL: Final = 0.0
NEVER_SEEN_RGB: Final = (255, 0, 255)


@dataclass(frozen=True, slots=True)
class BackgroundSettings:
    """How the room is learnt; all ours where not said.

    Attributes:
        memory_s: how long something must stand still to become part of the room, roughly a tenth
            of it where the place was seen empty before.
        learn_every: frames from one lesson to the next; between them the room is only looked at.
        distance: from a mean of the mixture, in standard deviations, beyond which a pixel shows
            something else (OpenCV's default).
        nearer_m: besides the noise, what is before the room is at least this far before it.
        lamp_share: of the pixels that nobody covers, from which a change of colour means that
            the light has changed, not that somebody came.
        lamp_memory_s: how long the new light takes to be learnt.
    """

    memory_s: float = 20.0
    learn_every: int = 4
    distance: float = 4.0
    nearer_m: float = 0.03
    lamp_share: float = 0.5
    lamp_memory_s: float = 0.5


class BackgroundMixtures:
    """The room as it looks without people, by colour and by depth; learnt on-line.

    `foreground` looks, `learn` learns: in between it becomes known where people are, who are not
    learnt, however long they stand still.
    """

    def __init__(self, settings: BackgroundSettings | None = None) -> None:
        self.settings = settings or BackgroundSettings()
        self._forget()

    def _forget(self) -> None:
        square = self.settings.distance**2
        self._color = cv2.createBackgroundSubtractorMOG2(500, square, detectShadows=False)
        self._depth = cv2.createBackgroundSubtractorMOG2(500, square, detectShadows=False)
        self._last_rgb: NDArray[np.uint8] | None = None
        self._last_level: NDArray[np.float32] | None = None
        self._room_level: NDArray[np.float32] | None = None
        self._lessons = 0
        self._frames = 0
        self._learnt_s = 0.0
        self.light_changed = False

    def foreground(self, view: ColorView) -> Mask:
        """[h, w] where something stands before the room, or it is not known whether.

        Depth decides wherever there is a reading, so that shadows, screens and lamps are nobody;
        colour decides where there is none. While the light changes, colour says nothing.
        """
        if self._last_level is not None and self._last_level.shape != view.depth_m.shape:
            self._forget()
        if self._room_level is None:
            return np.ones(view.depth_m.shape, np.bool_)
        level = inverse_depth(view.depth_m)
        has_reading = level > 0.0
        is_new = np.asarray(self._depth.apply(level, learningRate=0.0)) > 0
        is_nearer = level > self._room_level + _margin(level, self.settings.nearer_m)
        color_is_new = np.asarray(self._color.apply(view.rgb, learningRate=0.0)) > 0
        is_before = is_new & is_nearer
        is_empty = ~is_before & has_reading
        changed = np.count_nonzero(color_is_new & is_empty)
        empty = np.count_nonzero(is_empty)
        self.light_changed = bool(empty > 0 and changed > self.settings.lamp_share * empty)
        if self.light_changed:
            return is_before | ~has_reading
        return np.where(has_reading, is_before, color_is_new)

    def learn(self, view: ColorView, is_somebodys: Mask) -> None:
        """Learn a frame where it is nobody's ([h, w], e.g. the users' areas)."""
        level = inverse_depth(view.depth_m)
        if self._last_level is None or self._last_rgb is None:
            self._last_level = np.full_like(level, NEVER_SEEN_LEVEL)
            self._last_rgb = np.empty_like(view.rgb)
            self._last_rgb[:] = NEVER_SEEN_RGB
        is_free = ~is_somebodys
        np.copyto(self._last_rgb, view.rgb, where=is_free[..., None])
        np.copyto(self._last_level, level, where=is_free & (level > 0.0))
        self._frames += 1
        is_start = self._lessons < self.settings.learn_every
        if not (is_start or self.light_changed or self._frames % self.settings.learn_every == 0):
            return
        now_s = view.frame.timestamp_s
        elapsed_s = max(now_s - self._learnt_s, 0.0)
        self._lessons, self._learnt_s = self._lessons + 1, now_s
        self._teach(self._depth, self._last_level, elapsed_s / self.settings.memory_s)
        memory_s = self.settings.lamp_memory_s if self.light_changed else self.settings.memory_s
        self._teach(self._color, self._last_rgb, elapsed_s / memory_s)
        self._room_level = np.asarray(self._depth.getBackgroundImage(), np.float32)

    def _teach(self, mixture: cv2.BackgroundSubtractorMOG2, image: Any, share: float) -> None:
        rate = max(share, 1.0 / (2.0 * self._lessons)) if self._lessons < 10 else share
        mixture.apply(image, learningRate=float(min(max(rate, 1e-6), 1.0)))


def inverse_depth(depth_m: NDArray[np.float32]) -> NDArray[np.float32]:
    """[h, w] in `LEVELS`, 0 where there is no reading."""
    level = np.zeros_like(depth_m)
    np.divide(np.float32(LEVELS), depth_m, out=level, where=depth_m > 0.0)
    return level


def _margin(level: NDArray[np.float32], nearer_m: float) -> NDArray[np.float32]:
    """[h, w] levels by which a surface rises when it comes nearer by `nearer_m`."""
    return level * level * np.float32(nearer_m / LEVELS)
