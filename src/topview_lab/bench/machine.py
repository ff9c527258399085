"""What the times were measured on."""

from __future__ import annotations

import os
import platform
from dataclasses import dataclass
from pathlib import Path

from topview.kernels.threads import use_threads


@dataclass(frozen=True, slots=True)
class Machine:
    """The processor: its name, its cores, and the threads that the kernels may use."""

    cpu: str
    cores: int
    threads: int

    @classmethod
    def here(cls) -> Machine:
        """This machine."""
        return cls(_cpu_model(), os.cpu_count() or 1, use_threads(0))

    @property
    def thread_counts(self) -> list[int]:
        """One thread, and all of them."""
        return sorted({1, self.threads})

    def __str__(self) -> str:
        cores = f"{self.cores} core{'s' if self.cores > 1 else ''}"
        return f"{self.cpu}, {cores}; the kernels may use {self.threads} of them"


def _cpu_model() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        lines = []
    named = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return named[0] if named else platform.processor() or platform.machine()
