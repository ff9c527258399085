"""Human bodies that can be posed: joints at anatomical centres, and the flesh around them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.records import read_only
from topview.sim.anthropometry import joint_places, segment_offsets
from topview.sim.flesh import all_flesh
from topview.sim.looks import Look, Rgb
from topview.sim.primitives import RoundCones
from topview.sim.skeleton import SEGMENT_INDEX, SEGMENTS

PART_NAMES: Final[tuple[str, ...]] = (
    "head", "upper_torso", "lower_torso",
    "upper_arm_l", "forearm_l", "hand_l", "upper_arm_r", "forearm_r", "hand_r",
    "upper_leg_l", "lower_leg_l", "foot_l", "upper_leg_r", "lower_leg_r", "foot_r",
)  # fmt: skip
"""What a surface point belongs to; the part's index is its label."""

_PART_OF_STEM: Final = {
    "pelvis": "lower_torso", "abdomen": "lower_torso", "chest": "upper_torso",
    "clavicle": "upper_torso", "neck": "upper_torso", "head": "head",
    "upper_arm": "upper_arm", "forearm": "forearm", "hand": "hand",
    "thigh": "upper_leg", "calf": "lower_leg", "foot": "foot",
}  # fmt: skip

JOINT_NAMES: Final[tuple[str, ...]] = (
    "head_top", "head", "neck", "torso", "pelvis",
    "shoulder_l", "elbow_l", "wrist_l", "hand_l", "shoulder_r", "elbow_r", "wrist_r", "hand_r",
    "hip_l", "knee_l", "ankle_l", "foot_l", "hip_r", "knee_r", "ankle_r", "foot_r",
)  # fmt: skip

EYE_COLOR: Final[Rgb] = (0.03, 0.02, 0.02)


@dataclass(frozen=True, slots=True, eq=False)
class Body:
    """A body that can be posed: S segments, N pieces of flesh, J joints.

    Attributes:
        look: whose it is.
        offsets_m: [S, 3] origin of each segment in the frame that it hangs from.
        joint_segments, joint_offsets_m: [J], [J, 3] where each joint is fixed.
        joint_radii_m: [J] half breadth of the flesh around each joint.
        start_segments, starts_m, start_radii_m: [N], [N, 3], [N] first ball of each piece.
        end_segments, ends_m, end_radii_m: the same for its second ball.
        scales: [N, 3] stretch of its cross-section along the axes of its first ball's segment.
        parts: [N] uint8 index into `PART_NAMES`.
        materials: [N] uint8 index into `flesh.MATERIALS`.
        colors: [N, 3] linear colours in 0..1.
    """

    look: Look
    offsets_m: NDArray[np.float64]
    joint_segments: NDArray[np.intp]
    joint_offsets_m: NDArray[np.float64]
    joint_radii_m: NDArray[np.float64]
    start_segments: NDArray[np.intp]
    starts_m: NDArray[np.float64]
    start_radii_m: NDArray[np.float64]
    end_segments: NDArray[np.intp]
    ends_m: NDArray[np.float64]
    end_radii_m: NDArray[np.float64]
    scales: NDArray[np.float64]
    parts: NDArray[np.uint8]
    materials: NDArray[np.uint8]
    colors: NDArray[np.float64]

    def __post_init__(self) -> None:
        for name in self.__dataclass_fields__:
            if name != "look":
                read_only(getattr(self, name))

    def joints(self, Ts_a_segment: NDArray[np.float64]) -> NDArray[np.float64]:
        """[J, 3] joints in frame a, metres."""
        return _placed(Ts_a_segment, self.joint_segments, self.joint_offsets_m)

    def flesh(self, Ts_a_segment: NDArray[np.float64]) -> RoundCones:
        """The posed flesh in frame a."""
        return RoundCones(
            starts=_placed(Ts_a_segment, self.start_segments, self.starts_m),
            ends=_placed(Ts_a_segment, self.end_segments, self.ends_m),
            start_radii=self.start_radii_m,
            end_radii=self.end_radii_m,
            axes=Ts_a_segment[self.start_segments, :3, :3],
            scales=self.scales,
        )


def _placed(
    Ts_a_segment: NDArray[np.float64], segments: NDArray[np.intp], points: NDArray[np.float64]
) -> NDArray[np.float64]:
    poses = Ts_a_segment[segments]
    return np.einsum("nij,nj->ni", poses[:, :3, :3], points) + poses[:, :3, 3]


def build_body(look: Look) -> Body:
    """The body of a person who looks like that."""
    stature = look.stature_m
    middle, side = segment_offsets(look)
    flesh = all_flesh(look)
    offsets = {**middle, **{f"{name}_l": at for name, at in side.items()}}
    offsets |= {f"{name}_r": (-at[0], at[1], at[2]) for name, at in side.items()}
    offsets_m = stature * np.array([offsets[segment.name] for segment in SEGMENTS])
    joints = joint_places(look)
    clothes = look.clothes
    colors = (look.skin, look.hair, clothes.shirt, clothes.trousers, clothes.shoes, EYE_COLOR)
    return Body(
        look=look,
        offsets_m=offsets_m,
        joint_segments=np.array([SEGMENT_INDEX[joints[name][0]] for name in JOINT_NAMES]),
        joint_offsets_m=stature * np.array([joints[name][1] for name in JOINT_NAMES]),
        joint_radii_m=stature * np.array([joints[name][2] for name in JOINT_NAMES]),
        start_segments=np.array([SEGMENT_INDEX[piece.start_segment] for piece in flesh]),
        starts_m=stature * np.array([piece.start for piece in flesh]),
        start_radii_m=stature * np.array([piece.start_radius for piece in flesh]),
        end_segments=np.array([SEGMENT_INDEX[piece.end_segment] for piece in flesh]),
        ends_m=stature * np.array([piece.end for piece in flesh]),
        end_radii_m=stature * np.array([piece.end_radius for piece in flesh]),
        scales=np.array([piece.scales for piece in flesh]),
        parts=np.array([PART_NAMES.index(_part(piece.end_segment)) for piece in flesh], np.uint8),
        materials=np.array([piece.material for piece in flesh], np.uint8),
        colors=np.array([colors[piece.material] for piece in flesh]),
    )


def _part(segment: str) -> str:
    stem, side = (segment[:-2], segment[-2:]) if segment[-2:] in ("_l", "_r") else (segment, "")
    part = _PART_OF_STEM[stem]
    return part if part.endswith("torso") else part + side
