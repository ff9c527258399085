"""Fit how far joints are off (`topview.track.joint_errors`) to recordings with truth."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import nan
from typing import Final

import msgspec
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize
from scipy.special import digamma, gammaln

from topview.body import OUTPUT_JOINT_NAMES, PART_NAMES
from topview.records import InputError, Person
from topview.skeletons import About, SkeletonSequence, TrackedFrame
from topview.track import Tracker, TrackerSettings
from topview.track.joint_errors import (
    COUNTED_SHARES,
    ELLIPSOID_SHARE,
    STATED,
    TERMS,
    ErrorLaw,
    JointErrors,
    JointSigns,
    are_proposed,
    kinds_of,
)
from topview_lab.datasets import EvaluatedRecording
from topview_lab.metrics import Evaluation, SequenceErrors, measure_sequence, pool

Array = NDArray[np.float64]

# All ours.
# Of each kind of joints, that are fitted to, evenly taken; and that are needed.
MOST_JOINTS, FEWEST_JOINTS = 10_000, 100
KINDS: Final = (
    *("not behind others", "behind others"),
    *("not behind others, not proposed", "behind others, not proposed"),
)
ADDED_M2: Final = 1e-6  # a variance that is added, so that no law is flat
# Of people whom the network knows, that ellipsoids have to hold for 90 % to be held of the same
# people with other proportions (`scripts/fit_familiarity.py`, seeds 100 to 103); of `KINDS`.
KNOWN_HELD: Final = 0.947
HELD: Final = (KNOWN_HELD, KNOWN_HELD, ELLIPSOID_SHARE, ELLIPSOID_SHARE)
START_LOG_WEIGHT, START_MOST_M2, START_TAILS = -3.0, 0.1, 5.0
LOG_WEIGHTS: Final = (-14.0, 5.0)  # bounds
TAILS: Final = (2.0, 50.0)
SIGNIFICANT_DIGITS: Final = 4


@dataclass(frozen=True, slots=True, eq=False)
class TermErrors:
    """One recording, measured once for each term, whose matrices take the place of covariances; and
    once for whether another person hides a joint, 1 on the diagonal where that is so."""

    of_terms: tuple[SequenceErrors, ...]
    of_behind: SequenceErrors


@dataclass(frozen=True, slots=True, eq=False)
class ErrorRows:
    """N joints whose truth is known.

    Attributes:
        errors_camera: [N, 3] metres, the constant offsets out.
        terms: [K, N, 3, 3] of `TERMS`.
        kinds: [N] `kinds_of`.
        recording: [N] number of the recording.
    """

    errors_camera: Array
    terms: Array
    kinds: NDArray[np.int64]
    recording: NDArray[np.int64]

    @classmethod
    def of(cls, recordings: Sequence[TermErrors]) -> ErrorRows:
        """Of recordings of one method; their offsets are common."""
        pools = [
            pool(Evaluation(tuple(own.of_terms[k] for own in recordings)))
            for k in range(len(TERMS))
        ]
        behind = pool(Evaluation(tuple(own.of_behind for own in recordings)))
        errors = pools[0].corrected_camera - pools[0].samples.reference_camera
        terms = np.stack([each.samples.joint_covariance_m2 for each in pools])
        is_known = np.isfinite(errors).all(-1) & np.isfinite(terms).all((0, -2, -1))
        is_behind = behind.samples.joint_covariance_m2[..., 0, 0] > 0.5
        recording = np.broadcast_to(pools[0].sequence[:, None], is_known.shape)
        terms = terms[:, is_known]
        kinds = kinds_of(are_proposed(terms), is_behind[is_known])
        return cls(errors[is_known], terms, kinds, recording[is_known])

    @classmethod
    def joined(cls, parts: Sequence[ErrorRows]) -> ErrorRows:
        """One after the other, each of other recordings."""
        counts = [int(part.recording.max(initial=-1)) + 1 for part in parts]
        before = np.cumsum([0, *counts[:-1]])
        return cls(
            np.concatenate([part.errors_camera for part in parts]),
            np.concatenate([part.terms for part in parts], axis=1),
            np.concatenate([part.kinds for part in parts]),
            np.concatenate(
                [part.recording + start for part, start in zip(parts, before, strict=True)]
            ),
        )


@dataclass(frozen=True, slots=True, eq=False)
class ErrorsJob:
    """One recording to be tracked with these settings and measured, in any process; gives why
    where it cannot be."""

    recording: EvaluatedRecording
    settings: TrackerSettings

    def __call__(self) -> TermErrors | str:
        name = self.recording.name
        try:
            reference = self.recording.reference()
            signs = _signs_as_skeletons(self.recording, self.settings)
            measured = [measure_sequence(own, reference, name) for own in signs]
        except InputError as error:
            return f"{name}: {error}"
        return TermErrors(tuple(measured[1:]), measured[0])


def _signs_as_skeletons(
    recording: EvaluatedRecording, settings: TrackerSettings
) -> list[SkeletonSequence]:
    """What was tracked, with whether joints are behind others, then with each term, as
    covariances."""
    tracker = Tracker(settings)
    about = About(OUTPUT_JOINT_NAMES, PART_NAMES)
    frames: list[list[TrackedFrame]] = [[] for _ in range(1 + len(TERMS))]
    for frame in recording.open():
        people = tracker.update(frame)
        told = [_matrices(tracker.joint_signs[person.id]) for person in people]
        for k, of_term in enumerate(frames):
            with_term = [
                with_covariance(person, matrices[k])
                for person, matrices in zip(people, told, strict=True)
            ]
            packed = about.packed(with_term)
            of_term.append(TrackedFrame(frame.index, frame.timestamp_s, frame.name, packed))
    return [SkeletonSequence.from_frames(of_term, about) for of_term in frames]


def _matrices(signs: JointSigns) -> Array:
    """[1 + K, J, 3, 3] whether joints are behind others, and terms."""
    behind = signs.is_behind[:, None, None] * np.eye(3)
    return np.concatenate([behind[None], signs.terms()])


def with_covariance(person: Person, matrices: Array) -> Person:
    """The person, with [J, 3, 3] matrices as covariances."""
    return Person(
        person.id,
        person.height_m,
        person.joints_camera,
        person.joint_state,
        person.joint_confidence,
        person.Ts_camera_part,
        matrices.astype(np.float32),
    )


def fit_joint_errors(rows: ErrorRows, source: str) -> JointErrors:
    """The likeliest weights of the terms and tails. Each kind of joints counts the same, and of
    either kind each recording: errors within one are much alike.

    Raises:
        InputError: too few joints of a kind.
    """
    for kind, what in enumerate(KINDS):
        count = int((rows.kinds == kind).sum())
        if count < FEWEST_JOINTS:
            raise InputError(
                f"{count} joints {what} were found; {FEWEST_JOINTS} are needed: give more "
                "recordings"
            )
    chosen = np.concatenate([_some(rows.kinds == kind) for kind in range(len(KINDS))])
    errors, terms, kinds = rows.errors_camera[chosen], rows.terms[:, chosen], rows.kinds[chosen]
    tails = [np.log(START_TAILS)] * len(KINDS)
    start = [*[START_LOG_WEIGHT] * len(TERMS), np.log(START_MOST_M2), *tails]
    of_tails = [(np.log(TAILS[0]), np.log(TAILS[1]))] * len(KINDS)
    bounds = [*[LOG_WEIGHTS] * (len(TERMS) + 1), *of_tails]
    args = errors, terms, kinds, _shares(kinds, rows.recording[chosen])
    fitted = minimize(_unlikelihood, start, args, jac=True, bounds=bounds, method="L-BFGS-B")
    return with_counts(_with_weights(source, [*map(_rounded, np.exp(fitted.x))]), rows)


def _with_weights(source: str, values: Sequence[float]) -> JointErrors:
    """Of what is fitted; what is counted is not known yet."""
    unknown = (nan,) * len(COUNTED_SHARES)
    weights, tails = values[: -len(KINDS)], values[-len(KINDS) :]
    return JointErrors(source, tuple(ErrorLaw(own, nan, unknown) for own in tails), *weights)


def with_counts(told: JointErrors, rows: ErrorRows) -> JointErrors:
    """The same with how large errors are, of each kind of joints that there is: ellipsoids hold
    `KNOWN_HELD` of those that are proposed. Each recording counts the same."""
    matrices = told.matrices(rows.terms) + ADDED_M2 * np.eye(3)
    errors = rows.errors_camera
    squared = (errors * np.linalg.solve(matrices, errors[..., None])[..., 0]).sum(-1)
    shares, laws = _shares(rows.kinds, rows.recording), list(told.laws)
    for kind in np.unique(rows.kinds):
        is_kind = rows.kinds == kind
        ellipsoid, *counted = _weighted_quantiles(
            squared[is_kind], shares[is_kind], (HELD[kind], *COUNTED_SHARES)
        )
        laws[kind] = ErrorLaw(laws[kind].tails, ellipsoid, tuple(counted))
    return msgspec.structs.replace(told, laws=tuple(laws))


def _weighted_quantiles(values: Array, weights: Array, shares: Sequence[float]) -> list[float]:
    found = np.quantile(values, shares, weights=weights, method="inverted_cdf")
    return [_rounded(value) for value in found]


def _rounded(value: float) -> float:
    return float(f"{value:.{SIGNIFICANT_DIGITS}g}")


def _unlikelihood(
    place: Array, errors: Array, terms: Array, kinds: NDArray[np.int64], shares: Array
) -> tuple[float, Array]:
    """Minus the mean log-likelihood of [N] joints, each of which counts by its share, and how it
    changes with `place`: the logarithms of `JointErrors`' numbers."""
    told = _with_weights("", [*np.exp(place)])
    limited = told.limited(terms)
    tails = np.array([law.tails for law in told.laws])[kinds]
    values, by_matrix, by_tails = log_likelihoods(errors, told.matrices(terms), tails)
    by_matrix *= shares[:, None, None]
    by_weight = np.einsum("nab,knab->k", by_matrix, limited)
    stated = limited[:STATED]  # whose derivative by the bound is their square over its own
    by_most = np.einsum("nab,knac,kncb->k", by_matrix, stated, stated, optimize=True)
    by_place = [
        *(told.weights * by_weight),
        told.weights[:STATED] @ by_most / told.most_m2,
        *np.bincount(kinds, shares * by_tails * tails, len(told.laws)),
    ]
    return -float(shares @ values), -np.array(by_place)


