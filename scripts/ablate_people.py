"""What does each thing bring by which people are found and told apart?

    python scripts/ablate_people.py PATH... [--workers N] [--only WORD...] [--json FILE] [--alone]

Counts who is found in recordings in the folder layout, as `topview evaluate people` does, with all
that there is and without each thing, false people in 1000 frames; nothing is fitted anew. With
`--only`, the variants alone whose names have one of the words, beside the default. With `--alone`,
no network is asked.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from math import inf
from typing import Any, Final

import msgspec
import numpy as np
from ablation import (
    DEFAULT,
    Patches,
    Variants,
    chosen,
    left_out,
    nothing,
    parser_of,
    run_without,
)
from numpy.typing import NDArray
from rich.console import Console
from rich.table import Table

from topview.people.existence import Existence
from topview.people.features import FEATURE_NAMES
from topview.people.likelihood import shipped_likelihood
from topview.track.settings import TrackerSettings
from topview_lab.datasets import find_folder_recordings
from topview_lab.evaluate.people import (
    CountedRecording,
    PeopleCount,
    PeopleJob,
    PeopleOutcome,
    count_found,
)
from topview_lab.evaluate.tables import number, percent

NETWORK: Final = "the network"
HEAD_SHAPE: Final = ("unlike a head", "not upright")
CHEST: Final = (
    "head and chest too small",
    "head and chest too large",
    "rough outline",
    "no torso",
    "no torso read",
    "as slim as a post",
    "flat",
)
BODY_SIZE: Final = (
    "too low",
    "too high",
    "too much above the head",
    "too large",
    "too short",
    "too spread out",
)


def first(one: object, *_: object, **__: object) -> object:
    """What there was before."""
    return one


def second(_: object, other: object, *__: object) -> object:
    """The same, of what comes second."""
    return other


def zero(*_: object) -> float:
    """Tells nothing."""
    return 0.0


def as_they_are(tracks: Sequence[object], _: object, heads: Sequence[object], *__: object) -> Any:
    """No track begins anew at another head."""
    return list(tracks), list(heads)


def no_room(_: object, __: object, body: NDArray[np.float32], *___: object) -> NDArray[np.bool_]:
    """Nothing of a new body is held for the room."""
    return np.zeros(body.shape, np.bool_)


def lent_nothing(_: object, __: object, gains: NDArray[np.float64]) -> NDArray[np.float64]:
    """Nobody gains by another's track."""
    return np.zeros_like(gains)


def nowhere(_: object, depth_m: NDArray[np.float32], *__: object) -> NDArray[np.bool_]:
    """No pixel is known to be the room's."""
    return np.zeros(depth_m.shape, np.bool_)


def always_new(most: int | None, _: object) -> Existence:
    """Nobody is known again."""
    return Existence(most)


def likelihood(**changes: Any) -> Patches:
    """Another law of people and furniture."""
    changed = msgspec.structs.replace(shipped_likelihood(), **changes)
    return {"people.existence.shipped_likelihood": lambda: changed}


def without(*names: str) -> dict[str, float]:
    """The weights, by which these features tell nothing."""
    unknown = {*names} - {*FEATURE_NAMES}
    assert not unknown, f"no features: {unknown}"
    return {**shipped_likelihood().weights, **dict.fromkeys(names, 0.0)}


