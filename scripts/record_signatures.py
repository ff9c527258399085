"""Write down what a tracker calls of the kernels: `src/topview/kernels/signatures.json`.

    python scripts/record_signatures.py SOURCE...

Tracks the beginnings of the demo's scene and of recordings of one's own, with nothing compiled
before, and notes the types with which each kernel is called and the seconds that they take to
compile. Give it one recording of each kind that you have: with and without colour, with a second
camera for it, of several resolutions. Run it again when a kernel's arguments have changed; a test
tells.
"""

from __future__ import annotations

import json
import os
import sys
import tempfile
from collections import defaultdict
from itertools import islice
from pathlib import Path
from time import process_time

FRAMES = 40


def main() -> None:
    with tempfile.TemporaryDirectory() as folder:
        os.environ["NUMBA_CACHE_DIR"] = folder  # before anything imports numba
        seconds = _listen()
        _track_demo(Path(folder))
        for source in sys.argv[1:]:
            _track(Path(source))
        _write(seconds)


def _track_demo(folder: Path) -> None:
    from topview_lab.cli.demo import SCENE
    from topview_lab.sim import scene_by_name, write_scene

    write_scene(scene_by_name(SCENE, seed=0, frames=FRAMES), folder / SCENE)
    _track(folder / SCENE)


def _track(source: Path) -> None:
    import topview

    for proposals in ("network", "none"):
        tracker = topview.Tracker(topview.TrackerSettings(proposals=proposals))
        for frame in islice(topview.open(source), FRAMES):
            tracker.update(frame)


def _listen() -> dict[tuple[str, str], float]:
    """Seconds by module and kernel, counted from now on; of what it calls, too."""
    from numba.core import event

    seconds: dict[tuple[str, str], float] = defaultdict(float)
    started: list[float] = []

    class Compiling(event.Listener):
        def on_start(self, event: event.Event) -> None:
            started.append(process_time())

        def on_end(self, event: event.Event) -> None:
            taken = process_time() - started.pop()
            kernel = event.data["dispatcher"].py_func  # pyright: ignore
            if not started:
                seconds[kernel.__module__, kernel.__name__] += taken

    event.register("numba:compile", Compiling())
    return seconds


def _write(seconds: dict[tuple[str, str], float]) -> None:
    from topview.kernels.compiling import SIGNATURES, dispatcher_of

    found: dict[str, dict[str, object]] = defaultdict(dict)
    for (module, name), taken in sorted(seconds.items()):
        package, _, short = module.rpartition(".")
        if package == "topview.kernels":
            signatures = dispatcher_of(short, name).signatures
            texts = sorted([repr(one) for one in signature] for signature in signatures)
            found[short][name] = {"seconds": round(taken, 1), "signatures": texts}
    SIGNATURES.write_text(json.dumps(found, indent=1) + "\n")
    print(f"{len(seconds)} kernels, {sum(seconds.values()):.0f} s; written to {SIGNATURES}")


if __name__ == "__main__":
    main()
