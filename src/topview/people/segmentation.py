"""Which points of the cloud are whose (Sec. 5.3.1).

Every user grows from the head: points within about half a shoulder breadth of the head's
projection on the overview belong to the user, and from there everything that can be reached over
the visible surface within the length of a body. Where two can reach a point it is the one's whose
tracked body has the nearer surface; of users without one it is the nearer head's, and both's where
both are about as near. `BY_OVERVIEW` is the thesis's way instead.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import sqrt
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.body.parts import JOINTS
from topview.body.shapes import dressed_shapes
from topview.detect.heads import HEAD_HALF_HEIGHT_M, HEAD_RADIUS_M
from topview.geometry.segments import square_distances
from topview.kernels.noise import Law
from topview.kernels.segmentation import full_pixels_of, grow_body, share_bodies
from topview.room.scene import Scene
from topview.room.surfaces import jump_of

# Ours: a limb before or behind its body is no farther from it in depth.
LIMB_STEP_M: Final = 0.3


@dataclass(frozen=True, slots=True)
class SegmentationSettings:
    """Sizes of a user in shares of the stature, and tolerances in metres; ours where not said.

    Attributes:
        core_radius: of the cylinder under a head that is the user's own, half of the shoulder
            breadth (Table 3.1) and some clothing.
        asked_core_radius: the same where a joint network is asked about everybody. By their shape
            alone people are told by all that is near below the head, as it was learnt; the back of
            a chair is among it.
        reach: the longest way over the body from the head's centre, to the toes or, with the arm
            stretched down, the fingers.
        share_m: points that are up to this much further from one head than from another are both's,
            where a user has no tracked body.
        by_overview: whether all points within `core_radius` are the user's, and of what hangs
            together with them all that is in nobody else's cylinder, even if it is another's too.
    """

    core_radius: float = 0.15
    asked_core_radius: float = 0.12
    reach: float = 1.1
    share_m: float = 0.06
    by_overview: bool = False

    def where_asked(self) -> SegmentationSettings:
        """The same, where a joint network is asked about everybody."""
        return replace(self, core_radius=self.asked_core_radius)


BY_OVERVIEW: Final = SegmentationSettings(0.26, 0.26, by_overview=True)
"""As Sec. 5.3.1 has it: about the shoulder breadth (Table 3.1) around the face."""


_BONE_TO: Final = np.array([joint.bone_to for joint in JOINTS])
# In shares of the stature, of the parts at whose end the joints lie, in clothes: the mean of their
# semi-axes at both ends.
_BONE_RADII: Final = dressed_shapes(1.0)[[joint.part for joint in JOINTS], :4].mean(1)


NO_BODY: Final = np.empty((0, 0), np.float32)


@dataclass(frozen=True, slots=True, eq=False)
class Memory:
    """A user's body as it was last known.

    Attributes:
        body_m: [h, w] how far each of its pixels was from the head, infinity elsewhere.
        depth_m: [h, w] what was seen then.
        faded_m: how much further away than then it is taken to be.
    """

    body_m: NDArray[np.float32]
    depth_m: NDArray[np.float32]
    faded_m: float


def body_distance(
    scene: Scene,
    head_camera: NDArray[np.float64],
    height_m: float,
    settings: SegmentationSettings,
    memory: Memory | None = None,
    *,
    from_head: bool = True,
    jump: Law | None = None,
) -> NDArray[np.float32]:
    """[h, w] how far each pixel is from the head over the body's surface, infinity if too far.

    Args:
        scene: what is seen.
        head_camera: [3] the head's centre.
        height_m: the user's stature.
        settings: sizes.
        memory: what is known of the user: it counts where the depth has stayed.
        from_head: whether what is seen at the head and under it is the user's; else only what is
            remembered, and what hangs together with it.
        jump: largest step in depth from a pixel to the next; `jump_of` the noise if None.
    """
    cloud = scene.cloud
    height_along_up_m = scene.height_of(head_camera)
    head_height_m = height_along_up_m if scene.floor is not None else 0.7 * height_m
    top_m = height_along_up_m + HEAD_HALF_HEIGHT_M
    x, y, z = head_camera.tolist()
    right, forward = scene.overview_of(head_camera).tolist()
    stays = jump_of(cloud.camera.noise)
    distance_m = np.empty(cloud.depth_m.shape, np.float32)
    grow_body(
        scene.standing_px,
        scene.standing,
        cloud.depth_m,
        cloud.camera.fx,
        jump or stays,
        stays,
        (x, y, z),
        (right, forward),
        HEAD_HALF_HEIGHT_M + HEAD_RADIUS_M / 2,
        (settings.core_radius * height_m, top_m - 1.1 * height_m, top_m),
        torso_reach_m(head_height_m, height_m),
        settings.reach * height_m,
        NO_BODY if memory is None else memory.body_m,
        cloud.depth_m if memory is None else memory.depth_m,
        0.0 if memory is None else memory.faded_m,
        from_head,
        distance_m,
    )
    return distance_m


def torso_reach_m(head_height_m: float, height_m: float) -> float:
    """How far aside of the head, seen from above, a torso can reach.

    The hips are 0.45 statures from the head's centre, and at most 0.53 statures over the floor;
    that leaves less room aside the higher the head is. Half a torso's breadth is added to it.
    """
    below_m = max(head_height_m - 0.53 * height_m, 0.0)
    return sqrt(max((0.45 * height_m) ** 2 - below_m**2, 0.0)) + 0.13 * height_m + 0.05


def split_users(
    scene: Scene,
    bodies_m: NDArray[np.float32],
    is_persons: Sequence[bool],
    joints_camera: Sequence[NDArray[np.float64] | None],
    heights_m: Sequence[float],
    settings: SegmentationSettings,
) -> None:
    """Leave to each user the pixels that are nearer to this user than to the others, or about as
    near, over the surface from the head (`body_distance`, `bodies_m` [N, h, w]); what a person
    reaches is none of those who are not confirmed.

    Among users whose bodies are tracked (`joints_camera` [J, 3], else None) each pixel is the
    one's to whose body it is nearest, as thick as that is with the user's stature (`heights_m`).
    """
    is_tracked = np.array([joints is not None for joints in joints_camera], np.bool_)
    is_contested = np.empty(bodies_m.shape[1:], np.bool_)
    is_confirmed = np.array(is_persons, np.bool_)
    if not share_bodies(bodies_m, is_confirmed, is_tracked, settings.share_m, is_contested):
        return
    tracked = np.flatnonzero(is_tracked).tolist()
    points = scene.cloud.points_camera[is_contested].astype(np.float64)
    contested_m = bodies_m[:, is_contested]
    to_bodies_m = np.full((len(tracked), len(points)), np.inf)
    for row, index in enumerate(tracked):
        is_reached = np.isfinite(contested_m[index])
        joints = joints_camera[index]
        assert joints is not None
        to_bodies_m[row, is_reached] = surface_distance(
            points[is_reached], joints, heights_m[index]
        )
    nearest = to_bodies_m.argmin(0)
    for row, index in enumerate(tracked):
        contested_m[index, nearest != row] = np.inf
    bodies_m[:, is_contested] = contested_m


def split_by_overview(
    scene: Scene,
    bodies_m: NDArray[np.float32],
    heads_camera: Sequence[NDArray[np.float64]],
    radii_m: Sequence[float],
) -> None:
    """Leave to each user what lies within a radius of the head, seen from above, and what hangs
    together with it outside of all others' radii; `bodies_m` as for `split_users`."""
    is_core = np.zeros(bodies_m.shape, np.bool_)
    for own, body_m, head_camera, radius_m in zip(
        is_core, bodies_m, heads_camera, radii_m, strict=True
    ):
        own[:] = np.isfinite(body_m) & (scene.aside_of(head_camera) < radius_m)
    bodies_m[is_core.any(0) & ~is_core] = np.inf


