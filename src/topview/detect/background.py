"""Separate foreground from background: an adaptive Gaussian mixture per pixel (Sec. 4.1).

C. Stauffer and W. Grimson, Adaptive background mixture models for real-time tracking (CVPR 1999),
as improved by Z. Zivkovic (ICPR 2004) in OpenCV. One mixture models colour, the other depth. The
depth of a structured-light or stereo sensor enters as inverse depth, whose noise is the same near
and far; the depth of another sensor is warped to the same effect.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any, Final

import cv2
import numpy as np
from numpy.typing import NDArray

from topview.detect.color_view import ColorView, averaged
from topview.kernels.skin import before_background, learn_still
from topview.records import DepthNoise, read_only

Mask = NDArray[np.bool_]

# Levels per standard deviation of the depth noise; the noise of a colour camera is as wide.
NOISE_LEVELS: Final = 2.0
# Ours: resolution and end of the table of levels; a step is below the noise of any sensor.
LEVELS_PER_M: Final = 1000
FARTHEST_LEVEL_M: Final = 20.0
# A pixel that has had no reading, or has been covered by a person since the start: infinitely far
# away, and of a colour that nothing has.
NEVER_SEEN_LEVEL: Final = 0.0
NEVER_SEEN_RGB: Final = (255, 0, 255)
# Ours: seconds that an object must keep still to become background; roughly a tenth of it where the
# pixel was seen empty before.
BACKGROUND_MEMORY_S: Final = 20.0
# Ours: seconds from one update to the next. In the first `WARM_UP_S` seconds updates come more
# often, and the first `EARLY_UPDATES` weigh more.
UPDATE_INTERVAL_S: Final = 0.125
WARM_UP_S: Final = 0.12
WARM_UP_INTERVAL_S: Final = 1 / 30
EARLY_UPDATES: Final = 20
# Ours: timestamps are rounded by up to so many seconds.
TIMESTAMP_ROUNDING_S: Final = 0.002
# OpenCV's defaults. A pixel is foreground if it lies so many standard deviations from every mean of
# its mixture; and the length of the history where no learning rate is given (here one always is).
DISTANCE_SIGMAS: Final = 4.0
HISTORY: Final = 500
# Ours: foreground is nearer than the background by this much, besides the noise.
BACKGROUND_MARGIN_M: Final = 0.03
# All ours. The light has changed if this share of the uncovered pixels changes colour; seconds in
# which the new light is learnt; and pixels per mixture of a `LightChangeDetector`, in both
# directions.
LIGHT_CHANGE_SHARE: Final = 0.5
LIGHT_CHANGE_MEMORY_S: Final = 0.5
LIGHT_CHANGE_STRIDE_PX: Final = 4
# Ours: seconds that the depth of a pixel must stay the same for a `StillBackground`.
STILL_S: Final = 2.0


class UpdateSchedule:
    """When a background is updated, and at what learning rate."""

    def __init__(self) -> None:
        self._count = 0
        self._first_s = self._last_s = 0.0

    def is_due(self, view: ColorView, light_changed: bool) -> bool:
        """Whether the background is to be updated with this view."""
        now_s = view.frame.timestamp_s
        is_warming_up = now_s - self._first_s < WARM_UP_S
        interval_s = WARM_UP_INTERVAL_S if is_warming_up else UPDATE_INTERVAL_S
        # Timestamps may start anew.
        is_time = not 0.0 <= now_s - self._last_s < interval_s - TIMESTAMP_ROUNDING_S
        return not self._count or light_changed or is_time

    def start(self, view: ColorView) -> float:
        """Start the next update; returns the seconds since the last one."""
        now_s = view.frame.timestamp_s
        if not self._count:
            self._first_s = self._last_s = now_s
        elapsed_s = max(now_s - self._last_s, 0.0)
        self._count, self._last_s = self._count + 1, now_s
        return elapsed_s

    def rate(self, share: float) -> float:
        """The learning rate of an update that should weigh `share` of the whole, 0..1; early
        updates weigh more."""
        rate = max(share, 1.0 / (2.0 * self._count)) if self._count < EARLY_UPDATES else share
        return float(min(max(rate, 1e-6), 1.0))


class BackgroundMixtures:
    """The background by colour and by depth, learnt on-line.

    `foreground` compares a frame with the background, `update` learns from it. In between people
    are found; their pixels are not learnt, however long they stand still.
    """

    def __init__(self, *, by_depth: bool = True) -> None:
        """Without `by_depth` colour alone decides, as Sec. 4.1 has it."""
        self._by_depth = by_depth
        self._reset()

    def _reset(self) -> None:
        self._color, self._depth = _mixture(), _mixture()
        self._last_rgb: NDArray[np.uint8] | None = None
        self._last_level: NDArray[np.float32] | None = None
        self._background_level: NDArray[np.float32] | None = None
        self._schedule = UpdateSchedule()
        self.light_changed = False

    def foreground(self, view: ColorView) -> Mask:
        """[h, w] True where something stands before the background, or the background is unknown.

        Depth decides wherever there is a reading, so that shadows, screens and lamps are
        background; colour decides elsewhere. While the light changes, colour is not used.
        """
        if self._last_level is not None and self._last_level.shape != view.depth_m.shape:
            self._reset()
        if self._background_level is None:
            return np.ones(view.depth_m.shape, np.bool_)
        level, noise = depth_levels(view.depth_m, view.camera.noise), view.camera.noise
        has_reading = level > 0.0
        is_nearer = _is_new(self._depth, level)
        is_nearer &= level > self._background_level + _margin_levels(level, view.depth_m, noise)
        color_is_new = _is_new(self._color, view.rgb)
        self.light_changed = _light_changed(color_is_new, has_reading & ~is_nearer)
        unread = np.bool_(True) if self.light_changed else color_is_new
        return np.where(has_reading & self._by_depth, is_nearer, unread)

    def is_update_due(self, view: ColorView) -> bool:
        """Whether `update` would learn from the view."""
        return self._schedule.is_due(view, self.light_changed)

    def update(self, view: ColorView, is_person: Mask) -> None:
        """Learn from a frame, if an update is due, outside the people's pixels ([h, w])."""
        if not self.is_update_due(view):
            return
        level = depth_levels(view.depth_m, view.camera.noise)
        if self._last_level is None or self._last_rgb is None:
            self._last_level = np.full_like(level, NEVER_SEEN_LEVEL)
            self._last_rgb = _never_seen(view.rgb)
        is_free = ~is_person
        self._last_rgb[is_free] = view.rgb[is_free]
        np.copyto(self._last_level, level, where=is_free & (level > 0.0))
        elapsed_s = self._schedule.start(view)
        memory_s = LIGHT_CHANGE_MEMORY_S if self.light_changed else BACKGROUND_MEMORY_S
        self._color.apply(self._last_rgb, learningRate=self._schedule.rate(elapsed_s / memory_s))
        depth_rate = self._schedule.rate(elapsed_s / BACKGROUND_MEMORY_S)
        self._depth.apply(self._last_level, learningRate=depth_rate)
        self._background_level = np.asarray(self._depth.getBackgroundImage(), np.float32)


