"""Joint angles of each person for OpenSim, and the range of the knees.

    python docs/recipes/gait_to_opensim.py results/skeletons.npz gait.mot

Writes gait.mot (or gait_person1.mot, ...), which OpenSim shows on a whole-body model, and .trc
files with the joints as markers for its inverse kinematics. docs/outputs.md tells what the angles
are, and which of them are not the ISB's.
"""

import sys
from pathlib import Path

import numpy as np

import topview


def column(mot: Path, name: str) -> np.ndarray:
    """[N] a column of a .mot file."""
    lines = mot.read_text().splitlines()
    start = lines.index("endheader") + 1
    names = lines[start].split()
    rows = [line.split() for line in lines[start + 1 :] if line]
    return np.array([float(row[names.index(name)]) for row in rows])


def main(path: str, out: str) -> dict[str, float]:
    people = topview.read_skeletons(path)
    ranges = {}
    for mot in topview.write_skeletons(people, Path(out).with_suffix(".mot")):
        for side in ("r", "l"):
            knee_deg = column(mot, f"knee_angle_{side}")
            ranges[f"{mot.stem} {side}"] = float(np.ptp(knee_deg))
            print(f"{mot.name}: knee_angle_{side} moves over {np.ptp(knee_deg):.0f} degrees")
    topview.write_skeletons(people, Path(out).with_suffix(".trc"))
    return ranges


if __name__ == "__main__":
    main(*sys.argv[1:])
