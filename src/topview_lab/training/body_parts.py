"""Training data of the forest of body parts: simulated people with a label for every pixel.

They stand, walk and act anywhere in view, facing any direction, and some hold their arms in random
poses. That is more variety than in the simulator's scenes, so that poses are learnt and not scenes.
(Shotton et al., CVPR 2011, Sec. 2.3 render from motion capture what we draw at random.)
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import atan2, radians
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.body.parts import JOINT_NAMES
from topview.camera import unproject_depth
from topview.camera.pyramid import DepthView
from topview.records import Camera
from topview_lab.datasets.joints import RENDERED_JOINTS
from topview_lab.rivals.forest.growing import NO_CLASS, LabelledBody
from topview_lab.rivals.forest.model import person_depth
from topview_lab.sim.actions import ACTIONS
from topview_lab.sim.bodies import SIM_JOINT_NAMES, Body
from topview_lab.sim.furniture import furnished
from topview_lab.sim.images import Rendering
from topview_lab.sim.motions import Clip
from topview_lab.sim.paths import Path
from topview_lab.sim.render import draw_people
from topview_lab.sim.room import render_room
from topview_lab.sim.scene import Mount
from topview_lab.sim.scenes import KINECT_V1_HALF
from topview_lab.sim.scenes.stage import TO_CAMERA, Casting, varied_room
from topview_lab.sim.sensor import DepthCamera
from topview_lab.sim.skeleton import SEGMENT_INDEX, SEGMENT_LIMITS_RAD, Pose, segment_poses
from topview_lab.sim.truth import part_frames
from topview_lab.training.part_classes import part_classes

Array = NDArray[np.float64]

# All ours.
PER_ROOM: Final = 40
"""Images that share a room, as rendering a room takes as long as five images."""
DISTANCES_M: Final = (1.5, 4.3)
CAMERA_HEIGHTS_M: Final = (0.7, 2.2)
VARIED_AIM_M: Final = (2.8, 0.95)
"""Distance and height of the point that the camera looks at; its direction varies by
`AIM_SPREAD_RAD`."""
AIM_SPREAD_RAD: Final = 0.06
PAIR_SHARE: Final = 0.5
"""Share of images with two people, sometimes one in front of the other."""
FACING_SHARE: Final = 0.6
FACING_SPREAD_RAD: Final = radians(40.0)
"""Share of people who roughly face the camera, and how roughly; the others face anywhere."""
SECOND_CLIP_SHARE: Final = 0.3
WALK_SHARE: Final = 0.15
WALKED_M: Final = 2.0
"""Distance that people walk before and after their place."""
MIDWAY_S: Final = (1.5, 2.4)
INTO_ACTION_S: Final = (0.3, 6.0)
"""How long ago an action began."""
WITH_TARGET: Final = ("handshake", "hug", "throw_to", "catch_from", "reaching", "pointing")
"""Actions with a target in the room; here it is 1 m ahead and 1 m high."""
ANY_ARMS_SHARE: Final = 0.25
"""Share of people whose arms have random angles within the limits instead of their action's."""
SPREAD_RAD: Final = 0.12
"""Standard deviation of the noise on every angle."""
FEET_LOST_M: Final = 0.06
"""Greatest height up to which points are removed together with the floor."""
LEAST_PERSON_PIXELS: Final = 250


@dataclass(frozen=True, slots=True, eq=False)
class RenderedBody:
    """A labelled person, cut out of an image.

    Attributes:
        body: depth and labels.
        view: its depth, with the cut-out's principal point.
        joints_camera: [16, 3] metres, `topview.body.JOINT_NAMES` by the simulator's conventions.
        is_shown: [16] whether any pixels around the joint are visible.
    """

    body: LabelledBody
    view: DepthView
    joints_camera: Array
    is_shown: NDArray[np.bool_]


