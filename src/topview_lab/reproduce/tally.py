"""Rows of the tables of detected people."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from topview_lab.metrics.heads import PersonFound, due_of, recall_of
from topview_lab.metrics.statistics import CM_PER_M, share
from topview_lab.reproduce.finding import AUTO, Finding
from topview_lab.reproduce.section import Row, number, percent

NEAR_CM: Final = 6.0
"""Distance from the true centre within which a head counts as near (ours)."""
SOON_S: Final = 0.5
"""Time within which a person in view counts as found soon (ours)."""
HEADER: Final = (
    "people", "frames", "recall", "false / 1000", "exchanges", "head, cm: median",
    "90 %", "within 6 cm", "within 0.5 s", "ids kept",
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class Tally:
    """The counts of one row.

    Attributes:
        frames: of the recordings.
        people: everyone in them, or a subset.
        false, exchanges: of the recordings.
        is_of_all: False if the row is about a subset of the people, to which false positives cannot
            be assigned.
    """

    frames: int
    people: tuple[PersonFound, ...]
    false: int
    exchanges: int
    is_of_all: bool = True

    @classmethod
    def of(
        cls,
        findings: Iterable[Finding],
        detector: str = AUTO,
        tone: str | None = None,
    ) -> Tally:
        """Of some recordings; of the people whose skin has that tone, if one is given."""
        findings = list(findings)
        found = [finding.found[detector] for finding in findings]
        return cls(
            frames=sum(each.frames for each in found),
            people=tuple(
                person
                for finding in findings
                for person, own in zip(finding.found[detector].people, finding.tones, strict=True)
                if tone in (None, own)
            ),
            false=sum(each.false for each in found),
            exchanges=sum(each.exchanges for each in found),
            is_of_all=tone is None,
        )

    @property
    def person_frames(self) -> int:
        return due_of(self.people)

    @property
    def recall(self) -> float:
        return recall_of(self.people)

    @property
    def false_per_1000(self) -> float:
        return share(1000.0 * self.false, self.frames)

    @property
    def errors_cm(self) -> NDArray[np.float64]:
        errors_m = [person.errors_m for person in self.people]
        return CM_PER_M * np.concatenate([np.empty(0), *errors_m])

    def quantile_cm(self, q: float) -> float:
        errors_cm = self.errors_cm
        return float(np.quantile(errors_cm, q)) if len(errors_cm) else float("nan")

    @property
    def near(self) -> float:
        return share(int((self.errors_cm < NEAR_CM).sum()), len(self.errors_cm))

    @property
    def soon(self) -> float:
        waits_s = [person.wait_s for person in self.people if person.wait_s is not None]
        return share(sum(wait_s <= SOON_S for wait_s in waits_s), len(waits_s))

    @property
    def returns(self) -> int:
        return sum(person.returns for person in self.people)

    @property
    def kept(self) -> int:
        return sum(person.kept for person in self.people)

    def row(self, name: str) -> Row:
        of_recordings = (
            number(self.false_per_1000),
            str(self.exchanges),
        )
        return Row((
            name,
            str(len(self.people)),
            str(self.person_frames),
            percent(self.recall),
            *(of_recordings if self.is_of_all else ("–",) * len(of_recordings)),
            number(self.quantile_cm(0.5)),
            number(self.quantile_cm(0.9)),
            percent(self.near),
            percent(self.soon),
            f"{self.kept} of {self.returns}",
        ))  # fmt: skip

    def as_json(self) -> dict[str, Any]:
        names = ("recall", "false_per_1000", "exchanges", "near", "soon", "returns", "kept")
        return {"person_frames": self.person_frames} | {name: getattr(self, name) for name in names}
