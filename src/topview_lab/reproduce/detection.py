"""Sec. 4.1 and 5.3.1: users found in colour and depth; the thesis gives no numbers, we count."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Final

from topview_lab.metrics.heads import FORGOTTEN_AFTER_S, HEAD_GATE_M, LEAST_TO_BE_SEEN
from topview_lab.reproduce.context import Context
from topview_lab.reproduce.finding import (
    AUTO,
    BACKGROUNDS,
    DETECTOR_NAMES,
    SPECIAL,
    TONE_GROUPS,
    WITH_NETWORK,
    Case,
    Finding,
    Search,
)
from topview_lab.reproduce.runs import Measured
from topview_lab.reproduce.section import (
    Section,
    Table,
    Verdict,
    conclusion,
    number,
    percent,
)
from topview_lab.reproduce.tally import HEADER, Tally
from topview_lab.seeds import detection_seed

LEAST_RECALL, MOST_FALSE = 0.98, 1.0
"""Of person-frames, and in 1000 frames, for "users are found" (ours)."""

SCENES_WITH_ONE: Final = (
    "walking", "turning", "looking_around", "sitting", "behind_table", "bending", "kneeling",
    "sit_down_stand_up",
)  # fmt: skip
SCENES_WITH_SEVERAL: Final = (
    "two_users", "crossing", "pass_by", "stand_in_front", "handshake", "hug", "throw_between",
    "enter_and_leave", "dummy_occluder",
)  # fmt: skip
CROWDS: Final = (("crossing", 3), ("four_users", 4), ("enter_and_leave", 5), ("four_users", 6))


def cases(context: Context) -> list[Case]:
    """One to six people, then what is special."""
    seed = detection_seed(context.seed, 0)
    if context.quick:
        return [
            Case("walking", seed, 30),
            Case("crossing", seed, 30, start_s=1.0),
            Case("four_users", seed, 20, people=6),
            Case("crossing", seed, 20, conditions=SPECIAL[-1]),
        ]
    plain = [Case(scene, seed, 150) for scene in SCENES_WITH_ONE]
    plain += [Case(scene, seed + 1, 300) for scene in SCENES_WITH_SEVERAL]
    plain += [Case(scene, seed + 2, 150, people=people) for scene, people in CROWDS]
    plain += [Case("four_users", seed + 3, 210, start_s=38.5)]
    special = [
        Case("enter_and_leave", seed + 4, 150, conditions=conditions) for conditions in SPECIAL
    ]
    return plain + special


def searches(context: Context) -> list[Search]:
    """All detectors on what is not special."""
    return [
        Search(case, (AUTO,)) if case.conditions.name else Search(case) for case in cases(context)
    ]


def detection(context: Context, measured: Measured) -> Section:
    done = {search: measured.findings[search] for search in searches(context)}
    plain = {search: done[search] for search in done if not search.case.conditions.name}
    tables = {
        "by scene": _by(plain, lambda search: search.case.scene),
        "by number of people": _by(plain, lambda search: str(len(done[search].tones))),
        "by skin": {tone: Tally.of(plain.values(), tone=tone) for tone in TONE_GROUPS},
        "by detector": {
            name: Tally.of(plain.values(), name) for name in (*DETECTOR_NAMES, WITH_NETWORK)
        },
        "by background": {
            name: Tally.of(plain.values(), name) for name in (AUTO, "skin", *BACKGROUNDS)
        },
        "special cases": _by(
            {search: done[search] for search in done if search.case.conditions.name},
            lambda search: search.case.conditions.name,
        ),
    }
    whole, by_network = (Tally.of(plain.values(), name) for name in (AUTO, WITH_NETWORK))
    return Section(
        name="detection",
        title="Sections 4.1 and 5.3.1: users found",
        text=(
            "The people finder alone, on colour and depth of simulated scenes: people of all "
            "sizes, skins and clothes among furniture. Users and everybody in the room are matched "
            f"one to one, heads at most {HEAD_GATE_M:g} m apart. Recall: somebody counts in the "
            f"frames in which {LEAST_TO_BE_SEEN:.0%} or more of the body is to be seen. False: "
            "users who match nobody, per 1000 frames. Exchanges: times that somebody goes on under "
            f"another id without having been outside for {FORGOTTEN_AFTER_S:g} s. Within 0.5 s: "
            "people who were users so soon after half of the body was to be seen. Ids kept: by "
            "people who could not be seen and came back.",
            "By detector: the last row is the tracker as it is by default; its heads are those of "
            "the fitted bodies.",
            "By background: what is left out where skin is searched. By default, auto leaves out "
            "what keeps still in depth, and skin what the adaptive mixtures of Sec. 4.1 explain.",
        ),
        tables=tuple(
            Table(("", *HEADER), tuple(tally.row(name) for name, tally in tallies.items()), caption)
            for caption, tallies in ({"all": {"all": whole}} | tables).items()
        ),
        verdicts=_verdicts(whole, by_network),
        numbers={
            "all": whole.as_json(),
            **{
                caption: {name: tally.as_json() for name, tally in tallies.items()}
                for caption, tallies in tables.items()
            },
        },
    )


def _by(findings: Mapping[Search, Finding], name: Callable[[Search], str]) -> dict[str, Tally]:
    """A tally of those searches that have the same name."""
    names = dict.fromkeys(map(name, findings))
    return {
        each: Tally.of(finding for search, finding in findings.items() if name(search) == each)
        for each in names
    }


def _verdicts(tally: Tally, by_network: Tally) -> tuple[Verdict, ...]:
    return (
        conclusion(
            "users are found (Sec. 5.3.1)",
            tally.recall >= LEAST_RECALL and tally.false_per_1000 <= MOST_FALSE,
            f"{percent(tally.recall)} of person-frames, {number(tally.false_per_1000)} false in "
            f"1000 frames; with the joint network {percent(by_network.recall)}, "
            f"{number(by_network.false_per_1000)}",
            [tally.recall, by_network.recall],
        ),
        conclusion(
            "identities last while users hide each other (Sec. 4.1)",
            tally.exchanges == 0,
            f"{tally.exchanges} exchanges; {tally.kept} of {tally.returns} who were hidden kept "
            f"theirs; with the joint network {by_network.exchanges} exchanges, "
            f"{by_network.kept} of {by_network.returns}",
        ),
    )
