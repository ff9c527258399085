"""The flesh of a body: tapered, flattened round cones with human breadths and girths.

Sizes are shares of stature: means of C. Gordon et al., 1988 Anthropometric Survey of U.S. Army
Personnel (1989), over the men's mean stature; how they are spread over the pieces is ours.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from topview.sim.anthropometry import (
    CHIN_DROP_SHARE,
    KNEE_SHARE,
    SOLE_SHARE,
    Vector,
    head_share,
    segment_offsets,
)
from topview.sim.looks import Look

MATERIALS: Final[tuple[str, ...]] = ("skin", "hair", "shirt", "trousers", "shoes", "eyes")
SKIN, HAIR, SHIRT, TROUSERS, SHOES, EYES = range(len(MATERIALS))


@dataclass(frozen=True, slots=True)
class Flesh:
    """One round cone of the left half or the middle, lengths as shares of stature."""

    start_segment: str
    start: Vector
    start_radius: float
    end_segment: str
    end: Vector
    end_radius: float
    scales: Vector
    material: int


def all_flesh(look: Look) -> list[Flesh]:
    """Every piece of a person's flesh, both sides."""
    pieces = [*_trunk(look), *_head(look), *_arm(look), *_leg(look)]
    return [piece for half in pieces for piece in _both_sides(half)]


def _both_sides(piece: Flesh) -> list[Flesh]:
    """A piece and its mirror image; a piece in the middle stays alone."""
    names = (piece.start_segment, piece.end_segment)
    is_lateral = any(name.endswith("_l") for name in names) or piece.start[0] or piece.end[0]
    if not is_lateral:
        return [piece]
    other = [name[:-2] + "_r" if name.endswith("_l") else name for name in names]
    (ax, ay, az), (bx, by, bz) = piece.start, piece.end
    mirrored = Flesh(
        other[0], (-ax, ay, az), piece.start_radius,
        other[1], (-bx, by, bz), piece.end_radius,
        piece.scales, piece.material,
    )  # fmt: skip
    return [piece, mirrored]


ROUND: Final[Vector] = (1.0, 1.0, 1.0)
HEM_FLATNESS: Final = 0.35
"""How far the shirt bulges over its lower end, relative to its depth (ours)."""


def _ball(segment: str, at: Vector, radius: float, material: int, scales: Vector = ROUND) -> Flesh:
    return Flesh(segment, at, radius, segment, at, radius, scales, material)


def _cone(
    segment: str, start: Vector, start_radius: float, end: Vector, end_radius: float,
    material: int, scales: Vector = ROUND,
) -> Flesh:  # fmt: skip
    return Flesh(segment, start, start_radius, segment, end, end_radius, scales, material)


