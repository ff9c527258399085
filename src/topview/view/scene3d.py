"""A small painter of the scene in 3D: floor grid, point cloud, bodies as shaded solids.

Two frames beside the camera's: the stage (the camera's place and heading, levelled: x right, y
down along gravity, z forward, origin on the floor under the camera) and the eye, a second pinhole
camera that looks at the people from the side and from above.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import cos, radians, sin

import numpy as np
from numpy.typing import NDArray

from topview.body import OUTPUT_JOINTS, PARTS
from topview.body.model import BodyModel
from topview.body.proportions import ANATOMICAL
from topview.camera import pixel_rays, project, unproject_depth
from topview.geometry.rotations import levelled
from topview.records import Camera, Frame, JointState, Person
from topview.view.drawing import Image, draw_line, draw_text, resized
from topview.view.palette import GRID_LINE, GRID_LINE_STRONG, MUTED, PANEL, TEXT, mix, person_color

# The look of the view: all ours.
OVERSAMPLING = 2  # drawn twice as large and reduced: smooth edges everywhere
AZIMUTH = radians(50.0)  # of the eye around the people, from the camera's side
ELEVATION = radians(24.0)
MAX_POINTS = 25_000
CEILING_M = 2.4  # points higher than a raised hand only stand in the way
DOT = ((0, 0), (1, 0), (0, 1), (1, 1))  # pixels of a point
DOT_OPACITY = 0.6
LIGHT_EYE = np.array([-0.4, -0.7, -0.6]) / np.linalg.norm([-0.4, -0.7, -0.6])  # towards the lamp
FILL = 0.75  # of the picture, by the people
EYE_DISTANCE_M = 4.0  # from the eye to the nearest people
RIGHT_IS_LIGHTER = 0.45  # share of white in the colour of a person's right limbs
MIN_VIEW = 0.3  # angle, nearly, that the people are taken to fill at least


@dataclass(frozen=True, slots=True, eq=False)
class Stage:
    """Where the floor is and what the eye takes in, the same for all pictures of a recording.

    Attributes:
        T_stage_camera: [4, 4].
        joints_stage: [N, 3] metres, of all people in all pictures.
    """

    T_stage_camera: NDArray[np.float64]
    joints_stage: NDArray[np.float64]

    @classmethod
    def around(
        cls, joints_camera: NDArray[np.floating], up_camera: NDArray[np.float64], floor_m: float
    ) -> Stage:
        """A stage for the joints [N, 3].

        Args:
            joints_camera: of all people in all pictures, metres.
            up_camera: [3] unit vector against gravity.
            floor_m: how far the floor lies below the camera, along gravity.
        """
        T_stage_camera = levelled(up_camera, floor_m)
        joints_stage = joints_camera @ T_stage_camera[:3, :3].T + T_stage_camera[:3, 3]
        return cls(T_stage_camera, joints_stage)

    @property
    def centre_stage(self) -> NDArray[np.float64]:
        """[3] the middle of the people."""
        low, high = np.percentile(self.joints_stage, (1.0, 99.0), axis=0)
        return (low + high) / 2

    @property
    def radius_m(self) -> float:
        """How far around the centre people go, across the floor."""
        across = np.linalg.norm((self.joints_stage - self.centre_stage)[:, [0, 2]], axis=-1)
        return max(1.0, float(np.percentile(across, 99.0)))

    def eye(self, size_px: tuple[int, int]) -> tuple[Camera, NDArray[np.float64]]:
        """The eye's intrinsics for an image of (width, height), and T_eye_camera: it looks at the
        people's middle, and its image is the part of its view that they fill."""
        forward = np.array(
            [-sin(AZIMUTH) * cos(ELEVATION), sin(ELEVATION), cos(AZIMUTH) * cos(ELEVATION)]
        )
        right = np.cross([0.0, 1.0, 0.0], forward)
        right /= np.linalg.norm(right)
        distance_m = EYE_DISTANCE_M + 2.0 * self.radius_m
        T_eye_stage = np.eye(4)
        T_eye_stage[:3, :3] = np.stack([right, np.cross(forward, right), forward])
        T_eye_stage[:3, 3] = -T_eye_stage[:3, :3] @ (self.centre_stage - distance_m * forward)

        joints_eye = self.joints_stage @ T_eye_stage[:3, :3].T + T_eye_stage[:3, 3]
        seen = joints_eye[:, :2] / joints_eye[:, 2:]
        low, high = np.percentile(seen, (0.5, 99.5), axis=0)
        size = np.array(size_px)
        focal = float(np.min(FILL * size / np.maximum(high - low, MIN_VIEW)))
        centre = (size - 1) / 2 - focal * (low + high) / 2
        camera = Camera(focal, focal, float(centre[0]), float(centre[1]), *size_px)
        return camera, T_eye_stage @ self.T_stage_camera


