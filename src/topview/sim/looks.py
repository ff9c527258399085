"""Who people are: stature, build, skin, hair and clothes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal

import numpy as np

from topview.records import InputError

Sex = Literal["woman", "man"]
Rgb = tuple[float, float, float]

MEAN_STATURE_M: Final = 1.756
"""Of the men of Gordon et al. (1989), the reference of all girths in `topview.sim.flesh`."""
LEAST_STATURE_M, GREATEST_STATURE_M = 1.0, 2.2


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