def _trunk(look: Look) -> list[Flesh]:
    """Rib cage, belly, pelvis, seat and shoulder girdle; breadth is x, depth z."""
    g, is_man = look.girth, look.sex == "man"
    loose = 0.008 * look.clothes.looseness
    belly = max(g - 1.0, 0.0)
    # half depths, and how much broader than deep
    chest, chest_flat = (0.066 if is_man else 0.061) * g + loose, 1.42
    waist, waist_flat = (0.060 if is_man else 0.054) * g + loose, 1.32
    hips, hips_flat = (0.068 if is_man else 0.070) * g + loose, 1.38
    top = segment_offsets(look)[1]["clavicle"][1]  # shoulder girdle above the mid spine
    pieces = [
        _cone("chest", (0.0, top - 0.062, 0.000), chest, (0.0, 0.030, 0.004), 0.93 * chest,
              SHIRT, (chest_flat, 1.0, 1.0)),
        Flesh("chest", (0.0, 0.030, 0.004), 0.98 * waist, "abdomen", (0.0, 0.0, 0.006), waist,
               (1.03 * waist_flat, 1.0, 1.0), SHIRT),
        Flesh("abdomen", (0.0, 0.010, 0.004), waist, "pelvis", (0.0, 0.000, 0.002),
               1.05 * hips, (hips_flat, HEM_FLATNESS, 1.0), SHIRT),
        _cone("pelvis", (0.0, -0.008, 0.0), 0.97 * hips, (0.0, -0.022, 0.0), 0.95 * hips,
              TROUSERS, (hips_flat, 0.5, 1.0)),
        _ball("pelvis", (0.042, -0.024, -0.026), 0.050 * g + loose, TROUSERS, (1.0, 1.05, 0.95)),
        # trapezius, from the neck to the shoulder, and the deltoid
        Flesh("neck", (0.012, 0.000, 0.000), 0.030 * g, "clavicle_l",
               (0.070, 0.004, -0.020), 0.028 * g + loose, ROUND, SHIRT),
        Flesh("clavicle_l", (0.030, -0.024, -0.014), 0.040 * g + loose, "clavicle_l",
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


def _head(look: Look) -> list[Flesh]:
    """Neck, skull, jaw, nose, eyes and hair, in a frame whose y is 0 at the head's joint."""
    k, chin = head_share(look.stature_m), -CHIN_DROP_SHARE
    g = 0.6 + 0.4 * look.girth  # heads and necks vary less than bellies
    skull: Vector = (0.0, 0.66 * k + chin, -0.02 * k)
    pieces = [
        Flesh("neck", (0.0, -0.012, 0.004), 0.036 * g, "head", (0.0, 0.0, 0.0), 0.031 * g, ROUND,
               SKIN),
        _ball("head", skull, 0.34 * k, SKIN, (0.98, 1.0, 1.26)),
        _cone("head", (0.0, 0.52 * k + chin, 0.11 * k), 0.285 * k,
              (0.0, 0.14 * k + chin, 0.20 * k), 0.15 * k, SKIN, (1.05, 1.0, 1.0)),
        _cone("head", (0.0, 0.55 * k + chin, 0.40 * k), 0.035 * k,
              (0.0, 0.38 * k + chin, 0.45 * k), 0.055 * k, SKIN),
        _ball("head", (0.13 * k, 0.53 * k + chin, 0.355 * k), 0.036 * k, EYES, (1.3, 0.8, 1.0)),
        _ball("head", (0.34 * k, 0.50 * k + chin, 0.0), 0.08 * k, SKIN, (0.5, 1.5, 1.0)),
        _ball("head", (0.0, skull[1] + 0.085 * k, skull[2] - 0.05 * k), 0.345 * k, HAIR,
              (1.04, 0.98, 1.20)),
    ]  # fmt: skip
    if look.has_long_hair:
        pieces.append(
            _cone("head", (0.0, skull[1], skull[2] - 0.13 * k), 0.34 * k,
                  (0.0, -0.10 * k + chin, -0.30 * k), 0.24 * k, HAIR, (1.05, 1.0, 0.80))
        )  # fmt: skip
    return pieces


def _arm(look: Look) -> list[Flesh]:
    """The left arm: deltoid, upper arm, forearm with its muscle, palm, fingers and thumb."""
    g = look.girth if look.sex == "man" else 0.92 * look.girth
    clothes = look.clothes
    loose = 0.007 * clothes.looseness
    lower, cuff = (SHIRT, loose) if clothes.has_long_sleeves else (SKIN, 0.0)
    return [
        Flesh("chest", (0.058, 0.105, -0.006), 0.042 * g + loose, "upper_arm_l",
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


def _leg(look: Look) -> list[Flesh]:
    """The left leg: thigh, knee, calf muscle, shin, heel, sole and toes."""
    g = look.girth if look.sex == "man" else 1.03 * look.girth
    clothes = look.clothes
    loose = 0.010 * clothes.looseness
    lower, wide = (TROUSERS, loose) if clothes.has_long_legs else (SKIN, 0.0)
    ankle, sole = -(KNEE_SHARE - SOLE_SHARE), -SOLE_SHARE
    return [
        Flesh("pelvis", (0.044, -0.016, -0.002), 0.050 * g + loose, "thigh_l",
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
