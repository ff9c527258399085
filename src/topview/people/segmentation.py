"""Which points of the cloud are whose (Sec. 5.3.1).

Every user grows from the head: points within about half a shoulder breadth of the head's
projection on the overview belong to the user, and from there everything that can be reached over
the visible surface within the length of a body. Where two can reach a point it is the nearer one's;
points that are about as near to both are given to both.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from topview.body.parts import JOINTS
from topview.detect.cloud import Cloud, depth_noise_m
from topview.detect.heads import HEAD_HALF_HEIGHT_M, HEAD_RADIUS_M, right_of
from topview.kernels.segmentation import full_pixels_of, geodesic_distance, seed_body
from topview.people.floor import CAMERA_UP, FloorPlane

# Depths of neighbouring pixels on one surface differ by up to this, plus three standard deviations
# of the noise of both (`depth_noise_m`); ours: a hand on a hip is further away from what is behind.
JUMP_M = 0.04
JUMP_PER_SQUARE_M = 0.0035


@dataclass(frozen=True, slots=True)
class SegmentationSettings:
    """Sizes of a user in shares of the stature, and tolerances in metres; ours where not said.

    Attributes:
        floor_margin_m: what is lower than this, plus the noise, is floor; a foot is 7 cm high.
        core_radius: of the cylinder under the head that is the user's own, half of the shoulder
            breadth (Table 3.1) and some clothing.
        reach: the longest way over the body from the head's centre, to the toes or, with the arm
            stretched down, the fingers.
        bulk_radius_m: of a disc that fits into a child's torso, but into no limb: a thigh is
            18 cm across (NASA-STD-3000).
        huge_core_m2: area of a surface after `bulk_radius_m` is taken off all round, from which
            it is no person: two people who touch side by side are below it.
        share_m: points that are this much further from one user than from another are both's.
    """

    floor_margin_m: float = 0.035
    core_radius: float = 0.15
    reach: float = 1.1
    bulk_radius_m: float = 0.13
    huge_core_m2: float = 0.8
    share_m: float = 0.06


@dataclass(frozen=True, slots=True, eq=False)
class Scene:
    """A cloud with up and down: heights, the overview, and what may be a person's.

    Attributes:
        cloud: the small cloud.
        floor: the floor if one is in view.
        up_camera: [3] the floor's normal, else the camera's own up.
        basis_camera: [2, 3] unit vectors along the floor: to the camera's right, and forward.
        heights_m: [h, w] along `up_camera`: over the floor, else over the camera.
        overview_m: [h, w, 2] the points seen from above (right, forward).
        is_free_standing: [h, w] pixels with a reading that are neither floor, wall nor known
            background.
        inset_m: [h, w] how far each pixel is from the nearest depth edge or hole; 0 on them.
        is_bulky: [h, w] surfaces that a disc of `bulk_radius_m` fits into: torsos and furniture,
            but no limb.
    """

    cloud: Cloud
    floor: FloorPlane | None
    up_camera: NDArray[np.float64]
    basis_camera: NDArray[np.float64]
    heights_m: NDArray[np.float32]
    overview_m: NDArray[np.float32]
    is_free_standing: NDArray[np.bool_]
    inset_m: NDArray[np.float32]
    is_bulky: NDArray[np.bool_]

    @classmethod
    def of(
        cls,
        cloud: Cloud,
        floor: FloorPlane | None,
        is_background: NDArray[np.bool_],
        settings: SegmentationSettings,
    ) -> Scene:
        """`is_background` [h, w]: what is known to be the room's."""
        up_camera = CAMERA_UP if floor is None else floor.normal_camera
        points = cloud.points_camera
        heights_m = points @ up_camera.astype(np.float32)
        is_free_standing = cloud.has_reading & ~is_background
        if floor is not None:
            heights_m += np.float32(floor.distance_m)
            margin = floor_margin_m(cloud.depth_m, heights_m, floor, settings)
            is_free_standing = is_free_standing & (heights_m > margin)
        inset_m = inset_of_surfaces(cloud, is_free_standing)
        is_bulky, is_huge = bulky_surfaces(cloud, is_free_standing, inset_m, settings)
        is_free_standing = is_free_standing & ~is_huge
        basis_camera = overview_basis(up_camera)
        return cls(
            cloud,
            floor,
            up_camera,
            basis_camera,
            heights_m,
            points @ basis_camera.T.astype(np.float32),
            is_free_standing,
            inset_m,
            is_bulky,
        )

    def is_under(self, head_camera: NDArray[np.float64], radius_m: float) -> NDArray[np.bool_]:
        """[h, w] what lies in the upright cylinder under a head."""
        right, forward = self.overview_of(head_camera)
        aside_m = np.hypot(self.overview_m[..., 0] - right, self.overview_m[..., 1] - forward)
        top_m = self.height_of(head_camera) + HEAD_HALF_HEIGHT_M
        return (aside_m < radius_m) & (self.heights_m < top_m)

    def is_out(self, point_camera: NDArray[np.float64], border_m: float) -> bool:
        """Whether a [3] point is out of view, or less than `border_m` from where the view ends."""
        z = float(point_camera[2])
        camera = self.cloud.camera
        if z <= 0.1:
            return True
        u = point_camera[0] / z * camera.fx + camera.cx
        v = point_camera[1] / z * camera.fy + camera.cy
        border_px = border_m / z * camera.fx
        return not (
            border_px <= u < camera.width - border_px and border_px <= v < camera.height - border_px
        )

    def overview_of(self, points_camera: NDArray[np.float64]) -> NDArray[np.float64]:
        """[..., 2] right and forward of [..., 3] points."""
        return points_camera @ self.basis_camera.T

    def height_of(self, point_camera: NDArray[np.float64]) -> float:
        """Metres along up of a [3] point, as `heights_m`."""
        height_m = float(point_camera @ self.up_camera)
        return height_m if self.floor is None else height_m + self.floor.distance_m


