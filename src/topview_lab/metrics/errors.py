"""Errors over all recordings, raw and with the constant offsets taken out.

Two systems, or a system and a reference, rarely agree on what "the shoulder" is. A joint's
constant offset is that difference of definition: one vector per joint, in the frame of the part
that carries it and in shares of the stature, the same in every frame. It is the mean of reference
minus prediction over the frames in which the joint is in view: where a joint is hidden, what is
wrong is not the definition. Where the joint is hardly ever in view (ankles hide themselves in their
shoes) it is the mean over all frames: the few that show it may be of one wrong pose. The predicted
joints are corrected by it in all frames, and distances and angles are told of the joints as they
are and as they are corrected.

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

from topview.body import JOINT_NAMES, JOINTS
from topview.body.parts import END_JOINTS, END_NAMES
from topview_lab.metrics.samples import CAUSES, Evaluation, Samples
from topview_lab.metrics.statistics import CM_PER_M, Comparison, statistic

Offsets = Literal["set", "person"]

IN_VIEW_SHARE: Final = 0.05
"""Of a joint; where less of it is hidden, by whatever, its constant offset is told (ours)."""
KNOWN_SHARE: Final = 0.1
"""Of the person-frames; a joint that is in view in fewer is hardly ever in view (ours)."""
_JOINT_PARTS: Final = [joint.part for joint in JOINTS]
_END_PARTS: Final = [joint.part for joint in END_JOINTS]


@dataclass(frozen=True, slots=True, eq=False)
class Pool:
    """N person-frames of all recordings; J joints as in `JOINT_NAMES`.

    Attributes:
        samples: the person-frames.
        sequence: [N] index of the recording.
        group: [N] index of those that share their constant offsets.
        joint_offsets: [G, J, 3] constant offset of each joint in the frame of its part, in shares
            of the stature; NaN where unknown.
        corrected_camera: [N, J, 3] predicted joints with the constant offsets taken out, metres.
        false_confidence: [M, J] see `SequenceErrors`.
    """

    samples: Samples
    sequence: NDArray[np.int64]
    group: NDArray[np.int64]
    joint_offsets: NDArray[np.float64]
    corrected_camera: NDArray[np.float64]
    false_confidence: NDArray[np.float64]

    def hidden_share(
        self, joints: Sequence[str], causes: Sequence[str] = CAUSES
    ) -> NDArray[np.float64]:
        """[N] share 0..1 of these joints that these causes hide, on average; NaN where unknown."""
        hidden = self.samples.hidden[:, [JOINT_NAMES.index(joint) for joint in joints]]
        return total_share(hidden[..., [CAUSES.index(cause) for cause in causes]]).mean(-1)


@dataclass(frozen=True, slots=True, eq=False)
class Errors:
    """Errors of N person-frames at C joints, parts or angles, NaN where there is none.

    Attributes:
        names: C names.
        raw: [N, C] cm or degrees.
        offset_out: [N, C] with the constant offsets taken out.
        hidden: [N, C, 4] share 0..1 that each of `CAUSES` hides, NaN where unknown.
    """

    names: tuple[str, ...]
    raw: NDArray[np.float64]
    offset_out: NDArray[np.float64]
    hidden: NDArray[np.float64]

    def of(self, names: Sequence[str]) -> Errors:
        """Some of the columns."""
        chosen = [self.names.index(name) for name in names]
        return Errors(
            tuple(names), self.raw[:, chosen], self.offset_out[:, chosen], self.hidden[:, chosen]
        )

    def compare(self, where: NDArray[np.bool_] | None = None) -> Comparison:
        """Of all, or of the [N] person-frames or the [N, C] errors `where` says True."""
        if where is None:
            return Comparison(statistic(self.raw), statistic(self.offset_out))
        return Comparison(statistic(self.raw[where]), statistic(self.offset_out[where]))


def pool(evaluation: Evaluation, offsets: Offsets = "set") -> Pool:
    """All samples of at least one recording, with their constant offsets estimated."""
    parts = [sequence.samples for sequence in evaluation.sequences]
    samples = Samples.pooled(parts)
    sequence = np.repeat(np.arange(len(parts)), [len(part.person) for part in parts])
    group = np.zeros_like(sequence)
    if offsets == "person":
        pairs = np.stack([sequence, samples.person], axis=1)
        group = np.unique(pairs, axis=0, return_inverse=True)[1].reshape(-1)
    joint_offsets, corrected_camera = _corrected(
        samples,
        samples.predicted_camera,
        samples.reference_camera,
        samples.hidden,
        _JOINT_PARTS,
        group,
    )
    return Pool(
        samples=samples,
        sequence=sequence,
        group=group,
        joint_offsets=joint_offsets,
        corrected_camera=corrected_camera,
        false_confidence=np.concatenate([s.false_confidence for s in evaluation.sequences]),
    )


def _corrected(
    samples: Samples,
    predicted_camera: NDArray[np.float64],
    reference_camera: NDArray[np.float64],
    hidden: NDArray[np.float64],
    parts: Sequence[int],
    group: NDArray[np.int64],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """[G, J, 3] constant offset of each joint, as in `Pool`, and the [N, J, 3] predicted joints
    with it taken out, of joints that these parts carry. Where nothing tells that a joint is hidden,
    it is in view."""
    Rs_camera_part = samples.Rs_camera_part[:, parts]
    stature_m = samples.stature_m[:, None, None]
    errors_camera = reference_camera - predicted_camera
    errors_part = np.einsum("njab,nja->njb", Rs_camera_part, errors_camera) / stature_m
    is_in_view = np.nan_to_num(total_share(hidden)) < IN_VIEW_SHARE
    in_view_means = group_means(np.where(is_in_view[..., None], errors_part, np.nan), group)
    is_told = np.isfinite(errors_part).all(-1)
    in_view_share = group_means(np.where(is_told, is_in_view, np.nan), group)
    is_known = in_view_share[..., None] >= KNOWN_SHARE
    offsets = np.where(is_known, in_view_means, group_means(errors_part, group))
    offsets_part_m = offsets[group] * stature_m
    return offsets, predicted_camera + np.einsum("njab,njb->nja", Rs_camera_part, offsets_part_m)


def end_errors(pool: Pool) -> Errors:
    """Distance in cm of wrists and feet from the reference's; NaN where it does not tell them."""
    samples = pool.samples
    predicted_camera, reference_camera = (
        samples.predicted_ends_camera,
        samples.reference_ends_camera,
    )
    _, corrected_camera = _corrected(
        samples, predicted_camera, reference_camera, samples.hidden_ends, _END_PARTS, pool.group
    )
    return Errors(
        names=END_NAMES,
        raw=_distances_cm(predicted_camera, reference_camera),
        offset_out=_distances_cm(corrected_camera, reference_camera),
        hidden=samples.hidden_ends,
    )


