"""The flesh of a body: tapered, flattened round cones with human breadths and girths.

Sizes are shares of stature: means of C. Gordon et al., 1988 Anthropometric Survey of U.S. Army
Personnel (1989), over the men's mean stature; how they are spread over the pieces is ours.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from topview_lab.sim.anthropometry import (
    CHIN_DROP_SHARE,
    SOLE_SHARE,
    Vector,
    arm_shares,
    head_share,
    hip_share,
    knee_share,
    segment_offsets,
)
from topview_lab.sim.appearance import Appearance
from topview_lab.sim.materials import EYES, HAIR, SHIRT, SHOES, SKIN, TROUSERS


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


def all_flesh(appearance: Appearance) -> list[Flesh]:
    """Every piece of a person's flesh, both sides."""
    pieces = [
        *_trunk(appearance),
        *_head(appearance),
        *_arm(appearance),
        *_leg(appearance),
        *_skirt(appearance),
    ]
    return [piece for half in pieces for piece in _both_sides(half)]


def _both_sides(piece: Flesh) -> list[Flesh]:
    """A piece and its mirror image; a piece in the middle stays alone."""
    names = (piece.start_segment, piece.end_segment)
    is_lateral = any(name.endswith("_l") for name in names) or piece.start[0] or piece.end[0]
    if not is_lateral:
        return [piece]
    if {"thigh_l", "thigh_r"} == set(names):  # spans both sides
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
OPEN_END: Final[Vector] = (1.0, 0.4, 1.0)
"""Stretch of the ends of sleeves and trouser legs, which are rather flat (ours)."""
HEM_FLATNESS: Final = 0.35
"""How far the shirt bulges over its lower end, relative to its depth (ours)."""


def _ball(segment: str, at: Vector, radius: float, material: int, scales: Vector = ROUND) -> Flesh:
    return Flesh(segment, at, radius, segment, at, radius, scales, material)


def _cone(
    segment: str, start: Vector, start_radius: float, end: Vector, end_radius: float,
    material: int, scales: Vector = ROUND,
) -> Flesh:  # fmt: skip
    return Flesh(segment, start, start_radius, segment, end, end_radius, scales, material)


def _trunk(appearance: Appearance) -> list[Flesh]:
    """Rib cage, belly, pelvis, seat and shoulder girdle; breadth is x, depth z.

    A loose shirt hangs from chest and shoulders, and hides the waist.
    """
    g, more, is_man = appearance.girth, appearance.proportions, appearance.sex == "man"
    loose = appearance.clothes.looseness
    belly = more.belly + 0.08 * max(g - 1.0, 0.0)
    # half depths, and how much broader than deep
    chest, chest_flat = (0.066 if is_man else 0.061) * g + 0.012 * loose, 1.40 * more.shoulders
    waist, waist_flat = (0.060 if is_man else 0.054) * g + 0.023 * loose, 1.32
    hips, hips_flat = (0.066 if is_man else 0.068) * g, 1.38 * more.hips
    hem = hips + 0.002 + 0.018 * loose
    top = segment_offsets(appearance)["clavicle_l"][1]  # shoulder girdle above the mid spine
    slope = -0.004 - more.shoulder_slope
    pieces = [
        _cone("chest", (0.0, top - 0.062, 0.014), chest, (0.0, 0.030, 0.014), 0.93 * chest,
              SHIRT, (chest_flat, 1.0, 1.0)),
        Flesh("chest", (0.0, 0.030, 0.014), 0.98 * waist, "abdomen", (0.0, 0.0, 0.018), waist,
               (1.03 * waist_flat, 1.0, 1.0), SHIRT),
        Flesh("abdomen", (0.0, 0.010, 0.016), waist, "pelvis", (0.0, -0.012 * loose, 0.004),
               hem, (hips_flat, HEM_FLATNESS, 1.0), SHIRT),
        _cone("pelvis", (0.0, -0.008, 0.002), 0.97 * hips, (0.0, -0.022, 0.002), 0.95 * hips,
              TROUSERS, (hips_flat, 0.5, 1.0)),
        _ball("pelvis", (0.042 * more.hips, -0.024, -0.024), 0.050 * g, TROUSERS,
              (1.0, 1.05, 0.95)),
        # trapezius, from the neck to the shoulder, and the girdle below it
        Flesh("neck", (0.012, 0.004, 0.002), 0.029 * g, "clavicle_l", (0.066, slope, -0.018),
               0.028 * g + 0.004 * loose, ROUND, SHIRT),
        Flesh("clavicle_l", (0.030, -0.024, -0.010), 0.040 * g + 0.004 * loose, "clavicle_l",
               (0.080, -0.014, -0.018), 0.034 * g + 0.005 * loose, ROUND, SHIRT),
    ]  # fmt: skip
    if belly > 0.0:
        pieces.append(
            _ball("abdomen", (0.0, -0.004, 0.008 + belly), 0.066 * g + 0.008 * loose, SHIRT,
                  (1.18, 1.05, 0.85))
        )  # fmt: skip
    if is_man:
        pieces.append(
            _ball("chest", (0.036, top - 0.072, 0.040), (0.034 + 0.005 * more.muscle) * g, SHIRT,
                  (1.25, 0.85, 0.9))
        )  # fmt: skip
    else:
        pieces.append(
            _ball("chest", (0.034, top - 0.088, 0.042), 0.041 * g + 0.004 * loose, SHIRT,
                  (1.0, 1.0, 0.92))
        )  # fmt: skip
    if appearance.clothes.has_hood:
        pieces.append(
            _cone("chest", (0.018, top + 0.026, -0.040), 0.030, (0.034, top + 0.022, 0.000),
                  0.020, SHIRT)
        )  # fmt: skip
    return pieces


