"""Fit where limbs that are out of sight are on average
(`topview.track.methods.topview.unseen_limbs`) to recordings with truth."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, Final

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve

from topview.body.model import BodyModel
from topview.body.parts import JOINTS, PARTS, UPPER_TORSO
from topview.geometry.rotations import unit
from topview.records import InputError
from topview.track.body_tracker import Needs, Subject
from topview.track.elbows import limb_rotations
from topview.track.methods.topview.posture import (
    POSTURE_BLOCKS,
    mirrored_traits,
    posture_traits,
)
from topview.track.methods.topview.tracker import TopviewSettings, TopviewTracker
from topview.track.methods.topview.unseen_limbs import LIMB_PARTS, UnseenLimbs
from topview.track.pose import LIMBS, MIRRORED, OTHER_SIDE, Pose
from topview_lab.datasets import EvaluatedRecording
from topview_lab.training.found_people import SeenPose, found_people
from topview_lab.training.linear_laws import REWEIGHTED, Standardised, counted_by_distance

Array = NDArray[np.float64]

# All ours.
FEWEST_LIMBS: Final = 500  # parts out of sight that are needed
TYPICAL_CHORD: Final = 0.1  # between true and likely axes; what is farther counts by distance
LIMBS_RIDGE: Final = 0.05  # of a standardised trait, against all poses

MIRRORED_POSTURE: Final = mirrored_traits(POSTURE_BLOCKS)
_OTHER_LIMBS: Final = [LIMB_PARTS.index(OTHER_SIDE[part]) for part in LIMB_PARTS]
# The joint at the end of each of `LIMB_PARTS`, and the one where it begins.
_ENDS: Final = [max(n for n, joint in enumerate(JOINTS) if joint.part == p) for p in LIMB_PARTS]
_BEGINNINGS: Final = [JOINTS[end].bone_to for end in _ENDS]


@dataclass(frozen=True, slots=True, eq=False)
class LimbRows:
    """N found poses of people whose truth is known.

    Attributes:
        traits: [N, 38] of `posture_traits`.
        shares: [N, 8] of each of `LIMB_PARTS` that are out of sight.
        found: [N, 8, 3] their axes as they were found, in the frame of the upper torso.
        Rs_true: [N, 8, 3, 3] rotations in that frame, along the true axes.
    """

    traits: Array
    shares: Array
    found: Array
    Rs_true: Array

    @classmethod
    def joined(cls, parts: Sequence[LimbRows]) -> LimbRows:
        """One after the other."""
        return cls(
            np.concatenate([part.traits for part in parts]),
            np.concatenate([part.shares for part in parts]),
            np.concatenate([part.found for part in parts]),
            np.concatenate([part.Rs_true for part in parts]),
        )

    def mirrored(self) -> LimbRows:
        """Of the same people in a mirror."""
        signs, order = MIRRORED_POSTURE
        return LimbRows(
            signs * self.traits[:, order],
            self.shares[:, _OTHER_LIMBS],
            (self.found @ MIRRORED)[:, _OTHER_LIMBS],
            (MIRRORED @ self.Rs_true @ MIRRORED)[:, _OTHER_LIMBS],
        )

    def axes(self) -> Array:
        """[N, 8, 3] true axes in the frame of the upper torso, as they would be found: the truth
        has its joints elsewhere, so limbs in sight are found turned by a constant."""
        in_true = np.einsum("nkji,nkj->nki", self.Rs_true, self.found)
        is_seen = self.shares == 0.0
        tilts = unit(np.einsum("nk,nki->ki", is_seen, in_true))
        return np.einsum("nkij,kj->nki", self.Rs_true, tilts)


@dataclass(frozen=True, slots=True, eq=False)
class LimbsJob:
    """One recording to be tracked without proposals, in any process; gives why where it cannot
    be."""

    recording: EvaluatedRecording

    def __call__(self) -> LimbRows | str:
        try:
            return _rows_of(self.recording)
        except InputError as error:
            return f"{self.recording.name}: {error}"


@dataclass(frozen=True, slots=True, eq=False)
class _SeenLimbs(SeenPose):
    shares: Array  # [8] of each of `LIMB_PARTS` that are out of sight


def _rows_of(recording: EvaluatedRecording) -> LimbRows:
    seen: list[_SeenLimbs] = []
    rows = [
        (own.traits, own.shares, in_torso(own.pose, LIMB_PARTS)[..., 1], true_limbs(own.pose, true))
        for own, true in found_people(recording, _Seeing(seen), seen)
    ]
    return LimbRows(*map(np.array, zip(*rows, strict=True)))


def in_torso(pose: Pose, parts: int | Sequence[int]) -> Array:
    """[3, 3] rotation of a part, or of several, in the frame of the upper torso."""
    return pose.Rs[UPPER_TORSO].T @ pose.Rs[parts]


def true_limbs(pose: Pose, true_camera: Array) -> Array:
    """[8, 3, 3] rotations of limbs along true joints [16, 3], in the frame of a pose's upper
    torso."""
    axes = unit(true_camera[_ENDS] - true_camera[_BEGINNINGS]) @ pose.Rs[UPPER_TORSO]
    return np.concatenate(
        [
            limb_rotations(own, in_torso(pose, PARTS[upper].parent), upper)
            for upper, own in zip(LIMBS, axes.reshape(-1, 2, 3), strict=True)
        ]
    )


_NO_LAW: Final = np.zeros(0), np.zeros(0), np.zeros(0)


@dataclass(frozen=True, slots=True, eq=False)
class _Keeping(UnseenLimbs):
    """Keeps poses, and how much of their limbs is out of sight, and tells them as they are."""

    seen: list[_SeenLimbs]

    def told(self, pose: Pose, model: BodyModel, up_camera: Array, out: Array) -> Pose:
        traits = posture_traits(pose, model, up_camera)
        self.seen.append(_SeenLimbs(pose, model, traits, out[LIMB_PARTS]))
        return pose


@dataclass(frozen=True, slots=True)
class _Seeing:
    """The default method, whose poses are kept."""

    seen: list[_SeenLimbs]

    needs: ClassVar[Needs] = TopviewSettings.needs

    @property
    def name(self) -> str:
        return "topview"

    def tracker(self, subject: Subject) -> TopviewTracker:
        return TopviewTracker(subject, TopviewSettings(), unseen=_Keeping("", *_NO_LAW, self.seen))


def fit_unseen_limbs(rows: LimbRows, source: str) -> UnseenLimbs:
    """The law of the mean axes of limbs, by the shares of them that are out of sight. Left and
    right are alike. `source` says what it was learnt from.

    Raises:
        InputError: too little is out of sight.
    """
    count = int(np.count_nonzero(rows.shares))
    if count < FEWEST_LIMBS:
        raise InputError(
            f"{count} parts of limbs were out of sight; {FEWEST_LIMBS} are needed: give recordings "
            "of people of whom more is hidden"
        )
    both = LimbRows.joined([rows, rows.mirrored()])
    standard, axes = Standardised.of(both.traits), both.axes()
    weights = np.stack(
        [
            _least_squares(standard.traits, axes[:, n], both.shares[:, n])
            for n in range(len(LIMB_PARTS))
        ]
    )
    return UnseenLimbs(source, standard.weights(weights), standard.lowest, standard.highest)


def _least_squares(traits: Array, axes: Array, shares: Array) -> Array:
    """[3, T] with which standardised traits [N, T] tell axes [N, 3] best, which count by [N]."""
    held = np.append(0.0, np.ones(traits.shape[1] - 1))  # the constant is not
    law = np.zeros((3, traits.shape[1]))
    for _ in range(REWEIGHTED):
        counts = shares * counted_by_distance(axes - traits @ law.T, TYPICAL_CHORD)
        weighted = counts[:, None] * traits
        A = weighted.T @ traits
        A[np.diag_indices_from(A)] += LIMBS_RIDGE * counts.sum() * held + 1e-9
        law = solve(A, weighted.T @ axes, assume_a="pos").T
    return law


def chords_of(rows: LimbRows, law: UnseenLimbs | None = None) -> float:
    """Mean distance of unit axes from the true ones, by the shares out of sight: as they were
    found, or as a law tells."""
    told = rows.found
    if law is not None:
        told = unit(np.array([law.axes(traits) for traits in rows.traits]))
    off = np.linalg.norm(told - rows.axes(), axis=-1)
    return float(np.average(off, weights=rows.shares))