class LightChangeDetector:
    """Detects that the light has changed, by a coarse mixture over the background's colour."""

    def __init__(self) -> None:
        self._reset()

    def _reset(self) -> None:
        self._color = _mixture()
        self._last_rgb: NDArray[np.uint8] | None = None
        self._schedule = UpdateSchedule()
        self.light_changed = False

    def is_update_due(self, view: ColorView) -> bool:
        """Whether `update` would look at the view."""
        return self._schedule.is_due(view, self.light_changed)

    def update(self, view: ColorView, is_person: Mask) -> None:
        """Compare a frame with the background, if an update is due, outside the people's pixels
        ([h, w]), and learn from it."""
        if not self.is_update_due(view):
            return
        step = min(LIGHT_CHANGE_STRIDE_PX, *view.depth_m.shape)
        rgb = averaged(view.rgb, step)
        height, width = rgb.shape[:2]
        is_free = ~is_person[::step, ::step][:height, :width]
        if self._last_rgb is not None and self._last_rgb.shape != rgb.shape:
            self._reset()
        if self._last_rgb is None:
            self._last_rgb = _never_seen(rgb)
        else:
            self.light_changed = _light_changed(_is_new(self._color, rgb), is_free)
        self._last_rgb[is_free] = rgb[is_free]
        elapsed_s = self._schedule.start(view)
        memory_s = LIGHT_CHANGE_MEMORY_S if self.light_changed else BACKGROUND_MEMORY_S
        self._color.apply(self._last_rgb, learningRate=self._schedule.rate(elapsed_s / memory_s))