def _head(appearance: Appearance) -> list[Flesh]:
    """Neck, skull, jaw, nose, eyes and hair, in a frame whose y is 0 at the head's joint."""
    k, chin = head_share(appearance), -CHIN_DROP_SHARE
    g = 0.6 + 0.4 * appearance.girth  # heads and necks vary less than bellies
    skull: Vector = (0.0, 0.66 * k + chin, -0.02 * k)
    pieces = [
        Flesh("neck", (0.0, -0.012, 0.012), 0.036 * g, "head", (0.0, 0.0, 0.0), 0.031 * g, ROUND,
               SKIN),
        _ball("head", skull, 0.34 * k, SKIN, (0.98, 1.0, 1.26)),
        _cone("head", (0.0, 0.52 * k + chin, 0.11 * k), 0.285 * k,
              (0.0, 0.14 * k + chin, 0.20 * k), 0.15 * k * g, SKIN, (1.05, 1.0, 1.0)),
        _cone("head", (0.0, 0.55 * k + chin, 0.40 * k), 0.035 * k,
              (0.0, 0.38 * k + chin, 0.45 * k), 0.055 * k, SKIN),
        _ball("head", (0.13 * k, 0.53 * k + chin, 0.355 * k), 0.036 * k, EYES, (1.3, 0.8, 1.0)),
        _ball("head", (0.34 * k, 0.50 * k + chin, 0.0), 0.08 * k, SKIN, (0.5, 1.5, 1.0)),
        _ball("head", (0.0, skull[1] + 0.085 * k, skull[2] - 0.05 * k), 0.345 * k, HAIR,
              (1.04, 0.98, 1.20)),
    ]  # fmt: skip
    if appearance.has_long_hair:
        pieces.append(
            _cone("head", (0.0, skull[1], skull[2] - 0.13 * k), 0.34 * k,
                  (0.0, -0.10 * k + chin, -0.30 * k), 0.24 * k, HAIR, (1.05, 1.0, 0.80))
        )  # fmt: skip
    return pieces


def _arm(appearance: Appearance) -> list[Flesh]:
    """The left arm: deltoid, upper arm, forearm with its muscle, palm, fingers and thumb."""
    g = appearance.girth if appearance.sex == "man" else 0.92 * appearance.girth
    clothes, strong = appearance.clothes, 0.002 * appearance.proportions.muscle
    loose = 0.013 * clothes.looseness
    lower, cuff = (SHIRT, 0.002 + loose) if clothes.has_long_sleeves else (SKIN, 0.0)
    sleeve = 0.002 + loose
    upper, fore = arm_shares(appearance)
    top = segment_offsets(appearance)["clavicle_l"][1]
    return [
        Flesh("chest", (0.058 * appearance.proportions.shoulders, top - 0.085, 0.004),
               0.040 * g + 0.5 * sleeve, "upper_arm_l", (-0.004, -0.050, 0.0),
               0.026 * g + sleeve, ROUND, SHIRT),
        _cone("upper_arm_l", (0.002, -0.004, 0.0), 0.033 * g + strong + 0.5 * sleeve,
              (0.003, -0.32 * upper, 0.002), 0.029 * g + strong + sleeve, SHIRT),
        _cone("upper_arm_l", (0.003, -0.32 * upper, 0.002), 0.029 * g + strong + sleeve,
              (0.0, -0.70 * upper, 0.002), 0.027 * g + 1.3 * sleeve, SHIRT, OPEN_END),
        _cone("upper_arm_l", (0.0, -0.70 * upper, 0.002), 0.027 * g + cuff,
              (0.0, -0.99 * upper, 0.0), 0.0235 * g + cuff, lower),
        _cone("forearm_l", (0.0, 0.0, -0.001), 0.0245 * g + cuff, (0.002, -0.27 * fore, 0.002),
              0.0250 * g + 0.6 * strong + cuff, lower),
        _cone("forearm_l", (0.002, -0.27 * fore, 0.002), 0.0250 * g + 0.6 * strong + cuff,
              (0.0, -0.92 * fore, 0.0), 0.0165 * g + 0.9 * cuff, lower, (0.95, 1.0, 1.05)),
        _cone("forearm_l", (0.0, -0.89 * fore, 0.0), 0.0160, (0.0, -fore, 0.0), 0.0155, SKIN,
              (0.85, 1.0, 1.1)),
        _cone("hand_l", (0.0, -0.004, 0.0), 0.0170, (0.0, -0.045, 0.002), 0.0245, SKIN,
              (0.50, 1.0, 1.0)),
        _cone("hand_l", (0.001, -0.050, 0.012), 0.0085, (-0.005, -0.094, 0.013), 0.0060, SKIN),
        _cone("hand_l", (0.001, -0.050, 0.000), 0.0085, (-0.005, -0.100, 0.000), 0.0060, SKIN),
        _cone("hand_l", (0.001, -0.050, -0.012), 0.0080, (-0.006, -0.090, -0.013), 0.0055, SKIN),
        _cone("hand_l", (-0.002, -0.014, 0.014), 0.0095, (-0.008, -0.052, 0.036), 0.0065, SKIN),
    ]  # fmt: skip


