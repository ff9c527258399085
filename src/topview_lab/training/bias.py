"""Fit how far off found poses are on average (`topview.track.methods.topview.bias`) to recordings
with truth."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, Final

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve

from topview.body import JOINT_NAMES
from topview.body.parts import HEAD, JOINTS, UPPER_TORSO, other_side
from topview.records import InputError
from topview.track.body_tracker import Needs, Subject
from topview.track.methods.topview.bias import (
    MIRRORED_TRAITS,
    N_STEPS,
    TURNED,
    PoseBias,
    Unbiased,
)
from topview.track.methods.topview.tracker import TopviewSettings, TopviewTracker
from topview.track.methods.topview.whole_body import Found
from topview.track.pose import MIRRORED, OTHER_SIDE, TREE_PARENT, mirrored
from topview_lab.datasets import EvaluatedRecording
from topview_lab.training.found_people import SeenPose, found_people
from topview_lab.training.linear_laws import REWEIGHTED, Standardised, counted_by_distance

Array = NDArray[np.float64]

# All ours; the last two were chosen on seeds 100 to 105 of the rendered recordings.
FEWEST_POSES: Final = 500  # that are needed
TYPICAL_M: Final = 0.02  # of a joint; what is farther off counts by distance, not by its square
TRAITS_RIDGE: Final = 0.02  # of a standardised trait, against all joints that it moves

_JOINT_PART: Final = np.array([joint.part for joint in JOINTS])
_MIRRORED_JOINTS: Final = [JOINT_NAMES.index(other_side(name)) for name in JOINT_NAMES]


@dataclass(frozen=True, slots=True, eq=False)
class BiasRows:
    """N found poses of people whose truth is known.

    Attributes:
        traits: [N, T] of `pose_traits`.
        Rs: [N, 11, 3, 3] rotations of the parts, camera frame.
        origins: [N, 11, 3] their proximal joints, metres.
        joints_camera, true_camera: [N, 16, 3] found and true joints, metres.
    """

    traits: Array
    Rs: Array
    origins: Array
    joints_camera: Array
    true_camera: Array

    @classmethod
    def joined(cls, parts: Sequence[BiasRows]) -> BiasRows:
        """One after the other."""
        return cls(
            np.concatenate([part.traits for part in parts]),
            np.concatenate([part.Rs for part in parts]),
            np.concatenate([part.origins for part in parts]),
            np.concatenate([part.joints_camera for part in parts]),
            np.concatenate([part.true_camera for part in parts]),
        )

    def mirrored(self) -> BiasRows:
        """Of the same people in a mirror."""
        signs, order = MIRRORED_TRAITS
        return BiasRows(
            signs * self.traits[:, order],
            mirrored(self.Rs),
            (self.origins @ MIRRORED)[:, list(OTHER_SIDE)],
            (self.joints_camera @ MIRRORED)[:, _MIRRORED_JOINTS],
            (self.true_camera @ MIRRORED)[:, _MIRRORED_JOINTS],
        )


@dataclass(frozen=True, slots=True, eq=False)
class BiasJob:
    """One recording to be tracked without proposals, in any process, poses without the bias of a
    law or as they are found; gives why where it cannot be."""

    recording: EvaluatedRecording
    law: PoseBias | None

    def __call__(self) -> BiasRows | str:
        try:
            return _rows_of(self.recording, self.law)
        except InputError as error:
            return f"{self.recording.name}: {error}"


def _rows_of(recording: EvaluatedRecording, law: PoseBias | None) -> BiasRows:
    seen: list[SeenPose] = []
    rows = [
        (own.traits, own.pose.Rs, own.pose.origins(own.model), own.joints_camera, true)
        for own, true in found_people(recording, _Seeing(seen, law), seen)
    ]
    return BiasRows(*map(np.array, zip(*rows, strict=True)))


class _Keeping(Unbiased):
    """Keeps what poses look like."""

    def __init__(self, seen: list[SeenPose], law: PoseBias | None) -> None:
        super().__init__()
        self._seen, self._law = seen, law

    def steps(self, found: Found, traits: Array) -> Array:
        self._seen.append(SeenPose(found.pose, found.model, traits))
        return np.zeros(N_STEPS) if self._law is None else self._law.steps(traits)


@dataclass(frozen=True, slots=True)
class _Seeing:
    """The default method, whose poses and their traits are kept."""

    seen: list[SeenPose]
    law: PoseBias | None

    needs: ClassVar[Needs] = TopviewSettings.needs

    @property
    def name(self) -> str:
        return "topview"

    def tracker(self, subject: Subject) -> TopviewTracker:
        return TopviewTracker(subject, TopviewSettings(), _Keeping(self.seen, self.law))


def fit_bias(rows: BiasRows, source: str) -> PoseBias:
    """The law after which joints are nearest to the true ones, but for the constant offset that
    each has in its part: the truth has its joints elsewhere. Left and right are alike. `source`
    says what it was learnt from.

    Raises:
        InputError: too few poses.
    """
    if len(rows.traits) < FEWEST_POSES:
        raise InputError(
            f"{len(rows.traits)} poses were found; {FEWEST_POSES} are needed: give more recordings"
        )
    both = BiasRows.joined([rows, rows.mirrored()])
    standard = Standardised.of(both.traits)
    weights = standard.weights(_least_squares(standard.traits, moves_of(both), gaps_of(both)))
    return PoseBias(source, weights, standard.lowest, standard.highest)


def errors_m(rows: BiasRows, law: PoseBias | None = None) -> float:
    """Mean distance of joints from the true ones, constant offsets out, after the steps of a law;
    to the first order."""
    left = gaps_of(rows)
    if law is not None:
        left = left - np.einsum("njad,nd->nja", moves_of(rows), law.steps(rows.traits.T).T)
    return float(np.linalg.norm(left, axis=-1).mean())


def gaps_of(rows: BiasRows) -> Array:
    """[N, 16, 3] metres from each found joint to the true one, without its constant offset."""
    gaps = rows.true_camera - rows.joints_camera
    Rs = rows.Rs[:, _JOINT_PART]
    offsets_part = np.einsum("njab,nja->njb", Rs, gaps).mean(0)
    return gaps - np.einsum("njab,jb->nja", Rs, offsets_part)


def moves_of(rows: BiasRows) -> Array:
    """[N, 16, 3, 28] how each joint moves with each step of `PoseBias`."""
    moves = np.zeros((*rows.joints_camera.shape, N_STEPS))
    moves[..., :3] = rows.Rs[:, None, UPPER_TORSO]
    for d, (part, axis) in enumerate(TURNED, start=3):
        centre = rows.origins[:, UPPER_TORSO if part == HEAD else part, None]
        arms = rows.joints_camera - centre
        is_moved = [[_hangs_from(own, part)] for own in _JOINT_PART]
        moves[..., d] = is_moved * np.cross(rows.Rs[:, part, None, :, axis], arms)
    return moves


def _hangs_from(part: int, other: int) -> bool:
    """Whether a part moves with another one, which may be itself."""
    return part == other or (part >= 0 and _hangs_from(TREE_PARENT[part], other))


def _least_squares(traits: Array, moves: Array, gaps: Array) -> Array:
    """[28, T] with which steps, of standardised traits [N, T], close the gaps best."""
    T = traits.shape[1]
    held = np.append(0.0, np.ones(T - 1))  # the constant is not
    law = np.zeros((N_STEPS, T))
    ways = np.swapaxes(moves.reshape(len(moves), -1, N_STEPS), 1, 2)
    for _ in range(REWEIGHTED):
        left = gaps - np.einsum("njad,nd->nja", moves, traits @ law.T)
        counts = counted_by_distance(left, TYPICAL_M)
        weighted = np.repeat(counts, 3, axis=1)[:, None] * ways
        together = weighted @ np.swapaxes(ways, 1, 2)
        wanted = (weighted @ gaps.reshape(len(gaps), -1, 1))[..., 0]
        A = np.empty((N_STEPS, T, N_STEPS * T))
        for d in range(N_STEPS):
            products = together[:, d, :, None] * traits[:, None]
            A[d] = traits.T @ products.reshape(len(traits), -1)
        A = A.reshape(N_STEPS * T, -1)
        moved = np.einsum("ndd->d", together)
        A[np.diag_indices_from(A)] += (
            TRAITS_RIDGE * np.outer(moved, held).ravel() + 1e-6 * moved.max()
        )
        law = solve(A, (wanted.T @ traits).ravel(), assume_a="pos").reshape(N_STEPS, T)
    return law
