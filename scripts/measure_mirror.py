"""Does the tracker treat left and right alike? Each recording against its mirror image.

    python scripts/measure_mirror.py SOURCE... [--method M] [--seed S]

SOURCE is whatever `topview track` reads. Prints how far the joints lie from those that were tracked
in the images flipped left-right, flipped back: median and 95 % in cm. For comparison, how far they
lie from those of another seed: random numbers are not mirrored, so the first cannot be less.
"""

from __future__ import annotations

import argparse

import topview
from topview.track.settings import TrackerSettings
from topview_lab.evaluate.mirror import compare_with_mirror_image, compare_with_other_seed
from topview_lab.metrics.mirror import Apart


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("sources", nargs="+")
    parser.add_argument("--method", default=TrackerSettings().method)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    settings, other = (
        TrackerSettings(method=options.method, seed=seed)
        for seed in (options.seed, options.seed + 1)
    )
    for source in options.sources:
        recording = topview.open(source)
        mirrored = compare_with_mirror_image(recording, settings)
        print(f"{source}: {told(mirrored)} from the mirror image", flush=True)
        reseeded = compare_with_other_seed(recording, settings, other)
        print(f"{source}: {told(reseeded)} from another seed", flush=True)


def told(apart: Apart) -> str:
    median, most = apart.quantile_cm(0.5), apart.quantile_cm(0.95)
    return f"{median:.2f} cm (median), {most:.2f} cm (95 %), {apart.alone} person-frames alone"


if __name__ == "__main__":
    main()
