"""The floor, found in the depth image itself and kept over time."""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, radians

import numpy as np
from numpy.typing import NDArray

from topview.detect.cloud import Cloud
from topview.filter.over_time import Turns, share_after
from topview.filter.particles import time_key
from topview.kernels.scene import plane_moments
from topview.records import DepthNoise, read_only

Points = NDArray[np.float64]

# Ours: what is this near to the floor as it is known, plus the noise, makes up the floor.
NEAR_M = 0.04
# All ours, seconds: a floor is searched in every frame at first; it is given up where it has not
# been in view for so long; and over how many the mean is taken of what is seen of it.
SEARCH_FIRST_S, LOST_S, MEMORY_S = 0.15, 3.0, 0.32
# Of the cloud's pixels every second one in both directions tells of the floor.
EVERY = 2
CAMERA_UP = read_only(np.array([0.0, -1.0, 0.0]))


@dataclass(frozen=True, slots=True, eq=False)
class FloorPlane:
    """Points p of the floor have `normal_camera @ p + distance_m == 0`.

    Attributes:
        normal_camera: [3] unit vector pointing up.
        distance_m: how high the camera is above the floor.
    """

    normal_camera: NDArray[np.float64]
    distance_m: float

    def __post_init__(self) -> None:
        read_only(self.normal_camera)

    def height_of(self, points_camera: NDArray[np.floating]) -> NDArray[np.floating]:
        """[...] metres above the floor of [..., 3] points."""
        return points_camera @ self.normal_camera.astype(
            points_camera.dtype
        ) + points_camera.dtype.type(self.distance_m)


@dataclass(frozen=True, slots=True)
class FloorSettings:
    """Which planes may be a floor.

    Attributes:
        max_tilt_rad: of the floor's normal against the camera's own up; somewhat more than a
            camera is usually tilted.
        min_height_m, max_height_m: of the camera over the floor.
        min_pixels: in the small cloud; fewer say nothing about a plane.
        min_spread_m: standard deviation of the floor's points along the shorter direction; a chair
            or a table top spreads less, as do shoes and shoulders.
        max_below: share of all points that may lie under it, such as reflections in the floor.
        tries: planes through three random points.
        search_every_s: from one search to the next while there is no floor.
    """

    max_tilt_rad: float = radians(35)
    min_height_m: float = 0.4
    max_height_m: float = 3.3
    min_pixels: int = 150
    min_spread_m: float = 0.2
    max_below: float = 0.02
    tries: int = 100
    search_every_s: float = 0.33


class FloorTracker:
    """Finds the floor once, then follows it."""

    def __init__(self, settings: FloorSettings | None = None) -> None:
        self.settings = settings or FloorSettings()
        self.plane: FloorPlane | None = None
        self._first_s: float | None = None
        self._last_s = 0.0
        self._lost_since_s: float | None = None
        self._turns = Turns(self.settings.search_every_s)

    def update(self, cloud: Cloud) -> FloorPlane | None:
        """The floor as far as it is known after this frame."""
        time_s = cloud.frame.timestamp_s
        elapsed_s, self._last_s = time_s - self._last_s, time_s
        if self.plane is None:
            self._search(cloud, time_s)
        else:
            points, noise = cloud.points_camera, cloud.camera.noise
            refined = _refine(points, EVERY, self.plane, noise, self.settings)
            if refined is not None:
                self._lost_since_s = None
                self.plane = _blend(self.plane, refined, share_after(elapsed_s, MEMORY_S))
            elif self._lost_since_s is None:
                self._lost_since_s = time_s
            elif time_s - self._lost_since_s > LOST_S:
                self.plane = None
        return self.plane

    def _search(self, cloud: Cloud, time_s: float) -> None:
        """Look for a floor, if it is time to."""
        self._first_s = time_s if self._first_s is None else self._first_s
        is_turn = self._turns.due(time_s) > 0
        if is_turn or time_s - self._first_s < SEARCH_FIRST_S:
            self.plane = find_floor(cloud, self.settings, seed=time_key(time_s))


