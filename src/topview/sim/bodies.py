"""Human bodies: joints at anatomical centres, and flesh of many tapered, flattened round cones.

Lengths are shares of stature after R. Drillis and R. Contini, Body Segment Parameters (1966), as
printed in D. Winter, Biomechanics and Motor Control of Human Movement (2009), Fig. 4.1. Breadths
and girths are means of C. Gordon et al., 1988 Anthropometric Survey of U.S. Army Personnel
(1989), as shares of the men's mean stature, 1.756 m. Hip centres: A. Bell et al., Human Movement
Science 8 (1989).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from topview.records import InputError, read_only
from topview.sim.primitives import RoundCones
from topview.sim.skeleton import SEGMENT_INDEX, SEGMENTS

Sex = Literal["woman", "man"]
Vector = tuple[float, float, float]
Rgb = tuple[float, float, float]

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

MATERIALS: Final[tuple[str, ...]] = ("skin", "hair", "shirt", "trousers", "shoes", "eyes")
SKIN, HAIR, SHIRT, TROUSERS, SHOES, EYES = range(len(MATERIALS))

MEAN_STATURE_M: Final = 1.756
LEAST_STATURE_M, GREATEST_STATURE_M = 1.0, 2.2
ADULT_HEAD_SHARE: Final = 0.130  # chin to head top, Winter (2009)
SOLE_SHARE: Final = 0.039  # the ankle above the sole
HIP_SHARE, KNEE_SHARE = 0.530, 0.285


@dataclass(frozen=True, slots=True)
class Clothes:
    """What a person wears.

    Attributes:
        shirt, trousers, shoes: linear colours in 0..1.
        looseness: 0 tight, 1 as loose as a hooded jumper and wide trousers.
        has_long_sleeves: else they end above the elbow.
        has_long_legs: else the trousers end above the knee.
    """

    shirt: Rgb
    trousers: Rgb
    shoes: Rgb
    looseness: float = 0.4
    has_long_sleeves: bool = True
    has_long_legs: bool = True


@dataclass(frozen=True, slots=True)
class Look:
    """Who a body belongs to.

    Attributes:
        stature_m: of the standing person, without shoes and hair.
        sex: sets the breadth of shoulders and hips, and the chest.
        girth: breadth and depth of the flesh relative to the mean, 0.8 thin to 1.3 heavy.
        skin, hair: linear colours in 0..1.
        has_long_hair: down to the shoulders.
        clothes: what the person wears.
    """

    stature_m: float
    sex: Sex
    girth: float
    skin: Rgb
    hair: Rgb
    has_long_hair: bool
    clothes: Clothes

    def __post_init__(self) -> None:
        if not LEAST_STATURE_M <= self.stature_m <= GREATEST_STATURE_M:
            raise InputError(
                f"stature is {self.stature_m} m; "
                f"it must be {LEAST_STATURE_M:g} to {GREATEST_STATURE_M:g} m"
            )


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
        materials: [N] uint8 index into `MATERIALS`.
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


@dataclass(frozen=True, slots=True)
class _Flesh:
    """One round cone of the left half or the middle, lengths as shares of stature."""

    start_segment: str
    start: Vector
    start_radius: float
    end_segment: str
    end: Vector
    end_radius: float
    scales: Vector
    material: int


def head_share(stature_m: float) -> float:
    """Chin to head top as a share of stature: heads of children grow less than their bodies."""
    return ADULT_HEAD_SHARE * (MEAN_STATURE_M / stature_m) ** 0.6


def build_body(look: Look) -> Body:
    """The body of a person who looks like that."""
    stature = look.stature_m
    middle, side = _segment_offsets(look)
    flesh = [*_trunk(look), *_head(look), *_arm(look), *_leg(look)]
    flesh = [piece for half in flesh for piece in _both_sides(half)]
    offsets = {**middle, **{f"{name}_l": at for name, at in side.items()}}
    offsets |= {f"{name}_r": (-at[0], at[1], at[2]) for name, at in side.items()}
    offsets_m = stature * np.array([offsets[segment.name] for segment in SEGMENTS])
    joints = _joints(look)
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


def _both_sides(piece: _Flesh) -> list[_Flesh]:
    """A piece and its mirror image; a piece in the middle stays alone."""
    names = (piece.start_segment, piece.end_segment)
    is_lateral = any(name.endswith("_l") for name in names) or piece.start[0] or piece.end[0]
    if not is_lateral:
        return [piece]
    other = [name[:-2] + "_r" if name.endswith("_l") else name for name in names]
    (ax, ay, az), (bx, by, bz) = piece.start, piece.end
    mirrored = _Flesh(
        other[0], (-ax, ay, az), piece.start_radius,
        other[1], (-bx, by, bz), piece.end_radius,
        piece.scales, piece.material,
    )  # fmt: skip
    return [piece, mirrored]


def _segment_offsets(look: Look) -> tuple[dict[str, Vector], dict[str, Vector]]:
    """Origins of the middle and of the left segments in their carriers, shares of stature.

    The shoulder centre lies below and inside of the acromion (0.818 high, 0.129 to the side).
    """
    is_man = look.sex == "man"
    neck_base = 1.0 - head_share(look.stature_m) - 0.020
    shoulder = neck_base - 0.034
    torso = HIP_SHARE + 0.100
    middle: dict[str, Vector] = {
        "pelvis": (0.0, HIP_SHARE, 0.0),
        "abdomen": (0.0, 0.045, -0.006),
        "chest": (0.0, torso - HIP_SHARE - 0.045, 0.0),
        "neck": (0.0, neck_base - torso, -0.012),
        "head": (0.0, 0.052, 0.014),
    }
    reach = 0.106 if is_man else 0.098
    side: dict[str, Vector] = {
        "clavicle": (0.015, shoulder - torso + 0.004, 0.014),
        "upper_arm": (reach - 0.015, -0.004, -0.022),
        "forearm": (0.0, -0.186, 0.0),
        "hand": (0.0, -0.146, 0.0),
        "thigh": (0.050 if is_man else 0.052, 0.0, 0.0),
        "calf": (0.0, -(HIP_SHARE - KNEE_SHARE), 0.0),
        "foot": (0.0, -(KNEE_SHARE - SOLE_SHARE), 0.0),
    }
    return middle, side


def _joints(look: Look) -> dict[str, tuple[str, Vector, float]]:
    """Segment, place in it and half breadth of the flesh there, shares of stature."""
    g = look.girth
    head = head_share(look.stature_m)
    origin = (0.0, 0.0, 0.0)
    joints = {
        "head_top": ("head", (0.0, head - 0.032, 0.0), 0.35 * head),
        "head": ("head", (0.0, 0.5 * head - 0.032, 0.006), 0.35 * head),
        "neck": ("neck", origin, 0.035 * g),
        "torso": ("chest", origin, 0.070 * g),
        "pelvis": ("pelvis", origin, 0.080 * g),
    }
    for s in ("l", "r"):
        joints |= {
            f"shoulder_{s}": (f"upper_arm_{s}", origin, 0.034 * g),
            f"elbow_{s}": (f"forearm_{s}", origin, 0.024 * g),
            f"wrist_{s}": (f"hand_{s}", origin, 0.017),
            f"hand_{s}": (f"hand_{s}", (0.0, -0.030, 0.004), 0.022),
            f"hip_{s}": (f"thigh_{s}", origin, 0.050 * g),
            f"knee_{s}": (f"calf_{s}", origin, 0.034 * g),
            f"ankle_{s}": (f"foot_{s}", origin, 0.021),
            f"foot_{s}": (f"foot_{s}", (0.0, -0.026, 0.080), 0.024),
        }
    return joints


ROUND: Final[Vector] = (1.0, 1.0, 1.0)
HEM_FLATNESS: Final = 0.35
"""How far the shirt bulges over its lower end, relative to its depth (ours)."""


def _ball(segment: str, at: Vector, radius: float, material: int, scales: Vector = ROUND) -> _Flesh:
    return _Flesh(segment, at, radius, segment, at, radius, scales, material)


def _cone(
    segment: str, start: Vector, start_radius: float, end: Vector, end_radius: float,
    material: int, scales: Vector = ROUND,
) -> _Flesh:  # fmt: skip
    return _Flesh(segment, start, start_radius, segment, end, end_radius, scales, material)


def _trunk(look: Look) -> list[_Flesh]:
    """Rib cage, belly, pelvis, seat and shoulder girdle; breadth is x, depth z."""
    g, is_man = look.girth, look.sex == "man"
    loose = 0.008 * look.clothes.looseness
    belly = max(g - 1.0, 0.0)
    # half depths, and how much broader than deep
    chest, chest_flat = (0.066 if is_man else 0.061) * g + loose, 1.42
    waist, waist_flat = (0.060 if is_man else 0.054) * g + loose, 1.32
    hips, hips_flat = (0.068 if is_man else 0.070) * g + loose, 1.38
    top = _segment_offsets(look)[1]["clavicle"][1]  # shoulder girdle above the mid spine
    pieces = [
        _cone("chest", (0.0, top - 0.062, 0.000), chest, (0.0, 0.030, 0.004), 0.93 * chest,
              SHIRT, (chest_flat, 1.0, 1.0)),
        _Flesh("chest", (0.0, 0.030, 0.004), 0.98 * waist, "abdomen", (0.0, 0.0, 0.006), waist,
               (1.03 * waist_flat, 1.0, 1.0), SHIRT),
        _Flesh("abdomen", (0.0, 0.010, 0.004), waist, "pelvis", (0.0, 0.000, 0.002),
               1.05 * hips, (hips_flat, HEM_FLATNESS, 1.0), SHIRT),
        _cone("pelvis", (0.0, -0.008, 0.0), 0.97 * hips, (0.0, -0.022, 0.0), 0.95 * hips,
              TROUSERS, (hips_flat, 0.5, 1.0)),
        _ball("pelvis", (0.042, -0.024, -0.026), 0.050 * g + loose, TROUSERS, (1.0, 1.05, 0.95)),
        # trapezius, from the neck to the shoulder, and the deltoid
        _Flesh("neck", (0.012, 0.000, 0.000), 0.030 * g, "clavicle_l",
               (0.070, 0.004, -0.020), 0.028 * g + loose, ROUND, SHIRT),
        _Flesh("clavicle_l", (0.030, -0.024, -0.014), 0.040 * g + loose, "clavicle_l",
               (0.082, -0.014, -0.022), 0.035 * g + loose, ROUND, SHIRT),
    ]  # fmt: skip
    if belly > 0.0:
        pieces.append(
            _ball("abdomen", (0.0, 0.0, 0.012 + 0.08 * belly), 0.066 * g + loose, SHIRT,
                  (1.15, 1.0, 0.85))
        )  # fmt: skip
    if not is_man:
        pieces.append(
            _ball("chest", (0.034, top - 0.088, 0.030), 0.042 * g + 0.5 * loose, SHIRT,
                  (1.0, 1.0, 0.92))
        )  # fmt: skip
    return pieces


def _head(look: Look) -> list[_Flesh]:
    """Neck, skull, jaw, nose, eyes and hair; the head's frame sits 0.032 above the chin."""
    k = head_share(look.stature_m)
    g = 0.6 + 0.4 * look.girth  # heads and necks vary less than bellies
    skull: Vector = (0.0, 0.66 * k - 0.032, -0.02 * k)
    pieces = [
        _Flesh("neck", (0.0, -0.012, 0.004), 0.036 * g, "head", (0.0, 0.0, 0.0), 0.031 * g, ROUND,
               SKIN),
        _ball("head", skull, 0.34 * k, SKIN, (0.98, 1.0, 1.26)),
        _cone("head", (0.0, 0.52 * k - 0.032, 0.11 * k), 0.285 * k,
              (0.0, 0.14 * k - 0.032, 0.20 * k), 0.15 * k, SKIN, (1.05, 1.0, 1.0)),
        _cone("head", (0.0, 0.55 * k - 0.032, 0.40 * k), 0.035 * k,
              (0.0, 0.38 * k - 0.032, 0.45 * k), 0.055 * k, SKIN),
        _ball("head", (0.13 * k, 0.53 * k - 0.032, 0.355 * k), 0.036 * k, EYES, (1.3, 0.8, 1.0)),
        _ball("head", (0.34 * k, 0.50 * k - 0.032, 0.0), 0.08 * k, SKIN, (0.5, 1.5, 1.0)),
        _ball("head", (0.0, skull[1] + 0.085 * k, skull[2] - 0.05 * k), 0.345 * k, HAIR,
              (1.04, 0.98, 1.20)),
    ]  # fmt: skip
    if look.has_long_hair:
        pieces.append(
            _cone("head", (0.0, skull[1], skull[2] - 0.13 * k), 0.34 * k,
                  (0.0, -0.10 * k - 0.032, -0.30 * k), 0.24 * k, HAIR, (1.05, 1.0, 0.80))
        )  # fmt: skip
    return pieces


