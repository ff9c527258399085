"""Ground truth of a scene: joints, part frames, presence, and what hides each of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from topview.geometry.rotations import transform, unit
from topview.records import Camera, read_only
from topview_lab.sim.bodies import SIM_JOINT_NAMES, SIM_PART_NAMES, Body
from topview_lab.sim.images import Rendering
from topview_lab.sim.occlusion import OcclusionShares, hidden_shares, joint_samples, part_samples
from topview_lab.sim.render import Renderer
from topview_lab.sim.scene import Scene
from topview_lab.sim.skeleton import SEGMENT_INDEX

_MIDDLE: Final = {
    "head": ("head_top", "neck", "head"),
    "upper_torso": ("neck", "torso", "chest"),
    "lower_torso": ("torso", "pelvis", "pelvis"),
}
_LIMBS: Final = {
    "upper_arm": ("shoulder", "elbow", "upper_arm"),
    "forearm": ("elbow", "wrist", "forearm"),
    "hand": ("wrist", "hand", "hand"),
    "upper_leg": ("hip", "knee", "thigh"),
    "lower_leg": ("knee", "ankle", "calf"),
    "foot": ("ankle", "foot", "foot"),
}
"""For each part: the joint at its origin, the one at its far end, the segment it turns with."""


def _part_table() -> NDArray[np.intp]:
    """[B, 3] indices of these joints and of the segment."""
    rows = []
    for part in SIM_PART_NAMES:
        stem, side = (part[:-2], part[-2:]) if part[:-2] in _LIMBS else (part, "")
        first, last, segment = (name + side for name in (_LIMBS | _MIDDLE)[stem])
        rows.append(
            (SIM_JOINT_NAMES.index(first), SIM_JOINT_NAMES.index(last), SEGMENT_INDEX[segment])
        )
    return np.array(rows)


_PART_ORIGIN, _PART_END, _PART_SEGMENT = _part_table().T


@dataclass(frozen=True, slots=True, eq=False)
class GroundTruth:
    """F frames, P people, J joints, B parts; camera frame, metres. The fields are the keys of
    `groundtruth.npz`. How shares of joints and parts are sampled: `topview_lab.sim.occlusion`.

    Attributes:
        names: [J] joint names.
        joints: [F, P, J, 3] float32.
        ids: [P] int64, person k in the masks.
        stature: [P] float32.
        bodies: [P] what kind of body it is.
        actions: [F, P] what the person does.
        present: [F, P] True unless the whole of a person lies outside of the image.
        part_names: [B].
        Ts_camera_part: [F, P, B, 4, 4] float32 part frames as in `topview.records.Person`, their
            origins and far ends at the joints.
        joint_occ_person, joint_occ_furniture, joint_occ_inter, joint_occ_self, joint_outside:
            [F, P, J] float32 shares in 0..1 of a disc around the joint (inter: person or
            furniture).
        joint_occ_by: [F, P, J, P] float32 the share that person k + 1 hides, 0 for oneself; the
            sum is joint_occ_person.
        part_occ_person, ..., part_outside, part_occ_by: the same for the surface that each part
            would show the camera if it were alone.
        person_occ_person, ..., person_outside: [F, P] float32 means over the parts by the area
            that each has in the image.
    """

    names: NDArray[np.str_]
    joints: NDArray[np.float32]
    ids: NDArray[np.int64]
    stature: NDArray[np.float32]
    bodies: NDArray[np.str_]
    actions: NDArray[np.str_]
    present: NDArray[np.bool_]
    part_names: NDArray[np.str_]
    Ts_camera_part: NDArray[np.float32]
    joint_occ_person: NDArray[np.float32]
    joint_occ_furniture: NDArray[np.float32]
    joint_occ_inter: NDArray[np.float32]
    joint_occ_self: NDArray[np.float32]
    joint_outside: NDArray[np.float32]
    joint_occ_by: NDArray[np.float32]
    part_occ_person: NDArray[np.float32]
    part_occ_furniture: NDArray[np.float32]
    part_occ_inter: NDArray[np.float32]
    part_occ_self: NDArray[np.float32]
    part_outside: NDArray[np.float32]
    part_occ_by: NDArray[np.float32]
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
    """The truth of one frame: P people, J joints, B parts.

    Attributes:
        joints: [P, J, 3] metres in the camera frame.
        Ts_camera_part: [P, B, 4, 4].
        joint_hidden, part_hidden: shares of [P, J] and [P, B].
        part_area: [P, B] that each part has in the image if nothing hides it, at z = 1.
    """

    joints: NDArray[np.float64]
    Ts_camera_part: NDArray[np.float64]
    joint_hidden: OcclusionShares
    part_hidden: OcclusionShares
    part_area: NDArray[np.float64]


def frame_truth(
    bodies: Sequence[Body],
    Ts_camera_segment: Sequence[NDArray[np.float64]],
    rendering: Rendering,
    camera: Camera,
) -> FrameTruth:
    """Joints and parts of posed bodies, and what hides them in a noise-free rendering of them."""
    P = len(bodies)
    if P == 0:
        return _nobody()
    joints, frames, joint_hidden, part_hidden, areas = [], [], [], [], []
    for k, (body, Ts) in enumerate(zip(bodies, Ts_camera_segment, strict=True), start=1):
        joints.append(body.joints(Ts))
        frames.append(part_frames(joints[-1], Ts))
        of_joints = joint_samples(joints[-1], body.joint_radii_m, camera)
        of_parts = part_samples(body.flesh(Ts), body.parts, camera)
        joint_hidden.append(hidden_shares(of_joints, k, P, rendering, camera))
        part_hidden.append(hidden_shares(of_parts, k, P, rendering, camera))
        areas.append(of_parts.area)
    return FrameTruth(
        np.stack(joints),
        np.stack(frames),
        OcclusionShares.stacked(joint_hidden),
        OcclusionShares.stacked(part_hidden),
        np.stack(areas),
    )


def _nobody() -> FrameTruth:
    J, B = len(SIM_JOINT_NAMES), len(SIM_PART_NAMES)
    joints, parts = (OcclusionShares(np.zeros((0, n, 0)), *np.zeros((3, 0, n))) for n in (J, B))
    return FrameTruth(np.zeros((0, J, 3)), np.zeros((0, B, 4, 4)), joints, parts, np.zeros((0, B)))


def part_frames(
    joints_camera: NDArray[np.float64], Ts_camera_segment: NDArray[np.float64]
) -> NDArray[np.float64]:
    """[B, 4, 4] Ts_camera_part: from joint to joint, +x as near the person's right as can be."""
    origins = joints_camera[_PART_ORIGIN]
    y = unit(joints_camera[_PART_END] - origins)
    right = -Ts_camera_segment[_PART_SEGMENT, :3, 0]
    x = unit(right - (right * y).sum(-1, keepdims=True) * y)
    return transform(np.stack([x, y, np.cross(x, y)], -1), origins)


