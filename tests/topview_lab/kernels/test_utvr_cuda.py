"""The loops for a GPU, in numba's simulator of one, count what those for the CPU count."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

SCRIPT = Path(__file__).parents[3] / "scripts" / "measure_cuda.py"


def test_a_gpu_counts_what_the_cpu_counts():
    """The simulator takes plain Python alone, and has to be chosen before numba is imported."""
    simulated = {"NUMBA_ENABLE_CUDASIM": "1", "NUMBA_DISABLE_JIT": "1"}
    done = subprocess.run(
        [sys.executable, SCRIPT, "--sizes", "96x72", "--hypotheses", "3", "--once"],
        env=os.environ | simulated,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert "0 of 21" in done.stdout