def _arm(look: Look) -> list[_Flesh]:
    """The left arm: deltoid, upper arm, forearm with its muscle, palm, fingers and thumb."""
    g = look.girth if look.sex == "man" else 0.92 * look.girth
    clothes = look.clothes
    loose = 0.007 * clothes.looseness
    lower, cuff = (SHIRT, loose) if clothes.has_long_sleeves else (SKIN, 0.0)
    return [
        _Flesh("chest", (0.058, 0.105, -0.006), 0.042 * g + loose, "upper_arm_l",
               (-0.004, -0.050, 0.0), 0.026 * g + loose, ROUND, SHIRT),
        _cone("upper_arm_l", (0.002, -0.004, 0.0), 0.035 * g + loose, (0.003, -0.060, 0.002),
              0.031 * g + loose, SHIRT),
        _cone("upper_arm_l", (0.003, -0.060, 0.002), 0.031 * g + loose, (0.0, -0.130, 0.002),
              0.028 * g + loose, SHIRT),
        _cone("upper_arm_l", (0.0, -0.130, 0.002), 0.027 * g + cuff, (0.0, -0.184, 0.0),
              0.0235 * g + cuff, lower),
        _cone("forearm_l", (0.0, 0.0, -0.001), 0.0245 * g + cuff, (0.002, -0.040, 0.002),
              0.0265 * g + cuff, lower),
        _cone("forearm_l", (0.002, -0.040, 0.002), 0.0265 * g + cuff, (0.0, -0.134, 0.0),
              0.0165 * g + 1.2 * cuff, lower, (0.95, 1.0, 1.05)),
        _cone("forearm_l", (0.0, -0.130, 0.0), 0.0160, (0.0, -0.146, 0.0), 0.0155, SKIN,
              (0.85, 1.0, 1.1)),
        _cone("hand_l", (0.0, -0.004, 0.0), 0.0170, (0.0, -0.045, 0.002), 0.0245, SKIN,
              (0.50, 1.0, 1.0)),
        _cone("hand_l", (0.001, -0.050, 0.012), 0.0085, (-0.005, -0.094, 0.013), 0.0060, SKIN),
        _cone("hand_l", (0.001, -0.050, 0.000), 0.0085, (-0.005, -0.100, 0.000), 0.0060, SKIN),
        _cone("hand_l", (0.001, -0.050, -0.012), 0.0080, (-0.006, -0.090, -0.013), 0.0055, SKIN),
        _cone("hand_l", (-0.002, -0.014, 0.014), 0.0095, (-0.008, -0.052, 0.036), 0.0065, SKIN),
    ]  # fmt: skip


