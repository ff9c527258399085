"""What does each thing bring that `--method utvr` adds to the thesis's recipe?

    python scripts/ablate_recipe.py [--frames N] [--workers N] [--only WORD...] [FOLDER...]

Tracks the scenes that the additions were chosen on, and recordings in folders besides, with all
additions, without any, without each of them, and with other values; prints the mean distance of
joints, with offsets out, the share within 10 cm and the mean angle of the bones. With `--only`, the
variants alone whose names have one of the words, beside the default. A second table has the limbs
of the default by how foreshortened they are.
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from itertools import pairwise
from pathlib import Path
from typing import Final

import numpy as np
from rich.console import Console
from rich.table import Table

from topview.body import JOINT_NAMES
from topview.body.proportions import THESIS
from topview.geometry.rotations import unit
from topview.track.methods.utvr import AS_PRINTED, UtvrSettings
from topview_lab.datasets import EvaluatedRecording, FolderRecording
from topview_lab.datasets.simulated import SimulatedScene
from topview_lab.metrics import (
    ALL,
    DIRECTIONS,
    Evaluation,
    direction_errors,
    pool,
    summarise,
)
from topview_lab.reproduce.runs import Run, Variant, track_runs

SCENES: Final = {
    "boxing": (3000, 3001, 3002),
    "jumping_jacks": (3003,),
    "bending": (3004,),
    "throwing": (3005,),
    "sit_down_stand_up": (3006,),
    "waving_two_hands": (3007,),
    "clapping": (3008,),
    "walking": (3020,),
    "turning": (3021,),
}
DEFAULT: Final = "all additions, the default"
VARIANTS: Final[Mapping[str, UtvrSettings]] = {
    DEFAULT: UtvrSettings(),
    "as printed": AS_PRINTED,
    "without the wider torso": UtvrSettings(torso_reach_m=AS_PRINTED.torso_reach_m),
    "without the torso ahead": UtvrSettings(torso_ahead=0.0),
    "without the free neck": UtvrSettings(neck=None),
    "without the torso of Sec. 5.1": UtvrSettings(torso_turn_rad=None),
    "without the torso's lean": UtvrSettings(torso_lean_rad=None),
    "with the cylinders of Table 3.1": UtvrSettings(proportions=THESIS, torso_below_hips=0.0),
    "each part of a limb by itself": UtvrSettings(limbs_as_one=False),
    "without the descent": UtvrSettings(descent=0),
    "without usual poses": UtvrSettings(usual=0.0),
    "without bodies looked up": UtvrSettings(looks_up=False),
    "without stances": UtvrSettings(searches_anew=False),
    "with the stature as measured": UtvrSettings(weighs_stature=False),
    "torso_lean_rad 0.35": UtvrSettings(torso_lean_rad=0.35),
    "torso_lean_rad 0.5": UtvrSettings(torso_lean_rad=0.5),
    "torso_lean_rad 1.0": UtvrSettings(torso_lean_rad=1.0),
    "clothing 3 cm": UtvrSettings(clothing_m=0.03),
    "torso_turn_rad 0.15": UtvrSettings(torso_turn_rad=0.15),
    "torso_turn_rad 0.6": UtvrSettings(torso_turn_rad=0.6),
    "240 hypotheses": UtvrSettings(hypotheses=240),
}


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("folders", nargs="*", type=Path)
    parser.add_argument("--frames", type=int, default=90)
    parser.add_argument("--workers", type=int, default=0)
    parser.add_argument("--only", nargs="+", metavar="WORD", default=[""])
    options = parser.parse_args()
    recordings: list[EvaluatedRecording] = [
        SimulatedScene(scene, seed, frames=options.frames)
        for scene, seeds in SCENES.items()
        for seed in seeds
    ]
    recordings += [FolderRecording(folder) for folder in options.folders]
    runs = {
        name: [Run(Variant(settings), recording) for recording in recordings]
        for name, settings in VARIANTS.items()
        if name == DEFAULT or any(word in name for word in options.only)
    }
    done = track_runs([run for each in runs.values() for run in each], options.workers)
    for problem in done.problems:
        print(problem)
    table = Table("variant", "cm", "offsets out", "within 10 cm", "axes, °", box=None)
    for name, each in runs.items():
        evaluation = done.measured.of(each)
        joints = summarise(evaluation).joints_cm[ALL][ALL]
        axes = direction_errors(pool(evaluation)).compare().raw
        table.add_row(
            name,
            f"{joints.raw.mean:.1f}",
            f"{joints.offset_out.mean:.1f}",
            f"{joints.offset_out.within_10:.0%}",
            f"{axes.mean:.1f}",
        )
    console = Console()
    console.print(table)
    console.print(foreshortened(done.measured.of(runs[DEFAULT])))


def foreshortened(evaluation: Evaluation) -> Table:
    """How far the limbs' bones are off, by the angle between the true bone and the viewing ray."""
    pooled = pool(evaluation)
    off_deg, from_ray_deg = [], []
    for bone, column in zip(DIRECTIONS, direction_errors(pooled).raw.T, strict=True):
        if bone.part.endswith(("arm", "leg")):
            start, end = (
                pooled.samples.reference_camera[:, JOINT_NAMES.index(joint)]
                for joint in (bone.start, bone.end)
            )
            cosines = (unit(end - start) * unit(start + end)).sum(1)
            from_ray_deg.append(np.degrees(np.arccos(np.abs(cosines))))
            off_deg.append(column)
    off, angle = np.concatenate(off_deg), np.concatenate(from_ray_deg)
    table = Table("bone to viewing ray, °", "bones", "off by, °", "median, °", box=None)
    for low, high in pairwise((0, 15, 30, 45, 60, 75, 90)):
        here = off[(angle >= low) & (angle < high) & np.isfinite(off)]
        if len(here):
            table.add_row(
                f"{low} to {high}", str(len(here)), f"{here.mean():.0f}", f"{np.median(here):.0f}"
            )
    return table


if __name__ == "__main__":
    main()
