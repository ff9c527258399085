"""Simulated people whose every pixel is labelled: what the forest of body parts learns from.

They stand, walk and act anywhere before the camera, turned in any direction, and a share of them
holds the arms anyhow: more than the simulator's scenes show, so that poses are learnt and not
scenes. (Shotton et al., CVPR 2011, Sec. 2.3 render from motion capture what we draw at random.)
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import atan2, radians
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.body.parts import JOINT_NAMES
from topview.detect.forest.classes import CLASS_INDEX, CLASSES
from topview.detect.forest.growing import NO_CLASS, LabelledBody
from topview.detect.forest.model import person_depth
from topview.evaluate.joints import RENDERED_JOINTS
from topview.records import Camera
from topview.score.utvr import DepthView
from topview.sim.actions import ACTIONS
from topview.sim.bodies import JOINT_NAMES as SIM_JOINTS
from topview.sim.bodies import PART_NAMES, Body
from topview.sim.furniture import furnished
from topview.sim.images import Rendering
from topview.sim.motions import Clip
from topview.sim.paths import Path
from topview.sim.render import draw_people
from topview.sim.room import render_room
from topview.sim.scene import Mount
from topview.sim.scenes import KINECT_V1_HALF
from topview.sim.scenes.stage import TO_CAMERA, Casting, varied_room
from topview.sim.sensor import DepthCamera
from topview.sim.skeleton import LIMITS_RAD, SEGMENT_INDEX, Pose, segment_poses
from topview.sim.truth import part_frames

Array = NDArray[np.float64]

# All ours.
PER_ROOM: Final = 40
"""Images that share a room, whose drawing takes as long as five of them."""
DISTANCES_M: Final = (1.5, 4.3)
CAMERA_HEIGHTS_M: Final = (0.7, 2.2)
AIM_M: Final = (2.8, 0.95)
"""How far away and how high the camera looks, and by how much that varies, in radians."""
AIM_SPREAD_RAD: Final = 0.06
PAIR_SHARE: Final = 0.5
"""Images with two people, at times one before the other."""
FACING_SHARE: Final = 0.6
FACING_SPREAD_RAD: Final = radians(40.0)
"""People who more or less face the camera, as most do before one; the others face anywhere."""
SECOND_CLIP_SHARE: Final = 0.3
WALK_SHARE: Final = 0.15
ANY_ARMS_SHARE: Final = 0.25
"""People whose arms are held anyhow within the limits, in place of their action's."""
SPREAD_RAD: Final = 0.12
"""Standard deviation of what is added to every angle."""
FEET_LOST_M: Final = 0.06
"""Of the floor's neighbourhood, at most so much is lost with the floor."""
LEAST_PIXELS: Final = 250


@dataclass(frozen=True, slots=True, eq=False)
class KnownBody:
    """A labelled person, as cut out of an image.

    Attributes:
        body: depth and labels.
        view: its depth, with the cut-out's principal point.
        joints_camera: [16, 3] metres, `topview.body.JOINT_NAMES` by the simulator's conventions.
        is_shown: [16] whether pixels around the joint are seen at all.
    """

    body: LabelledBody
    view: DepthView
    joints_camera: Array
    is_shown: NDArray[np.bool_]


