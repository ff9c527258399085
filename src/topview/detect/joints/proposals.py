"""What proposes joints, and what a proposal says."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Final, Protocol

import numpy as np
from numpy.typing import NDArray

from topview.body.parts import JOINT_NAMES, other_side
from topview.detect.joints.windows import Windows
from topview.records import InputError, read_only

_LIMBS = (("shoulder", "elbow", "wrist", "hand"), ("hip", "knee", "ankle", "foot"))

PROPOSED_JOINTS: Final[tuple[str, ...]] = (
    "head_top",
    "head",
    "neck",
    "torso",
    "pelvis",
    *(f"{side}_{joint}" for limb in _LIMBS for side in ("left", "right") for joint in limb),
)
"""The 21 joints that the network proposes; sides are the person's own."""

OTHER_SIDES: Final = np.array([PROPOSED_JOINTS.index(other_side(name)) for name in PROPOSED_JOINTS])
"""[21] the same joint on the other side of the body."""

FACED_MODES: Final = (0, 1)
"""The network's whole-body modes: as it is if it faces the camera, and if it is turned away."""
FACING_MODE: Final = FACED_MODES[0]


@dataclass(frozen=True, slots=True, eq=False)
class JointProposals:
    """Where P people's joints may be, each in up to M whole-body modes.

    An unused mode has weight 0 and finite values. The network's modes are `FACED_MODES`.

    Attributes:
        positions_camera: [P, M, J, 3] metres.
        scales_m: [P, M, J, 3] of Laplace laws: to the image's right, down the image, both at the
            joint's depth, and along the ray through the joint, in metres of depth.
        weights: [P, M] of the modes, each person's sum to 1, or all 0 where nothing is proposed.
        p_person: [P] probability that the window shows one person.
        joint_names: [J].
        to_cover_m: [P, M, J] metres from each joint to the nearest surface that is seen of another
            person before it: `topview.detect.joints.windows.Windows.to_cover_m`; None where nobody
            has looked.
    """

    positions_camera: NDArray[np.float64]
    scales_m: NDArray[np.float64]
    weights: NDArray[np.float64]
    p_person: NDArray[np.float64]
    joint_names: tuple[str, ...]
    to_cover_m: NDArray[np.float64] | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "joint_names", tuple(self.joint_names))
        P, M = self.weights.shape
        J = len(self.joint_names)
        for name, shape in (
            ("positions_camera", (P, M, J, 3)),
            ("scales_m", (P, M, J, 3)),
            ("p_person", (P,)),
        ):
            values = getattr(self, name)
            if values.shape != shape:
                raise InputError(f"{name} is {values.shape}; it must be {shape}")
            if not np.isfinite(values).all():
                raise InputError(f"{name} holds values that are not finite; all must be")
            read_only(values)
        if not (self.scales_m > 0.0).all():
            raise InputError(f"scales_m holds {self.scales_m.min()}; all must be above 0")
        if not (self.weights >= 0.0).all():
            raise InputError(f"weights holds {self.weights.min()}; all must be 0 or more")
        read_only(self.weights)
        if self.to_cover_m is not None:
            read_only(self.to_cover_m)

    def of_person(
        self, index: int, to_cover_m: NDArray[np.float64] | None = None
    ) -> JointProposals:
        """The proposals of one of the people, P = 1; `to_cover_m` as of all, where somebody has
        looked since."""
        one = slice(index, index + 1)
        to_cover_m = self.to_cover_m if to_cover_m is None else to_cover_m
        return JointProposals(
            self.positions_camera[one],
            self.scales_m[one],
            self.weights[one],
            self.p_person[one],
            self.joint_names,
            None if to_cover_m is None else to_cover_m[one],
        )


class JointProposer(Protocol):
    """Proposes the joints of people from the windows round them, a frame at a time."""

    def propose(self, windows: Windows) -> JointProposals:
        """Proposals for each window, in their order."""
        ...


@lru_cache(maxsize=64)  # proposers and who asks them each have names of their own
def proposed_of_joints(
    joint_names: tuple[str, ...], wanted: tuple[str, ...] = JOINT_NAMES
) -> NDArray[np.int64]:
    """[J] index into `joint_names` of each wanted joint, the body's if none are named; -1 for one
    that is not proposed."""
    index_of = {name: index for index, name in enumerate(joint_names)}
    return read_only(np.array([index_of.get(name, -1) for name in wanted]))
