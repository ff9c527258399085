"""From errors to numbers: mean, standard deviation, share within 10 cm or 10 degrees.

Two systems, or a system and a reference, rarely agree on what "the shoulder" is. A joint's
constant offset is that difference of definition: one vector per joint, in the frame of the part
that carries it and in shares of the stature, the same in every frame. It is the mean, over all
frames evaluated, of reference minus prediction; distances are given with it and without it. The
same is done for a part's axis, whose constant offset is the mean direction of the reference bone
in the part's frame.

`offsets="set"` estimates one offset for all recordings and people pooled; `offsets="person"` one
for each person of each recording, which also takes out what a system gets constantly wrong about
a person, and so flatters it more.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from topview.body import JOINT_NAMES
from topview.evaluate.metrics.errors import BONES, Evaluation, Samples
from topview.evaluate.metrics.matching import PeopleCounts

Offsets = Literal["set", "person"]

CM_PER_M: Final = 100.0
WITHIN: Final = 10.0  # cm for joints, degrees for axes: the accuracy A of Sec. 6.1.3
HEAVY_OCCLUSION: Final = 0.3  # ours: shares of a joint that another person hides
SEVERE_OCCLUSION: Final = 0.6
ALL: Final = "all"


@dataclass(frozen=True, slots=True)
class Statistic:
    """Errors in cm (joints) or degrees (axes): NaN where there is none.

    Attributes:
        count: how many.
        mean: their mean.
        std: their standard deviation.
        within_10: share 0..1 that is at most 10.
    """

    count: int
    mean: float
    std: float
    within_10: float


@dataclass(frozen=True, slots=True)
class Comparison:
    """The same errors as they are, and with the constant offsets taken out."""

    raw: Statistic
    offset_out: Statistic


Table = dict[str, Comparison]  # by joint or part, and ALL


@dataclass(frozen=True, slots=True)
class SequenceSummary:
    """One recording's numbers; the offsets are still those of the whole set."""

    name: str
    joints: Comparison
    axes: Comparison
    people: PeopleCounts
    frames_per_second: float


@dataclass(frozen=True, slots=True)
class Summary:
    """The numbers of all tables.

    Attributes:
        offsets: how the constant offsets were estimated.
        joints_cm: distances, by occlusion ("all", "hidden < 30 %", ...) and joint.
        axes_deg: angles between part axis and reference bone, by occlusion and part.
        joint_offsets: the constant offset of each joint, reference minus prediction as x, y, z in
            the frame of its part and in shares of the stature; empty unless one for the whole set.
        people: counts over all recordings.
        recall: see `PeopleCounts`.
        precision: see `PeopleCounts`.
        tracked_frames: how many.
        seconds: spent in the tracker, all processes together.
        frames_per_second: of one process.
        sequences: one each.
    """

    offsets: Offsets
    joints_cm: dict[str, Table]
    axes_deg: dict[str, Table]
    joint_offsets: dict[str, tuple[float, ...]]
    people: PeopleCounts
    recall: float
    precision: float
    tracked_frames: int
    seconds: float
    frames_per_second: float
    sequences: tuple[SequenceSummary, ...]


def statistic(errors: NDArray[np.float64]) -> Statistic:
    """Of all the finite values."""
    finite = errors[np.isfinite(errors)]
    if finite.size == 0:
        return Statistic(0, *[float("nan")] * 3)
    return Statistic(
        count=finite.size,
        mean=float(finite.mean()),
        std=float(finite.std()),
        within_10=float((finite <= WITHIN).mean()),
    )


@dataclass(frozen=True, slots=True, eq=False)
class _Errors:
    """[N, C] errors of C joints or parts, raw and offset out, and who hides them."""

    names: tuple[str, ...]
    raw: NDArray[np.float64]
    offset_out: NDArray[np.float64]
    occluded: NDArray[np.float64]

    def compare(self, where: NDArray[np.bool_]) -> Comparison:
        return Comparison(statistic(self.raw[where]), statistic(self.offset_out[where]))

    def tables(self) -> dict[str, Table]:
        where = {
            ALL: np.ones(self.raw.shape, bool),
            f"hidden < {HEAVY_OCCLUSION:.0%}": self.occluded < HEAVY_OCCLUSION,
            f"hidden ≥ {HEAVY_OCCLUSION:.0%}": self.occluded >= HEAVY_OCCLUSION,
            f"hidden ≥ {SEVERE_OCCLUSION:.0%}": self.occluded >= SEVERE_OCCLUSION,
        }
        return {occlusion: self._table(chosen) for occlusion, chosen in where.items()}

    def _table(self, where: NDArray[np.bool_]) -> Table:
        columns = np.eye(len(self.names), dtype=bool)
        by_name = {n: self.compare(where & c) for n, c in zip(self.names, columns, strict=True)}
        return by_name | {ALL: self.compare(where)}