def left_of(body_m: NDArray[np.float32], nearest_m: NDArray[np.float32]) -> NDArray[np.float32]:
    """[h, w] what of a body (`body_distance`) is not nearer to another's head."""
    return np.where(nearest_m < body_m, np.float32(np.inf), body_m)


def surface_distance(
    points_camera: NDArray[np.float64],
    joints_camera: NDArray[np.float64],
    height_m: float,
    spread_m: NDArray[np.float64] | None = None,
) -> NDArray[np.float64]:
    """[N] metres from [N, 3] points to a body's surface, below 0 inside: that of round bones
    (`topview.body.JOINTS`) as thick as those of somebody of this stature in clothes; none end at
    joints that are absent, NaN. With [J] `spread_m`, bones are thicker by as much as the joints at
    their ends may be off, in the mean of both."""
    is_given = np.asarray(np.isfinite(joints_camera).all(1))
    ends = [end for end, to in enumerate(_BONE_TO) if to >= 0 and is_given[to] and is_given[end]]
    starts = _BONE_TO[ends]
    to_bones_m2 = square_distances(points_camera, joints_camera[starts], joints_camera[ends])
    radii_m = _BONE_RADII[ends] * height_m
    if spread_m is not None:
        radii_m = radii_m + 0.5 * (spread_m[starts] + spread_m[ends])
    return (np.sqrt(to_bones_m2) - radii_m).min(1)


def full_pixels(scene: Scene, is_users: NDArray[np.bool_]) -> NDArray[np.int32]:
    """Flat indices into the full image of what the cloud pixels [h, w] of a user stand for: the
    full pixels around each whose depth is the same surface's."""
    cloud, floor = scene.cloud, scene.floor
    camera = cloud.frame.camera
    return full_pixels_of(
        cloud.frame.depth_m,
        cloud.depth_m,
        is_users,
        cloud.stride,
        jump_of(camera.noise),
        (camera.fx, camera.fy),
        (camera.cx, camera.cy),
        (0.0, 0.0, 0.0, 0.0)
        if floor is None
        else (*floor.normal_camera.tolist(), floor.distance_m),
        -np.inf if floor is None else scene.settings.floor_margin_m,
        camera.noise.times(2.0),
    )
