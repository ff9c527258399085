"""Run the command line on broken files and odd options, more of them than the tests do.

    python scripts/fuzz.py --cases 5000 --seed 1
    python scripts/fuzz.py --only "truth.npz | a key's type" --cases 1 --seed 3

Prints how many cases ended in each way, and each that should not have ended as it did: a traceback,
a hang, too much memory, more than a few lines. The second call runs what such a line names.
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests" / "helpers"))

from fuzz.running import run_apart, table


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--cases", type=int, default=5000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", default="", help="a family of cases")
    options = parser.parse_args()
    start, endings = time.perf_counter(), []
    for ending in run_apart(options.cases, options.seed, options.only):
        endings.append(ending)
        if not ending.is_fine or options.only:
            print(f"{ending.outcome}: {ending.case}: {ending.arguments}\n{ending.said}", flush=True)
    print(table(endings))
    print(f"{len(endings)} cases in {time.perf_counter() - start:.0f} s")
    return 0 if all(ending.is_fine for ending in endings) else 1


if __name__ == "__main__":
    sys.exit(main())
