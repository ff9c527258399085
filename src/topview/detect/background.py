"""What an image shows besides the room: an adaptive Gaussian mixture per pixel (Sec. 4.1).

C. Stauffer and W. Grimson, Adaptive background mixture models for real-time tracking (CVPR 1999),
as improved by Z. Zivkovic (ICPR 2004) in OpenCV. One mixture is over colour, one over inverse
depth, in which a structured-light or stereo sensor's noise is the same near and far, or over what
does the same for a sensor of another kind.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any, Final

import cv2
import numpy as np
from numpy.typing import NDArray

from topview.detect.seeing import ColorView, averaged
from topview.records import DepthNoise, read_only

Mask = NDArray[np.bool_]

# The sensor's noise is so many levels wide, as a colour camera's is.
NOISE_LEVELS: Final = 2.0
# Ours: where levels are looked up, in steps of one below any sensor's noise, and how far.
STEPS_PER_M: Final = 1000
FAR_M: Final = 20.0
# No reading, and a place that somebody stood before since the start: infinitely far away, and a
# colour that nothing has.
NEVER_SEEN_LEVEL: Final = 0.0
NEVER_SEEN_RGB: Final = (255, 0, 255)
# Ours: in so many seconds at the start lessons are no further apart than this; so many lessons tell
# more than later ones.
FIRST_S: Final = 0.12
FIRST_LESSON_S: Final = 1 / 30
EARLY_LESSONS: Final = 20
# Ours: seconds that something must stand still to become part of the room; roughly a tenth of it
# where the place was seen empty before.
ROOM_MEMORY_S: Final = 20.0
# Ours: seconds from one lesson to the next; between them the room is only looked at.
LESSON_S: Final = 0.125
# Ours: time stamps are rounded by up to so many seconds.
ROUNDED_S: Final = 0.002
# OpenCV's defaults. A pixel shows something else from so many standard deviations from each mean of
# a mixture on; and the frames that count where no rate of learning is given (here one always is).
DISTANCE_SIGMAS: Final = 4.0
HISTORY: Final = 500
# Ours: besides the noise, what is before the room is at least so many metres before it.
ROOM_MARGIN_M: Final = 0.03
# All ours. Of the pixels that nobody covers, if this share changes its colour, the light has
# changed; in so many seconds the new light is learnt. A `LampWatch` has one mixture for so many
# pixels, in both directions.
LAMP_SHARE: Final = 0.5
LAMP_MEMORY_S: Final = 0.5
LAMP_STRIDE_PX: Final = 4
# Ours: seconds that the depth of a place must stay the same for a `StillRoom`.
STILL_S: Final = 2.0


class Lessons:
    """When to learn a room, and how much of it."""

    def __init__(self) -> None:
        self._count = 0
        self._first_s = self._last_s = 0.0

    def is_due(self, view: ColorView, light_changed: bool) -> bool:
        """Whether the view is to be learnt."""
        now_s = view.frame.timestamp_s
        lesson_s = FIRST_LESSON_S if now_s - self._first_s < FIRST_S else LESSON_S
        # Time stamps may start anew.
        is_time = not 0.0 <= now_s - self._last_s < lesson_s - ROUNDED_S
        return not self._count or light_changed or is_time

    def start(self, view: ColorView) -> float:
        """Start the next one; gives the seconds since the last."""
        now_s = view.frame.timestamp_s
        if not self._count:
            self._first_s = self._last_s = now_s
        elapsed_s = max(now_s - self._last_s, 0.0)
        self._count, self._last_s = self._count + 1, now_s
        return elapsed_s

    def rate(self, share: float) -> float:
        """Of learning, for a lesson that should tell this share of the whole; the first tell
        more."""
        rate = max(share, 1.0 / (2.0 * self._count)) if self._count < EARLY_LESSONS else share
        return float(min(max(rate, 1e-6), 1.0))


class BackgroundMixtures:
    """The room as it looks without people, by colour and by depth; learnt on-line.

    `foreground` looks, `learn` learns: in between it becomes known where people are, who are not
    learnt, however long they stand still.
    """

    def __init__(self) -> None:
        self._forget()

    def _forget(self) -> None:
        self._color, self._depth = _mixture(), _mixture()
        self._last_rgb: NDArray[np.uint8] | None = None
        self._last_level: NDArray[np.float32] | None = None
        self._room_level: NDArray[np.float32] | None = None
        self._lessons = Lessons()
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
        level, noise = depth_levels(view.depth_m, view.camera.noise), view.camera.noise
        has_reading = level > 0.0
        is_before = _is_new(self._depth, level)
        margin = _margin(level, view.depth_m, noise)
        is_before &= level > self._room_level + margin
        color_is_new = _is_new(self._color, view.rgb)
        self.light_changed = _is_lamp(color_is_new, has_reading & ~is_before)
        unread = np.bool_(True) if self.light_changed else color_is_new
        return np.where(has_reading, is_before, unread)

    def is_lesson_due(self, view: ColorView) -> bool:
        """Whether `learn` would learn the view."""
        return self._lessons.is_due(view, self.light_changed)

    def learn(self, view: ColorView, is_somebodys: Mask) -> None:
        """Learn a frame, if it is time to, where it is nobody's ([h, w], e.g. the users' areas)."""
        if not self.is_lesson_due(view):
            return
        level = depth_levels(view.depth_m, view.camera.noise)
        if self._last_level is None or self._last_rgb is None:
            self._last_level = np.full_like(level, NEVER_SEEN_LEVEL)
            self._last_rgb = _never_seen(view.rgb)
        is_free = ~is_somebodys
        self._last_rgb[is_free] = view.rgb[is_free]
        np.copyto(self._last_level, level, where=is_free & (level > 0.0))
        elapsed_s = self._lessons.start(view)
        memory_s = LAMP_MEMORY_S if self.light_changed else ROOM_MEMORY_S
        self._color.apply(self._last_rgb, learningRate=self._lessons.rate(elapsed_s / memory_s))
        depth_rate = self._lessons.rate(elapsed_s / ROOM_MEMORY_S)
        self._depth.apply(self._last_level, learningRate=depth_rate)
        self._room_level = np.asarray(self._depth.getBackgroundImage(), np.float32)


class LampWatch:
    """Notices that the light changes, by a coarse mixture over the room's colours alone."""

    def __init__(self) -> None:
        self._forget()

    def _forget(self) -> None:
        self._color = _mixture()
        self._last_rgb: NDArray[np.uint8] | None = None
        self._lessons = Lessons()
        self.light_changed = False

    def is_lesson_due(self, view: ColorView) -> bool:
        """Whether `learn` would look at the view."""
        return self._lessons.is_due(view, self.light_changed)

    def learn(self, view: ColorView, is_somebodys: Mask) -> None:
        """Look at a frame, if it is time to, where it is nobody's ([h, w]), and learn it."""
        if not self.is_lesson_due(view):
            return
        step = min(LAMP_STRIDE_PX, *view.depth_m.shape)
        rgb = averaged(view.rgb, step)
        height, width = rgb.shape[:2]
        is_free = ~is_somebodys[::step, ::step][:height, :width]
        if self._last_rgb is not None and self._last_rgb.shape != rgb.shape:
            self._forget()
        if self._last_rgb is None:
            self._last_rgb = _never_seen(rgb)
        else:
            self.light_changed = _is_lamp(_is_new(self._color, rgb), is_free)
        self._last_rgb[is_free] = rgb[is_free]
        elapsed_s = self._lessons.start(view)
        memory_s = LAMP_MEMORY_S if self.light_changed else ROOM_MEMORY_S
        self._color.apply(self._last_rgb, learningRate=self._lessons.rate(elapsed_s / memory_s))


