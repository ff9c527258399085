"""Every seed of the simulator that this project has used, and what was made of it.

The people, clothes, rooms, motions and noise of a scene are drawn from its seed and its name. A
number says something about new people only if nobody chose anything by the people that it was
measured on. What follows is what the project's history tells; where it does not tell, that is said.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import Final

SKIN_LEARNT_SEED: Final = 0
SKIN_HELD_OUT_SEED: Final = 1
"""Of `topview train-skin --simulated`: keys of generators that draw the scenes' seeds."""
HANDS_LEARNT_SEEDS: Final = range(1)
HANDS_HELD_OUT_SEEDS: Final = (100,)
"""Of `topview train-hands --simulated`: every scene of the simulator, with the people of each."""
PEOPLE_LEARNT_SEEDS: Final = (0,)
"""Of `topview train-people --simulated`."""
FOREST_LEARNT_SEED, FOREST_CALIBRATED_SEED, FOREST_HELD_OUT_SEED = 2000, 2500, 2900
"""Of `topview train-forest`, which adds its --seed: keys of generators."""
REPORT_SEED: Final = 6000
"""First of the scenes of `topview reproduce`, but those of its section `detection`."""
DETECTION_SEED: Final = 7000
"""First of the scenes of the section `detection`."""
SEEDS_PER_REPORT: Final = 100
"""So many scene seeds belong to each --seed of `topview reproduce`."""


class Knowledge(StrEnum):
    """What the people of a seed have been used for, beyond being measured."""

    FITTED = "fitted on"
    LOOKED_AT = "looked at"
    NUMBERS_READ = "numbers read"
    UNRECORDED = "no use recorded"


@dataclass(frozen=True, slots=True)
class SeedUse:
    """What some seeds of scenes have been used for.

    Attributes:
        seeds: of the scenes.
        scenes: which ones.
        used_for: what is learnt from or measured on them.
        knowledge: FITTED if something that ships was learnt from them; LOOKED_AT if single
            recordings were looked at, or named as the reason of a change, while something was
            built; NUMBERS_READ if their numbers were read between changes.
        note: how this is known, or what is not.
    """

    seeds: tuple[int | range, ...]
    scenes: str
    used_for: str
    knowledge: Knowledge
    note: str = ""

    def __contains__(self, seed: int) -> bool:
        return any(seed == own if isinstance(own, int) else seed in own for own in self.seeds)

    @property
    def label(self) -> str:
        """The seeds, for a table."""
        return ", ".join(
            str(own) if isinstance(own, int) else f"{own[0]} to {own[-1]}" for own in self.seeds
        )


