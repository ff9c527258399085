"""Which joints are visible, and what hides the others."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.body.model import BodyModel
from topview.body.parts import END_JOINTS, OUTPUT_JOINTS
from topview.camera.pyramid import DepthView
from topview.kernels.visibility import look_round_joints

Array = NDArray[np.float64]

# All ours. Distances are from the surface of the joint's part, along the line of sight: as the body
# is dressed, as clothes and bellies stand out farther than the thesis's cylinders.
IN_FRONT_M: Final = 0.08  # what is nearer by more than this hides the joint
OWN_IN_FRONT_M: Final = 0.06  # the same of the own body
CONFIRMS_M: Final = 0.12  # what is seen within this confirms the joint
ROUNDING_M: Final = 1e-6  # of rounding: joints are where pieces end

_PART_OF = np.array([joint.part for joint in OUTPUT_JOINTS])
_PART_OF_ENDS = np.array([joint.part for joint in END_JOINTS])
# Places around a joint, in radii of its surface: the joint itself and eight on a circle.
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
    view: DepthView,
    labels: NDArray[np.int32],
) -> Visibility:
    """Compare places around each joint with the depth image there.

    Args:
        joints_camera: [20, 3] metres; a joint that is NaN is absent.
        model: the body's size.
        person: id of the person.
        view: the depth of the whole scene.
        labels: [H, W] id of the person that each pixel belongs to, 0 for nobody.
    """
    radii_m = _surface_radii(model)
    state, confirmed = np.empty(len(radii_m), np.uint8), np.empty(len(radii_m))
    look_round_joints(
        joints_camera, radii_m, _SAMPLES, view.depth_m, labels, person,
        (view.fx, view.fy, view.cx, view.cy), (IN_FRONT_M, OWN_IN_FRONT_M), CONFIRMS_M, state,
        confirmed,
    )  # fmt: skip
    return Visibility(state, confirmed)


def _surface_radii(model: BodyModel) -> Array:
    """[20] metres from each joint to the surface there, across where that is thinner: of the pieces
    of its part that it is in, the thinnest; wrists and feet are at the far ends of theirs."""
    places = np.concatenate([model.joints_part, np.zeros((len(END_JOINTS), 3))])
    places[len(model.joints_part) :, 1] = model.lengths_m[_PART_OF_ENDS]
    surface = model.surface
    in_piece = (places[:, None] - surface.origins_part)[:, :, None] @ surface.Rs_part
    x, y, z = np.moveaxis(in_piece[:, :, 0], -1, 0)
    share = np.clip(y / surface.lengths_m, 0.0, 1.0)[..., None]
    radii_m = surface.shapes_m[:, :2] + share * (surface.shapes_m[:, 2:4] - surface.shapes_m[:, :2])
    is_beside = np.hypot(x, z) < radii_m.max(-1)
    is_along = (y > -ROUNDING_M) & (y < surface.lengths_m + ROUNDING_M)
    is_own = surface.owners == _PART_OF[:, None]
    first = np.arange(len(surface.owners)) == _PART_OF[:, None]  # that of the part itself
    is_in = is_own & ((is_beside & is_along) | first)
    return np.where(is_in, radii_m.min(-1), np.inf).min(1)
