"""Human bodies that can be posed: joints at anatomical centres, and the flesh around them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.records import read_only
from topview_lab.sim.anthropometry import joint_places, segment_offsets
from topview_lab.sim.appearance import Appearance
from topview_lab.sim.flesh import all_flesh
from topview_lab.sim.folds import Folds
from topview_lab.sim.materials import HAIR, SHIRT, TROUSERS, fold_amplitudes, material_colors
from topview_lab.sim.primitives import RoundCones
from topview_lab.sim.skeleton import SEGMENT_INDEX, SEGMENTS

SIM_PART_NAMES: Final[tuple[str, ...]] = (
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

SIM_JOINT_NAMES: Final[tuple[str, ...]] = (
    "head_top", "head", "neck", "torso", "pelvis",
    "shoulder_l", "elbow_l", "wrist_l", "hand_l", "shoulder_r", "elbow_r", "wrist_r", "hand_r",
    "hip_l", "knee_l", "ankle_l", "foot_l", "hip_r", "knee_r", "ankle_r", "foot_r",
)  # fmt: skip


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
        parts: [N] uint8 index into `SIM_PART_NAMES`.
        materials: [N] uint8 index into `materials.MATERIALS`.
        colors: [N, 3] linear colours in 0..1.
        folds: irregularities of the surface, over places in the standing body.
        places_m: [N, 3] where the origin of each piece's first segment lies in the standing body.
        fold_amplitudes_m: [N] of each piece's surface.
    """

    appearance: Appearance
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
    folds: Folds
    places_m: NDArray[np.float64]
    fold_amplitudes_m: NDArray[np.float64]

    def __post_init__(self) -> None:
        for name in self.__dataclass_fields__:
            if name not in ("appearance", "folds"):
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

    def pattern(
        self, piece: NDArray[np.int32], places_m: NDArray[np.float32]
    ) -> NDArray[np.float32]:
        """[M] share of its colour that the shirt shows at places [M, 3] in the standing body."""
        shades = np.ones(len(piece), np.float32)
        if self.appearance.clothes.pattern == "plain":
            return shades
        cloth = self.materials[piece] == SHIRT
        x, y, _ = np.sin(np.float32(2.0 * np.pi / STRIPE_M) * places_m[cloth]).T
        is_dark = y > 0.0 if self.appearance.clothes.pattern == "stripes" else (x > 0.0) ^ (y > 0.0)
        shades[cloth] = np.where(is_dark, np.float32(DARK_STRIPE), np.float32(1.0))
        return shades


STRIPE_M: Final = 0.08
"""Width of a light and a dark stripe together (ours)."""
DARK_STRIPE: Final = 0.45
"""Share of its colour that cloth shows in the dark stripes (ours)."""


def _placed(
    Ts_a_segment: NDArray[np.float64], segments: NDArray[np.intp], points: NDArray[np.float64]
) -> NDArray[np.float64]:
    poses = Ts_a_segment[segments]
    return np.einsum("nij,nj->ni", poses[:, :3, :3], points) + poses[:, :3, 3]


def build_body(appearance: Appearance) -> Body:
    """The body of a person who looks like that."""
    stature = appearance.stature_m
    flesh = all_flesh(appearance)
    offsets = segment_offsets(appearance)
    offsets_m = stature * np.array([offsets[segment.name] for segment in SEGMENTS])
    joints = joint_places(appearance)
    materials = np.array([piece.material for piece in flesh], np.uint8)
    even = appearance.folds_seed is None
    folds = Folds.sample(np.random.default_rng(appearance.folds_seed or 0))
    body = Body(
        appearance=appearance,
        offsets_m=offsets_m,
        joint_segments=np.array([SEGMENT_INDEX[joints[name][0]] for name in SIM_JOINT_NAMES]),
        joint_offsets_m=stature * np.array([joints[name][1] for name in SIM_JOINT_NAMES]),
        joint_radii_m=stature * np.array([joints[name][2] for name in SIM_JOINT_NAMES]),
        start_segments=np.array([SEGMENT_INDEX[piece.start_segment] for piece in flesh]),
        starts_m=stature * np.array([piece.start for piece in flesh]),
        start_radii_m=stature * np.array([piece.start_radius for piece in flesh]),
        end_segments=np.array([SEGMENT_INDEX[piece.end_segment] for piece in flesh]),
        ends_m=stature * np.array([piece.end for piece in flesh]),
        end_radii_m=stature * np.array([piece.end_radius for piece in flesh]),
        scales=np.array([piece.scales for piece in flesh]),
        parts=np.array(
            [SIM_PART_NAMES.index(_part(piece.end_segment)) for piece in flesh], np.uint8
        ),
        materials=materials,
        colors=np.array(material_colors(appearance))[materials],
        folds=folds,
        places_m=_standing_places(offsets_m)[[SEGMENT_INDEX[f.start_segment] for f in flesh]],
        fold_amplitudes_m=(0.0 if even else 1.0) * np.array(fold_amplitudes(appearance))[materials],
    )
    return body if even else _rumpled(body)


def _standing_places(offsets_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """[S, 3] origins of the segments in the standing body, whose segments' axes are all alike."""
    places = np.zeros_like(offsets_m)
    for s, segment in enumerate(SEGMENTS):
        if segment.hangs_from:
            places[s] = places[SEGMENT_INDEX[segment.hangs_from]] + offsets_m[s]
    return places


def _rumpled(body: Body) -> Body:
    """Clothes that stand off the body here and there and hang askew, so that outlines are uneven
    as well. Balls at one place are moved alike."""
    places = _standing_places(body.offsets_m)
    is_cloth = np.isin(body.materials, (HAIR, SHIRT, TROUSERS))
    amplitudes = np.where(is_cloth, body.fold_amplitudes_m, 0.0).astype(np.float32)

    def moved(
        segments: NDArray[np.intp], points: NDArray[np.float64], radii: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        standing = places[segments] + points
        at = [
            body.folds.at((standing + shift).astype(np.float32), amplitudes)[0]
            for shift in FOLD_SHIFTS
        ]
        askew = np.stack([at[1], np.zeros_like(at[1]), at[2]], -1)
        return points + 0.5 * askew, radii + 0.5 * (amplitudes + at[0])

    starts, start_radii = moved(body.start_segments, body.starts_m, body.start_radii_m)
    ends, end_radii = moved(body.end_segments, body.ends_m, body.end_radii_m)
    return replace(
        body, starts_m=starts, start_radii_m=start_radii, ends_m=ends, end_radii_m=end_radii
    )


FOLD_SHIFTS: Final = (0.0, 10.0, 20.0)
"""Metres between the places at which the folds are read for radius, side and depth (ours): far
enough for the three to have nothing to do with each other."""


def _part(segment: str) -> str:
    stem, side = (segment[:-2], segment[-2:]) if segment[-2:] in ("_l", "_r") else (segment, "")
    part = _PART_OF_STEM[stem]
    return part if part.endswith("torso") else part + side