def simulated_bodies(
    images: int, seed: int, camera: Camera = KINECT_V1_HALF
) -> Iterator[list[KnownBody]]:
    """The people of each image."""
    for room_number in range(-(-images // PER_ROOM)):
        rng = np.random.default_rng((seed, room_number))
        room, _ = varied_room(rng)
        height_m = rng.uniform(*CAMERA_HEIGHTS_M)
        tilt_rad = atan2(height_m - AIM_M[1], AIM_M[0]) + rng.normal(0.0, AIM_SPREAD_RAD)
        mount = Mount(height_m, tilt_rad)
        background = render_room(room, furnished(rng, room), camera, mount)
        sensor = DepthCamera(camera, int(rng.integers(2**31)))
        for _ in range(min(PER_ROOM, images - room_number * PER_ROOM)):
            yield _image(background, mount, sensor, rng)


def _image(
    background: Rendering, mount: Mount, sensor: DepthCamera, rng: np.random.Generator
) -> list[KnownBody]:
    casting = Casting(rng)
    T_camera_room = mount.T_camera_room()
    places = _places(sensor.camera, rng)
    bodies, Ts = [], []
    for x, y in places:
        body, pose = _somebody(casting, float(x), float(y), rng)
        bodies.append(body)
        Ts.append(T_camera_room @ segment_poses(body.offsets_m, pose))
    drawn = draw_people(bodies, Ts, background, sensor.camera)
    depth_m = sensor.sense(drawn, rng).astype(np.float32) / np.float32(1000.0)
    found = []
    for k, (body, T) in enumerate(zip(bodies, Ts, strict=True), start=1):
        feet_lost_m = rng.uniform(0.0, FEET_LOST_M)
        known = _cut_out(body, T, k, drawn, depth_m, sensor.camera, mount, feet_lost_m)
        if known is not None:
            found.append(known)
    return found


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
    points = ((x, y),)
    start_s = 0.0
    if rng.random() < WALK_SHARE:
        ahead = 2.0 * np.array([np.cos(heading), np.sin(heading)])
        points = (
            (x - float(ahead[0]), y - float(ahead[1])),
            (x + float(ahead[0]), y + float(ahead[1])),
        )
    path = Path(points, heading, heading, start_s)
    time_s = float(rng.uniform(1.5, 2.4)) if len(points) == 2 else float(rng.uniform(0.0, 12.0))
    names = list(ACTIONS)
    clips = []
    for _ in range(1 + int(rng.random() < SECOND_CLIP_SHARE)):
        name = names[rng.integers(len(names))]
        begin = time_s - float(rng.uniform(0.3, 6.0))
        side = "l" if rng.random() < 0.5 else "r"
        target = None
        if name in ("handshake", "hug", "throw_to", "catch_from", "reaching", "pointing"):
            target = (x + 1.0 * np.cos(heading), y + 1.0 * np.sin(heading), 1.0)
        clips.append(Clip(name, begin, begin + 8.0, side, target_room=target))
    actor = casting.actor(path, tuple(clips))
    pose = actor.performance.pose(actor.body, time_s)
    return actor.body, _varied(pose, rng)


def _varied(pose: Pose, rng: np.random.Generator) -> Pose:
    angles = pose.angles_rad + rng.normal(0.0, SPREAD_RAD, pose.angles_rad.shape)
    if rng.random() < ANY_ARMS_SHARE:
        for side in "lr":
            for name in ("upper_arm", "forearm"):
                row = SEGMENT_INDEX[f"{name}_{side}"]
                angles[row] = rng.uniform(LIMITS_RAD[row, :, 0], LIMITS_RAD[row, :, 1])
    return replace(pose, angles_rad=np.clip(angles, LIMITS_RAD[..., 0], LIMITS_RAD[..., 1]))


def _cut_out(
    body: Body,
    Ts_camera_segment: Array,
    person: int,
    drawn: Rendering,
    depth_m: NDArray[np.float32],
    camera: Camera,
    mount: Mount,
    feet_lost_m: float,
) -> KnownBody | None:
    joints = body.joints(Ts_camera_segment)
    Ts_camera_part = part_frames(joints, Ts_camera_segment)
    is_body = (drawn.instance == person) & (depth_m > 0.0)
    v, u = np.nonzero(is_body)
    z = depth_m[v, u].astype(np.float64)
    points = np.stack([(u - camera.cx) * z / camera.fx, (v - camera.cy) * z / camera.fy, z], axis=1)
    T = mount.T_camera_room()
    heights_m = (points - T[:3, 3]) @ T[:3, 2]
    kept = heights_m > feet_lost_m
    is_body[v[~kept], u[~kept]] = False
    v, u, points = v[kept], u[kept], points[kept]
    if len(v) < LEAST_PIXELS:
        return None
    label = np.full(depth_m.shape, NO_CLASS, np.uint8)
    label[v, u] = part_classes(points, drawn.part[v, u], joints, Ts_camera_part)
    top, left = v.min(), u.min()
    window = np.s_[top : v.max() + 1, left : u.max() + 1]
    cut = LabelledBody(
        np.ascontiguousarray(person_depth(depth_m, is_body)[window]),
        np.ascontiguousarray(label[window]),
    )
    view = DepthView(cut.depth_m, camera.fx, camera.fy, camera.cx - left, camera.cy - top)
    return KnownBody(cut, view, joints[_OURS], _shown(points, joints[_OURS]))


_SIM_NAME: Final = {ours: theirs for theirs, ours in RENDERED_JOINTS.items() if ours is not None}
_OURS: Final = [SIM_JOINTS.index(_SIM_NAME[name]) for name in JOINT_NAMES]
SHOWN_M: Final = 0.2


def _shown(points: Array, joints_camera: Array) -> NDArray[np.bool_]:
    """[J] whether any of the points is near the joint."""
    gaps = np.linalg.norm(points[:, None] - joints_camera, axis=-1)
    return np.asarray((gaps < SHOWN_M).sum(0) >= 8)


# Where along a part one class ends and the next begins, as shares of its length.
_ALONG: Final[dict[str, tuple[tuple[float, str], ...]]] = {
    "head": ((np.inf, "head"),),
    "upper_torso": ((0.7, "chest"), (np.inf, "waist")),
    "lower_torso": ((0.4, "waist"), (np.inf, "pelvis")),
    "upper_arm": ((0.3, "shoulder"), (0.75, "upper_arm"), (np.inf, "elbow")),
    "forearm": ((0.25, "elbow"), (0.85, "forearm"), (np.inf, "hand")),
    "hand": ((np.inf, "hand"),),
    "upper_leg": ((0.3, "hip"), (0.78, "upper_leg"), (np.inf, "knee")),
    "lower_leg": ((0.22, "knee"), (0.8, "lower_leg"), (np.inf, "ankle")),
    "foot": ((0.3, "ankle"), (np.inf, "foot")),
}
NECK_M: Final = 0.09
"""What is nearer to the neck joint, seen along the trunk or across it, is neck."""
SHOULDER_M: Final = 0.11
"""What of the trunk is nearer to a shoulder is shoulder."""


def part_classes(
    points: Array, part: NDArray[np.uint8], joints_camera: Array, Ts_camera_part: Array
) -> NDArray[np.uint8]:
    """[S] index into `CLASSES` of points [S, 3] on parts [S] (index into `sim.bodies.PART_NAMES`)
    of a person with these joints [21, 3] and part frames [15, 4, 4]."""
    out = np.empty(len(points), np.uint8)
    for index, name in enumerate(PART_NAMES):
        own = np.flatnonzero(part == index)
        stem, side = (name[:-2], name[-2:]) if name[-2:] in ("_l", "_r") else (name, "")
        local = (points[own] - Ts_camera_part[index, :3, 3]) @ Ts_camera_part[index, :3, :3]
        far = joints_camera[_END[index]] - Ts_camera_part[index, :3, 3]
        share = local[:, 1] / np.linalg.norm(far)
        is_left = np.full(len(own), side == "_l") if side else local[:, 0] < 0.0
        ends = np.array([end for end, _ in _ALONG[stem]])
        which = np.searchsorted(ends, share)
        for k, (_, kind) in enumerate(_ALONG[stem]):
            for left, prefix in ((True, "left_"), (False, "right_")):
                code = CLASS_INDEX.get(kind, CLASS_INDEX.get(prefix + kind, 0))
                out[own[(which == k) & (is_left == left)]] = code
    trunk = np.flatnonzero(part == PART_NAMES.index("upper_torso"))
    for joint, kind, radius_m in (
        ("shoulder_l", "left_shoulder", SHOULDER_M),
        ("shoulder_r", "right_shoulder", SHOULDER_M),
        ("neck", "neck", NECK_M),
    ):
        gaps = np.linalg.norm(points[trunk] - joints_camera[SIM_JOINTS.index(joint)], axis=1)
        out[trunk[gaps < radius_m]] = CLASS_INDEX[kind]
    assert len(CLASSES) <= NO_CLASS
    return out


_END: Final = [
    SIM_JOINTS.index(
        {"head": "neck", "upper_torso": "torso", "lower_torso": "pelvis"}.get(name)
        or {"upper_arm": "elbow", "forearm": "wrist", "hand": "hand", "upper_leg": "knee",
            "lower_leg": "ankle", "foot": "foot"}[name[:-2]] + name[-2:]
    )
    for name in PART_NAMES
]  # fmt: skip
