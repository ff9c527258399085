"""People who are always the same: twelve adults and a child.

The twelve are the counterpart of the 12 subjects of Berkeley MHAD (F. Ofli et al., WACV 2013: 7
men and 5 women, 23 to 30 years old and one elderly): other people, but as different from each
other.
"""

from __future__ import annotations

from typing import Final

from topview_lab.sim.appearance import (
    AVERAGE,
    CLOTHS,
    DENIMS,
    HAIRS,
    LEATHERS,
    SKINS,
    Appearance,
    Clothes,
    Proportions,
    Rgb,
    Sex,
)

_RED, _BLUE, _GREEN, _WHITE, _BLACK, _ORANGE, _PURPLE, _TEAL = CLOTHS
_NAVY, _GREY, _SAND, _DENIM = DENIMS
_SOLES = LEATHERS


def _person(
    sex: Sex, stature_m: float, girth: float, skin: Rgb, hair: Rgb, clothes: Clothes,
    proportions: Proportions = AVERAGE, *, has_long_hair: bool = False, seed: int = 0,
) -> Appearance:  # fmt: skip
    return Appearance(stature_m, sex, girth, skin, hair, has_long_hair, clothes, proportions, seed)


# fmt: off
TWELVE_PEOPLE: Final[tuple[Appearance, ...]] = (
    # an average man in a T-shirt and jeans
    _person(
        "man", 1.76, 1.00, SKINS[1], HAIRS[1],
        Clothes(_BLUE, _DENIM, _SOLES[2], 0.35, 0.35, has_long_sleeves=False),
        seed=1,
    ),
    # a thin tall man in tight sports clothes
    _person(
        "man", 1.95, 0.86, SKINS[2], HAIRS[0],
        Clothes(_BLACK, _GREY, _SOLES[3], 0.05, 0.05),
        Proportions(legs=1.03, arms=1.03, shoulders=0.96, neck_forward=0.006),
        seed=2,
    ),
    # a heavy man in a shirt
    _person(
        "man", 1.72, 1.25, SKINS[0], HAIRS[4],
        Clothes(_WHITE, _GREY, _SOLES[1], 0.45, 0.6, pattern="checks"),
        Proportions(belly=0.022, legs=0.98, shoulder_slope=0.004, muscle=0.6),
        seed=3,
    ),
    # a muscular man with a tight T-shirt and shorts
    _person(
        "man", 1.83, 1.10, SKINS[4], HAIRS[0],
        Clothes(_ORANGE, _NAVY, _SOLES[2], 0.10, 0.5, has_long_sleeves=False, has_long_legs=False),
        Proportions(shoulders=1.07, muscle=1.9, hips=0.97),
        seed=4,
    ),
    # a young man in a hooded jumper and wide trousers
    _person(
        "man", 1.79, 0.93, SKINS[3], HAIRS[0],
        Clothes(_GREEN, _SAND, _SOLES[2], 1.0, 1.0, has_hood=True),
        Proportions(arms=0.97, neck_forward=0.008),
        seed=5,
    ),
    # a short stocky man in a wide jumper
    _person(
        "man", 1.62, 1.15, SKINS[5], HAIRS[0],
        Clothes(_TEAL, _DENIM, _SOLES[0], 0.9, 0.5),
        Proportions(legs=0.97, shoulders=1.04, belly=0.010),
        seed=6,
    ),
    # an elderly man, stooping, in loose clothes
    _person(
        "man", 1.69, 0.95, SKINS[0], HAIRS[4],
        Clothes(_GREY, _SAND, _SOLES[1], 0.7, 0.8),
        Proportions(
            neck_forward=0.014, shoulder_slope=0.010, belly=0.012, muscle=0.3, shoulders=0.96
        ),
        seed=7,
    ),
    # an average woman with long hair in a jumper and jeans
    _person(
        "woman", 1.64, 0.98, SKINS[1], HAIRS[2],
        Clothes(_RED, _DENIM, _SOLES[1], 0.5, 0.2),
        has_long_hair=True,
        seed=8,
    ),
    # a small thin woman in tight clothes
    _person(
        "woman", 1.50, 0.84, SKINS[2], HAIRS[0],
        Clothes(_PURPLE, _NAVY, _SOLES[3], 0.05, 0.05),
        Proportions(legs=0.985, head=1.03),
        has_long_hair=True,
        seed=9,
    ),
    # a tall woman in a knee-long dress
    _person(
        "woman", 1.80, 0.95, SKINS[5], HAIRS[0],
        Clothes(_ORANGE, _ORANGE, _SOLES[0], 0.4, 0.5, has_long_sleeves=False, skirt_share=0.25),
        Proportions(legs=1.02, hips=1.04),
        seed=10,
    ),
    # a heavy woman in a wide jumper and a skirt
    _person(
        "woman", 1.61, 1.24, SKINS[0], HAIRS[3],
        Clothes(_TEAL, _NAVY, _SOLES[0], 0.8, 0.5, skirt_share=0.22),
        Proportions(belly=0.012, hips=1.05),
        has_long_hair=True,
        seed=11,
    ),
    # a sporty woman in a striped shirt and shorts, short hair
    _person(
        "woman", 1.70, 1.02, SKINS[3], HAIRS[1],
        Clothes(_WHITE, _GREY, _SOLES[2], 0.3, 0.6, has_long_legs=False, pattern="stripes"),
        Proportions(shoulders=1.05, muscle=1.5, hips=0.96),
        seed=12,
    ),
)
# fmt: on
"""Both sexes, 1.50 to 1.95 m, thin to heavy, light to dark, tight to loose clothes."""

CHILD_PROPORTIONS: Final = Proportions(
    legs=0.965, arms=0.965, shoulders=0.95, hips=0.93, neck_forward=0.002, muscle=0.3
)
"""Of eight years against adults (ours, after the charts of R. Snyder et al., Anthropometry of
Infants, Children and Youths to Age 18, 1977). The head grows by `anthropometry.head_share`."""

CHILD: Final = _person(
    "woman",
    1.27,
    0.93,
    SKINS[2],
    HAIRS[1],
    Clothes(_RED, _DENIM, _SOLES[2], 0.6, 0.4, has_long_sleeves=False, pattern="stripes"),
    CHILD_PROPORTIONS,
    has_long_hair=True,
    seed=13,
)
"""A girl of about eight years."""