def _leg(appearance: Appearance) -> list[Flesh]:
    """The left leg: thigh, knee, calf muscle, shin, heel, sole and toes.

    Wide trousers hang from the thigh: they are wider the lower they are.
    """
    g = appearance.girth if appearance.sex == "man" else 1.03 * appearance.girth
    clothes, strong = appearance.clothes, appearance.proportions.muscle
    is_bare = clothes.skirt_share > 0.0
    loose = 0.0 if is_bare else 0.001 + 0.012 * clothes.leg_looseness
    upper = SKIN if is_bare else TROUSERS
    lower, wide = (TROUSERS, loose) if clothes.has_long_legs and not is_bare else (SKIN, 0.0)
    thigh, calf = (
        hip_share(appearance) - knee_share(appearance),
        knee_share(appearance) - SOLE_SHARE,
    )
    sole = -SOLE_SHARE
    return [
        Flesh("pelvis", (0.044 * appearance.proportions.hips, -0.016, 0.0), 0.050 * g + 0.5 * loose,
               "thigh_l", (0.003, -0.18 * thigh, 0.000), 0.053 * g + 0.7 * loose, ROUND,
               TROUSERS),
        _cone("thigh_l", (0.003, -0.18 * thigh, 0.0), 0.053 * g + 0.7 * loose,
              (0.002, -0.70 * thigh, 0.004), 0.041 * g + loose, upper, OPEN_END),
        _ball("thigh_l", (0.004, -0.42 * thigh, 0.014), (0.034 + 0.003 * strong) * g + loose,
              upper, (1.0, 2.0, 1.0)),
        _cone("thigh_l", (0.002, -0.67 * thigh, 0.004), 0.041 * g + wide,
              (0.0, -0.99 * thigh, 0.002), 0.034 * g + 1.1 * wide, lower),
        _cone("calf_l", (0.0, 0.0, 0.002), 0.0345 * g + 1.1 * wide, (0.0, -0.24 * calf, -0.004),
              0.0320 * g + 1.2 * wide, lower),
        _ball("calf_l", (0.000, -0.25 * calf, -0.012), (0.025 + 0.002 * strong) * g + 1.1 * wide,
              lower, (1.1, 2.0, 1.0)),
        _cone("calf_l", (0.0, -0.24 * calf, -0.004), 0.0320 * g + 1.2 * wide,
              (0.0, -0.61 * calf, -0.004), 0.0240 * g + 1.6 * wide, lower),
        _cone("calf_l", (0.0, -0.61 * calf, -0.004), 0.0240 * g + 1.6 * wide,
              (0.0, 0.014 - calf, -0.004), 0.0200 + 2.0 * wide, lower,
              OPEN_END),
        _cone("foot_l", (0.0, 0.004, -0.002), 0.0210, (0.0, sole + 0.024, 0.022), 0.0230, SHOES),
        _cone("foot_l", (0.0, sole + 0.020, -0.018), 0.0200, (0.002, sole + 0.017, 0.070),
              0.0170, SHOES, (1.25, 1.0, 1.0)),
        _cone("foot_l", (0.002, sole + 0.017, 0.060), 0.0170, (0.002, sole + 0.012, 0.104),
              0.0120, SHOES, (1.65, 1.0, 1.0)),
    ]  # fmt: skip


SKIRT_FLATNESS: Final = 0.08
"""How far a skirt bulges over its hem, relative to its radius (ours)."""


def _skirt(appearance: Appearance) -> list[Flesh]:
    """A cone around each thigh, and what spans the gap when they part; together they hide where
    the thighs are."""
    length = appearance.clothes.skirt_share
    if length == 0.0:
        return []
    hips, span = 0.062 * appearance.girth, 0.042 * appearance.girth
    wide = 0.058 * appearance.girth + 0.022 * (0.5 + appearance.clothes.leg_looseness)
    inwards = -0.3 * hips
    cone = _cone("thigh_l", (inwards, 0.0, 0.002), hips, (-0.012, -length, 0.004), wide, TROUSERS,
                 (1.15, SKIRT_FLATNESS, 1.0))  # fmt: skip
    bands = [
        Flesh("thigh_l", (0.0, -y, 0.004), span, "thigh_r", (0.0, -y, 0.004), span, ROUND, TROUSERS)
        for y in np.linspace(0.3 * length, length - span, 4).tolist()
    ]
    return [cone, *bands]