def find_floor(cloud: Cloud, settings: FloorSettings, seed: int = 0) -> FloorPlane | None:
    """The largest plane that faces up and has next to nothing below it; None if there is none."""
    points, is_level = _level_points(cloud, settings)
    noise = cloud.camera.noise
    candidates = points[is_level]
    level = candidates.astype(np.float32)
    if len(candidates) < settings.min_pixels:
        return None
    generator = np.random.default_rng(seed)
    triples = candidates[generator.integers(0, len(candidates), (settings.tries, 3))]
    normals = np.cross(triples[:, 1] - triples[:, 0], triples[:, 2] - triples[:, 0])
    lengths = np.linalg.norm(normals, axis=1)
    normals = normals / np.maximum(lengths, 1e-9)[:, None]
    normals *= np.where(normals @ CAMERA_UP < 0.0, -1.0, 1.0)[:, None]
    distances = -np.einsum("ij,ij->i", normals, triples[:, 0])
    may_be = (
        (lengths > 1e-4)
        & (normals @ CAMERA_UP > cos(settings.max_tilt_rad))
        & (distances > settings.min_height_m)
        & (distances < settings.max_height_m)
    )
    normals, distances = normals[may_be], distances[may_be]
    if not len(normals):
        return None
    sample = candidates[:: max(1, len(candidates) // 1000)]
    heights = sample @ normals.T + distances
    tolerance = 0.03 + noise.sigma_m(sample[:, 2])[:, None]
    # Each pixel counts for the area that it covers, or a near table would outvote the floor.
    area = (sample[:, 2] ** 2)[:, None]
    support = (area * (np.abs(heights) < tolerance)).sum(0)
    all_points = points[:: max(1, len(points) // 1000)]
    below = all_points @ normals.T + distances < -3.0 * (
        0.05 + noise.sigma_m(all_points[:, 2])[:, None]
    )
    support[below.mean(0) > settings.max_below] = 0.0
    best = int(np.argmax(support))
    if support[best] == 0.0:
        return None
    plane: FloorPlane | None = FloorPlane(normals[best], float(distances[best]))
    for _ in range(2):
        plane = plane and _refine(level[None], 1, plane, noise, settings)
    return plane


def _level_points(cloud: Cloud, settings: FloorSettings) -> tuple[Points, NDArray[np.bool_]]:
    """[N, 3] points of the cloud, and whether the surface there faces up."""
    grid = cloud.points_camera[::EVERY, ::EVERY]
    across = np.zeros_like(grid)
    down = np.zeros_like(grid)
    across[:, 1:-1] = grid[:, 2:] - grid[:, :-2]
    down[1:-1] = grid[2:] - grid[:-2]
    normal = np.cross(down, across)
    length = np.linalg.norm(normal, axis=-1)
    depth = grid[..., 2]
    is_smooth = (np.abs(across[..., 2]) < 0.1 * depth) & (np.abs(down[..., 2]) < 0.3 * depth)
    # Readings are noisy: a surface may seem tilted by some more than the floor is.
    up = -normal[..., 1] / np.maximum(length, 1e-9)
    is_level = is_smooth & (np.abs(up) > cos(settings.max_tilt_rad + radians(10)))
    is_level &= (length > 0.0) & (np.einsum("ijk,ijk->ij", normal, grid) * up < 0.0)
    is_valid = depth > 0.0
    return grid[is_valid].astype(np.float64), is_level[is_valid]


def _refine(
    points: NDArray[np.float32],
    step: int,
    plane: FloorPlane,
    noise: DepthNoise,
    settings: FloorSettings,
) -> FloorPlane | None:
    """Least squares on those of [h, w, 3] points, every `step`-th in both directions, that are near
    a plane; None where they do not make up a floor."""
    mean, spread = np.empty(3), np.empty((3, 3))
    count = plane_moments(
        points,
        step,
        plane.normal_camera,
        plane.distance_m,
        noise.times(1.0, NEAR_M),
        mean,
        spread,
    )
    if count < settings.min_pixels:
        return None
    variances, axes = np.linalg.eigh(spread)
    normal = axes[:, 0] * np.sign(axes[:, 0] @ plane.normal_camera)
    refined = FloorPlane(normal, float(-normal @ mean))
    is_floor = (
        variances[1] > settings.min_spread_m**2
        and normal @ CAMERA_UP > cos(settings.max_tilt_rad)
        and settings.min_height_m < refined.distance_m < settings.max_height_m
    )
    return refined if is_floor else None


def _blend(old: FloorPlane, new: FloorPlane, share: float) -> FloorPlane:
    normal = (1.0 - share) * old.normal_camera + share * new.normal_camera
    return FloorPlane(
        normal / np.linalg.norm(normal),
        (1.0 - share) * old.distance_m + share * new.distance_m,
    )
