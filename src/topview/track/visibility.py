"""Which joints are visible, and what hides the others."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.body.model import BodyModel
from topview.body.parts import OUTPUT_JOINTS
from topview.camera.pyramid import DepthView
from topview.kernels.visibility import look_round_joints

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
    radii_m = model.radii_m.min(1)[_PART_OF]
    state, confirmed = np.empty(len(radii_m), np.uint8), np.empty(len(radii_m))
    look_round_joints(
        joints_camera, radii_m, _SAMPLES, view.depth_m, labels, person,
        (view.fx, view.fy, view.cx, view.cy), IN_FRONT_M, CONFIRMS_M, state, confirmed,
    )  # fmt: skip
    return Visibility(state, confirmed)