def floor_margin_m(
    depth_m: NDArray[np.float32],
    heights_m: NDArray[np.floating],
    floor: FloorPlane,
    settings: SegmentationSettings,
) -> NDArray[np.floating]:
    """How high a reading of the floor may seem to be: the noise lies along the ray, so that it
    moves a point up by the share of the ray's own descent."""
    drop_per_m = np.abs(heights_m - np.float32(floor.distance_m)) / np.maximum(depth_m, 0.1)
    return settings.floor_margin_m + 2.0 * depth_noise_m(depth_m) * drop_per_m


def overview_basis(up_camera: NDArray[np.float64]) -> NDArray[np.float64]:
    """[2, 3] unit vectors along the floor: to the camera's right, and forward."""
    right = right_of(up_camera)
    return np.stack([right, np.cross(up_camera, right)])


def inset_of_surfaces(cloud: Cloud, is_allowed: NDArray[np.bool_]) -> NDArray[np.float32]:
    """[h, w] metres from each pixel to the nearest depth edge, hole or forbidden pixel."""
    depth = cloud.depth_m
    jump = JUMP_M + JUMP_PER_SQUARE_M * depth * depth
    is_inner = is_allowed.astype(np.uint8)
    is_inner[:, 1:][np.abs(depth[:, 1:] - depth[:, :-1]) > jump[:, 1:]] = 0
    is_inner[1:][np.abs(depth[1:] - depth[:-1]) > jump[1:]] = 0
    inset_px = cv2.distanceTransform(is_inner, cv2.DIST_L2, 3)
    inset_px = np.minimum(inset_px, max(inset_px.shape))  # without an edge it is all but infinite
    return inset_px * depth / np.float32(cloud.camera.fx)