class StillRoom:
    """The room by its stillness in depth alone: what is no candidate, though it is taken for one.

    What has kept still is the room, and so is all that is behind it, until something else has kept
    still there.
    """

    def __init__(self) -> None:
        self._nearest_m = np.empty((0, 0), np.float32)
        self._last_m = np.empty((0, 0), np.float32)
        self._still_s = np.empty((0, 0), np.float32)
        self._learnt_s = 0.0

    def is_seen_in(self, view: ColorView) -> Mask:
        """[h, w] where the depth is the room's, or further away, or there is no reading: beside
        people lies the sensor's shadow on the room."""
        if self._nearest_m.shape != view.depth_m.shape:
            return np.zeros(view.depth_m.shape, np.bool_)
        return (view.depth_m > self._nearest_m) | (view.depth_m == 0.0)

    def learn(self, view: ColorView, is_somebodys: Mask) -> None:
        """Learn a frame where it is nobody's ([h, w]); the first one tells all."""
        depth_m = view.depth_m
        if self._nearest_m.shape != depth_m.shape:
            self._nearest_m = np.full(depth_m.shape, np.inf, np.float32)
            self._last_m = depth_m.copy()
            self._still_s = np.full(depth_m.shape, STILL_S, np.float32)
        elapsed_s = np.float32(max(view.frame.timestamp_s - self._learnt_s, 0.0))
        self._learnt_s = view.frame.timestamp_s
        is_free = ~is_somebodys & (depth_m > 0.0)
        margin_m = _still_margin_m(depth_m, view.camera.noise)
        stays = np.abs(depth_m - self._last_m) < margin_m
        np.copyto(self._still_s, (self._still_s + elapsed_s) * stays, where=is_free)
        np.copyto(self._last_m, depth_m, where=is_free)
        is_still = is_free & (self._still_s >= STILL_S)
        np.copyto(self._nearest_m, depth_m - margin_m, where=is_still)