def paint_scene(
    frame: Frame, people: Sequence[Person], stage: Stage, size_px: tuple[int, int]
) -> Image:
    """The frame's points and its people on the stage, as an image of (width, height)."""
    width, height = size_px
    eye, T_eye_camera = stage.eye((width * OVERSAMPLING, height * OVERSAMPLING))
    painting = Painting(eye)
    _paint_floor(painting, stage, T_eye_camera)
    for person in people:
        _paint_person(painting, person, T_eye_camera)
    points_camera, light = _cloud(frame, stage)
    points_eye = points_camera @ T_eye_camera[:3, :3].T + T_eye_camera[:3, 3]
    painting.points(points_eye, (light[:, None] * np.array(TEXT)).astype(np.uint8))
    return resized(painting.image, size_px)


class Painting:
    """An image with a depth per pixel, so that what is nearer hides what is behind."""

    def __init__(self, eye: Camera) -> None:
        self.eye = eye
        self.image: Image = np.full((eye.height, eye.width, 3), PANEL, np.uint8)
        self.depth_m = np.full((eye.height, eye.width), np.inf)
        self._rays = pixel_rays(eye).astype(np.float64)

    def points(self, points_eye: NDArray[np.floating], colors: NDArray[np.uint8]) -> None:
        """Translucent dots of two by two pixels, [N, 3] metres in the eye's frame, [N, 3] RGB; to
        be painted after the solids."""
        places = project(points_eye, self.eye)
        inside = ((places >= 0.0) & (places < (self.eye.width - 1, self.eye.height - 1))).all(-1)
        order = np.flatnonzero(inside)
        order = np.repeat(order[np.argsort(-points_eye[order, 2], kind="stable")], len(DOT))
        columns, rows = (np.floor(places[order]) + np.resize(DOT, (len(order), 2))).astype(int).T
        nearer = points_eye[order, 2] < self.depth_m[rows, columns]
        rows, columns, order = rows[nearer], columns[nearer], order[nearer]
        under = self.image[rows, columns].astype(np.float64)
        self.image[rows, columns] = under + DOT_OPACITY * (colors[order] - under)  # nearest last

    def solid(
        self,
        T_eye_solid: NDArray[np.float64],
        radii_m: tuple[float, float],
        length_m: float,
        color: tuple[int, int, int],
    ) -> None:
        """A round-ended elliptic cylinder along +y from the origin, lit and shaded.

        Rays are cast in the solid's frame, scaled so that the solid becomes a capsule of radius 1.
        """
        window = self._window(T_eye_solid, radii_m, length_m)
        if window is None:
            return
        end = min(*radii_m, length_m / 3)
        scale = np.array([radii_m[0], end, radii_m[1]])
        R, origin = T_eye_solid[:3, :3], T_eye_solid[:3, 3]
        rays = self._rays[window] @ R / scale
        start = -(R.T @ origin) / scale
        distance, normals = _cast_on_capsule(start, rays, 1.0, length_m / end - 1.0)
        nearer = distance < self.depth_m[window]  # rays have z = 1: distance is depth
        normals_eye = (normals / scale) @ R.T
        normals_eye /= np.maximum(np.linalg.norm(normals_eye, axis=-1, keepdims=True), 1e-12)
        diffuse = np.clip(normals_eye @ LIGHT_EYE, 0.0, 1.0)
        facing = np.clip(-normals_eye[..., 2], 0.0, 1.0)
        shade = 0.30 + 0.62 * diffuse + 0.16 * facing**12
        shaded = np.clip(shade[..., None] * np.array(color), 0, 255).astype(np.uint8)
        self.image[window][nearer] = shaded[nearer]
        self.depth_m[window][nearer] = distance[nearer]

    def _window(
        self, T_eye_solid: NDArray[np.float64], radii_m: tuple[float, float], length_m: float
    ) -> tuple[slice, slice] | None:
        """Rows and columns that the solid can cover, None if it is out of sight."""
        corners = np.array(
            [
                (x * radii_m[0], y * length_m, z * radii_m[1], 1.0)
                for x in (-1, 1)
                for y in (0, 1)
                for z in (-1, 1)
            ]
        )
        places = project((corners @ T_eye_solid.T)[:, :3], self.eye)
        if not np.isfinite(places).all():
            return None
        left, top = np.maximum(np.floor(places.min(axis=0)), 0).astype(int)
        right, bottom = np.ceil(places.max(axis=0)).astype(int) + 1
        if left >= min(right, self.eye.width) or top >= min(bottom, self.eye.height):
            return None
        return slice(top, bottom), slice(left, right)


