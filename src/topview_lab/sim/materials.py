"""What people's surfaces are made of: colours and the size of their folds."""

from __future__ import annotations

from typing import Final

from topview_lab.sim.appearance import Appearance, Rgb

MATERIALS: Final[tuple[str, ...]] = ("skin", "hair", "shirt", "trousers", "shoes", "eyes")
SKIN, HAIR, SHIRT, TROUSERS, SHOES, EYES = range(len(MATERIALS))
EYE_COLOR: Final[Rgb] = (0.03, 0.02, 0.02)
HAIR_FOLDS_M, SKIN_FOLDS_M, CLOTH_FOLDS_M, LOOSE_FOLDS_M = 0.004, 0.0015, 0.003, 0.012
"""Greatest displacement of the surface: hair, skin, tight cloth, and what loose cloth adds to it
(ours)."""


def fold_amplitudes(appearance: Appearance) -> tuple[float, ...]:
    """Greatest displacement of the surface of each of `MATERIALS`, metres."""
    clothes = appearance.clothes
    return (
        SKIN_FOLDS_M,
        HAIR_FOLDS_M,
        CLOTH_FOLDS_M + LOOSE_FOLDS_M * clothes.looseness,
        CLOTH_FOLDS_M + LOOSE_FOLDS_M * clothes.leg_looseness,
        0.0,
        0.0,
    )


def material_colors(appearance: Appearance) -> tuple[Rgb, ...]:
    """Linear colour of each of `MATERIALS`."""
    clothes = appearance.clothes
    return (
        appearance.skin,
        appearance.hair,
        clothes.shirt,
        clothes.trousers,
        clothes.shoes,
        EYE_COLOR,
    )