def bulky_surfaces(
    cloud: Cloud,
    is_allowed: NDArray[np.bool_],
    inset_m: NDArray[np.float32],
    settings: SegmentationSettings,
) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """[h, w] what a disc of `bulk_radius_m` fits into between depth edges (a morphological
    opening), and what of it is part of something larger than any person."""
    pixel_m = cloud.depth_m / np.float32(cloud.camera.fx)
    is_core = inset_m > settings.bulk_radius_m
    is_bulky = np.isfinite(
        surface_distance(cloud, is_allowed, _at(is_core), settings.bulk_radius_m)
    )
    _, numbers = cv2.connectedComponents(is_core.astype(np.uint8), connectivity=4)
    labels = np.asarray(numbers, np.int32)
    area_m2 = np.bincount(labels.ravel(), (pixel_m * pixel_m).ravel())
    area_m2[0] = 0.0
    is_huge_core = (area_m2 > settings.huge_core_m2)[labels]
    if not is_huge_core.any():
        return is_bulky, np.zeros_like(is_bulky)
    return is_bulky, np.isfinite(
        surface_distance(cloud, is_allowed, _at(is_huge_core), settings.bulk_radius_m)
    )


def surface_distance(
    cloud: Cloud,
    is_allowed: NDArray[np.bool_],
    start_m: NDArray[np.float32],
    limit_m: float,
) -> NDArray[np.float32]:
    """[h, w] length of the shortest way over the allowed surface from where `start_m` [h, w] is
    finite, added to it; infinity where there is none up to `limit_m`."""
    distance_m = np.where(is_allowed & (start_m <= limit_m), start_m, np.float32(np.inf))
    geodesic_distance(
        cloud.depth_m,
        is_allowed,
        cloud.camera.fx,
        JUMP_M,
        JUMP_PER_SQUARE_M,
        limit_m,
        np.empty(distance_m.size, np.int32),
        np.zeros(distance_m.shape, np.bool_),
        distance_m,
    )
    return distance_m


def _at(is_seed: NDArray[np.bool_]) -> NDArray[np.float32]:
    """[h, w] 0 at the seeds, infinity elsewhere."""
    return np.where(is_seed, np.float32(0.0), np.float32(np.inf))


def body_distance(
    scene: Scene,
    head_camera: NDArray[np.float64],
    height_m: float,
    settings: SegmentationSettings,
    remembered_m: NDArray[np.float32] | None = None,
    *,
    from_head: bool = True,
) -> NDArray[np.float32]:
    """[h, w] how far each pixel is from the head over the body's surface, infinity if too far.

    Args:
        scene: what is seen.
        head_camera: [3] the head's centre.
        height_m: the user's stature.
        settings: sizes.
        remembered_m: [h, w] how far the pixels that are known to be the user's are, infinity
            elsewhere.
        from_head: whether what is seen at the head and under it is the user's; else only what is
            remembered, and what hangs together with it.
    """
    cloud = scene.cloud
    height_along_up_m = scene.height_of(head_camera)
    head_height_m = height_along_up_m if scene.floor is not None else 0.7 * height_m
    top_m = height_along_up_m + HEAD_HALF_HEIGHT_M
    is_allowed = np.empty(cloud.depth_m.shape, np.bool_)
    start_m = np.empty(cloud.depth_m.shape, np.float32)
    seed_body(
        cloud.points_camera,
        scene.overview_m,
        scene.heights_m,
        scene.is_free_standing,
        scene.is_bulky,
        head_camera.astype(np.float32),
        scene.overview_of(head_camera).astype(np.float32),
        HEAD_HALF_HEIGHT_M + HEAD_RADIUS_M / 2,
        settings.core_radius * height_m,
        top_m - 1.1 * height_m,
        top_m,
        torso_reach_m(head_height_m, height_m),
        is_allowed,
        start_m,
    )
    if remembered_m is not None:
        start_m = np.where(np.isfinite(start_m) & from_head, start_m, remembered_m)
    elif not from_head:
        start_m[:] = np.inf
    return surface_distance(cloud, is_allowed, start_m, settings.reach * height_m)


