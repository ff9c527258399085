"""Which joints are visible, and what hides the others."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.body.model import BodyModel
from topview.body.parts import OUTPUT_JOINTS
from topview.camera import project
from topview.records import Camera, JointState

Array = NDArray[np.float64]

# All ours. Distances are from the surface of the joint's part, along the line of sight.
IN_FRONT_M: Final = 0.08  # what is nearer by more than this hides the joint
CONFIRMS_M: Final = 0.12  # what is seen within this confirms the joint

_PART_OF = np.array([joint.part for joint in OUTPUT_JOINTS])
# Places around a joint, in radii of its part: the joint itself and eight on a circle.
_SAMPLES = 0.7 * np.array([(0.0, 0.0)] + [(np.cos(a), np.sin(a)) for a in np.arange(8) * np.pi / 4])


@dataclass(frozen=True, slots=True, eq=False)
class Visibility:
    """What the image shows of a body's joints.

    Attributes:
        joint_state: [20] `JointState`.
        confirmed: [20] share of the places around each joint that confirm it, 0 to 1.
    """

    joint_state: NDArray[np.uint8]
    confirmed: NDArray[np.float64]


def joint_visibility(
    joints_camera: Array,
    model: BodyModel,
    person: int,
    depth_m: NDArray[np.float32],
    labels: NDArray[np.int32],
    camera: Camera,
) -> Visibility:
    """Compare places around each joint with the depth image there.

    Args:
        joints_camera: [20, 3] metres; a joint that is NaN is absent.
        model: the body's size.
        person: id of the person.
        depth_m: [H, W] of the whole scene.
        labels: [H, W] id of the person that each pixel belongs to, 0 for nobody.
        camera: of the image.
    """
    radii = model.radii_m.min(1)[_PART_OF]
    places = np.repeat(joints_camera[:, None], len(_SAMPLES), axis=1)
    places[..., :2] += _SAMPLES * radii[:, None, None]
    pixels = np.nan_to_num(project(places, camera), nan=-1e6)
    u, v = np.rint(pixels[..., 0]).astype(int), np.rint(pixels[..., 1]).astype(int)
    inside = (u >= 0) & (v >= 0) & (u < camera.width) & (v < camera.height)
    u, v = np.where(inside, u, 0), np.where(inside, v, 0)
    seen, owner = depth_m[v, u], labels[v, u]
    is_own = owner == person
    surface = places[..., 2] - radii[:, None]
    has_reading = inside & (seen > 0)
    in_front = has_reading & (seen < surface - IN_FRONT_M)
    confirms = has_reading & (np.abs(seen - surface) < CONFIRMS_M) & is_own

    places_in_state = np.array(  # in the order of JointState, ABSENT aside
        [
            inside & ~in_front,
            in_front & is_own,
            in_front & ~is_own & (owner > 0),
            in_front & (owner == 0),
            ~inside,
        ]
    )
    state = 1 + places_in_state.sum(-1).argmax(0)
    state[~np.isfinite(joints_camera).all(1)] = JointState.ABSENT
    return Visibility(state.astype(np.uint8), confirms.mean(1))