def _leg(look: Look) -> list[_Flesh]:
    """The left leg: thigh, knee, calf muscle, shin, heel, sole and toes."""
    g = look.girth if look.sex == "man" else 1.03 * look.girth
    clothes = look.clothes
    loose = 0.010 * clothes.looseness
    lower, wide = (TROUSERS, loose) if clothes.has_long_legs else (SKIN, 0.0)
    ankle, sole = -(KNEE_SHARE - SOLE_SHARE), -SOLE_SHARE
    return [
        _Flesh("pelvis", (0.044, -0.016, -0.002), 0.050 * g + loose, "thigh_l",
               (0.003, -0.045, 0.000), 0.053 * g + loose, ROUND, TROUSERS),
        _cone("thigh_l", (0.003, -0.045, 0.0), 0.053 * g + loose, (0.002, -0.165, 0.004),
              0.041 * g + loose, TROUSERS),
        _cone("thigh_l", (0.002, -0.165, 0.004), 0.041 * g + wide, (0.0, -0.243, 0.002),
              0.034 * g + wide, lower),
        _cone("calf_l", (0.0, 0.0, 0.002), 0.0345 * g + wide, (0.0, -0.060, -0.006),
              0.0335 * g + wide, lower),
        _cone("calf_l", (0.0, -0.060, -0.006), 0.0335 * g + wide, (0.0, -0.150, -0.004),
              0.0250 * g + 1.2 * wide, lower),
        _cone("calf_l", (0.0, -0.150, -0.004), 0.0250 * g + 1.2 * wide,
              (0.0, ankle + 0.012, -0.004), 0.0205 + 1.4 * wide, lower),
        _cone("foot_l", (0.0, 0.004, -0.002), 0.0210, (0.0, sole + 0.024, 0.022), 0.0230, SHOES),
        _cone("foot_l", (0.0, sole + 0.020, -0.018), 0.0200, (0.002, sole + 0.017, 0.070),
              0.0170, SHOES, (1.25, 1.0, 1.0)),
        _cone("foot_l", (0.002, sole + 0.017, 0.060), 0.0170, (0.002, sole + 0.012, 0.104),
              0.0120, SHOES, (1.65, 1.0, 1.0)),
    ]  # fmt: skip


