"""What does each thing bring by which bodies are fitted?

    python scripts/ablate_body.py PATH... [--workers N] [--only WORD...] [--json FILE]

Tracks recordings in the folder layout as `topview evaluate folder` does, with all that there is and
without each thing; nothing is fitted anew. Distances and shares have the constant offsets out.
With `--only`, the variants alone whose names have one of the words, beside the default.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Final

from ablation import DEFAULT, Patches, Variants, chosen, left_out, nothing, parser_of, run_without
from rich.console import Console
from rich.table import Table

from topview.detect.joints import JointProposals
from topview.track.methods.topview.guided import GUIDED_REFINEMENT, GuideSettings
from topview.track.methods.topview.tracker import TopviewSettings
from topview.track.settings import TrackerSettings
from topview_lab.datasets import EvaluatedRecording, find_folder_recordings
from topview_lab.evaluate.run import Job, Outcome
from topview_lab.evaluate.tables import number, percent
from topview_lab.metrics import ALL, Evaluation, Summary, hidden_split, summarise

HANDS: Final = ("left_hand", "right_hand")
HIDDEN: Final = hidden_split(0.3, "another person")


def filtered(_: object, proposals: JointProposals, *__: object) -> JointProposals:
    """Each frame's joints alone."""
    return proposals


def by_weights(_: object, yaws: object, sigmas: object, weights: Any, *__: object) -> Any:
    """The modes as likely as the network says in this frame."""
    return weights


def guide(**changes: Any) -> Patches:
    """Another guide."""
    own = TopviewSettings(guide=GuideSettings(**changes))
    return {"track.tracker.method_by_name": lambda _: own}


def refinement(**changes: Any) -> Patches:
    """Other weights of the refinement."""
    return guide(refinement=replace(GUIDED_REFINEMENT, **changes))


VARIANTS: Final[Variants] = {
    DEFAULT: dict,
    "the network": dict,
    "the network, and hypotheses that are kept": lambda: {
        "track.methods.topview.hypotheses.MOST_HYPOTHESES": 0
    },
    "the surface: joints alone": dict,
    "joints in the refinement": lambda: refinement(joint_weight=0.0),
    "joints in the cost": lambda: guide(joints_cost=0.0),
    "free space": lambda: refinement(free_space_weight=0.0),
    "collisions": lambda: refinement(collision_weight=0.0),
    "limits of joints": lambda: refinement(limit_weight=0.0),
    "the head's centre": lambda: refinement(head_weight=0.0),
    "being held to the prediction": lambda: refinement(
        place_prior_weight=0.01, turn_prior_weight=0.001, twist_prior_weight=0.01
    ),
    "motion": lambda: {"track.methods.topview.tracker.VELOCITY_S": 1e-9},
    "refinement, 1 step of 5": lambda: refinement(iterations=1),
    "refinement, 15 steps of 5": lambda: refinement(iterations=15),
    "joints over time": lambda: {"track.joint_filter.JointFilter.update": filtered},
    "the belief of the yaw": lambda: {
        "track.methods.topview.yaw_belief.YawBelief.update": by_weights
    },
    "all modes but the likeliest": lambda: guide(least_weight=0.999),
    "the modes' weights in the cost": lambda: guide(mode_cost=0.0),
    "the person's own bones": lambda: {"track.bone_lengths.BoneLengths.update": nothing},
    "how familiar the window looks": lambda: {
        "track.familiarity.Familiarity.widening": property(lambda _: 1.0)
    },
}
SETTINGS: Final[Mapping[str, TrackerSettings]] = {
    "the network": TrackerSettings(threads=1, proposals="none"),
    "the network, and hypotheses that are kept": TrackerSettings(threads=1, proposals="none"),
    "the surface: joints alone": TrackerSettings(threads=1, method="joints"),
}


@dataclass(frozen=True, slots=True)
class AblatedBody:
    """A recording that is measured without one thing."""

    variant: str
    job: Job

    def __call__(self) -> Outcome:
        with left_out(VARIANTS[self.variant]()):
            return self.job()


def main() -> None:
    options = parser_of(__doc__).parse_args()
    recordings = find_folder_recordings(options.paths)
    names = chosen(VARIANTS, options.only)
    outcomes = run_without(names, recordings, _job, options.workers)
    measured = {name: tuple(o.errors for o in own if o.errors) for name, own in outcomes.items()}
    summaries = {name: summarise(Evaluation(own)) for name, own in measured.items() if own}
    Console().print(told(summaries))
    if options.json:
        rows = {name: figures(summary) for name, summary in summaries.items()}
        options.json.write_text(json.dumps(rows))


def _job(name: str, recording: EvaluatedRecording) -> AblatedBody:
    return AblatedBody(name, Job(recording, SETTINGS.get(name, TrackerSettings(threads=1))))


def figures(summary: Summary) -> dict[str, float]:
    """What is told of each variant."""
    joints, axes = summary.joints_cm, summary.axes_deg
    hidden = joints.get(HIDDEN, {}).get(ALL)
    return {
        "cm": joints[ALL][ALL].offset_out.mean,
        "within": joints[ALL][ALL].offset_out.within_10,
        "axes": axes[ALL][ALL].raw.mean,
        "hands": sum(joints[ALL][hand].offset_out.mean for hand in HANDS) / len(HANDS),
        "hidden": float("nan") if hidden is None else hidden.offset_out.mean,
        "facing": summary.facing.share,
        "back": summary.reacquired.share,
    }


def told(summaries: Mapping[str, Summary]) -> Table:
    """A line for each variant."""
    table = Table(
        "without", "cm", "within 10 cm", "axes, °", "hands, cm", "hidden, cm", "facing",
        "come back", box=None,
    )  # fmt: skip
    for name, summary in summaries.items():
        own = figures(summary)
        table.add_row(
            name,
            number(own["cm"], 2),
            percent(own["within"]),
            number(own["axes"]),
            number(own["hands"]),
            number(own["hidden"]),
            percent(own["facing"]),
            percent(own["back"]),
        )
    return table


if __name__ == "__main__":
    main()