def log_likelihoods(errors: Array, matrices: Array, tails: Array) -> tuple[Array, Array, Array]:
    """[N] of [N, 3] errors under Student laws of [N, 3, 3] matrices and [N] degrees of freedom; and
    how they change with the matrices, [N, 3, 3], and with the degrees of freedom, [N]."""
    matrices = matrices + ADDED_M2 * np.eye(3)
    inverses = np.linalg.inv(matrices)
    pulls = (inverses @ errors[..., None])[..., 0]
    squared = (errors * pulls).sum(-1)
    log_tails = np.log1p(squared / tails)
    values = (
        gammaln(0.5 * (tails + 3.0))
        - gammaln(0.5 * tails)
        - 1.5 * np.log(np.pi * tails)
        - 0.5 * np.linalg.slogdet(matrices).logabsdet
        - 0.5 * (tails + 3.0) * log_tails
    )
    pull = (tails + 3.0) / (tails + squared)
    by_matrix = pull[:, None, None] * pulls[:, :, None] * pulls[:, None, :] - inverses
    by_tails = digamma(0.5 * (tails + 3.0)) - digamma(0.5 * tails) - log_tails
    by_tails += pull * squared / tails - 3.0 / tails
    return values, 0.5 * by_matrix, 0.5 * by_tails


def _shares(kinds: NDArray[np.int64], recording: NDArray[np.int64]) -> Array:
    """[N] how much each joint counts; 1 together."""
    _, group, counts = np.unique(
        len(KINDS) * recording + kinds, return_inverse=True, return_counts=True
    )
    shares = 1.0 / counts[group]
    return shares / np.bincount(kinds, shares)[kinds] / len(np.unique(kinds))


def _some(where: NDArray[np.bool_]) -> NDArray[np.intp]:
    """Indices of so many of them as are fitted to."""
    index = np.flatnonzero(where)
    return index[:: max(1, -(-len(index) // MOST_JOINTS))]