def _cast_on_capsule(
    start: NDArray[np.float64], rays: NDArray[np.float64], low: float, high: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Where rays from one point first meet a capsule of radius 1 along y in low..high.

    Returns:
        distance [...] in multiples of each ray, infinite where it misses; normals [..., 3].
    """
    distance = np.full(rays.shape[:-1], np.inf)
    normals = np.zeros(rays.shape)
    for axis_y in (None, low, high):  # the side, then the two ends
        centre = np.array([0.0, axis_y or 0.0, 0.0])
        weight = np.array([1.0, 0.0 if axis_y is None else 1.0, 1.0])
        offset = start - centre
        a = (rays * rays) @ weight
        b = (rays * offset) @ weight
        c = (offset * offset) @ weight - 1.0
        discriminant = b * b - a * c
        with np.errstate(invalid="ignore", divide="ignore"):
            root = (-b - np.sqrt(discriminant)) / a
        hit = start + root[..., None] * rays
        y = hit[..., 1]
        if axis_y is None:
            belongs = (y >= low) & (y <= high)
        else:
            belongs = y <= low if axis_y == low else y >= high
        first = (discriminant >= 0.0) & (root > 0.0) & belongs & (root < distance)
        distance[first] = root[first]
        normals[first] = ((hit - centre) * weight)[first]
    return distance, normals


def _cloud(frame: Frame, stage: Stage) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The points near the people [N, 3], and how light each dot is [N]: lighter where higher."""
    points = unproject_depth(frame.depth_m, frame.camera)[frame.depth_m > 0.0].astype(np.float64)
    T = stage.T_stage_camera
    points_stage = points @ T[:3, :3].T + T[:3, 3]
    across = np.linalg.norm((points_stage - stage.centre_stage)[:, [0, 2]], axis=-1)
    is_low = -points_stage[:, 1] < CEILING_M
    near = np.flatnonzero(is_low & (across < stage.radius_m + 1.0))
    near = near[:: 1 + len(near) // MAX_POINTS]
    light = 0.45 + 0.45 * np.clip(-points_stage[near, 1] / 1.8, 0.0, 1.0)
    return points[near], light


def _paint_floor(painting: Painting, stage: Stage, T_eye_camera: NDArray[np.float64]) -> None:
    """Lines a metre apart, with the distance from the camera written at the side."""
    T_eye_stage = T_eye_camera @ np.linalg.inv(stage.T_stage_camera)
    reach = np.ceil(stage.radius_m + 0.5)
    x0, z0 = np.round(stage.centre_stage[[0, 2]])
    steps = np.arange(-reach, reach + 1)

    def place(x: float, z: float) -> NDArray[np.float64]:
        point = T_eye_stage @ np.array([x, 0.0, z, 1.0])
        return project(point[:3], painting.eye)

    for step in steps:
        for start, end, strong in (
            ((x0 + step, z0 - reach), (x0 + step, z0 + reach), x0 + step == 0.0),
            ((x0 - reach, z0 + step), (x0 + reach, z0 + step), False),
        ):
            color = GRID_LINE_STRONG if strong else GRID_LINE
            draw_line(painting.image, place(*start), place(*end), color, OVERSAMPLING)
        at = place(float(np.clip(0.0, x0 - reach, x0 + reach)) + 0.1, z0 + step - 0.1)
        margin = 24 * OVERSAMPLING
        room = np.array([painting.eye.width, painting.eye.height]) - margin
        if z0 + step > 0.0 and (margin < at).all() and (at < room).all():
            label = f"{z0 + step:.0f} m"
            draw_text(painting.image, label, (at[0], at[1]), 9 * OVERSAMPLING, MUTED)


def _paint_person(painting: Painting, person: Person, T_eye_camera: NDArray[np.float64]) -> None:
    """Every part as a solid; the person's right limbs are lighter, and parts none of whose joints
    is visible are darkened."""
    body = BodyModel.of(person.height_m, ANATOMICAL)
    color = person_color(person.id)
    seen = {
        joint.part
        for joint, state in zip(OUTPUT_JOINTS, person.joint_state, strict=True)
        if state == JointState.VISIBLE
    }
    for part, about in enumerate(PARTS):
        T_camera_part = person.Ts_camera_part[part]
        own = mix(color, TEXT, RIGHT_IS_LIGHTER) if about.name.startswith("right_") else color
        if np.isfinite(T_camera_part).all():
            radius_x, radius_z = body.radii_m[part]
            painting.solid(
                T_eye_camera @ T_camera_part,
                (float(radius_x), float(radius_z)),
                float(body.lengths_m[part]),
                own if part in seen else mix(own, PANEL, 0.6),
            )
