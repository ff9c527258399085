"""Compare two checkouts of topview: every array of their `skeletons.npz`, bit by bit.

    python scripts/compare_checkouts.py BEFORE AFTER SOURCE... [--method M] [--before-method M]

BEFORE and AFTER are folders that hold `src/topview`; SOURCE is whatever `topview track` reads. Both
are tracked on this machine, as floating-point results differ from processor to processor. Prints a
line for each recording; exit status 1 if any array that both files hold differs, with how far the
joints lie apart. Of joints, those are compared that both have.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

TEXTS = ("settings",)  # names of methods and settings may change; what is tracked may not
OF_JOINTS = ("joints_camera", "joint_state", "joint_confidence", "joint_covariance_m2")
EMPTY = {
    "joints_camera": np.nan, "joint_state": 0, "joint_confidence": 0, "Ts_camera_part": np.nan,
    "joint_covariance_m2": np.nan,
}  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("before", type=Path)
    parser.add_argument("after", type=Path)
    parser.add_argument("sources", type=Path, nargs="+")
    parser.add_argument("--method", help="of both, if it is not the default")
    parser.add_argument("--before-method", help="its name in BEFORE, if that differs")
    options = parser.parse_args()
    differing = 0
    for source in options.sources:
        with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor(2) as pool:
            befores = options.before_method or options.method
            jobs = [
                pool.submit(track, checkout, source, Path(folder) / name, method)
                for checkout, name, method in (
                    (options.before, "before", befores),
                    (options.after, "after", options.method),
                )
            ]
            before, after = (job.result() for job in jobs)
        verdict = compare(before, after)
        differing += verdict != "same"
        print(f"{source}: {verdict}", flush=True)
    sys.exit(differing > 0)


def track(checkout: Path, source: Path, out: Path, method: str | None) -> dict[str, np.ndarray]:
    """The arrays of the `skeletons.npz` that a checkout writes."""
    command = [
        sys.executable,
        "-m",
        "topview",
        "track",
        str(source),
        "--out",
        str(out),
        "--threads",
        "1",
    ]
    if method:
        command += ["--method", method]
    environment = os.environ | {"PYTHONPATH": str(checkout.resolve() / "src")}
    finished = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    if not (out / "skeletons.npz").exists():
        sys.exit(f"{checkout}: {finished.stderr.strip()}")
    with np.load(out / "skeletons.npz") as arrays:
        return by_person({name: arrays[name] for name in arrays.files})


def by_person(arrays: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """The arrays with a column for each person, as in format versions 1 and 2."""
    slots = arrays["person_ids"]
    if slots.ndim == 1:
        return {name: array for name, array in arrays.items() if name != "format_version"}
    people = arrays["people_ids"]
    rows, columns = np.nonzero(slots)
    persons = np.searchsorted(people, slots[rows, columns])
    dense = {name: arrays[name] for name in arrays if name not in ("format_version", "people_ids")}
    dense["person_ids"] = people
    for name in EMPTY.keys() & arrays.keys():  # older ones write less
        array, nothing = arrays[name], EMPTY[name]
        dense[name] = np.full((len(slots), len(people), *array.shape[2:]), nothing, array.dtype)
        dense[name][rows, persons] = array[rows, columns]
    return dense


def compare(before: dict[str, np.ndarray], after: dict[str, np.ndarray]) -> str:
    """ "same", or what differs in the arrays that both have."""
    before, after = of_common_joints(before, after), of_common_joints(after, before)
    names = sorted((before.keys() & after.keys()) - set(TEXTS))
    differing = [name for name in names if not _same(before[name], after[name])]
    if not differing:
        return "same"
    joints = before["joints_camera"], after["joints_camera"]
    if joints[0].shape != joints[1].shape:
        return f"{', '.join(differing)} differ"
    apart_cm = 100 * np.linalg.norm(joints[0] - joints[1], axis=-1)
    return (
        f"{', '.join(differing)} differ; joints lie {np.nanmedian(apart_cm):.2f} cm apart "
        f"(median), {np.nanmax(apart_cm):.2f} at most"
    )


def of_common_joints(
    arrays: dict[str, np.ndarray], others: dict[str, np.ndarray]
) -> dict[str, np.ndarray]:
    """The arrays with those joints alone that the others have, too."""
    columns = np.flatnonzero(np.isin(arrays["joint_names"], others["joint_names"]))
    chosen = {name: arrays[name][:, :, columns] for name in OF_JOINTS}
    return arrays | chosen | {"joint_names": arrays["joint_names"][columns]}


def _same(a: np.ndarray, b: np.ndarray) -> bool:
    return a.shape == b.shape and a.dtype == b.dtype and a.tobytes() == b.tobytes()


if __name__ == "__main__":
    main()
