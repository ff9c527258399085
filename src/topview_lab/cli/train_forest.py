"""`topview train-forest`: what body parts look like in depth images, learnt from the simulator."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter
from rich.table import Table

from topview.body.parts import JOINT_NAMES
from topview.cli.outputs import prepare_output_file
from topview.cli.printing import plain_console
from topview.cli.progress import progress_bar
from topview.io import write_atomically
from topview.kernels.threads import use_threads
from topview.records import InputError
from topview_lab.rivals.forest import Forest
from topview_lab.rivals.forest.classes import CLASSES, SIDED
from topview_lab.rivals.forest.growing import CANDIDATE_BLOCK, GrowingSettings
from topview_lab.seeds import (
    FOREST_CALIBRATED_SEED,
    FOREST_HELD_OUT_SEED,
    FOREST_LEARNT_SEED,
)
from topview_lab.training.body_parts import RenderedBody, simulated_bodies
from topview_lab.training.forest import ForestScore, learn_forest, score_forest

CALIBRATION_IMAGES = 200
HELD_OUT_IMAGES = 200
DEFAULT_GROWING = GrowingSettings()
# Ours: far beyond what Shotton et al. grew (3 trees, 20 levels, 300 000 images, 2000 candidates and
# pixels), and what a machine holds.
MOST_IMAGES, MOST_TREES, MOST_DEPTH, MOST_PIXELS_OF_ONE = 1_000_000, 100, 24, 100_000
MOST_CANDIDATES = 640 * CANDIDATE_BLOCK


def train_forest(
    *,
    out: Path | None = None,
    images: int = 10_000,
    trees: int = DEFAULT_GROWING.trees,
    depth: int = DEFAULT_GROWING.depth,
    candidates: int = DEFAULT_GROWING.candidates,
    pixels: int = DEFAULT_GROWING.pixels,
    seed: int = 0,
    threads: int = 0,
    force: Annotated[bool, Parameter(negative="")] = False,
) -> None:
    """Learn to tell body parts, for `--method forest`.

    Renders people of the simulator in many poses, grows the trees, and prints how well parts and
    joints are found on people that they were not learnt from. The same numbers give the same forest
    with any number of threads.

    Args:
        out: the .npz to write; without it, the forest that there is is only measured.
        images: to render, of one or two people each.
        trees: how many.
        depth: levels of splits.
        candidates: features tried at each node, a multiple of 64.
        pixels: of each person and tree.
        seed: of people, poses and features.
        threads: 0 for all cores.
        force: replace the file that is there.
    """
    for name, value, most in (
        ("images", images, MOST_IMAGES),
        ("trees", trees, MOST_TREES),
        ("depth", depth, MOST_DEPTH),
        ("pixels", pixels, MOST_PIXELS_OF_ONE),
    ):
        if not 1 <= value <= most:
            raise InputError(f"--{name} is {value}; it must be 1 to {most}")
    if not 1 <= candidates <= MOST_CANDIDATES or candidates % CANDIDATE_BLOCK:
        raise InputError(
            f"--candidates is {candidates}; it must be a multiple of {CANDIDATE_BLOCK}, "
            f"at most {MOST_CANDIDATES}"
        )
    if not 0 <= seed < 50:
        raise InputError(f"--seed is {seed}; it must be 0 to 49, as held-out people are others'")
    if threads < 0:
        raise InputError(f"--threads is {threads}; it must be 0 (all cores) or more")
    if out is not None:
        prepare_output_file("--out", out, force)
    use_threads(threads)
    settings = GrowingSettings(trees=trees, depth=depth, candidates=candidates, pixels=pixels)
    if out is None:
        forest = Forest.load()
    else:
        forest = _learn(images, settings, seed)
        data = forest.npz()
        write_atomically(out, data)
        print(f"trained on {forest.trained_on}; {len(data) / 1e6:.1f} MB written to {out}")
    score = score_forest(forest, _simulated(HELD_OUT_IMAGES, FOREST_HELD_OUT_SEED + seed))
    _report(score)


def _learn(images: int, settings: GrowingSettings, seed: int) -> Forest:
    bodies = _simulated(images, FOREST_LEARNT_SEED + seed)
    others = _simulated(CALIBRATION_IMAGES, FOREST_CALIBRATED_SEED + seed)
    trained_on = (
        f"{len(bodies)} people in {images} renders of the simulator, "
        f"seed {FOREST_LEARNT_SEED + seed}, {settings.pixels} pixels each "
        f"for each of {settings.trees} trees"
    )
    with progress_bar() as progress:
        bar = progress.add_task("growing", total=settings.trees * (settings.depth + 1))
        return learn_forest(
            bodies, others, settings, seed, trained_on, lambda: progress.advance(bar)
        )


def _simulated(images: int, seed: int) -> Sequence[RenderedBody]:
    bodies: list[RenderedBody] = []
    with progress_bar() as progress:
        bar = progress.add_task("simulating", total=images)
        for of_image in simulated_bodies(images, seed):
            bodies += of_image
            progress.advance(bar)
    return bodies


def _report(score: ForestScore) -> None:
    parts = Table("part", title="pixels rightly told, on other people")
    parts.add_column("%", justify="right")
    share = dict(zip(CLASSES, score.accuracy, strict=True))
    for name in ("head", "neck", "waist"):
        parts.add_row(name, f"{100 * share[name]:.0f}")
    for name in SIDED:
        left, right = (share[f"{side}_{name}"] for side in ("left", "right"))
        parts.add_row(f"{name}, left and right", f"{100 * left:.0f} {100 * right:.0f}")
    parts.add_row("mean", f"{100 * score.accuracy.mean():.1f}")
    joints = Table("joint", title="joints that are seen, the best candidate of each")
    joints.add_column("within 10 cm, %", justify="right")
    joints.add_column("median error, cm", justify="right")
    for name, within, median_m in zip(JOINT_NAMES, score.within, score.median_m, strict=True):
        joints.add_row(name, f"{100 * within:.0f}", f"{100 * median_m:.1f}")
    joints.add_row("mean", f"{100 * score.within.mean():.1f}", f"{100 * score.median_m.mean():.1f}")
    for table in (parts, joints):
        plain_console().print(table)
