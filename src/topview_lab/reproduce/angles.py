"""Table 6.4: angles at torso, arm and leg joints, in all frames and under occlusion."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Final

from topview_lab.metrics import (
    DIRECTION_GROUPS,
    RELATIVE_ANGLE_GROUPS,
    Errors,
    Pool,
    direction_errors,
    pool,
    relative_angle_errors,
)
from topview_lab.metrics.statistics import Comparison, Statistic
from topview_lab.reproduce.context import Context
from topview_lab.reproduce.occlusion import INTERACTION, is_occluded, is_subject
from topview_lab.reproduce.printed import FRAME_SETS, GROUPS, TABLE_6_4, Group, Part, Printed
from topview_lab.reproduce.runs import DEFAULT_VARIANT, THESIS_RECIPE, Measured, Run, Variant
from topview_lab.reproduce.section import (
    Row,
    Section,
    Table,
    Verdict,
    as_json,
    compared,
    conclusion,
    statistic_cells,
)

ANGLE_METHODS: Final[dict[str, Variant]] = {
    "topview": DEFAULT_VARIANT,
    "utvr, the thesis's recipe": THESIS_RECIPE,
}
CLOSED_RIVAL: Final = (
    "The Kinect SDK is a closed binary: it has the thesis's numbers alone, of its recordings."
)
_JOINTS: Final[dict[Group, str]] = {
    "torso": "torso joints", "arms": "arm joints", "legs": "leg joints",
}  # fmt: skip

Angles = dict[Group, dict[Part, Statistic]]


def runs_6_4(context: Context) -> list[Run]:
    return [Run(v, r) for v in ANGLE_METHODS.values() for r in context.own_sequences()]


def table_6_4(context: Context, measured: Measured) -> Section:
    pools = {
        name: pool(measured.of(Run(variant, r) for r in context.own_sequences()))
        for name, variant in ANGLE_METHODS.items()
    }
    errors = {name: relative_angle_errors(p) for name, p in pools.items()}
    relative = {name: _angles(pools[name], own, _raw) for name, own in errors.items()}
    offsets_out = {name: _angles(pools[name], own, _offset_out) for name, own in errors.items()}
    direct = {
        name: _angles(p, direction_errors(p), _raw, DIRECTION_GROUPS) for name, p in pools.items()
    }
    frames = sum(recording.frames for recording in context.own_sequences())
    return Section(
        name="table-6.4",
        title="Table 6.4: angles by group of joints",
        text=(
            f"Two kinds of simulated sequences, {frames} frames in all: one user alone, whose body "
            "hides parts of itself, and a user who is occluded by another one who plays the dummy. "
            f"Occluded: frames in which the other hides {INTERACTION:.0%} or more of the user. "
            "Relative angles are those between a bone and the one before it, as Sec. 6.1.2 asks; "
            "they do not tell whether a body leans as a whole. Directions of bones in the camera's "
            "frame do, and are stricter. The default method's network has learnt where other "
            "people's skeletons have their joints, which is not where the simulator's have them: "
            "offsets out, each joint's constant offset from the simulator's is not counted.",
        ),
        tables=(
            _table("relative angles of consecutive joints", relative, with_printed=True),
            _table("the same, offsets out", offsets_out, with_printed=False),
            _table("directions of the bones between them", direct, with_printed=False),
        ),
        verdicts=(*_comparisons(relative), _conclusion(relative)),
        numbers={
            kind: {
                name: {g: {p: as_json(s) for p, s in parts.items()} for g, parts in groups.items()}
                for name, groups in angles.items()
            }
            for kind, angles in (
                ("relative", relative),
                ("relative_offsets_out", offsets_out),
                ("directions", direct),
            )
        },
    )


def _angles(
    pooled: Pool,
    errors: Errors,
    pick: Callable[[Comparison], Statistic],
    groups: Mapping[str, tuple[str, ...]] = RELATIVE_ANGLE_GROUPS,
) -> Angles:
    subject = is_subject(pooled)
    where = {"overall": subject, "occluded": subject & is_occluded(pooled)}
    return {
        group: {
            part: pick(errors.of(groups[_JOINTS[group]]).compare(where[part]))
            for part in FRAME_SETS
        }
        for group in GROUPS
    }


def _raw(errors: Comparison) -> Statistic:
    return errors.raw


def _offset_out(errors: Comparison) -> Statistic:
    return errors.offset_out


def _table(caption: str, ours: dict[str, Angles], with_printed: bool) -> Table:
    rows = []
    for group in GROUPS:
        if with_printed:
            rows += [
                Row((f"{group}, thesis: {who}", *_cells(by_part)), "printed")
                for who, by_part in TABLE_6_4[group].items()
            ]
        rows += [
            Row((f"{group}, topview, {name}", *_cells(angles[group])))
            for name, angles in ours.items()
        ]
    header = ("", "μE, °", "σE, °", "A, 10°", "occluded: μE, °", "σE, °", "A, 10°")
    return Table(header, tuple(rows), caption, foot=CLOSED_RIVAL if with_printed else "")


def _cells(by_part: Mapping[Part, Statistic | Printed]) -> list[str]:
    return [cell for part in FRAME_SETS for cell in statistic_cells(by_part[part])]


def _comparisons(relative: dict[str, Angles]) -> list[Verdict]:
    return [
        compared(
            f"Table 6.4, {group}, {part}, {name}",
            angles[group][part],
            TABLE_6_4[group]["uTVR"][part],
            "°",
        )
        for name, angles in relative.items()
        for group in GROUPS
        for part in FRAME_SETS
    ]


def _conclusion(relative: dict[str, Angles]) -> Verdict:
    angles = relative["topview"]
    return conclusion(
        "occlusion by another user costs accuracy, and tracking goes on (Sec. 6.1.3)",
        all(angles[g]["occluded"].mean >= angles[g]["overall"].mean for g in GROUPS),
        ", ".join(
            f"{g} {angles[g]['overall'].mean:.1f}° to {angles[g]['occluded'].mean:.1f}°"
            for g in GROUPS
        ),
        [angles[g]["occluded"].mean for g in GROUPS],
    )