VARIANTS: Final[Variants] = {
    DEFAULT: dict,
    "the shape of the head": lambda: likelihood(weights=without(*HEAD_SHAPE)),
    "head and chest": lambda: likelihood(weights=without(*CHEST)),
    "the size of the body": lambda: likelihood(weights=without(*BODY_SIZE)),
    "all shape": lambda: likelihood(by_shape=0.0, weights=without(*FEATURE_NAMES)),
    "shape, where the network tells": lambda: likelihood(by_shape=0.0),
    "stillness": lambda: likelihood(by_stillness=0.0, weights=without("has not moved")),
    "having been seen to move": lambda: likelihood(weights=without("not seen to move")),
    NETWORK: dict,
    "clusters that the network looks at": lambda: {
        "people.clusters.clusters_in": lambda *_: iter(())
    },
    "free space that is seen": lambda: {
        "people.places.FREE_PER_S": 0.1,
        "people.places.SURFACE_PER_S": 0.1,
    },
    "the hidden body's place": lambda: {"people.step.over_body": second},
    "clothes": lambda: {
        "people.association.CLOTHES_WEIGHT": 0.0,
        "people.returning.CLOTHES_WEIGHT": 0.0,
        "people.appearance.CLEARLY": inf,
    },
    "exchanges that clothes tell": lambda: {"people.appearance.CLEARLY": inf},
    "statures, in association": lambda: {"people.association.Seeker._by_stature": zero},
    "heads followed by their shape": lambda: {"people.association.Seeker.followed": nothing},
    "heads that slip": lambda: {"people.association.SLIPPED": 0.0},
    "heads on the bodies of others": lambda: {"people.association.ANOTHERS_HEAD": 0.0},
    "who comes back": lambda: {"people.finder.ReturningPeople": always_new},
    "better heads on a body": lambda: {"people.finder.rejoined": as_they_are},
    "heads that the network corrects": lambda: {"people.track.Track.corrected": first},
    "what was refused": lambda: {"people.existence.Existence.remembered_at": nothing},
    "loose pieces": lambda: {"people.pieces.Pieces.join_to": nothing},
    "pieces far from the joints": lambda: {"people.bodies._leave_out_far": nothing},
    "what shows of who is out of the picture": lambda: {"people.bodies._leave_out_inner": nothing},
    "what emerges": lambda: {"people.finder.give_what_emerges": nothing},
    "legs below a torso that is not read": lambda: {"people.features.stands_on_legs": nothing},
    "the room round a new head": lambda: {"people.finder.room_left_of": no_room},
    "what is lent to who comes back": lambda: {
        "people.association._lent_to_who_comes_back": lent_nothing
    },
    "who fell a moment ago": lambda: {"people.existence.Existence._just_ended_near": nothing},
    "heads that are not seen, but told": lambda: {"people.track.Track.told_at": first},
    "bodies without the room": lambda: {"people.step.without_room": second},
    "what the network takes for nobody's": lambda: {"people.told.Told.is_nobodys": nothing},
    "what the network sees of another's body": lambda: {"people.told.Told.share_on_body": zero},
    "bones of others": lambda: {"people.told.Told.is_on_body": nothing},
    "the room, learnt": lambda: {"room.background.Background.is_seen_in": nowhere},
}


@dataclass(frozen=True, slots=True)
class AblatedJob:
    """A recording whose people are counted without one thing."""

    variant: str
    job: PeopleJob

    def __call__(self) -> PeopleOutcome:
        with left_out(VARIANTS[self.variant]()):
            return self.job()


def main() -> None:
    parser = parser_of(__doc__)
    parser.add_argument("--alone", action="store_true")
    options = parser.parse_args()
    recordings = find_folder_recordings(options.paths)
    names = [n for n in chosen(VARIANTS, options.only) if not (options.alone and n == NETWORK)]
    outcomes = run_without(names, recordings, partial(_job, options.alone), options.workers)
    counts = {
        name: count_found([o.found for o in own if o.found]) for name, own in outcomes.items()
    }
    Console().print(told(counts))
    if options.json:
        options.json.write_text(json.dumps({name: asdict(c) for name, c in counts.items()}))


def _job(is_alone: bool, name: str, recording: CountedRecording) -> AblatedJob:
    proposals = "none" if is_alone or name == NETWORK else "network"
    return AblatedJob(name, PeopleJob(recording, TrackerSettings(threads=1, proposals=proposals)))


def told(counts: Mapping[str, PeopleCount]) -> Table:
    """A line for each variant."""
    table = Table("without", "found", "false", "swaps", "fragments", "95 %, s", box=None)
    for name, count in counts.items():
        table.add_row(
            name,
            percent(count.recall),
            number(count.false_per_1000),
            str(count.swaps),
            str(count.fragments),
            number(count.wait_95_s, 2),
        )
    return table


if __name__ == "__main__":
    main()
