"""All trackers on the same recordings, by the same ruler, with about the same time where they can
choose: how accurate each is, alone and occluded, how fast, and what it needs."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import isfinite
from typing import Final

from topview.track.methods.btvr import BtvrSettings
from topview_lab.evaluate.predictions import PredictedJob, Predictions
from topview_lab.metrics import ALL, Evaluation, Summary, hidden_split, summarise
from topview_lab.metrics.statistics import Comparison
from topview_lab.reproduce.context import QUICK_FRAMES, Context
from topview_lab.reproduce.runs import (
    DEFAULT_VARIANT,
    NETWORK_ALONE,
    THESIS_RECIPE,
    WITHOUT_NETWORK,
    Counterpart,
    Measured,
    Run,
    Variant,
)
from topview_lab.reproduce.section import (
    Row,
    Section,
    Table,
    Verdict,
    as_json,
    number,
    percent,
)
from topview_lab.rivals.ellipsoids import EllipsoidSettings
from topview_lab.rivals.forest.tracker import ForestSettings
from topview_lab.rivals.swarm import EQUAL_TIME

OCCLUDED_SPLIT: Final = hidden_split(0.3, "another person")
UPPER: Final = (
    "head", "neck", "torso", "left_shoulder", "left_elbow", "left_hand", "right_shoulder",
    "right_elbow", "right_hand",
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class Rival:
    """A tracker to compare with.

    Attributes:
        variant: how it is run here.
        needs: besides a depth camera, in a few words.
    """

    variant: Variant
    needs: str = ""


OURS: Final = "topview, the default"
BPSO: Final = "bPSO, as much time as topview"
PPSO: Final = "pPSO, as much time as topview"
RIVALS: Final[dict[str, Rival]] = {
    OURS: Rival(DEFAULT_VARIANT, "a network of rendered people; hands' colour helps"),
    "topview without the network": Rival(WITHOUT_NETWORK, "hands' colour helps"),
    "joints, the network alone": Rival(NETWORK_ALONE, "a network of rendered people"),
    "utvr, the recipe of Sec. 5.3": Rival(THESIS_RECIPE),
    "bTVR, upper body (Sec. 5.1)": Rival(Variant(BtvrSettings()), "hands' colour helps"),
    "ellipsoids, upper body (Sec. 2.2)": Rival(Variant(EllipsoidSettings())),
    BPSO: Rival(Variant(EQUAL_TIME)),
    PPSO: Rival(Variant(replace(EQUAL_TIME, perturbed=True))),
    "forest (Shotton et al.)": Rival(Variant(ForestSettings()), "training: the simulator's bodies"),
}
BRIDGE: Final = "bridge: another system's skeletons"
OPEN_BRIDGE: Final = "bridge: MediaPipe Pose, lifted by depth"


def recordings(context: Context) -> list[Counterpart]:
    """People alone, then people who hide each other."""
    if context.quick:
        return [
            context.counterpart("waving_two_hands", 80, QUICK_FRAMES),
            context.counterpart("crossing", 83, QUICK_FRAMES, start_s=1.0),
        ]
    return [
        context.counterpart("all_actions", 80, 300),
        context.counterpart("walking", 81, 150),
        context.counterpart("sit_down_stand_up", 82, 150),
        context.counterpart("crossing", 83, 150),
        context.counterpart("stand_in_front", 84, 150),
        context.counterpart("dummy_occluder", 85, 300, start_s=4.0),
    ]


def runs_of_rivals(context: Context) -> list[Run]:
    return [Run(r.variant, recording) for r in RIVALS.values() for recording in recordings(context)]


def rivals(context: Context, measured: Measured) -> Section:
    runs = recordings(context)
    summaries = {
        name: summarise(measured.of(Run(rival.variant, recording) for recording in runs))
        for name, rival in RIVALS.items()
    }
    rows = [Row((name, *_cells(s), RIVALS[name].needs)) for name, s in summaries.items()]
    bridged = _bridged(context)
    if bridged is None:
        rows.append(
            Row((OPEN_BRIDGE, *[""] * 7, "an environment of its own; --bridge FOLDER"), "open")
        )
    else:
        summaries[BRIDGE] = bridged
        rows.append(Row((BRIDGE, *_cells(bridged), str(context.bridge))))
    return Section(
        name="rivals",
        title="Rivals on the same recordings",
        text=(
            f"{len(runs)} simulated recordings: people alone, and people who hide each other. "
            "Upper body: head, neck, torso, shoulders, elbows, hands; the trackers of the upper "
            "body have nothing else. Occluded: joints of which another person hides 30 % or more. "
            "Offsets are out, as joints are defined differently. Frames per second on one core, "
            "with all the people in the frame, while others are busy. The swarms have as many "
            "generations as take the default's time on the same core. The forest was trained on "
            "other bodies of the same simulator, which flatters it.",
        ),
        tables=(
            Table(
                ("tracker", "all joints, cm", "A, 10 cm", "upper body, cm", "occluded, cm",
                 "occluded, upper body, cm", "recall", "frames/s", "needs"),
                tuple(rows),
            ),
        ),
        verdicts=tuple(_beats(summaries, swarm) for swarm in (BPSO, PPSO)),
        numbers={
            name: {
                "joints_cm": as_json(s.joints_cm[ALL][ALL].offset_out),
                "occluded_cm": as_json(s.joints_cm[OCCLUDED_SPLIT][ALL].offset_out),
                "recall": s.recall,
                "frames_per_second": s.frames_per_second,
            }
            for name, s in summaries.items()
        },
    )  # fmt: skip


def _bridged(context: Context) -> Summary | None:
    if context.bridge is None:
        return None
    predictions = Predictions(context.bridge)
    outcomes = [PredictedJob(recording, predictions)() for recording in recordings(context)]
    errors = tuple(outcome.errors for outcome in outcomes if outcome.errors is not None)
    return summarise(Evaluation(errors)) if errors else None


def _cells(summary: Summary) -> tuple[str, ...]:
    whole = summary.joints_cm[ALL][ALL].offset_out
    return (
        number(whole.mean),
        percent(whole.within_10),
        number(_upper_cm(summary.joints_cm[ALL])),
        number(summary.joints_cm[OCCLUDED_SPLIT][ALL].offset_out.mean),
        number(_upper_cm(summary.joints_cm[OCCLUDED_SPLIT])),
        percent(summary.recall),
        number(summary.frames_per_second),
    )


def _upper_cm(joints: dict[str, Comparison]) -> float:
    """Mean over the joints of the upper body that are known."""
    known = [joints[name].offset_out for name in UPPER if isfinite(joints[name].offset_out.mean)]
    count = sum(joint.count for joint in known)
    return sum(joint.mean * joint.count for joint in known) / count if count else float("nan")


def _beats(summaries: dict[str, Summary], swarm: str) -> Verdict:
    (ours, others), (our_occluded, their_occluded) = (
        [summaries[name].joints_cm[split][ALL].offset_out.mean for name in (OURS, swarm)]
        for split in (ALL, OCCLUDED_SPLIT)
    )
    is_ahead = {ours <= others, our_occluded <= their_occluded}
    known = all(map(isfinite, (ours, others, our_occluded, their_occluded)))
    return Verdict(
        "open" if not known else "mixed" if len(is_ahead) > 1 else
        "ahead" if is_ahead.pop() else "behind",
        f"topview against {swarm}",
        f"{number(ours)} against {number(others)} cm, occluded {number(our_occluded)} against "
        f"{number(their_occluded)} cm",
    )  # fmt: skip