def torso_reach_m(head_height_m: float, height_m: float) -> float:
    """How far aside of the head, seen from above, a torso can reach.

    The hips are 0.45 statures from the head's centre, and at most 0.53 statures over the floor;
    that leaves less room aside the higher the head is. Half a torso's breadth is added to it.
    """
    below_m = max(head_height_m - 0.53 * height_m, 0.0)
    return float(np.sqrt(max((0.45 * height_m) ** 2 - below_m**2, 0.0))) + 0.13 * height_m + 0.05


def split_users(
    scene: Scene,
    distances_m: Sequence[NDArray[np.float32]],
    joints_camera: Sequence[NDArray[np.float64] | None],
    settings: SegmentationSettings,
) -> list[NDArray[np.bool_]]:
    """[h, w] per user: the pixels that are nearer to this user than to the others, or about as
    near.

    Over the surface from the head (`body_distance`, `distances_m`); but among users whose bodies
    are tracked (`joints_camera` [J, 3], else None) it is the distance to the bones that counts.
    """
    if not distances_m:
        return []
    nearest = np.minimum.reduce(list(distances_m))
    masks = [np.isfinite(own) & (own <= nearest + settings.share_m) for own in distances_m]
    tracked = [index for index, joints in enumerate(joints_camera) if joints is not None]
    reached = np.sum([np.isfinite(distances_m[index]) for index in tracked], axis=0)
    is_contested = np.asarray(reached > 1)
    if not is_contested.any():
        return masks
    points = scene.cloud.points_camera[is_contested].astype(np.float64)
    to_bones_m = np.full((len(tracked), len(points)), np.inf)
    for row, index in enumerate(tracked):
        is_reached = np.isfinite(distances_m[index][is_contested])
        joints = joints_camera[index]
        assert joints is not None
        to_bones_m[row, is_reached] = bone_distance(points[is_reached], joints)
    is_own = np.isfinite(to_bones_m) & (to_bones_m <= to_bones_m.min(0) + settings.share_m)
    for row, index in enumerate(tracked):
        masks[index][is_contested] = is_own[row]
    return masks


def bone_distance(
    points_camera: NDArray[np.float64], joints_camera: NDArray[np.float64]
) -> NDArray[np.float64]:
    """[N] metres from [N, 3] points to the nearest of a body's bones (`topview.body.JOINTS`)."""
    bones = [(joint.bone_to, end) for end, joint in enumerate(JOINTS) if joint.bone_to >= 0]
    starts, ends = (joints_camera[list(indices)] for indices in zip(*bones, strict=True))
    along = ends - starts
    offset = points_camera[:, None] - starts
    square = np.maximum((along**2).sum(-1), 1e-9)
    share = np.clip(np.einsum("nbi,bi->nb", offset, along) / square, 0.0, 1.0)
    offset -= share[..., None] * along
    return np.sqrt(np.einsum("nbi,nbi->nb", offset, offset).min(1))


def full_pixels(
    scene: Scene, is_users: NDArray[np.bool_], settings: SegmentationSettings
) -> NDArray[np.int32]:
    """Flat indices into the full image of what the cloud pixels [h, w] of a user stand for: the
    full pixels around each whose depth is the same surface's."""
    cloud = scene.cloud
    full_depth_m, camera = cloud.frame.depth_m, cloud.frame.camera
    pixels = np.empty(full_depth_m.size, np.int32)
    count = full_pixels_of(
        full_depth_m, cloud.depth_m, is_users, cloud.stride, JUMP_M, JUMP_PER_SQUARE_M, pixels
    )
    pixels = pixels[:count].copy()
    if scene.floor is None:
        return pixels
    row, column = np.divmod(pixels, full_depth_m.shape[1])
    depth_m = full_depth_m.ravel()[pixels]
    up = scene.floor.normal_camera
    rise = (column - camera.cx) * (up[0] / camera.fx) + (row - camera.cy) * (up[1] / camera.fy)
    heights_m = (rise + up[2]) * depth_m + scene.floor.distance_m
    return pixels[heights_m > floor_margin_m(depth_m, heights_m, scene.floor, settings)]