def summarise(evaluation: Evaluation, offsets: Offsets = "set") -> Summary:
    """The numbers of all tables; `offsets` as described in the module."""
    sequences = evaluation.sequences
    sequence, group, samples = _pool([s.samples for s in sequences], offsets)
    joint_offsets = _joint_offsets(samples, group)
    joints = _Errors(
        names=JOINT_NAMES,
        raw=samples.distances_m * CM_PER_M,
        offset_out=_distances_offset_out_m(samples, joint_offsets[group]) * CM_PER_M,
        occluded=samples.joint_occluded,
    )
    axes = _Errors(
        names=tuple(bone.part for bone in BONES),
        raw=_angles_deg(samples.bones_part, np.array([0.0, 1.0, 0.0])),
        offset_out=_angles_deg(samples.bones_part, _group_means(samples.bones_part, group)[group]),
        occluded=samples.bone_occluded,
    )
    people = sum((s.people for s in sequences), PeopleCounts())
    tracked_frames = sum(s.tracked_frames for s in sequences)
    seconds = sum(s.seconds for s in sequences)
    return Summary(
        offsets=offsets,
        joints_cm=joints.tables(),
        axes_deg=axes.tables(),
        joint_offsets=_by_joint(joint_offsets[0]) if offsets == "set" else {},
        people=people,
        recall=people.recall,
        precision=people.precision,
        tracked_frames=tracked_frames,
        seconds=seconds,
        frames_per_second=_rate(tracked_frames, seconds),
        sequences=tuple(
            SequenceSummary(
                name=s.name,
                joints=joints.compare(np.broadcast_to(sequence[:, None] == i, joints.raw.shape)),
                axes=axes.compare(np.broadcast_to(sequence[:, None] == i, axes.raw.shape)),
                people=s.people,
                frames_per_second=_rate(s.tracked_frames, s.seconds),
            )
            for i, s in enumerate(sequences)
        ),
    )


def _rate(frames: int, seconds: float) -> float:
    return frames / seconds if seconds > 0.0 else float("nan")


def _pool(
    parts: Sequence[Samples], offsets: Offsets
) -> tuple[NDArray[np.int64], NDArray[np.int64], Samples]:
    """[N] index of the recording, [N] group that shares its constant offsets, all samples."""
    samples = Samples.pooled(parts)
    sequence = np.repeat(np.arange(len(parts)), [len(part.person) for part in parts])
    if offsets == "set":
        return sequence, np.zeros_like(sequence), samples
    pairs = np.stack([sequence, samples.person], axis=1)
    _, group = np.unique(pairs, axis=0, return_inverse=True)
    return sequence, group.reshape(-1), samples


def _group_means(vectors: NDArray[np.float64], group: NDArray[np.int64]) -> NDArray[np.float64]:
    """[G, C, 3] mean of the finite ones of the [N, C, 3] vectors in each of G groups, else NaN."""
    groups = int(group.max(initial=0)) + 1
    known = np.isfinite(vectors).all(-1, keepdims=True)
    total = np.zeros((groups, *vectors.shape[1:]))
    count = np.zeros((groups, vectors.shape[1], 1))
    np.add.at(total, group, np.where(known, vectors, 0.0))
    np.add.at(count, group, known)
    return total / np.where(count > 0, count, np.nan)


def _joint_offsets(samples: Samples, group: NDArray[np.int64]) -> NDArray[np.float64]:
    """[G, J, 3] constant offset of each joint in the frame of its part, in shares of stature."""
    return _group_means(samples.errors_part_m / samples.stature_m[:, None, None], group)


def _distances_offset_out_m(
    samples: Samples, offsets_part: NDArray[np.float64]
) -> NDArray[np.float64]:
    """[N, J] what is left of the distances after the [N, J, 3] offsets, in shares of stature."""
    offsets_part_m = offsets_part * samples.stature_m[:, None, None]
    return np.linalg.norm(samples.errors_part_m - offsets_part_m, axis=-1)


def _by_joint(offsets_part: NDArray[np.float64]) -> dict[str, tuple[float, ...]]:
    return dict(zip(JOINT_NAMES, map(tuple, offsets_part.tolist()), strict=True))


def _angles_deg(directions: NDArray[np.float64], axes: NDArray[np.float64]) -> NDArray[np.float64]:
    """[...] angle between two [..., 3] directions of any length, exact near 0 and 180 degrees."""
    across = np.linalg.norm(np.cross(directions, axes), axis=-1)
    return np.degrees(np.arctan2(across, (directions * axes).sum(-1)))
