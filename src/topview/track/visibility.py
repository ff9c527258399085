"""What is seen of a pose, and what hides the rest: states and confidences of joints."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from topview.body.model import BodyModel
from topview.body.parts import JOINTS
from topview.camera import project
from topview.records import Camera, JointState

Array = NDArray[np.float64]

# Ours: something hides a joint if it is nearer than the part's surface by more than this.
IN_FRONT_M = 0.08
# Ours: what is seen within this of the part's surface confirms the joint.
CONFIRMS_M = 0.12
# Ours: a hidden joint is trusted this much at first, and by a factor e less after a second.
HIDDEN_CONFIDENCE = 0.4
HIDDEN_DECAY_S = 1.0
OUT_OF_VIEW_CONFIDENCE = 0.1

_PART_OF = np.array([joint.part for joint in JOINTS])
# A joint's neighbourhood: its middle and eight places around, in radii of its part.
_DISC = 0.7 * np.array([(0.0, 0.0)] + [(np.cos(a), np.sin(a)) for a in np.arange(8) * np.pi / 4])


@dataclass(frozen=True, slots=True, eq=False)
class Visibility:
    """[16] each: a `JointState`, and the share of the neighbourhood that confirms the joint."""

    joint_state: NDArray[np.uint8]
    confirmed: NDArray[np.float64]


def look(
    joints_camera: Array,
    model: BodyModel,
    person: int,
    depth_m: NDArray[np.float32],
    owner: NDArray[np.int32],
    camera: Camera,
) -> Visibility:
    """Compare each joint's neighbourhood with what the image shows there; a joint that is NaN is
    absent.

    Args:
        joints_camera: [16, 3] metres.
        person: id of the person.
        depth_m: [H, W] the whole scene.
        owner: [H, W] id of the user that each pixel belongs to, 0 for none.
    """
    radii = model.radii_m.min(1)[_PART_OF]
    places = np.repeat(joints_camera[:, None], len(_DISC), axis=1)
    places[..., :2] += _DISC * radii[:, None, None]
    pixels = np.nan_to_num(project(places, camera), nan=-1e6)
    u, v = np.rint(pixels[..., 0]).astype(int), np.rint(pixels[..., 1]).astype(int)
    inside = (u >= 0) & (v >= 0) & (u < camera.width) & (v < camera.height)
    u, v = np.where(inside, u, 0), np.where(inside, v, 0)
    seen, whose = depth_m[v, u], owner[v, u]
    surface = places[..., 2] - radii[:, None]
    has_reading = inside & (seen > 0)
    in_front = has_reading & (seen < surface - IN_FRONT_M)
    confirms = has_reading & (np.abs(seen - surface) < CONFIRMS_M) & (whose == person)

    share = np.stack(
        [
            (inside & ~in_front).mean(1),
            (in_front & (whose == person)).mean(1),
            (in_front & (whose != person) & (whose > 0)).mean(1),
            (in_front & (whose == 0)).mean(1),
            (~inside).mean(1),
        ],
        axis=1,
    )
    state = 1 + share.argmax(1)  # in the order of JointState, ABSENT aside
    state[~np.isfinite(joints_camera).all(1)] = JointState.ABSENT
    return Visibility(state.astype(np.uint8), confirms.mean(1))


def confidences(visibility: Visibility, hidden_for_s: NDArray[np.float64]) -> NDArray[np.float32]:
    """[16] in 0..1: how much of a seen joint is confirmed; a hidden one fades with time; an absent
    one has none."""
    state = visibility.joint_state
    hidden = HIDDEN_CONFIDENCE * np.exp(-hidden_for_s / HIDDEN_DECAY_S)
    out = np.where(state == JointState.VISIBLE, visibility.confirmed, hidden)
    out = np.where(state == JointState.OUT_OF_VIEW, np.minimum(out, OUT_OF_VIEW_CONFIDENCE), out)
    return np.where(state == JointState.ABSENT, 0.0, out).astype(np.float32)
