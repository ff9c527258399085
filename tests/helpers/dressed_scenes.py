"""Known heads in a coloured room, for the tests of tracks."""

from __future__ import annotations

import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray

from people_scenes import CAMERA, Ball, frame, plane, render
from topview.body.parts import PARTS
from topview.detect.cloud import Cloud
from topview.detect.heads import HeadCandidate
from topview.people.bodies import body_of
from topview.people.features import SHAPE
from topview.people.segmentation import SegmentationSettings
from topview.people.track import Track
from topview.records import Frame, Person
from topview.room.floor import FloorPlane
from topview.room.scene import Scene, SceneSettings

UP = np.array([0.0, -1.0, 0.0])
GROUND_Y = 1.1
FLOOR = plane(UP, GROUND_Y)
ROOM = [FLOOR, np.full_like(FLOOR, 4.9)]
RED, BLUE, GREY = (180, 40, 40), (40, 50, 190), (120, 120, 120)
Rgb = tuple[int, int, int]


def scene_of(depth_m: NDArray[np.float32], color: NDArray[np.uint8] | None, index: int) -> Scene:
    plain = frame(depth_m, index)
    colored = Frame(plain.index, plain.timestamp_s, plain.depth_m, CAMERA, color)
    nothing = np.zeros((240, 320), np.bool_)
    cloud = Cloud.from_frame(colored)
    is_background = nothing[:: cloud.stride, :: cloud.stride]
    return Scene.of(cloud, FloorPlane(UP.copy(), GROUND_Y), is_background, SceneSettings())


def dressed(people: list[tuple[list[Ball], Rgb]]) -> tuple[NDArray[np.float32], NDArray[np.uint8]]:
    """[H, W] depth of people in a room, and [H, W, 3] their colours, all over."""
    depth_m = render([ball for balls, _ in people for ball in balls], ROOM)
    color = np.full((*depth_m.shape, 3), GREY, np.uint8)
    for balls, rgb in people:
        color[(render(balls) > 0.0) & (np.abs(render(balls) - depth_m) < 1e-4)] = rgb
    return depth_m, color


def track_at(
    scene: Scene,
    place_camera: NDArray[np.float64],
    key: int = 1,
    *,
    confidence: float = 0.9,
    stature_m: float | None = None,
) -> Track:
    """Of a person, with the body, whose head is seen at [3] in a scene."""
    features = np.zeros(len(SHAPE))
    track = Track.born(key, scene.cloud, HeadCandidate(place_camera, confidence), features)
    track.height.add(stature_m, scene.time_s)
    track = replace(track, id=key)
    return replace(track, body_m=body_of(scene, track, SegmentationSettings(), None))


def person_with(
    joints_camera: NDArray[np.float64], confidence: float, id: int = 1, height_m: float = 1.7
) -> Person:
    """As tracked, with these joints, all of them so sure."""
    count = len(joints_camera)
    return Person(
        id=id,
        height_m=height_m,
        joints_camera=joints_camera,
        joint_state=np.zeros(count, np.uint8),
        joint_confidence=np.full(count, confidence, np.float32),
        Ts_camera_part=np.tile(np.eye(4), (len(PARTS), 1, 1)),
    )
