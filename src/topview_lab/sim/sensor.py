"""A Kinect-like depth sensor: what a structured-light camera makes of an ideal depth image.

Models: K. Khoshelham and S. Oude Elberink, Accuracy and Resolution of Kinect Depth Data, Sensors
12 (2012): disparity steps and noise; C. Nguyen, S. Izadi and D. Lovell, Modeling Kinect Sensor
Noise for Improved 3D Reconstruction and Tracking, 3DIMPVT (2012): lateral noise and the loss of
readings at grazing angles; K. Konolige and P. Mihelich, Technical description of Kinect
calibration (ROS, 2011): the matching window. Pixel sizes are meant at 640 x 480 and scale with the
focal length. Recordings of a Kinect v1 (a wall at 2.6 m) show that errors are
correlated over the width of the window, and that at least two thirds of the error variance stays
the same while nothing moves.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri

from topview.camera.projection import pixel_rays
from topview.records import Camera
from topview_lab.sim.colour import COLOR_BASELINE_M
from topview_lab.sim.images import Rendering
from topview_lab.sim.materials import HAIR
from topview_lab.sim.noise import NoiseField

FULL_FOCAL_PX: Final = 525.0
"""Focal length of the Kinect v1 at 640 x 480, nominal."""
NOTHING_M: Final = 1e3
"""Depth of empty pixels in the ideal image, out of any range."""


@dataclass(frozen=True, slots=True)
class Sensor:
    """A sensor's traits; the defaults are a Kinect v1.

    Attributes:
        baseline_m: from camera to projector, which sits to the camera's right.
        step_per_m: one disparity step in 1/m: depth comes in steps of z^2 times this
            (Khoshelham and Elberink, Eq. 10: 2.85e-5 per cm).
        noise_steps: standard deviation of the disparity in steps (same, Sec. 3.2: half a step).
        lasting_share: of the noise's variance that is the same in all frames (recordings).
        lateral_px: standard deviation of the silhouettes at 640 x 480 (Nguyen, Eq. 1, frontal).
        match_px: width of the matching window at 640 x 480, within which noise is correlated
            (Konolige and Mihelich); objects narrower than half of it are not seen.
        graze_rad: readings begin to fail at this angle between ray and normal, and all fail
            `GRAZE_BAND_RAD` beyond it (Nguyen measured planes up to about 80 degrees).
        hair_loss: share of readings that dark hair loses at 3 m (ours, from recordings).
        edge_loss: share of readings lost beside a depth edge (ours, from recordings).
        random_loss: share of readings lost anywhere (ours, from recordings).
        color_baseline_m: from the depth to the colour camera; 0 for perfect registration.
        least_m, greatest_m: range.
    """

    baseline_m: float = 0.075
    step_per_m: float = 2.85e-3
    noise_steps: float = 0.5
    lasting_share: float = 0.7
    lateral_px: float = 0.8
    match_px: float = 9.0
    graze_rad: float = np.radians(78)
    hair_loss: float = 0.30
    edge_loss: float = 0.25
    random_loss: float = 0.0005
    color_baseline_m: float = COLOR_BASELINE_M
    least_m: float = 0.5
    greatest_m: float = 8.0


KINECT_V1: Final = Sensor()
LASTING: Final = 1 << 31
"""Key of the generator for noise that all frames share, above any frame number."""


class DepthCamera:
    """A depth sensor, with the noise that stays the same in all frames."""

    def __init__(self, camera: Camera, seed: int, sensor: Sensor = KINECT_V1) -> None:
        self.camera, self.sensor = camera, sensor
        shape = camera.height, camera.width
        self._scale = camera.fx / FULL_FOCAL_PX
        rng = np.random.default_rng((seed, LASTING))
        self._noise = NoiseField(shape, max(1, round(sensor.match_px * self._scale)), rng)
        self._lasting = self._noise.draw(rng).copy()
        rays = pixel_rays(camera)
        self._rays = rays / np.linalg.norm(rays, axis=-1, keepdims=True)
        self._columns, self._rows = np.meshgrid(
            np.arange(camera.width, dtype=np.float32), np.arange(camera.height, dtype=np.float32)
        )

    def sense(self, rendering: Rendering, rng: np.random.Generator) -> NDArray[np.uint16]:
        """[H, W] uint16 depth in mm, 0 where the sensor has no reading."""
        sensor = self.sensor
        ideal = _without_slivers(
            np.minimum(rendering.depth_m, NOTHING_M), 0.5 * sensor.match_px * self._scale
        )
        lost = projector_shadow(ideal, self.camera, sensor.baseline_m)
        lost |= self._too_dark(rendering, rng)
        lost |= _depth_edges(ideal) & (self._noise.draw(rng) < ndtri(sensor.edge_loss))

        spread_px = sensor.lateral_px * self._scale
        x = self._columns + spread_px * self._noise.draw(rng)
        y = self._rows + spread_px * self._noise.draw(rng)
        shaken, lost_there = (
            cv2.remap(image, x, y, cv2.INTER_NEAREST, borderMode=cv2.BORDER_REPLICATE)
            for image in (ideal, lost.view(np.uint8))
        )
        depth_m = self._in_steps(np.asarray(shaken, np.float32), rng)
        is_in_range = (depth_m >= sensor.least_m) & (depth_m <= sensor.greatest_m)
        is_read = is_in_range & ~lost & (lost_there == 0)
        return np.where(is_read, np.rint(1000.0 * depth_m), 0.0).astype(np.uint16)

    def _in_steps(
        self, depth_m: NDArray[np.float32], rng: np.random.Generator
    ) -> NDArray[np.float32]:
        """Noise and rounding of the disparity."""
        sensor = self.sensor
        lasting = np.float32(sensor.noise_steps * np.sqrt(sensor.lasting_share))
        passing = np.float32(sensor.noise_steps * np.sqrt(1.0 - sensor.lasting_share))
        steps = np.asarray(1.0 / (sensor.step_per_m * depth_m), np.float32)
        steps += lasting * self._lasting
        steps += passing * self._noise.draw(rng)
        with np.errstate(divide="ignore"):
            sensed_m = np.float32(1.0 / sensor.step_per_m) / np.rint(steps)
        return np.asarray(sensed_m, np.float32)

    def _too_dark(self, rendering: Rendering, rng: np.random.Generator) -> NDArray[np.bool_]:
        """[H, W] True where too little light returns: grazing rays, dark hair, random loss."""
        sensor = self.sensor
        facing = -np.einsum("hwi,hwi->hw", rendering.normals, self._rays)
        begins, gone = np.cos(sensor.graze_rad), np.cos(sensor.graze_rad + GRAZE_BAND_RAD)
        is_hair = rendering.material == HAIR
        rows, columns = np.nonzero((facing < begins) | is_hair)
        chance = np.clip((begins - facing[rows, columns]) / (begins - gone), 0.0, 1.0)
        hair = is_hair[rows, columns]
        albedo, depth_m = rendering.albedo[is_hair], rendering.depth_m[is_hair]
        darkness = 1.0 - np.clip(albedo.mean(-1) / BRIGHT_HAIR, 0.0, 1.0)
        chance[hair] += sensor.hair_loss * darkness * (depth_m / 3.0) ** 2
        noise = self._noise.draw(rng)
        lost = noise < ndtri(sensor.random_loss)
        lost[rows, columns] |= noise[rows, columns] < ndtri(np.clip(chance, 0.0, 1.0))
        return lost


def _without_slivers(depth_m: NDArray[np.float32], width_px: float) -> NDArray[np.float32]:
    """The median over small windows, which removes whatever is narrower than half a window."""
    size = 5 if width_px >= 4.0 else 3  # the sizes that OpenCV has for float images
    if width_px < 2.0:
        return depth_m
    return np.asarray(cv2.medianBlur(depth_m, size), np.float32)


def projector_shadow(
    depth_m: NDArray[np.float32], camera: Camera, baseline_m: float
) -> NDArray[np.bool_]:
    """[H, W] True where the camera sees a surface that the projector, to its right, does not.

    The projector sees a pixel's surface at column u - f b / z. A pixel lies in the shadow if a
    pixel further to the right falls on its column or left of it. (That also holds for a pixel
    behind a nearer surface that is narrower than the difference of the disparities.)
    """
    columns = np.arange(camera.width, dtype=np.float32)
    columns = columns - np.float32(camera.fx * baseline_m) / depth_m
    beyond = np.minimum.accumulate(columns[:, ::-1], axis=1)[:, ::-1]
    shadow = np.zeros(depth_m.shape, np.bool_)
    shadow[:, :-1] = beyond[:, 1:] <= columns[:, :-1]
    return shadow


GRAZE_BAND_RAD: Final = np.radians(9)
BRIGHT_HAIR: Final = 0.2
"""Hair of this linear brightness, or above, loses no reading (ours)."""
EDGE_STEP: Final = 0.03
"""Neighbours whose depths differ by more than this share of the depth form an edge (ours)."""


def _depth_edges(depth_m: NDArray[np.float32]) -> NDArray[np.bool_]:
    kernel = np.ones((3, 3), np.uint8)
    spread = cv2.dilate(depth_m, kernel) - cv2.erode(depth_m, kernel)
    return spread > EDGE_STEP * depth_m
