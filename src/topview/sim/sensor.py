"""A Kinect-like depth sensor: what a structured-light camera makes of an ideal depth image.

Models: K. Khoshelham and S. Oude Elberink, Accuracy and Resolution of Kinect Depth Data, Sensors
12 (2012): disparity steps and noise; C. Nguyen, S. Izadi and D. Lovell, Modeling Kinect Sensor
Noise for Improved 3D Reconstruction and Tracking, 3DIMPVT (2012): lateral noise and the loss of
readings at grazing angles. Pixel sizes are meant at 640 x 480 and scale with the focal length.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from topview.records import Camera
from topview.sim.flesh import HAIR
from topview.sim.images import Rendering

FULL_FOCAL_PX: Final = 525.0
"""Focal length of the Kinect v1 at 640 x 480, nominal."""


NOTHING_M: Final = 1e3
"""Where there is nothing, the ideal image is taken to lie this far away, out of any range."""


@dataclass(frozen=True, slots=True)
class Sensor:
    """A sensor's traits; the defaults are a Kinect v1.

    Attributes:
        baseline_m: from camera to projector, which sits to the camera's right.
        step_per_m: one disparity step in 1/m: depth comes in steps of z^2 times this
            (Khoshelham and Elberink, Eq. 10: 2.85e-5 per cm).
        noise_steps: standard deviation of the disparity in steps (same, Sec. 3.2: half a step).
        lateral_px: standard deviation of the silhouettes at 640 x 480 (Nguyen, Eq. 1, frontal).
        match_px: standard deviation of the matching window's weight at 640 x 480, which makes the
            noise of neighbours alike (ours, from recordings).
        graze_rad: readings begin to fail at this angle between ray and normal, and are gone
            `GRAZE_BAND_RAD` later (Nguyen measured planes up to about 80 degrees).
        hair_loss: share of readings that dark hair loses at 3 m (ours, from recordings).
        edge_loss: share of readings lost beside a depth edge (ours, from recordings).
        random_loss: share of readings lost anywhere (ours, from recordings).
        least_m, greatest_m: range.
    """

    baseline_m: float = 0.075
    step_per_m: float = 2.85e-3
    noise_steps: float = 0.5
    lateral_px: float = 0.8
    match_px: float = 1.4
    graze_rad: float = np.radians(78)
    hair_loss: float = 0.30
    edge_loss: float = 0.35
    random_loss: float = 0.0005
    least_m: float = 0.5
    greatest_m: float = 8.0


KINECT_V1: Final = Sensor()


def noise_generator(seed: int, frame: int) -> np.random.Generator:
    """The random numbers of one frame, the same whatever was drawn before."""
    return np.random.default_rng((seed, frame))


def sense_depth(
    rendering: Rendering,
    rays: NDArray[np.float32],
    camera: Camera,
    rng: np.random.Generator,
    sensor: Sensor = KINECT_V1,
) -> NDArray[np.uint16]:
    """[H, W] uint16 depth in mm, 0 where the sensor has no reading.

    Args:
        rendering: the ideal images.
        rays: [H, W, 3] the pixels' rays, z = 1.
        camera: intrinsics.
        rng: of the noise.
        sensor: which one.
    """
    scale = camera.fx / FULL_FOCAL_PX
    ideal = np.minimum(rendering.depth_m, NOTHING_M)
    lost = projector_shadow(ideal, camera, sensor.baseline_m)
    lost |= _chance_of_loss(rendering, rays, sensor) > ndtr(
        _smooth_noise(ideal.shape, sensor.match_px * scale, rng)
    )
    edges = _depth_edges(ideal)
    lost |= edges & (rng.random(ideal.shape, np.float32) < sensor.edge_loss)

    rows, columns = _jittered(ideal.shape, sensor.lateral_px * scale, sensor.match_px * scale, rng)
    shaken = ideal[rows, columns]
    lost |= lost[rows, columns]
    steps = 1.0 / (sensor.step_per_m * shaken)
    steps += sensor.noise_steps * _smooth_noise(ideal.shape, sensor.match_px * scale, rng)
    with np.errstate(divide="ignore", invalid="ignore"):
        depth_m = 1.0 / (sensor.step_per_m * np.rint(steps))
    is_in_range = (depth_m >= sensor.least_m) & (depth_m <= sensor.greatest_m)
    return np.where(is_in_range & ~lost, np.rint(1000.0 * depth_m), 0.0).astype(np.uint16)


def projector_shadow(
    depth_m: NDArray[np.float32], camera: Camera, baseline_m: float
) -> NDArray[np.bool_]:
    """[H, W] True where the camera sees a surface that the projector, to its right, does not.

    The column at which the projector sees a pixel's surface is u - f b / z. A pixel lies in the
    shadow if one further to the right falls on its column or left of it. (So does one behind a
    nearer surface that is narrower than the difference of their disparities.)
    """
    columns = np.arange(camera.width) - camera.fx * baseline_m / depth_m
    beyond = np.minimum.accumulate(columns[:, ::-1], axis=1)[:, ::-1]
    shadow = np.zeros(depth_m.shape, np.bool_)
    shadow[:, :-1] = beyond[:, 1:] <= columns[:, :-1]
    return shadow


GRAZE_BAND_RAD: Final = np.radians(9)
BRIGHT_HAIR: Final = 0.2
"""Hair of this linear brightness, or above, loses no reading (ours)."""
EDGE_STEP: Final = 0.03
"""Neighbours whose depths differ by this share of the depth are on two sides of an edge (ours)."""


def _depth_edges(depth_m: NDArray[np.float32]) -> NDArray[np.bool_]:
    kernel = np.ones((3, 3), np.uint8)
    spread = cv2.dilate(depth_m, kernel) - cv2.erode(depth_m, kernel)
    return spread > EDGE_STEP * depth_m


def _chance_of_loss(
    rendering: Rendering, rays: NDArray[np.float32], sensor: Sensor
) -> NDArray[np.float32]:
    """[H, W] chance that too little light comes back: grazing rays, dark hair, bad luck."""
    facing = -np.einsum("hwi,hwi->hw", rendering.normals, rays)
    facing /= np.sqrt(np.einsum("hwi,hwi->hw", rays, rays))
    begins, gone = np.cos(sensor.graze_rad), np.cos(sensor.graze_rad + GRAZE_BAND_RAD)
    loss = sensor.random_loss + np.clip((begins - facing) / (begins - gone), 0.0, 1.0)
    is_hair = rendering.material == HAIR
    darkness = 1.0 - np.clip(rendering.albedo[is_hair].mean(-1) / BRIGHT_HAIR, 0.0, 1.0)
    loss[is_hair] += sensor.hair_loss * darkness * (rendering.depth_m[is_hair] / 3.0) ** 2
    return loss


def _smooth_noise(
    shape: tuple[int, ...], blur_px: float, rng: np.random.Generator
) -> NDArray[np.float32]:
    """[H, W] normal noise of unit variance that neighbours share."""
    noise = cv2.GaussianBlur(rng.standard_normal(shape, np.float32), (0, 0), blur_px)
    return noise * np.float32(2.0 * np.sqrt(np.pi) * blur_px)


def _jittered(
    shape: tuple[int, ...], spread_px: float, blur_px: float, rng: np.random.Generator
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Rows and columns of the pixel that each pixel shows instead of itself."""
    height, width = shape
    shifts = spread_px * np.stack([_smooth_noise(shape, blur_px, rng) for _ in range(2)])
    down, right = np.rint(shifts).astype(np.intp)
    rows = np.clip(np.arange(height)[:, None] + down, 0, height - 1)
    columns = np.clip(np.arange(width) + right, 0, width - 1)
    return rows, columns
