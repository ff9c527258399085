"""Which simulated people a report rests on, and what else they were used for."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from topview_lab.reproduce.section import Row, Section, Table
from topview_lab.seeds import OTHER_DATA, SEED_USES, Knowledge, use_of

SeedsByExperiment = Mapping[str, Sequence[int]]


def provenance(seeds: SeedsByExperiment) -> Section:
    """Each experiment's seeds, sorted by what is recorded of them, and all that is recorded."""
    kinds = tuple(Knowledge)
    own = [
        Row((name, *(", ".join(map(str, _known_as(kind, used))) or "–" for kind in kinds)))
        for name, used in seeds.items()
        if used
    ]
    recorded = [
        Row((use.label, use.scenes, use.used_for, use.knowledge, use.note)) for use in SEED_USES
    ]
    tables = [Table(("experiment", *kinds), tuple(own), "seeds of this report's scenes")]
    header = ("seeds", "scenes", "used for", "what is recorded", "note")
    tables.append(Table(header, tuple(recorded), "all seeds that are recorded"))
    return Section(
        name="seeds",
        title="Seeds: who was looked at",
        text=(
            "People, clothes, rooms, motions and noise of a scene are drawn from its seed. Fitted "
            "on: something that ships was learnt from them. Looked at: single recordings were "
            "looked at, or named as the reason of a change, while something was built. Numbers "
            "read: they were measured between changes. Only where no use is recorded are the "
            "people new. The report's pictures show these scenes: whoever changes something after "
            "looking at them has used them up, and reports on another --seed.",
            *OTHER_DATA,
        ),
        tables=tuple(tables) if own else tuple(tables[1:]),
        numbers={name: _as_json(used) for name, used in seeds.items()},
    )


def _known_as(kind: Knowledge, seeds: Sequence[int]) -> list[int]:
    return [seed for seed in seeds if use_of(seed).knowledge == kind]


def _as_json(seeds: Sequence[int]) -> dict[str, Any]:
    return {"seeds": list(seeds)} | {kind.value: _known_as(kind, seeds) for kind in Knowledge}
