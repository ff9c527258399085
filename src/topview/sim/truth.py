"""The truth behind a scene: joints, who is there, and what hides each joint from the camera."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from topview.camera.projection import project
from topview.records import Camera, read_only
from topview.sim.bodies import JOINT_NAMES, PART_NAMES, Body
from topview.sim.images import FURNITURE, Rendering
from topview.sim.render import Renderer
from topview.sim.scene import Scene

_PARTS_OF_JOINT: Final = {
    "head_top": ("head",), "head": ("head",), "neck": ("head", "upper_torso"),
    "torso": ("upper_torso", "lower_torso"),
    "pelvis": ("lower_torso", "upper_leg_l", "upper_leg_r"),
    "shoulder": ("upper_torso", "upper_arm"), "elbow": ("upper_arm", "forearm"),
    "wrist": ("forearm", "hand"), "hand": ("hand",),
    "hip": ("lower_torso", "upper_leg"), "knee": ("upper_leg", "lower_leg"),
    "ankle": ("lower_leg", "foot"), "foot": ("foot",),
}  # fmt: skip


def _carriers() -> NDArray[np.bool_]:
    """[J, 256] True for the part labels that a joint belongs to."""
    table = np.zeros((len(JOINT_NAMES), 256), np.bool_)
    for j, name in enumerate(JOINT_NAMES):
        stem, side = (name[:-2], name[-2:]) if name[-2:] in ("_l", "_r") else (name, "")
        for part in _PARTS_OF_JOINT[stem]:
            label = part if part in PART_NAMES else part + side
            table[j, PART_NAMES.index(label)] = True
    return table


_CARRIERS: Final = read_only(_carriers())


@dataclass(frozen=True, slots=True, eq=False)
class GroundTruth:
    """F frames, P people, J joints; camera frame, metres. The fields are `groundtruth.npz`'s keys.

    A joint's neighbourhood is a disc of four fifths of the limb's radius around it that faces the
    camera. A sample of it is hidden by what an ideal camera sees there in front of the joint:
    another person, furniture, or a part of the own body that does not carry the joint (or that
    carries it, but lies more than a limb's width in front, as the near hip does in profile).

    Attributes:
        names: [J] joint names.
        joints: [F, P, J, 3] float32.
        ids: [P] int64, person k in the masks.
        stature: [P] float32.
        present: [F, P] True unless the whole of a person lies outside of the image.
        joint_occ_person, joint_occ_furniture, joint_occ_inter, joint_occ_self, joint_outside:
            [F, P, J] float32 shares of the neighbourhood in 0..1 (inter: person or furniture).
        person_occ_person, person_occ_furniture, person_occ_inter, person_occ_self, person_outside:
            [F, P] float32, the means over the joints.
    """

    names: NDArray[np.str_]
    joints: NDArray[np.float32]
    ids: NDArray[np.int64]
    stature: NDArray[np.float32]
    present: NDArray[np.bool_]
    joint_occ_person: NDArray[np.float32]
    joint_occ_furniture: NDArray[np.float32]
    joint_occ_inter: NDArray[np.float32]
    joint_occ_self: NDArray[np.float32]
    joint_outside: NDArray[np.float32]
    person_occ_person: NDArray[np.float32]
    person_occ_furniture: NDArray[np.float32]
    person_occ_inter: NDArray[np.float32]
    person_occ_self: NDArray[np.float32]
    person_outside: NDArray[np.float32]

    def __post_init__(self) -> None:
        for name in self.arrays():
            read_only(getattr(self, name))

    def arrays(self) -> dict[str, Any]:
        """What `groundtruth.npz` holds."""
        return {field.name: getattr(self, field.name) for field in fields(self)}


@dataclass(frozen=True, slots=True, eq=False)
class FrameTruth:
    """The truth of one frame, P people: joints [P, J, 3] metres in the camera frame, and shares of
    each joint's neighbourhood [P, J]."""

    joints: NDArray[np.float64]
    by_person: NDArray[np.float64]
    by_furniture: NDArray[np.float64]
    by_self: NDArray[np.float64]
    outside: NDArray[np.float64]


def _disc(rings: int = 4) -> NDArray[np.float64]:
    """[K, 2] points that fill the unit disc evenly."""
    radii = (np.arange(rings) + 0.5) / rings
    points = [
        radius * np.array([np.cos(angle), np.sin(angle)])
        for ring, radius in enumerate(radii)
        for angle in 2.0 * np.pi * (np.arange(6 * ring + 3) + 0.5 * ring) / (6 * ring + 3)
    ]
    return np.array(points)


_DISC: Final = read_only(0.8 * _disc())


def frame_truth(
    bodies: Sequence[Body],
    Ts_camera_segment: Sequence[NDArray[np.float64]],
    rendering: Rendering,
    camera: Camera,
) -> FrameTruth:
    """Joints of posed bodies, and what hides them in a noise-free rendering of them."""
    P, J = len(bodies), len(JOINT_NAMES)
    joints = np.zeros((P, J, 3))
    shares = np.zeros((4, P, J))
    for p, (body, Ts) in enumerate(zip(bodies, Ts_camera_segment, strict=True)):
        joints[p] = body.joints(Ts)
        shares[:, p] = _hidden(joints[p], body.joint_radii_m, p + 1, rendering, camera)
    return FrameTruth(joints, *shares)


def _hidden(
    joints_camera: NDArray[np.float64],
    radii_m: NDArray[np.float64],
    person: int,
    rendering: Rendering,
    camera: Camera,
) -> NDArray[np.float64]:
    """[4, J] shares of one person's joints hidden by others, furniture, itself; outside."""
    samples = np.repeat(joints_camera[:, None], len(_DISC), axis=1)
    samples[..., :2] += radii_m[:, None, None] * _DISC
    pixels = project(samples, camera)
    beyond = (camera.width - 0.5, camera.height - 0.5)
    is_inside = np.all((pixels >= -0.5) & (pixels < beyond), axis=-1)
    u, v = np.where(is_inside[..., None], np.rint(pixels), 0).astype(np.intp).transpose(2, 0, 1)

    depth, instance, part = rendering.depth_m[v, u], rendering.instance[v, u], rendering.part[v, u]
    joint_depth, radius = joints_camera[:, None, 2], radii_m[:, None]
    is_front = is_inside & (depth < joint_depth)
    is_own = instance == person
    is_carrier = _CARRIERS[np.arange(len(radii_m))[:, None], part]
    hides_itself = is_own & (~is_carrier | (depth < joint_depth - 2.0 * radius))
    is_furniture = instance == FURNITURE
    is_other = ~is_own & ~is_furniture & (instance > 0)
    flags = (is_front & is_other, is_front & is_furniture, is_front & hides_itself, ~is_inside)
    return np.stack([flag.mean(-1) for flag in flags])


def simulate_truth(scene: Scene) -> GroundTruth:
    """The truth of a whole scene; renders every frame without noise."""
    renderer = Renderer(scene)
    bodies = [actor.body for actor in scene.actors]
    frames = []
    for frame in range(scene.frames):
        drawing = renderer.draw(frame)
        poses = drawing.Ts_camera_segment
        frames.append(frame_truth(bodies, poses, drawing.rendering, scene.camera))
    return stack_truth(bodies, frames)


def stack_truth(bodies: Sequence[Body], frames: Sequence[FrameTruth]) -> GroundTruth:
    """The truth of many frames as one record."""

    def stacked(name: str) -> NDArray[np.float32]:
        return np.array([getattr(frame, name) for frame in frames], np.float32)

    shares = {
        "occ_person": stacked("by_person"),
        "occ_furniture": stacked("by_furniture"),
        "occ_inter": stacked("by_person") + stacked("by_furniture"),
        "occ_self": stacked("by_self"),
        "outside": stacked("outside"),
    }
    return GroundTruth(
        names=np.array(JOINT_NAMES),
        joints=stacked("joints"),
        ids=np.arange(1, len(bodies) + 1, dtype=np.int64),
        stature=np.array([body.look.stature_m for body in bodies], np.float32),
        present=(shares["outside"] < 1.0).any(-1),
        **{f"joint_{name}": share for name, share in shares.items()},
        **{f"person_{name}": share.mean(-1) for name, share in shares.items()},
    )
