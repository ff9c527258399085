"""Table 5.2: the torso by bTVR, the thesis's upper-body tracker, in all frames and occluded; and
which of upper-body and full-body tracker is better at what."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from topview.track.methods.btvr import BTVR_AS_PRINTED, BtvrSettings
from topview_lab.metrics import (
    DIRECTION_GROUPS,
    Evaluation,
    Statistic,
    direction_errors,
    pool,
    position_errors,
)
from topview_lab.metrics.errors import total_share
from topview_lab.reproduce.context import Context
from topview_lab.reproduce.occlusion import INTERACTION, is_occluded, is_subject
from topview_lab.reproduce.printed import FRAME_SETS, TABLE_5_2, Part, Printed
from topview_lab.reproduce.runs import DEFAULT_VARIANT, THESIS_RECIPE, Measured, Run, Variant
from topview_lab.reproduce.section import (
    Row,
    Section,
    Table,
    as_json,
    compared,
    number,
)

BTVR: Final = "topview, btvr"
BTVR_PRINTED: Final = "topview, btvr as printed"
TOPVIEW: Final = "topview, the default"
TORSO_METHODS: Final[dict[str, Variant]] = {
    BTVR: Variant(BtvrSettings()),
    BTVR_PRINTED: Variant(BTVR_AS_PRINTED),
    "topview, thesis's full-body recipe": THESIS_RECIPE,
    TOPVIEW: DEFAULT_VARIANT,
}
BESIDE: Final = (BTVR, TOPVIEW)
"""The methods that are compared part by part."""
HIDDEN_JOINT_SHARE: Final = 0.3


def runs_5_2(context: Context) -> list[Run]:
    return [Run(v, r) for v in TORSO_METHODS.values() for r in context.own_sequences()]


def table_5_2(context: Context, measured: Measured) -> Section:
    ours = {name: _torso_errors(context, measured, v) for name, v in TORSO_METHODS.items()}
    rows = [
        *(Row(_cells(f"thesis: {who}", parts), "printed") for who, parts in TABLE_5_2.items()),
        *(Row(_cells(name, parts)) for name, parts in ours.items()),
    ]
    return Section(
        name="table-5.2",
        title="Table 5.2: the torso by bTVR",
        text=(
            "Angles between the estimated and the true directions of neck to mid torso, mid torso "
            "to hips, and shoulder to shoulder, on the sequences of Table 6.4. Occluded: frames in "
            f"which another user hides {INTERACTION:.0%} or more of the one who is looked at. As "
            "printed: the torso's axis is the best view by f_bTVR, its yaw that of the ellipse "
            "that fits best, of each frame alone, and of a cylinder as wide as the shoulders.",
        ),
        tables=(
            Table(("method", "μE, °", "σE, °", "occluded: μE, °", "σE, °"), tuple(rows)),
            _by_part(context, measured),
        ),
        verdicts=tuple(
            compared(f"Table 5.2, torso, {part}, {name}", ours[method][part], printed, "°")
            for name, method in (("btvr", BTVR), ("btvr as printed", BTVR_PRINTED))
            for part, printed in TABLE_5_2["bTVR"].items()
        ),
        numbers={
            name: {part: as_json(statistic) for part, statistic in parts.items()}
            for name, parts in ours.items()
        },
    )


def _torso_errors(context: Context, measured: Measured, variant: Variant) -> dict[Part, Statistic]:
    pooled = pool(measured.of(Run(variant, r) for r in context.own_sequences()))
    errors = direction_errors(pooled).of(DIRECTION_GROUPS["torso joints"])
    subject = is_subject(pooled)
    where = {"overall": subject, "occluded": subject & is_occluded(pooled)}
    return {part: errors.compare(where[part]).raw for part in FRAME_SETS}


def _by_part(context: Context, measured: Measured) -> Table:
    """Upper-body and full-body tracker, sequence by sequence."""
    rows = [
        Row(
            (
                f"{recording.name}, {name}",
                *_parts(measured.of([Run(TORSO_METHODS[name], recording)])),
            )
        )
        for recording in context.own_sequences()
        for name in BESIDE
    ]
    header = (
        "sequence, method", "torso, °", "occluded", "palms, cm", "occluded", "elbows, cm",
        "occluded", "ms per person",
    )  # fmt: skip
    caption = (
        "μE by part. Occluded: for the torso as above; for palms and elbows, those of which "
        f"{HIDDEN_JOINT_SHARE:.0%} or more is hidden by anything, and the column before has the "
        "others. Milliseconds include finding people."
    )
    return Table(header, tuple(rows), caption)


def _parts(evaluation: Evaluation) -> tuple[str, ...]:
    if not evaluation.sequences:
        return ("–",) * 7
    pooled = pool(evaluation)
    subject, occluded = is_subject(pooled), is_occluded(pooled)
    torso = direction_errors(pooled).of(DIRECTION_GROUPS["torso joints"])
    cells = [torso.compare(subject).raw, torso.compare(subject & occluded).raw]
    for joint in ("hand", "elbow"):
        errors = position_errors(pooled).of([f"{side}_{joint}" for side in ("left", "right")])
        hidden = total_share(errors.hidden) >= HIDDEN_JOINT_SHARE
        cells += [errors.compare(subject[:, None] & where).raw for where in (~hidden, hidden)]
    seconds = sum(sequence.seconds for sequence in evaluation.sequences)
    found = max(int(pooled.samples.found.sum()), 1)
    return *(number(cell.mean) for cell in cells), number(1000.0 * seconds / found, 0)


def _cells(name: str, parts: Mapping[Part, Statistic | Printed]) -> tuple[str, ...]:
    numbers = (number(v, 2) for part in FRAME_SETS for v in (parts[part].mean, parts[part].std))
    return name, *numbers
