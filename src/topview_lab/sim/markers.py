"""People who wear colour markers at their joints, seen by a front and a raised rear camera.

The set-up of Sec. 6.1.2: markers on both sides of the body, so that each is seen by one of the two
cameras, which look at each other over the person.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from math import pi, radians
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from topview.camera.projection import pixel_rays, project
from topview.records import Camera, InputError
from topview_lab.sim.appearance import Rgb
from topview_lab.sim.bodies import SIM_JOINT_NAMES, Body
from topview_lab.sim.flesh import EYES
from topview_lab.sim.images import FURNITURE, NO_MATERIAL, NO_PART, Rendering
from topview_lab.sim.render import draw_people
from topview_lab.sim.scene import Box, Cylinder, Furniture, Mount, Scene
from topview_lab.sim.scenes import KINECT_V1_FULL, SCENES, scene_by_name
from topview_lab.sim.skeleton import SEGMENT_INDEX, SEGMENTS, Pose, segment_poses
from topview_lab.sim.write import check_free, write_scene

MARKED_JOINTS: Final[tuple[str, ...]] = tuple(
    name for name in SIM_JOINT_NAMES if not name.startswith(("head_top", "wrist", "foot"))
)
"""The joints that the tracker reports too."""

SCENE_PREFIX: Final = "markers"
DEFAULT_SCENE: Final = "all_actions"


REAR_MOUNT: Final = Mount(
    height_m=2.3, tilt_rad=radians(24), heading_rad=pi, position_room=(0.25, 5.6)
)
"""Behind the person, raised, looking back at the front camera (ours)."""


@dataclass(frozen=True, slots=True)
class MarkerSetup:
    """Markers and the rear camera (ours).

    Attributes:
        color: linear, of every marker.
        radius_m: of the balls, which sit half sunk in cloth and skin.
        wearers: how many of the scene's people wear markers, the first ones.
        rear: where the second camera hangs; it looks back at the first.
    """

    color: Rgb = (0.90, 0.01, 0.35)
    radius_m: float = 0.025
    wearers: int = 1
    rear: Mount = REAR_MOUNT


def marker_scenes(
    name: str = SCENE_PREFIX,
    *,
    seed: int = 0,
    frames: int | None = None,
    people: int | None = None,
    camera: Camera = KINECT_V1_FULL,
    setup: MarkerSetup = MarkerSetup(),
) -> tuple[Scene, Scene]:
    """The front and the rear camera's view of one scene.

    Args:
        name: "markers", or "markers:SCENE" with another scene of `topview_lab.sim.SCENES`.
        seed: of bodies, looks, style of motion and sensor noise.
        frames: how many, 120 if None.
        people: how many are in the scene, as it says if None.
        camera: intrinsics of both; at half the resolution, markers are too small to be found.
        setup: the markers and the second camera.

    Raises:
        InputError: the name is unknown, or a number is out of range.
    """
    _, colon, base = name.partition(":")
    if colon and base not in SCENES:
        raise InputError(
            f"scene {name!r} is not known; it must be {SCENE_PREFIX}, or {SCENE_PREFIX}: and one "
            f"of {', '.join(SCENES)}"
        )
    base = base or DEFAULT_SCENE
    scene = scene_by_name(base, seed=seed, frames=frames, people=people, camera=camera)
    actors = tuple(
        replace(actor, body=with_markers(actor.body, setup)) if k < setup.wearers else actor
        for k, actor in enumerate(scene.actors)
    )
    room = replace(scene.room, far_wall_m=6.0)
    front = replace(
        scene, name="front", actors=actors, room=room, furniture=scene.furniture + _alike(setup)
    )
    return front, replace(front, name="rear", mount=setup.rear, seed=front.seed + 1)


def _alike(setup: MarkerSetup) -> tuple[Furniture, ...]:
    """Distractors in the markers' colour: a cushion, and two pots of a marker's size."""
    return (
        Box((-1.75, 4.05, 0.56), (0.40, 0.16, 0.34), setup.color, 0.3),
        Cylinder((2.10, 4.40, 1.40), setup.radius_m, 0.05, setup.color),
        Cylinder((-0.95, 3.95, 0.0), setup.radius_m, 0.06, setup.color),
    )


def with_markers(body: Body, setup: MarkerSetup = MarkerSetup()) -> Body:
    """The same body with a ball in front of and behind each of `MARKED_JOINTS`."""
    joints = [SIM_JOINT_NAMES.index(name) for name in MARKED_JOINTS]
    segments = np.repeat(body.joint_segments[joints], 2)
    places = marker_offsets(body).reshape(-1, 3)
    donor = int(np.flatnonzero(body.materials == EYES)[0])  # even, without pattern or loss
    part_of = dict(zip(body.start_segments.tolist(), body.parts, strict=True))
    part_of |= dict(zip(body.end_segments.tolist(), body.parts, strict=True))
    n = len(segments)
    own: dict[str, Any] = {
        "start_segments": segments,
        "starts_m": places,
        "start_radii_m": np.full(n, setup.radius_m),
        "end_segments": segments,
        "ends_m": places,
        "end_radii_m": np.full(n, setup.radius_m),
        "scales": np.ones((n, 3)),
        "parts": np.array([part_of[int(s)] for s in segments], np.uint8),
        "colors": np.tile(setup.color, (n, 1)),
    }
    arrays = {field.name: getattr(body, field.name) for field in fields(body)}
    of_pieces = {
        name: value
        for name, value in arrays.items()
        if isinstance(value, np.ndarray) and len(value) == len(body.parts)
    }
    return replace(
        body,
        **{
            name: np.concatenate([value, own.get(name, np.repeat(value[donor, None], n, 0))])
            for name, value in of_pieces.items()
        },
    )


LOOK_M: Final = 4.0
"""Distance from which the standing body is rendered to find its surface (ours)."""
ABDUCTION_RAD: Final = radians(45)
"""Abduction of the arms in that rendering (ours)."""


def marker_offsets(body: Body) -> NDArray[np.float64]:
    """[M, 2, 3] metres in the frame of each joint's segment: the surface in front of and behind
    the joint of the standing body."""
    joints = [SIM_JOINT_NAMES.index(name) for name in MARKED_JOINTS]
    angles_rad = np.zeros((len(SEGMENTS), 3))
    for side in ("l", "r"):  # nothing hides another part
        angles_rad[SEGMENT_INDEX[f"upper_arm_{side}"], 1] = ABDUCTION_RAD
    pose = Pose(np.zeros(3), radians(-90), angles_rad)
    Ts_room_segment = segment_poses(body.offsets_m, pose)
    sides = [_surface(body, Ts_room_segment, behind)[joints] for behind in (False, True)]
    surface_room = np.stack(sides, 1)
    Ts = Ts_room_segment[body.joint_segments[joints]]
    return np.einsum("mji,msj->msi", Ts[:, :3, :3], surface_room - Ts[:, None, :3, 3])


def _surface(body: Body, Ts_room_segment: NDArray[np.float64], behind: bool) -> NDArray[np.float64]:
    """[J, 3] where the line of sight to each joint meets the body, from the front or the back."""
    camera = Camera(fx=900.0, fy=900.0, cx=299.5, cy=299.5, width=600, height=600)
    heading = pi if behind else 0.0
    mount = Mount(0.0, 0.0, heading, (0.0, LOOK_M if behind else -LOOK_M))
    T_camera_room = mount.T_camera_room()
    Ts = T_camera_room @ Ts_room_segment
    depth_m = draw_people([body], [Ts], _nothing(camera), camera).depth_m
    u, v = np.rint(project(body.joints(Ts), camera)).astype(int).T
    points = pixel_rays(camera)[v, u] * depth_m[v, u, None]
    return (points - T_camera_room[:3, 3]) @ T_camera_room[:3, :3]


def _nothing(camera: Camera) -> Rendering:
    shape = camera.height, camera.width
    return Rendering(
        depth_m=np.full(shape, np.inf, np.float32),
        instance=np.full(shape, FURNITURE, np.uint8),
        part=np.full(shape, NO_PART, np.uint8),
        material=np.full(shape, NO_MATERIAL, np.uint8),
        normals=np.zeros((*shape, 3), np.float32),
        albedo=np.zeros((*shape, 3), np.float32),
    )


def marker_places(scene: Scene, wearers: int = 1) -> NDArray[np.float64]:
    """[F, P, M, 2, 3] metres in the scene's camera frame: the middles of the balls in front of and
    behind the `MARKED_JOINTS` of those who wear them."""
    T_camera_room = scene.mount.T_camera_room()
    places = np.empty((scene.frames, wearers, len(MARKED_JOINTS) * 2, 3))
    for p, actor in enumerate(scene.actors[:wearers]):
        body = actor.body
        balls = slice(-places.shape[2], None)  # the last pieces of flesh
        for f in range(scene.frames):
            pose = actor.performance.pose(body, scene.time_s(f))
            Ts = T_camera_room @ segment_poses(body.offsets_m, pose)
            places[f, p] = body.flesh(Ts).starts[balls]
    return places.reshape(scene.frames, wearers, -1, 2, 3)


def T_front_rear(front: Scene, rear: Scene) -> NDArray[np.float64]:
    """[4, 4] rear into front camera frame."""
    return front.mount.T_camera_room() @ np.linalg.inv(rear.mount.T_camera_room())


def write_marker_scenes(
    front: Scene,
    rear: Scene,
    folder: Path | str,
    on_frame: Callable[[int], None] | None = None,
    force: bool = False,
) -> None:
    """Simulate into `front/` and `rear/`, in the folder layout but without `groundtruth.npz`, and
    `truth.npz` for checking: the keys of `topview_lab.sim.truth.GroundTruth`, seen from the front
    camera, `T_front_rear`, `marker_joints` and `markers` (see `marker_places`).

    Args:
        front, rear: what to simulate.
        folder: made where it is missing.
        on_frame: called with each frame's number after it is written.
        force: replace the recordings that are there.

    Raises:
        InputError: the folder holds recordings already, or cannot be written to.
    """
    folder = Path(folder)
    for name in ("front", "rear"):
        check_free(folder / name, force)
    truth = write_scene(front, folder / "front", on_frame, force=force)
    write_scene(rear, folder / "rear", on_frame, force=force)
    try:
        for name in ("front", "rear"):
            (folder / name / "groundtruth.npz").unlink()
        arrays: dict[str, Any] = {
            **truth.arrays(),
            "T_front_rear": T_front_rear(front, rear),
            "marker_joints": np.array(MARKED_JOINTS),
            "markers": marker_places(front),
        }
        np.savez_compressed(folder / "truth.npz", **arrays)
    except OSError as error:
        raise InputError(
            f"{error.filename or folder}: {error.strerror or error}; "
            "the folder must be one that can be written to"
        ) from error