def position_errors(pool: Pool) -> Errors:
    """Distance in cm of each joint from the reference's."""
    reference_camera = pool.samples.reference_camera
    return Errors(
        names=JOINT_NAMES,
        raw=_distances_cm(pool.samples.predicted_camera, reference_camera),
        offset_out=_distances_cm(pool.corrected_camera, reference_camera),
        hidden=pool.samples.hidden,
    )


def total_share(hidden: NDArray[np.float64]) -> NDArray[np.float64]:
    """[...] share that the [..., causes] hide together, NaN where none is known."""
    known = np.isfinite(hidden)
    total = np.minimum(np.where(known, hidden, 0.0).sum(-1), 1.0)
    return np.where(known.any(-1), total, np.nan)


def hidden_of(pool: Pool, joints: Sequence[Sequence[str]]) -> NDArray[np.float64]:
    """[N, C, 4] mean share of the joints that each of C lists names, by cause."""
    columns = [[JOINT_NAMES.index(joint) for joint in names] for names in joints]
    return np.stack([pool.samples.hidden[:, chosen].mean(1) for chosen in columns], axis=1)


def group_means(values: NDArray[np.float64], group: NDArray[np.int64]) -> NDArray[np.float64]:
    """[G, C, ...] mean of the finite ones of the [N, C, ...] values in each group, else NaN."""
    shape = (int(group.max(initial=0)) + 1, *values.shape[1:])
    known = np.isfinite(values)
    total, count = np.zeros(shape), np.zeros(shape)
    np.add.at(total, group, np.where(known, values, 0.0))
    np.add.at(count, group, known)
    return total / np.where(count > 0, count, np.nan)


def _distances_cm(
    points_camera: NDArray[np.float64], others_camera: NDArray[np.float64]
) -> NDArray[np.float64]:
    return np.linalg.norm(points_camera - others_camera, axis=-1) * CM_PER_M
