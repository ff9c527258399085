"""What every experiment is given, and how it asks for tracked recordings."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True, slots=True)
class Context:
    """How an experiment is run.

    Attributes:
        out: the report's folder.
        quick: smaller, for a first look.
        seed: of all that varies.
        mhad: folder of Berkeley MHAD, or None for its simulated counterparts.
    """

    out: Path
    quick: bool = False
    seed: int = 0
    mhad: Path | None = None

    def picture(self, name: str) -> Path:
        return self.out / "pictures" / name