def simulate_truth(scene: Scene) -> GroundTruth:
    """The truth of a whole scene; renders every frame without noise."""
    renderer = Renderer(scene)
    bodies = [actor.body for actor in scene.actors]
    frames = []
    for frame in range(scene.frames):
        drawing = renderer.draw(frame)
        poses = drawing.Ts_camera_segment
        frames.append(frame_truth(bodies, poses, drawing.rendering, scene.camera))
    return stack_truth(scene, frames)


def stack_truth(scene: Scene, frames: Sequence[FrameTruth]) -> GroundTruth:
    """The truth of a scene's first frames as one record."""
    actors = scene.actors
    hidden = {
        "joint": OcclusionShares.stacked([frame.joint_hidden for frame in frames]),
        "part": OcclusionShares.stacked([frame.part_hidden for frame in frames]),
    }
    hidden["person"] = hidden["part"].mean(np.stack([frame.part_area for frame in frames]))
    shares = {
        f"{scope}_{name}": share.astype(np.float32)
        for scope, of in hidden.items()
        for name, share in _shares(of).items()
    }
    del shares["person_occ_by"]
    return GroundTruth(
        names=np.array(SIM_JOINT_NAMES),
        joints=np.array([frame.joints for frame in frames], np.float32),
        ids=np.arange(1, len(actors) + 1, dtype=np.int64),
        stature=np.array([actor.body.appearance.stature_m for actor in actors], np.float32),
        bodies=np.array([actor.body.appearance.label for actor in actors], np.str_),
        actions=_actions(scene, len(frames)),
        present=np.any(shares["part_outside"] < 1.0, axis=-1),
        part_names=np.array(SIM_PART_NAMES),
        Ts_camera_part=np.array([frame.Ts_camera_part for frame in frames], np.float32),
        **shares,
    )


def _shares(hidden: OcclusionShares) -> dict[str, NDArray[np.float64]]:
    by_person = hidden.by.sum(-1)
    return {
        "occ_person": by_person,
        "occ_furniture": hidden.by_furniture,
        "occ_inter": by_person + hidden.by_furniture,
        "occ_self": hidden.by_self,
        "outside": hidden.outside,
        "occ_by": hidden.by,
    }


def _actions(scene: Scene, frames: int) -> NDArray[np.str_]:
    """[F, P] the action of each person."""
    times_s = [scene.time_s(frame) for frame in range(frames)]
    names = [[actor.performance.action_at(t) for actor in scene.actors] for t in times_s]
    return np.array(names, np.str_).reshape(frames, len(scene.actors))