def simulated_bodies(
    images: int, seed: int, camera: Camera = KINECT_V1_HALF
) -> Iterator[list[RenderedBody]]:
    """The people of each image."""
    for room_number in range(-(-images // PER_ROOM)):
        rng = np.random.default_rng((seed, room_number))
        room, _ = varied_room(rng)
        height_m = rng.uniform(*CAMERA_HEIGHTS_M)
        tilt_rad = atan2(height_m - VARIED_AIM_M[1], VARIED_AIM_M[0]) + rng.normal(
            0.0, AIM_SPREAD_RAD
        )
        mount = Mount(height_m, tilt_rad)
        background = render_room(room, furnished(rng, room), camera, mount)
        sensor = DepthCamera(camera, int(rng.integers(2**31)))
        for _ in range(min(PER_ROOM, images - room_number * PER_ROOM)):
            yield _image(background, mount, sensor, rng)


def _image(
    background: Rendering, mount: Mount, sensor: DepthCamera, rng: np.random.Generator
) -> list[RenderedBody]:
    casting, camera = Casting(rng), sensor.camera
    T_camera_room = mount.T_camera_room()
    places = _places(camera, rng)
    bodies, Ts = [], []
    for x, y in places:
        body, pose = _somebody(casting, float(x), float(y), rng)
        bodies.append(body)
        Ts.append(T_camera_room @ segment_poses(body.offsets_m, pose))
    drawn = draw_people(bodies, Ts, background, camera)
    depth_m = sensor.sense(drawn, rng).astype(np.float32) / np.float32(1000.0)
    seen = DepthView(depth_m, camera.fx, camera.fy, camera.cx, camera.cy)
    points = unproject_depth(depth_m, camera).astype(np.float64)
    heights_m = (points - T_camera_room[:3, 3]) @ T_camera_room[:3, 2]
    found = [
        _cut_out(k, body, T, drawn, seen, heights_m, rng.uniform(0.0, FEET_LOST_M))
        for k, (body, T) in enumerate(zip(bodies, Ts, strict=True), start=1)
    ]
    return [known for known in found if known is not None]


def _places(camera: Camera, rng: np.random.Generator) -> Array:
    """[1 or 2, 2] in the room: anywhere in view, or near the first one's line of sight."""
    half_width = 0.5 * camera.width / camera.fx
    y = rng.uniform(*DISTANCES_M)
    first = np.array([rng.uniform(-0.75, 0.75) * half_width * y, y])
    if rng.random() >= PAIR_SHARE:
        return first[None]
    other_y = rng.uniform(*DISTANCES_M)
    if abs(other_y - y) < 0.5:
        other_y = y + 0.6
    aside = rng.normal(0.0, 0.4) + first[0] * other_y / y
    return np.stack([first, [aside, other_y]])


def _somebody(casting: Casting, x: float, y: float, rng: np.random.Generator) -> tuple[Body, Pose]:
    """A body and its pose: one action or two, walking or not, with noise on every angle."""
    heading = rng.uniform(-np.pi, np.pi)
    if rng.random() < FACING_SHARE:
        heading = rng.normal(TO_CAMERA, FACING_SPREAD_RAD)
    ahead_x, ahead_y = float(np.cos(heading)), float(np.sin(heading))
    points, times_s = ((x, y),), (0.0, 12.0)
    if rng.random() < WALK_SHARE:
        points = (
            (x - WALKED_M * ahead_x, y - WALKED_M * ahead_y),
            (x + WALKED_M * ahead_x, y + WALKED_M * ahead_y),
        )
        times_s = MIDWAY_S
    time_s = float(rng.uniform(*times_s))
    clips = []
    for _ in range(1 + int(rng.random() < SECOND_CLIP_SHARE)):
        name = list(ACTIONS)[rng.integers(len(ACTIONS))]
        start_s = time_s - float(rng.uniform(*INTO_ACTION_S))
        side = "l" if rng.random() < 0.5 else "r"
        target = (x + ahead_x, y + ahead_y, 1.0) if name in WITH_TARGET else None
        clips.append(Clip(name, start_s, start_s + 8.0, side, target_room=target))
    actor = casting.actor(Path(points, heading, heading), tuple(clips))
    return actor.body, _varied(actor.performance.pose(actor.body, time_s), rng)


def _varied(pose: Pose, rng: np.random.Generator) -> Pose:
    """Add noise to every joint angle; some people get random arms."""
    angles = pose.angles_rad + rng.normal(0.0, SPREAD_RAD, pose.angles_rad.shape)
    if rng.random() < ANY_ARMS_SHARE:
        for side in "lr":
            for name in ("upper_arm", "forearm"):
                row = SEGMENT_INDEX[f"{name}_{side}"]
                angles[row] = rng.uniform(
                    SEGMENT_LIMITS_RAD[row, :, 0], SEGMENT_LIMITS_RAD[row, :, 1]
                )
    return replace(
        pose, angles_rad=np.clip(angles, SEGMENT_LIMITS_RAD[..., 0], SEGMENT_LIMITS_RAD[..., 1])
    )


def _cut_out(
    person: int,
    body: Body,
    Ts_camera_segment: Array,
    drawn: Rendering,
    seen: DepthView,
    heights_m: Array,
    floor_m: float,
) -> RenderedBody | None:
    """Cut one person out of an image; None if hardly anything of the person is visible.

    Args:
        person: the number in `drawn`.
        body: of that person.
        Ts_camera_segment: [S, 4, 4] the pose.
        drawn: the noise-free rendering, which labels each pixel.
        seen: the sensor's depth image.
        heights_m: [H, W] of what is seen, over the floor.
        floor_m: what is lower counts as floor.
    """
    is_body = (drawn.instance == person) & (seen.depth_m > 0.0) & (heights_m > floor_m)
    v, u = np.nonzero(is_body)
    if len(v) < LEAST_PERSON_PIXELS:
        return None
    z = seen.depth_m[v, u].astype(np.float64)
    points = np.stack([(u - seen.cx) * z / seen.fx, (v - seen.cy) * z / seen.fy, z], axis=1)
    joints = body.joints(Ts_camera_segment)
    label = np.full(is_body.shape, NO_CLASS, np.uint8)
    label[v, u] = part_classes(
        points, drawn.part[v, u], joints, part_frames(joints, Ts_camera_segment)
    )
    window = np.s_[v.min() : v.max() + 1, u.min() : u.max() + 1]
    depth_m = np.ascontiguousarray(person_depth(seen.depth_m, is_body)[window])
    view = DepthView(depth_m, seen.fx, seen.fy, seen.cx - u.min(), seen.cy - v.min())
    cut = LabelledBody(depth_m, np.ascontiguousarray(label[window]))
    return RenderedBody(cut, view, joints[_OURS], _shown(points, joints[_OURS]))


_SIM_NAME: Final = {ours: theirs for theirs, ours in RENDERED_JOINTS.items() if ours is not None}
_OURS: Final = [SIM_JOINT_NAMES.index(_SIM_NAME[name]) for name in JOINT_NAMES]
# Ours: a joint with this many points within this distance is visible.
SHOWN_M: Final = 0.2
SHOWN_POINTS: Final = 8


def _shown(points: Array, joints_camera: Array) -> NDArray[np.bool_]:
    """[J] whether points are near the joint."""
    gaps = np.linalg.norm(points[:, None] - joints_camera, axis=-1)
    return np.asarray((gaps < SHOWN_M).sum(0) >= SHOWN_POINTS)