class StillBackground:
    """The background among given candidates: pixels whose depth keeps still.

    A pixel that has kept still is background, and so is everything behind it, until another depth
    has kept still there.
    """

    def __init__(self) -> None:
        self._nearest_m = np.empty((0, 0), np.float32)
        self._last_m = np.empty((0, 0), np.float32)
        self._still_s = np.empty((0, 0), np.float32)
        self._updated_s = 0.0

    def before(self, view: ColorView, is_candidate: Mask) -> Mask:
        """[h, w] the candidates without what is the background's, or further away, or has no
        reading: beside people lies the sensor's shadow on the background."""
        if self._nearest_m.shape != view.depth_m.shape:
            return is_candidate
        is_before = np.empty(view.depth_m.shape, np.bool_)
        before_background(is_candidate, view.depth_m, self._nearest_m, is_before)
        return is_before

    def update(self, view: ColorView, is_person: Mask) -> None:
        """Learn from a frame outside the people's pixels ([h, w]); all of the first frame is
        background."""
        depth_m = view.depth_m
        if self._nearest_m.shape != depth_m.shape:
            self._nearest_m = np.full(depth_m.shape, np.inf, np.float32)
            self._last_m = depth_m.copy()
            self._still_s = np.full(depth_m.shape, STILL_S, np.float32)
        elapsed_s = max(view.frame.timestamp_s - self._updated_s, 0.0)
        self._updated_s = view.frame.timestamp_s
        margin = view.camera.noise.times(DISTANCE_SIGMAS, BACKGROUND_MARGIN_M)
        learn_still(
            depth_m, is_person, elapsed_s, STILL_S, margin,
            self._last_m, self._still_s, self._nearest_m,
        )  # fmt: skip


def depth_levels(depth_m: NDArray[np.float32], noise: DepthNoise) -> NDArray[np.float32]:
    """[h, w] float32, the higher the nearer, `NOISE_LEVELS` to a standard deviation of the noise at
    any depth; 0 where there is no reading, as infinitely far away."""
    if not noise.is_quadratic:
        steps = np.minimum(depth_m * LEVELS_PER_M + 0.5, LEVELS_PER_M * FARTHEST_LEVEL_M)
        return _level_table(noise)[steps.astype(np.int32)]
    level = np.zeros_like(depth_m)
    per_inverse_m = np.float32(NOISE_LEVELS / noise.per_square_m)
    np.divide(per_inverse_m, depth_m, out=level, where=depth_m > 0.0)
    return level


def _margin_levels(
    level: NDArray[np.float32], depth_m: NDArray[np.float32], noise: DepthNoise
) -> NDArray[np.float32]:
    """[h, w] by how many levels a surface rises when it comes nearer by `BACKGROUND_MARGIN_M`."""
    if not noise.is_quadratic:
        return np.float32(NOISE_LEVELS * BACKGROUND_MARGIN_M) / noise.sigma_m(depth_m)
    return level * level * np.float32(BACKGROUND_MARGIN_M / (NOISE_LEVELS / noise.per_square_m))


@lru_cache(maxsize=8)
def _level_table(noise: DepthNoise) -> NDArray[np.float32]:
    """The level at each step of depth: the sum of `NOISE_LEVELS` over the noise from there to the
    farthest."""
    middles_m = (np.arange(round(LEVELS_PER_M * FARTHEST_LEVEL_M)) + 0.5) / LEVELS_PER_M
    rises = NOISE_LEVELS / LEVELS_PER_M / noise.sigma_m(middles_m)
    table = np.append(np.cumsum(rises[::-1])[::-1], 0.0)
    table[0] = 0.0  # no reading
    return read_only(table.astype(np.float32))


def _mixture() -> cv2.BackgroundSubtractorMOG2:
    return cv2.createBackgroundSubtractorMOG2(HISTORY, DISTANCE_SIGMAS**2, detectShadows=False)


def _is_new(mixture: cv2.BackgroundSubtractorMOG2, image: NDArray[Any]) -> Mask:
    """[h, w] the pixels that the mixture does not explain; it learns nothing here."""
    return np.asarray(mixture.apply(image, learningRate=0.0), np.uint8) > 0


def _light_changed(color_is_new: Mask, is_free: Mask) -> bool:
    """Whether so many uncovered pixels have a new colour that the light must have changed."""
    free = np.count_nonzero(is_free)
    return bool(np.count_nonzero(color_is_new & is_free) > LIGHT_CHANGE_SHARE * free)


def _never_seen(rgb: NDArray[np.uint8]) -> NDArray[np.uint8]:
    image = np.empty_like(rgb)
    image[:] = NEVER_SEEN_RGB
    return image
