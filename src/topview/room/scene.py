"""What one frame shows, with up and down, and what of it may be a person's."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Final

import msgspec
import numpy as np
from numpy.typing import NDArray

from topview.detect.cloud import Cloud
from topview.detect.heads import HEAD_HALF_HEIGHT_M, HEAD_RADIUS_M, INSIDE, right_of
from topview.kernels.heads import covered_share
from topview.kernels.scene import gather_standing, moved_share, set_up
from topview.room.background import Background, same_depth
from topview.room.floor import CAMERA_UP, FloorPlane
from topview.room.surfaces import bulky_surfaces, jump_of

# Ours, metres: what is so much nearer than a head's centre hides it.
NEARER_M: Final = 2 * HEAD_RADIUS_M
# Ours: sums of times are less exact.
CLOCK_S: Final = 0.01


@dataclass(frozen=True, slots=True)
class SceneSettings:
    """What is floor, and what is too bulky for a limb or a person; metres, ours where not said.

    Attributes:
        floor_margin_m: what is lower than this, plus the noise, is floor; a foot is 7 cm high.
        bulk_radius_m: of a disc that fits into a child's torso, but into no limb: a thigh is
            18 cm across (NASA-STD-3000).
        huge_core_m2: area of a surface after `bulk_radius_m` is taken off all round, from which
            it is no person: two people who touch side by side are below it.
    """

    floor_margin_m: float = 0.035
    bulk_radius_m: float = 0.13
    huge_core_m2: float = 0.8


class Scene(msgspec.Struct, frozen=True, eq=False, dict=True):
    """A cloud with up and down: heights, the overview, and what may be a person's.

    Attributes:
        cloud: the small cloud.
        settings: what it was made with.
        floor: the floor if one is in view.
        up_camera: [3] the floor's normal, else the camera's own up.
        basis_camera: [2, 3] unit vectors along the floor: to the camera's right, and forward.
        heights_m: [h, w] along `up_camera`: over the floor, else over the camera.
        plan_m: [2, h, w] the points seen from above: right, forward.
        is_free_standing: [h, w] pixels with a reading that are neither floor, wall nor known
            background.
        inset_m: [h, w] how far each pixel is from the nearest depth edge or hole; 0 on them.
        is_bulky: [h, w] surfaces that a disc of `bulk_radius_m` fits into: torsos and furniture,
            but no limb.
        steady: of all that is seen, which tells what has changed; None where it is not known.
    """

    cloud: Cloud
    settings: SceneSettings
    floor: FloorPlane | None
    up_camera: NDArray[np.float64]
    basis_camera: NDArray[np.float64]
    heights_m: NDArray[np.float32]
    plan_m: NDArray[np.float32]
    is_free_standing: NDArray[np.bool_]
    inset_m: NDArray[np.float32]
    is_bulky: NDArray[np.bool_]
    steady: Background | None = None

    @classmethod
    def of(
        cls,
        cloud: Cloud,
        floor: FloorPlane | None,
        is_background: NDArray[np.bool_],
        settings: SceneSettings,
    ) -> Scene:
        """`is_background` [h, w]: what is known to be the room's."""
        up_camera = CAMERA_UP if floor is None else floor.normal_camera
        basis_camera = overview_basis(up_camera)
        shape = cloud.depth_m.shape
        heights_m = np.empty(shape, np.float32)
        plan_m = np.empty((2, *shape), np.float32)
        is_free_standing = np.empty(shape, np.bool_)
        is_inner = np.empty(shape, np.uint8)
        set_up(
            cloud.depth_m,
            (cloud.camera.fx, cloud.camera.fy),
            (cloud.camera.cx, cloud.camera.cy),
            is_background,
            np.vstack([basis_camera, up_camera]).astype(np.float32),
            0.0 if floor is None else floor.distance_m,
            -np.inf if floor is None else settings.floor_margin_m,
            cloud.camera.noise.times(2.0),
            jump_of(cloud.camera.noise),
            heights_m,
            plan_m,
            is_free_standing,
            is_inner,
        )
        inset_m, is_bulky, is_huge = bulky_surfaces(
            cloud, is_free_standing, is_inner, settings.bulk_radius_m, settings.huge_core_m2
        )
        is_free_standing &= ~is_huge
        return cls(
            cloud,
            settings,
            floor,
            up_camera,
            basis_camera,
            heights_m,
            plan_m,
            is_free_standing,
            inset_m,
            is_bulky,
        )

    @cached_property
    def standing_px(self) -> NDArray[np.int64]:
        """Flat indices, ascending, of `is_free_standing`."""
        return np.flatnonzero(self.is_free_standing)

    @cached_property
    def standing(self) -> NDArray[np.float32]:
        """[7, N] what bodies grow over, of `standing_px` (`gather_standing`)."""
        return gather_standing(
            self.standing_px, self.plan_m, self.heights_m, self.cloud.points_camera, self.is_bulky
        )

    @property
    def overview_m(self) -> NDArray[np.float32]:
        """[h, w, 2] the points seen from above (right, forward)."""
        return np.moveaxis(self.plan_m, 0, -1)

    @property
    def room_ends_m(self) -> float:
        """Depth of the farthest that has been seen; nobody is behind it."""
        return np.inf if self.steady is None else self.steady.farthest_m

    @cached_property
    def time_s(self) -> float:
        """Of the frame."""
        return self.cloud.frame.timestamp_s

    def changed_share(self, is_own: NDArray[np.bool_], since_s: float) -> float:
        """Share of the pixels [h, w] of a thing that have changed since a moment, but for those on
        edges; 1 where that is not known."""
        if self.steady is None:
            return 1.0
        is_inner = is_own & (self.inset_m > 0.0)
        gone_s = self.time_s - since_s - CLOCK_S
        return self.steady.changed_share(
            is_inner, self.cloud.depth_m, gone_s, self.cloud.camera.noise
        )

    def moved_share(
        self, is_own: NDArray[np.bool_], before_m: NDArray[np.float32], least_m2: float
    ) -> float:
        """Share of the area of a thing [h, w], of at least `least_m2`, that has come to where
        something farther was seen before [h, w], but for edges."""
        depth_m, camera = self.cloud.depth_m, self.cloud.camera
        is_inner = is_own & (self.inset_m > 0.0)
        same = same_depth(camera.noise)
        return moved_share(is_inner, depth_m, before_m, same, camera.fx, least_m2)

    def aside_of(self, point_camera: NDArray[np.float64]) -> NDArray[np.float64]:
        """[h, w] metres from a [3] point, seen from above."""
        right, forward = self.overview_of(point_camera)
        return np.hypot(self.plan_m[0] - right, self.plan_m[1] - forward)

    def away_m(self, point_camera: NDArray[np.float64]) -> NDArray[np.float64]:
        """[h, w] how far each pixel's point is from a [3] point."""
        return np.linalg.norm(self.cloud.points_camera - point_camera, axis=-1)

    def is_under(self, head_camera: NDArray[np.float64], radius_m: float) -> NDArray[np.bool_]:
        """[h, w] what lies in the upright cylinder under a head."""
        top_m = self.height_of(head_camera) + HEAD_HALF_HEIGHT_M
        return (self.aside_of(head_camera) < radius_m) & (self.heights_m < top_m)

    def is_above(self, point_camera: NDArray[np.float64]) -> bool:
        """Whether a [3] point is out of view beyond the upper border alone."""
        x, y, z = point_camera.tolist()
        camera = self.cloud.camera
        return bool(
            z > 0.1
            and camera.fy * y / z + camera.cy < 0.0
            and 0.0 <= camera.fx * x / z + camera.cx < camera.width
        )

    def overview_of(self, points_camera: NDArray[np.float64]) -> NDArray[np.float64]:
        """[..., 2] right and forward of [..., 3] points."""
        return points_camera @ self.basis_camera.T

    def height_of(self, point_camera: NDArray[np.float64]) -> float:
        """Metres along up of a [3] point, as `heights_m`."""
        height_m = float(point_camera @ self.up_camera)
        return height_m if self.floor is None else height_m + self.floor.distance_m

    def point_at(self, overview_m: NDArray[np.float64], height_m: float) -> NDArray[np.float64]:
        """[..., 3] points at [..., 2] places of the overview, so high along up."""
        above_camera_m = height_m if self.floor is None else height_m - self.floor.distance_m
        return overview_m @ self.basis_camera + above_camera_m * self.up_camera

    def covered_share(self, head_camera: NDArray[np.float64]) -> float:
        """Share of a head at a [3] place that something nearer hides or that is out of view."""
        cloud = self.cloud
        camera = cloud.camera
        return covered_share(
            cloud.depth_m, (camera.fx, camera.fy), (camera.cx, camera.cy),
            tuple(head_camera.tolist()), tuple(self.up_camera.tolist()), INSIDE, NEARER_M,
        )  # fmt: skip

    def is_hidden_at(self, point_camera: NDArray[np.float64]) -> bool:
        """Whether something nearer hides a head's place."""
        row, column, in_view = self.cloud.pixel_at(point_camera)
        return in_view and bool(0.0 < self.cloud.depth_m[row, column] < point_camera[2] - NEARER_M)


def overview_basis(up_camera: NDArray[np.float64]) -> NDArray[np.float64]:
    """[2, 3] unit vectors along the floor: to the camera's right, and forward."""
    (x, y, z), right = up_camera.tolist(), right_of(up_camera).tolist()
    right_x, right_y, _ = right
    return np.array([right, [-z * right_y, z * right_x, x * right_y - y * right_x]])