SEED_USES: Final[tuple[SeedUse, ...]] = (
    SeedUse(
        (0,), "all", "tables of faces and hands (train-hands); the demo", Knowledge.FITTED,
        "learnt from the first 72 frames of every scene, the demo's too",
    ),
    SeedUse(
        (range(1, 11),), "any", "tests, examples; 1 is the default of evaluate simulated",
        Knowledge.LOOKED_AT, "tests check bounds on some of them",
    ),
    SeedUse(
        (range(31, 61),), "crossing, the camera hung otherwise", "evaluate mounts",
        Knowledge.NUMBERS_READ,
        "31 to 40 and 51 to 60 measured once; 41 to 50 twice, one detail between",
    ),
    SeedUse(
        (12,), "walk", "evaluate simulated, in the README", Knowledge.LOOKED_AT,
        "was tracked the wrong way round; telling front from back was built after that",
    ),
    SeedUse(
        (11, 13), "all_actions, pass_by", "evaluate simulated, in the README",
        Knowledge.NUMBERS_READ, "measured again after changes",
    ),
    SeedUse(
        (range(3000, 3015), 3020, 3021), "boxing and other actions",
        "what --method utvr adds to the recipe",
        Knowledge.FITTED, "chosen on them; some were looked at frame by frame",
    ),
    SeedUse(
        (range(8501, 8531),), "the report's --seed 25", "Tables 6.1 and 6.2, --method utvr",
        Knowledge.NUMBERS_READ, "measured once",
    ),
    SeedUse(
        (8671, 8672), "the report's --seed 26: two_users, four_users", "users, --method utvr",
        Knowledge.NUMBERS_READ, "measured once",
    ),
    SeedUse(
        (range(8700, 8800),), "the report's --seed 27, quick form", "the report's pictures",
        Knowledge.LOOKED_AT, "how strips and figures are drawn was designed on them",
    ),
    SeedUse(
        (range(3030, 3037),), "walking, sitting, crossing and others",
        "what --detector skin searches before", Knowledge.FITTED, "chosen on them",
    ),
    SeedUse(
        (9000, 9001), "single_user, dummy_occluder",
        "Table 5.2 and Fig. 5.4, the report's --seed 30", Knowledge.NUMBERS_READ, "measured once",
    ),
    SeedUse(
        (range(10000, 10004),), "detection, --seed 30", "what skin is searched before",
        Knowledge.NUMBERS_READ, "measured once",
    ),
    SeedUse(
        (range(9100, 9131), range(9300, 9331), range(9400, 9431)),
        "the report's --seed 31, 33 and 34",
        "Tables 6.1, 6.2 and 6.3, --method utvr", Knowledge.NUMBERS_READ, "measured once each",
    ),
    SeedUse(
        (range(9501, 9531),), "the report's --seed 35", "Tables 6.1 and 6.2, --method utvr",
        Knowledge.NUMBERS_READ, "Table 6.1 measured once, with the descent",
    ),
    SeedUse(
        (range(9600, 9631), 9700, 9701), "the report's --seed 36 and 37",
        "Tables 6.1, 6.2 and 6.4; of 37 Table 6.4 alone", Knowledge.NUMBERS_READ, "measured once",
    ),
    SeedUse(
        (range(9800, 9831), range(9870, 9873), range(9880, 9886)), "the report's --seed 38",
        "Tables 6.1 to 6.4, users, rivals", Knowledge.NUMBERS_READ, "measured once",
    ),
    SeedUse(
        (range(9900, 9931), range(9970, 9973)), "the report's --seed 39",
        "Tables 6.1 to 6.3, users", Knowledge.NUMBERS_READ,
        "measured once; Fig. 6.7 looked at after the last change",
    ),
    SeedUse(
        (range(10070, 10073),), "the report's --seed 40", "users", Knowledge.NUMBERS_READ,
        "measured once",
    ),
    SeedUse(
        (range(11100, 11105), range(11300, 11305)), "the report's --seed 41 and 43: detection",
        "who is found, by the finder alone and by the tracker", Knowledge.NUMBERS_READ,
        "measured once",
    ),
    SeedUse(
        (range(11200, 11205),), "the report's --seed 42: detection",
        "who is found, by the finder alone and by the tracker", Knowledge.LOOKED_AT,
        "a crossing and a hug read frame by frame",
    ),
    SeedUse(
        (3040, 3041), "four_users", "why hidden people are lost without a network",
        Knowledge.LOOKED_AT, "read frame by frame; nothing that was tried is kept",
    ),
    SeedUse((100,), "all", "held out by train-hands", Knowledge.NUMBERS_READ),
    SeedUse(
        (range(101, 112),), "who is hidden (returns); two_users 105",
        "how the scenes are laid out; whether left and right are alike", Knowledge.LOOKED_AT,
        "the scenes by their truth alone, before any tracker was measured on them",
    ),
    SeedUse(
        (503, 521, 731, 802), "walk, throwing, hug, wave", "tests", Knowledge.LOOKED_AT,
        "tests check bounds on them",
    ),
    SeedUse(
        (range(2950, 2953),), "waving_two_hands, walk", "tests of the forest", Knowledge.LOOKED_AT,
        "tests check bounds on them",
    ),
    SeedUse(
        (6000, 6001), "single_user, dummy_occluder, body01", "Tables 5.2, 6.1, 6.3, 6.4, figures",
        Knowledge.LOOKED_AT,
        "two trackers were compared on each of them while they were built (docs/method.md)",
    ),
    SeedUse(
        (6083,), "crossing", "rivals", Knowledge.LOOKED_AT,
        "--method utvr was looked at frame by frame, and not changed after it",
    ),
    SeedUse(
        (range(6002, 6083), range(6084, 6100)), "the report's others",
        "Tables 6.1, 6.2, users, rivals",
        Knowledge.NUMBERS_READ, "the report was made again after changes",
    ),
    SeedUse(
        (range(7100, 7200), range(7600, 7700)), "detection, --seed 1 and 6", "users found",
        Knowledge.LOOKED_AT, "the people finder was made better on them",
    ),
    SeedUse(
        (range(7000, 7100), range(7200, 7600), range(7700, 8000)),
        "detection, --seed 0, 2 to 5, 7 to 9", "users found", Knowledge.NUMBERS_READ,
        "one more of --seed 0 to 9 was looked at; the history does not tell which",
    ),
)  # fmt: skip

OTHER_DATA: Final = (
    "Who is hidden (evaluate returns): seeds 1 to 3 were read frame by frame, 4 to 15 measured; "
    "behind a person, 30 to 43 were read in numbers, 44 to 49 measured.",
    "Skin histograms: renders with scene seeds drawn from the keys 0 (learnt) and 1 (held out).",
    "Forest: renders with people drawn from the keys 2000 (grown), 2500 (calibrated) and 2900 "
    "(held out).",
    "Joint network: 100 people in postures, seeds 0 to 99, and 500 to 509 to measure it on; its "
    "joint centres, all_actions 3000 to 3007 and turning 3010 to 3013.",
    "Weights of front against back: a logistic regression on simulated people and on UTD-MHAD. The "
    "history tells neither the seeds nor the sequences, so UTD-MHAD is no unseen data.",
    "Yaw and start of --method utvr, yaw of btvr: rendered people, even seeds 0 to 16, seeds 1, 23 "
    "and 122; the lean of its torso, seeds 100 to 103; its hips, its "
    "limbs as one, and the lean again, seeds 18 to 24; its descent, seeds 100 to 103, and 0 to 5 "
    "of turn and sit were read.",
    "Heads of people who bend: 65 of 97 simulated bends were used while this was built; their "
    "seeds are not recorded.",
    "People hidden by others: a rendered recording that is not part of the project, b3_stand60, is "
    "named as the reason of a change.",
)
"""What was learnt from, or changed because of, data that no scene's seed names."""


def report_seed(shift: int, number: int) -> int:
    """The seed of a scene of the report; `shift` is the --seed of `topview reproduce`."""
    return REPORT_SEED + SEEDS_PER_REPORT * shift + number


def detection_seed(shift: int, number: int) -> int:
    """The same of the section `detection`."""
    return DETECTION_SEED + SEEDS_PER_REPORT * shift + number


def use_of(seed: int) -> SeedUse:
    """What is recorded of a scene's seed."""
    unrecorded = SeedUse((seed,), "any", "", Knowledge.UNRECORDED)
    return next((use for use in SEED_USES if seed in use), unrecorded)