def depth_levels(depth_m: NDArray[np.float32], noise: DepthNoise) -> NDArray[np.float32]:
    """[h, w] float32, the higher the nearer, `NOISE_LEVELS` to a standard deviation of the noise at
    any depth; 0 where there is no reading, as infinitely far away."""
    if not noise.is_quadratic:
        steps = np.minimum(depth_m * STEPS_PER_M + 0.5, STEPS_PER_M * FAR_M)
        return _level_table(noise)[steps.astype(np.int32)]
    level = np.zeros_like(depth_m)
    per_inverse_m = np.float32(NOISE_LEVELS / noise.per_square_m)
    np.divide(per_inverse_m, depth_m, out=level, where=depth_m > 0.0)
    return level


def _margin(
    level: NDArray[np.float32], depth_m: NDArray[np.float32], noise: DepthNoise
) -> NDArray[np.float32]:
    """[h, w] levels by which a surface rises when it comes nearer by `ROOM_MARGIN_M`."""
    if not noise.is_quadratic:
        return np.float32(NOISE_LEVELS * ROOM_MARGIN_M) / noise.sigma_m(depth_m)
    return level * level * np.float32(ROOM_MARGIN_M / (NOISE_LEVELS / noise.per_square_m))


def _still_margin_m(depth_m: NDArray[np.float32], noise: DepthNoise) -> NDArray[np.float32]:
    """[h, w] metres by which the depth of something still may change."""
    return np.float32(ROOM_MARGIN_M) + DISTANCE_SIGMAS * noise.sigma_m(depth_m)


@lru_cache(maxsize=8)
def _level_table(noise: DepthNoise) -> NDArray[np.float32]:
    """Of each step: the sum of `NOISE_LEVELS` over the noise from there to the farthest."""
    middles_m = (np.arange(round(STEPS_PER_M * FAR_M)) + 0.5) / STEPS_PER_M
    rises = NOISE_LEVELS / STEPS_PER_M / noise.sigma_m(middles_m)
    table = np.append(np.cumsum(rises[::-1])[::-1], 0.0)
    table[0] = 0.0  # no reading
    return read_only(table.astype(np.float32))


def _mixture() -> cv2.BackgroundSubtractorMOG2:
    return cv2.createBackgroundSubtractorMOG2(HISTORY, DISTANCE_SIGMAS**2, detectShadows=False)


def _is_new(mixture: cv2.BackgroundSubtractorMOG2, image: NDArray[Any]) -> Mask:
    """[h, w] what is not of the mixture, which learns nothing."""
    return np.asarray(mixture.apply(image, learningRate=0.0), np.uint8) > 0


def _is_lamp(color_is_new: Mask, is_empty: Mask) -> bool:
    """Whether so much of the empty room has another colour that a lamp must have been switched."""
    empty = np.count_nonzero(is_empty)
    return bool(np.count_nonzero(color_is_new & is_empty) > LAMP_SHARE * empty)


def _never_seen(rgb: NDArray[np.uint8]) -> NDArray[np.uint8]:
    image = np.empty_like(rgb)
    image[:] = NEVER_SEEN_RGB
    return image
