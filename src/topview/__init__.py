"""topview: 3D body tracking of several people from one depth camera. It needs no data of yours.

    tracker = topview.Tracker()
    for frame in topview.open(path):
        people = tracker.update(frame)

Lengths are metres; positions are in the frame of the camera: x right, y down, z forward.
"""

from __future__ import annotations

import logging
from os import PathLike
from pkgutil import resolve_name
from typing import TYPE_CHECKING, Any

from topview.body.parts import OUTPUT_JOINT_NAMES as JOINT_NAMES
from topview.body.parts import PART_NAMES
from topview.records import (
    JOINT_STATE_NAMES,
    Camera,
    Distortion,
    Frame,
    InputError,
    JointState,
    PartMap,
    Person,
    Recording,
)
from topview.skeletons import SkeletonSequence
from topview.version import installed_version

if TYPE_CHECKING:
    from topview.body.hierarchy import Articulation
    from topview.body.known_body import KnownBody, KnownBone, read_bodies
    from topview.io.writers.bodies import write_bodies
    from topview.io.writers.joint_frames import JointFrames, bone_lengths_m, joint_frames
    from topview.io.writers.levelled import T_world_camera, articulation_of
    from topview.io.writers.npz import read_skeletons_npz as read_skeletons
    from topview.io.writers.registry import write_skeletons
    from topview.track.settings import TrackerSettings
    from topview.track.tracker import Tracker

__all__ = [
    "JOINT_NAMES",
    "JOINT_STATE_NAMES",
    "PART_NAMES",
    "Articulation",
    "Camera",
    "Distortion",
    "Frame",
    "InputError",
    "JointFrames",
    "JointState",
    "KnownBody",
    "KnownBone",
    "PartMap",
    "Person",
    "Recording",
    "SkeletonSequence",
    "T_world_camera",
    "Tracker",
    "TrackerSettings",
    "__version__",
    "articulation_of",
    "bone_lengths_m",
    "joint_frames",
    "open",
    "read_bodies",
    "read_skeletons",
    "write_bodies",
    "write_skeletons",
]

__version__ = installed_version()
logging.getLogger(__name__).addHandler(logging.NullHandler())  # the user says what is shown

# Loaded when first asked for: the tracker brings numba, which takes a second.
_LAZY = {
    "Articulation": "topview.body.hierarchy:Articulation",
    "JointFrames": "topview.io.writers.joint_frames:JointFrames",
    "KnownBody": "topview.body.known_body:KnownBody",
    "KnownBone": "topview.body.known_body:KnownBone",
    "T_world_camera": "topview.io.writers.levelled:T_world_camera",
    "Tracker": "topview.track.tracker:Tracker",
    "TrackerSettings": "topview.track.settings:TrackerSettings",
    "articulation_of": "topview.io.writers.levelled:articulation_of",
    "bone_lengths_m": "topview.io.writers.joint_frames:bone_lengths_m",
    "joint_frames": "topview.io.writers.joint_frames:joint_frames",
    "read_bodies": "topview.body.known_body:read_bodies",
    "read_skeletons": "topview.io.writers.npz:read_skeletons_npz",
    "write_bodies": "topview.io.writers.bodies:write_bodies",
    "write_skeletons": "topview.io.writers.registry:write_skeletons",
}


def open(  # noqa: A001 - as `topview.open`
    path: str | PathLike[str], format: str | None = None
) -> Recording:
    """Open a depth recording: a folder of images, a ROS bag, an Azure Kinect's `.mkv`, ...

    Iterate over it to get its `Frame`s, again if need be; frames that cannot be read are left out
    and named in its `problems`. See `topview.io.readers` for the formats and their names.

    Raises:
        InputError: the recording cannot be used at all; one line says why.
    """
    from topview.io.readers import open_recording

    return open_recording(path, format)


def __getattr__(name: str) -> Any:
    if name not in _LAZY:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return resolve_name(_LAZY[name])
