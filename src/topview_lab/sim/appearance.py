"""Appearance of people: stature, proportions, skin, hair and clothes."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final, Literal

import numpy as np

from topview.records import InputError

Sex = Literal["woman", "man"]
Pattern = Literal["plain", "stripes", "checks"]
Rgb = tuple[float, float, float]

MEAN_STATURE_M: Final = 1.756
"""Mean of the men of Gordon et al. (1989); all girths in `topview_lab.sim.flesh` refer to it."""
LEAST_STATURE_M, GREATEST_STATURE_M = 1.0, 2.2
CHILD_STATURE_M: Final = 1.42
"""A smaller person is labelled a child."""


@dataclass(frozen=True, slots=True)
class Clothes:
    """What a person wears.

    Attributes:
        shirt, trousers, shoes: linear colours in 0..1.
        looseness: of what covers the trunk and the arms: 0 tight, 1 a wide jumper.
        leg_looseness: of what covers the legs: 0 tight, 1 wide trousers.
        has_long_sleeves: else they end above the elbow.
        has_long_legs: else the trousers end above the knee; under a skirt, the legs are bare.
        skirt_share: length of a skirt below the hips as a share of stature, 0 for none; it has the
            trousers' colour.
        has_hood: lies on the shoulders behind the neck.
        pattern: of the shirt.
    """

    shirt: Rgb
    trousers: Rgb
    shoes: Rgb
    looseness: float = 0.4
    leg_looseness: float = 0.4
    has_long_sleeves: bool = True
    has_long_legs: bool = True
    skirt_share: float = 0.0
    has_hood: bool = False
    pattern: Pattern = "plain"


@dataclass(frozen=True, slots=True)
class Proportions:
    """How a body differs from the mean one of its stature and sex: all ones and zeros is the mean.

    Attributes:
        legs: height of the hips; the trunk takes what is left.
        shins: knee height, on top of that.
        arms, forearms: lengths; the forearms' on top of the arms'.
        left_arm: length of the left arm, on top of that.
        shoulders, hips: breadths of the skeleton.
        head: length and breadth of the head.
        shoulder_slope: by how much the shoulders hang lower, a share of stature.
        neck_forward: by how much the neck leans forward, a share of stature.
        belly: by how much the belly stands out, a share of stature.
        muscle: size of muscles; 0 shows none.
    """

    legs: float = 1.0
    shins: float = 1.0
    arms: float = 1.0
    forearms: float = 1.0
    left_arm: float = 1.0
    shoulders: float = 1.0
    hips: float = 1.0
    head: float = 1.0
    shoulder_slope: float = 0.0
    neck_forward: float = 0.0
    belly: float = 0.0
    muscle: float = 1.0

    @classmethod
    def sample(cls, rng: np.random.Generator) -> Proportions:
        """Natural variation (`SPREADS`), within two standard deviations."""
        drawn = {
            name: getattr(AVERAGE, name) + spread * float(np.clip(rng.standard_normal(), -2.0, 2.0))
            for name, spread in SPREADS.items()
        }
        return cls(**drawn)


AVERAGE: Final = Proportions()
SPREADS: Final[dict[str, float]] = {
    "legs": 0.025, "shins": 0.025, "arms": 0.03, "forearms": 0.03, "left_arm": 0.004,
    "shoulders": 0.045, "hips": 0.045, "head": 0.03, "shoulder_slope": 0.005,
    "neck_forward": 0.005, "belly": 0.008, "muscle": 0.3,
}  # fmt: skip
"""Standard deviations of people's proportions (ours): lengths and breadths over stature vary about
as much as in Gordon et al. (1989)."""


@dataclass(frozen=True, slots=True)
class Appearance:
    """A person's appearance, from which the body is built.

    Attributes:
        stature_m: of the standing person, without shoes and hair.
        sex: sets the breadth of shoulders and hips, and the chest.
        girth: breadth and depth of the flesh relative to the mean, 0.8 thin to 1.3 heavy.
        skin, hair: linear colours in 0..1.
        has_long_hair: down to the shoulders.
        clothes: what the person wears.
        proportions: how the body differs from others of its stature and sex.
        folds_seed: of the small irregularities of skin and cloth; None for an even surface.
    """

    stature_m: float
    sex: Sex
    girth: float
    skin: Rgb
    hair: Rgb
    has_long_hair: bool
    clothes: Clothes
    proportions: Proportions = AVERAGE
    folds_seed: int | None = 0

    def __post_init__(self) -> None:
        if not LEAST_STATURE_M <= self.stature_m <= GREATEST_STATURE_M:
            raise InputError(
                f"stature is {self.stature_m} m; "
                f"it must be {LEAST_STATURE_M:g} to {GREATEST_STATURE_M:g} m"
            )

    @property
    def label(self) -> str:
        """The name of this body in tables, such as "woman 1.62 m"."""
        who = "child" if self.stature_m < CHILD_STATURE_M else self.sex
        return f"{who} {self.stature_m:.2f} m"

    def even(self) -> Appearance:
        """The same person, mirror-symmetric, without folds."""
        return replace(self, folds_seed=None, proportions=replace(self.proportions, left_arm=1.0))


SKINS: Final[tuple[Rgb, ...]] = (
    (0.82, 0.60, 0.49), (0.74, 0.50, 0.37), (0.61, 0.38, 0.26), (0.42, 0.25, 0.16),
    (0.25, 0.14, 0.09), (0.13, 0.07, 0.05),
)  # fmt: skip
"""Light to dark, evenly over the Fitzpatrick scale (ours)."""
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


def random_appearance(
    rng: np.random.Generator, sex: Sex | None = None, shirt: Rgb | None = None
) -> Appearance:
    """An adult of either sex; statures after Gordon et al. (1989), colours and clothes ours."""
    sex = sex or ("man" if rng.random() < 0.5 else "woman")
    mean, spread = (MEAN_STATURE_M, 0.067) if sex == "man" else (1.629, 0.064)
    return Appearance(
        stature_m=float(np.clip(rng.normal(mean, spread), 1.45, 2.0)),
        sex=sex,
        girth=float(np.clip(rng.normal(1.0, 0.1), 0.8, 1.3)),
        skin=_pick(rng, SKINS),
        hair=_pick(rng, HAIRS),
        has_long_hair=sex == "woman" and bool(rng.random() < 0.7),
        clothes=_random_clothes(rng, sex, shirt),
        proportions=Proportions.sample(rng),
        folds_seed=int(rng.integers(2**31)),
    )


def _random_clothes(rng: np.random.Generator, sex: Sex, shirt: Rgb | None) -> Clothes:
    looseness, leg_looseness = rng.uniform(0.05, 1.0, 2)
    wears_skirt = sex == "woman" and bool(rng.random() < 0.15)
    patterns: tuple[Pattern, ...] = ("plain", "plain", "stripes", "checks")
    return Clothes(
        shirt=shirt or _pick(rng, CLOTHS),
        trousers=_pick(rng, DENIMS),
        shoes=_pick(rng, LEATHERS),
        looseness=float(looseness),
        leg_looseness=float(leg_looseness),
        has_long_sleeves=bool(rng.random() < 0.6),
        has_long_legs=bool(rng.random() < 0.85),
        skirt_share=float(rng.uniform(0.16, 0.26)) if wears_skirt else 0.0,
        has_hood=bool(looseness > 0.6 and rng.random() < 0.4),
        pattern=patterns[rng.integers(len(patterns))],
    )


def _pick(rng: np.random.Generator, colors: tuple[Rgb, ...]) -> Rgb:
    return colors[rng.integers(len(colors))]
