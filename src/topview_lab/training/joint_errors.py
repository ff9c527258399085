"""Fit how far joints are off (`topview.track.joint_errors`) to recordings with truth."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
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
    PROPOSED,
    STATED,
    TERMS,
    JointErrors,
    JointSigns,
)
from topview_lab.datasets import EvaluatedRecording
from topview_lab.metrics import Evaluation, SequenceErrors, measure_sequence, pool

Array = NDArray[np.float64]

# All ours.
MOST_JOINTS: Final = 20_000  # that are fitted to, evenly taken
FEWEST_JOINTS: Final = 100  # of each kind
ADDED_M2: Final = 1e-6  # a variance that is added, so that no law is flat
# Of people whom the network knows, that ellipsoids have to hold for 90 % to be held of the same
# people with other proportions (`scripts/fit_familiarity.py`, seeds 100 to 103).
KNOWN_HELD: Final = 0.947
START_LOG_WEIGHT, START_MOST_M2, START_TAILS = -3.0, 0.1, 5.0
LOG_WEIGHTS: Final = (-14.0, 5.0)  # bounds
TAILS: Final = (2.0, 50.0)
SIGNIFICANT_DIGITS: Final = 4


@dataclass(frozen=True, slots=True, eq=False)
class TermErrors:
    """One recording, measured once for each term, whose matrices take the place of covariances; and
    once for the kind of each joint, 1 on the diagonal where another person hides it."""

    of_terms: tuple[SequenceErrors, ...]
    of_kinds: SequenceErrors


@dataclass(frozen=True, slots=True, eq=False)
class ErrorRows:
    """N joints whose truth is known.

    Attributes:
        errors_camera: [N, 3] metres, the constant offsets out.
        terms: [K, N, 3, 3] of `TERMS`.
        is_behind: [N] `JointSigns.is_behind`.
        recording: [N] number of the recording.
    """

    errors_camera: Array
    terms: Array
    is_behind: NDArray[np.bool_]
    recording: NDArray[np.int64]

    @classmethod
    def of(cls, recordings: Sequence[TermErrors]) -> ErrorRows:
        """Of recordings of one method; their offsets are common."""
        pools = [
            pool(Evaluation(tuple(own.of_terms[k] for own in recordings)))
            for k in range(len(TERMS))
        ]
        kinds = pool(Evaluation(tuple(own.of_kinds for own in recordings)))
        errors = pools[0].corrected_camera - pools[0].samples.reference_camera
        terms = np.stack([each.samples.joint_covariance_m2 for each in pools])
        is_known = np.isfinite(errors).all(-1) & np.isfinite(terms).all((0, -2, -1))
        is_behind = kinds.samples.joint_covariance_m2[..., 0, 0] > 0.5
        recording = np.broadcast_to(pools[0].sequence[:, None], is_known.shape)
        return cls(errors[is_known], terms[:, is_known], is_behind[is_known], recording[is_known])

    @classmethod
    def joined(cls, parts: Sequence[ErrorRows]) -> ErrorRows:
        """One after the other, each of other recordings."""
        counts = [int(part.recording.max(initial=-1)) + 1 for part in parts]
        before = np.cumsum([0, *counts[:-1]])
        return cls(
            np.concatenate([part.errors_camera for part in parts]),
            np.concatenate([part.terms for part in parts], axis=1),
            np.concatenate([part.is_behind for part in parts]),
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
            kinds, *terms = _signs_as_skeletons(self.recording, self.settings)
            measured = [measure_sequence(own, reference, name) for own in (kinds, *terms)]
        except InputError as error:
            return f"{name}: {error}"
        return TermErrors(tuple(measured[1:]), measured[0])


def _signs_as_skeletons(
    recording: EvaluatedRecording, settings: TrackerSettings
) -> list[SkeletonSequence]:
    """What was tracked, with the kinds of joints, then with each term as covariances."""
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
    """[1 + K, J, 3, 3] kinds and terms."""
    kinds = signs.is_behind[:, None, None] * np.eye(3)
    return np.concatenate([kinds[None], signs.terms()])


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
    """The likeliest weights of the terms and tails. Joints behind others count as much as all
    others, and of either kind each recording the same: errors within one are much alike.

    Raises:
        InputError: too few joints of a kind.
    """
    for is_kind, what in (
        (~rows.is_behind, "not behind others"),
        (rows.is_behind, "behind others"),
    ):
        if is_kind.sum() < FEWEST_JOINTS:
            raise InputError(
                f"{is_kind.sum()} joints {what} were found; {FEWEST_JOINTS} are needed: give more "
                "recordings"
            )
    chosen = np.concatenate([_some(rows.is_behind), _some(~rows.is_behind)])
    errors, terms, is_behind = (
        rows.errors_camera[chosen],
        rows.terms[:, chosen],
        rows.is_behind[chosen],
    )
    start = [*[START_LOG_WEIGHT] * len(TERMS), np.log(START_MOST_M2), *[np.log(START_TAILS)] * 2]
    bounds = [*[LOG_WEIGHTS] * (len(TERMS) + 1), *[(np.log(TAILS[0]), np.log(TAILS[1]))] * 2]
    args = errors, terms, is_behind, _shares(is_behind, rows.recording[chosen])
    fitted = minimize(_unlikelihood, start, args, jac=True, bounds=bounds, method="L-BFGS-B")
    return with_counts(_with_laws(source, map(_rounded, np.exp(fitted.x))), rows)


def _with_laws(source: str, values: Iterable[float]) -> JointErrors:
    """Of everything but what is counted, which is not known yet."""
    unknown = (nan,) * len(COUNTED_SHARES)
    return JointErrors(source, *values, nan, nan, unknown, unknown)


def with_counts(told: JointErrors, rows: ErrorRows) -> JointErrors:
    """The same with how large the errors of proposed joints are, of either kind, and ellipsoids that
    hold `KNOWN_HELD` of them; each recording counts the same."""
    is_proposed = rows.terms[:PROPOSED].any((0, 2, 3))
    errors, is_behind = rows.errors_camera[is_proposed], rows.is_behind[is_proposed]
    matrices = told.matrices(rows.terms[:, is_proposed]) + ADDED_M2 * np.eye(3)
    squared = (errors * np.linalg.solve(matrices, errors[..., None])[..., 0]).sum(-1)
    shares = _shares(is_behind, rows.recording[is_proposed])
    (ellipsoid, *in_view), (ellipsoid_behind, *behind) = (
        _weighted_quantiles(squared[is_kind], shares[is_kind], (KNOWN_HELD, *COUNTED_SHARES))
        for is_kind in (~is_behind, is_behind)
    )
    return msgspec.structs.replace(
        told,
        ellipsoid=ellipsoid,
        ellipsoid_behind=ellipsoid_behind,
        squared=tuple(in_view),
        squared_behind=tuple(behind),
    )


def _weighted_quantiles(values: Array, weights: Array, shares: Sequence[float]) -> list[float]:
    found = np.quantile(values, shares, weights=weights, method="inverted_cdf")
    return [_rounded(value) for value in found]


def _rounded(value: float) -> float:
    return float(f"{value:.{SIGNIFICANT_DIGITS}g}")


def _unlikelihood(
    place: Array, errors: Array, terms: Array, is_behind: NDArray[np.bool_], shares: Array
) -> tuple[float, Array]:
    """Minus the mean log-likelihood of [N] joints, each of which counts by its share, and how it
    changes with `place`: the logarithms of `JointErrors`' numbers."""
    told = _with_laws("", np.exp(place))
    limited = told.limited(terms)
    tails = np.where(is_behind, told.tails_behind, told.tails)
    values, by_matrix, by_tails = log_likelihoods(errors, told.matrices(terms), tails)
    by_matrix *= shares[:, None, None]
    by_weight = np.einsum("nab,knab->k", by_matrix, limited)
    stated = limited[:STATED]  # whose derivative by the bound is their square over its own
    by_most = np.einsum("nab,knac,kncb->k", by_matrix, stated, stated, optimize=True)
    by_place = [
        *(told.weights * by_weight),
        told.weights[:STATED] @ by_most / told.most_m2,
        *((shares * by_tails * tails)[is_kind].sum() for is_kind in (~is_behind, is_behind)),
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


def _shares(is_behind: NDArray[np.bool_], recording: NDArray[np.int64]) -> Array:
    """[N] how much each joint counts; 1 together."""
    _, group, counts = np.unique(2 * recording + is_behind, return_inverse=True, return_counts=True)
    shares = 1.0 / counts[group]
    for is_kind in (is_behind, ~is_behind):
        shares[is_kind] *= 0.5 / shares[is_kind].sum()
    return shares


def _some(where: NDArray[np.bool_]) -> NDArray[np.intp]:
    """Indices of so many of them as are fitted to."""
    index = np.flatnonzero(where)
    return index[:: max(1, -(-2 * len(index) // MOST_JOINTS))]