EYE_COLOR: Final[Rgb] = (0.03, 0.02, 0.02)
SKINS: Final[tuple[Rgb, ...]] = (
    (0.78, 0.55, 0.43), (0.68, 0.44, 0.32), (0.50, 0.30, 0.20), (0.26, 0.14, 0.09),
)  # fmt: skip
HAIRS: Final[tuple[Rgb, ...]] = (
    (0.02, 0.015, 0.012), (0.06, 0.03, 0.018), (0.20, 0.10, 0.04), (0.55, 0.38, 0.16),
    (0.35, 0.33, 0.31),
)  # fmt: skip
CLOTHS: Final[tuple[Rgb, ...]] = (
    (0.55, 0.04, 0.05), (0.03, 0.13, 0.42), (0.05, 0.28, 0.12), (0.70, 0.68, 0.62),
    (0.06, 0.06, 0.07), (0.75, 0.42, 0.06), (0.28, 0.12, 0.36), (0.20, 0.42, 0.50),
)  # fmt: skip
DENIMS: Final[tuple[Rgb, ...]] = (
    (0.04, 0.07, 0.16), (0.10, 0.10, 0.11), (0.30, 0.25, 0.17), (0.09, 0.16, 0.28),
)  # fmt: skip
LEATHERS: Final[tuple[Rgb, ...]] = (
    (0.03, 0.03, 0.03), (0.10, 0.05, 0.02), (0.60, 0.60, 0.58), (0.25, 0.05, 0.05),
)  # fmt: skip


def random_look(rng: np.random.Generator, sex: Sex | None = None, shirt: Rgb | None = None) -> Look:
    """An adult of either sex; statures after Gordon et al. (1989), colours ours."""
    sex = sex or ("man" if rng.random() < 0.5 else "woman")
    mean, spread = (MEAN_STATURE_M, 0.067) if sex == "man" else (1.629, 0.064)

    def pick(colors: tuple[Rgb, ...]) -> Rgb:
        return colors[rng.integers(len(colors))]

    return Look(
        stature_m=float(np.clip(rng.normal(mean, spread), 1.45, 2.0)),
        sex=sex,
        girth=float(np.clip(rng.normal(1.0, 0.08), 0.82, 1.3)),
        skin=pick(SKINS),
        hair=pick(HAIRS),
        has_long_hair=sex == "woman" and bool(rng.random() < 0.7),
        clothes=Clothes(
            shirt=shirt or pick(CLOTHS),
            trousers=pick(DENIMS),
            shoes=pick(LEATHERS),
            looseness=float(rng.uniform(0.1, 1.0)),
            has_long_sleeves=bool(rng.random() < 0.5),
            has_long_legs=bool(rng.random() < 0.85),
        ),
    )
