"""What does each thing bring that the joints' network learns from?

    python scripts/ablate_joints.py RENDERED... --out DIR --measure FOLDER... [--windows N]

Trains one small network for each variant, from chance, on as many windows: of rendered people with
`characters` in groundtruth.npz, and of our simulator's people in postures. Each is measured on
every folder of recordings with true masks, and on simulated people in postures that it has not
seen. DIR keeps the weights, for `topview evaluate ... --weights`, and what was measured; what was
stopped goes on when the same command is given again.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Annotated, Final

import numpy as np
from cyclopts import App, Parameter
from rich.console import Console
from rich.table import Table

from topview.detect.joints.network import opened
from topview.files import read_archive
from topview_lab.training.joints.export import exported
from topview_lab.training.joints.learning import LearningSettings, Step, first_windows, learn
from topview_lab.training.joints.measuring import JointScores, measure
from topview_lab.training.joints.net import NetSettings
from topview_lab.training.joints.recordings import Samples, cached, folders_in, gathered, kept
from topview_lab.training.joints.simulated import posture_recording
from topview_lab.training.joints.windows import Variation

FEW_PEOPLE: Final = 5  # those whom most recordings show
BATCH: Final = 16  # so short a training learns more from more steps
POSTURES: Final = 100  # simulated people to learn from
FIRST_MEASURED_POSTURE, MEASURED_POSTURES = 500, 10  # docs/joints.md measures the same
MEASURED_WINDOWS: Final = 600
CALIBRATING: Final = 256  # windows that tell how large numbers become


@dataclass(frozen=True, slots=True)
class Variant:
    """How one network learns.

    Attributes:
        variation: of the windows.
        how: it learns; windows and seed are the same for all.
        people: rendered people, those whom most recordings show; all where there are fewer.
        postures: simulated people.
    """

    variation: Variation = field(default_factory=Variation)
    how: LearningSettings = field(default_factory=LearningSettings)
    people: int = 1000
    postures: int = POSTURES


DEFAULT: Final = "all of it"
VARIANTS: Final = {
    DEFAULT: Variant(),
    "five people instead of sixteen": Variant(people=FEW_PEOPLE),
    "people not stretched": Variant(Variation(stretch=(0.0, 0.0, 0.0))),
    "without simulated people": Variant(postures=0),
    "background as it is": Variant(
        Variation(other_room_share=0.0, no_background_share=0.0, far_background_share=0.0)
    ),
    # Who faces where decides nothing: both modes learn the same.
    "one mode": Variant(how=LearningSettings(facing_sharpness=0.0)),
}


def main(
    *rendered: Path,
    out: Path,
    measure_on: Annotated[list[Path], Parameter("--measure", negative="")],
    windows: int = 32_000,
    only: Annotated[list[str] | None, Parameter(negative="")] = None,
) -> None:
    """Train, measure, and print a table of means and of shares within 10 cm."""
    out.mkdir(parents=True, exist_ok=True)
    cache = out / "cache"
    folders = list(folders_in(rendered))
    samples = gathered([cached(folder, cache) for folder in folders])
    characters = [read_archive(folder / "groundtruth.npz")["characters"] for folder in folders]
    sets = {
        own.name: gathered([cached(folder, cache) for folder in folders_in([own])])
        for own in measure_on
    }
    sets["postures"] = simulated(FIRST_MEASURED_POSTURE, MEASURED_POSTURES, cache)
    table = Table("", *(f"{name}: cm, %" for name in sets))
    for name, variant in VARIANTS.items():
        if only and not any(word in name for word in only):
            continue
        own = with_people(samples, characters, variant.people)
        own = together(own, simulated(0, variant.postures, cache))
        place = out / name.replace(" ", "_")
        told = place.with_suffix(".json")
        if not told.exists():
            scores = trained_and_measured(own, variant, windows, place, sets)
            told.write_text(json.dumps(scores, indent=1))
        said = json.loads(told.read_text())
        table.add_row(name, *(f"{said[key][0]:.2f}, {said[key][1]:.1f}" for key in sets))
    Console().print(table)


def simulated(first: int, count: int, cache: Path) -> Samples:
    """So many simulated people in postures."""
    numbers = range(first, first + count)
    return gathered([kept(cache / f"posture_{n}", partial(posture_recording, n)) for n in numbers])


def with_people(samples: Samples, characters: Sequence[np.ndarray], count: int) -> Samples:
    """The samples of so many characters, those of whom there are most."""
    own = np.array([str(characters[which][person]) for which, _, person in samples.index])
    chosen = [name for name, _ in Counter(own.tolist()).most_common(count)]
    return Samples(samples.recordings, samples.index[np.isin(own, chosen)])


def together(first: Samples, second: Samples) -> Samples:
    """The samples of both."""
    index = second.index + np.array([len(first.recordings), 0, 0])
    return Samples((*first.recordings, *second.recordings), np.concatenate([first.index, index]))


def trained_and_measured(
    samples: Samples, variant: Variant, windows: int, place: Path, sets: dict[str, Samples]
) -> dict[str, tuple[float, float]]:
    """Mean distance in cm, and percent within 10 cm, of each set."""
    how = replace(variant.how, windows=windows, batch=BATCH)
    print(f"{place.name}: {len(samples)} samples", flush=True)
    checkpoint = place.with_suffix(".checkpoint")
    net = learn(samples, NetSettings(), how, variant.variation, checkpoint, say, report_steps=500)
    images = first_windows(samples, variant.variation, how.seed, CALIBRATING)
    weights = exported(net, images)
    place.with_suffix(".onnx").write_bytes(weights)
    answers = opened(weights).answers
    every = {name: max(1, len(own) // MEASURED_WINDOWS) for name, own in sets.items()}
    scores = {name: measure(answers, own, every[name], lambda: None) for name, own in sets.items()}
    return {name: summary(own) for name, own in scores.items()}


def summary(scores: JointScores) -> tuple[float, float]:
    """Mean distance in cm and percent within 10 cm, of all joints."""
    return 100.0 * float(scores.mean_m.mean()), 100.0 * float(scores.within.mean())


def say(step: Step) -> None:
    """How far a training is."""
    print(f"{step.step} of {step.steps}, {step.windows_a_second:.0f} windows/s", flush=True)


if __name__ == "__main__":
    app = App()
    app.default(main)
    app()
