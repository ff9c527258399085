"""How far joints may be off: a covariance each, and from it the probability of 10 cm (ours).

A joint's error has a matrix: a sum of terms that the frame tells (`JointSigns.terms`), each with a
weight that `topview train-confidence` has fitted, as of a multivariate Student law. However unsure
a proposal is, the body is where it is: what it states is bounded. How many errors are how large, in
units of the matrix, was counted: no Student law has as many that are far too large and as few
between these and the usual ones. What is told as the covariance is scaled so that the ellipsoid
that would hold 90 % of a Gaussian law's errors holds 90 % of these.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from importlib import resources
from typing import Final

import msgspec
import numpy as np
from numpy.typing import NDArray

from topview.body.parts import (
    LEFT_FOREARM,
    LEFT_UPPER_ARM,
    OUTPUT_JOINT_NAMES,
    OUTPUT_JOINTS,
    RIGHT_FOREARM,
    RIGHT_UPPER_ARM,
)
from topview.detect.joints import JointProposals
from topview.geometry.rotations import lengths
from topview.kernels.joint_errors import fill_terms
from topview.records import JointState, read_only
from topview.track.familiarity import FAMILIAR, Familiarity
from topview.track.joint_fit import body_joints
from topview.track.visibility import Visibility

Array = NDArray[np.float64]

JOINT_ERRORS_FILE: Final = "joint_errors.json"
RIGHT_M: Final = 0.1  # `joint_confidence` is the probability of an error up to this
ELLIPSOID_SHARE: Final = 0.9  # of the errors, that the ellipsoids hold which the covariance is for
ELLIPSOID: Final = 6.2514  # squared radius of a Gaussian's, by chi-square with 3 degrees of freedom
# Of the errors, that are no larger than what `ErrorLaw.squared` holds. Ours.
COUNTED_SHARES: Final = (
    *(0.01, 0.02, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.85, 0.9, 0.93, 0.95),
    *(0.97, 0.98, 0.99, 0.995, 0.998),
)
HIDDEN_MEMORY_S: Final = 1.0  # ours; after which a joint that is not seen may be anywhere, for 63 %

TERMS: Final = (
    *("proposed", "behind", "arms_behind", "apart"),
    *("place", "swing", "unconfirmed", "lost"),
)
STATED: Final = 3  # of these, the first, are what the proposals state
PROPOSED: Final = 4  # of these, the first, are of joints that are proposed

# Lebedev's rule of 26 directions, exact up to degree 7; one of each opposite pair, with twice its
# weight.
_DIRECTIONS = np.array(
    [
        *((1, 0, 0), (0, 1, 0), (0, 0, 1)),
        *((1, 1, 0), (1, -1, 0), (1, 0, 1), (1, 0, -1), (0, 1, 1), (0, 1, -1)),
        *((1, 1, 1), (1, 1, -1), (1, -1, 1), (-1, 1, 1)),
    ],
    np.float64,
)
_DIRECTIONS /= np.linalg.norm(_DIRECTIONS, axis=1, keepdims=True)
_SHARES = 2.0 * np.repeat([1 / 21, 4 / 105, 9 / 280], [3, 6, 4])
_BONE_TO = [joint.bone_to for joint in OUTPUT_JOINTS]


def _limb_bones(index: int) -> list[int]:
    """The joints whose bones lead from the limb's first joint to this one; none on the trunk."""
    before = _BONE_TO[index]
    if before < 0 or "_" not in OUTPUT_JOINTS[before].name:
        return []
    return [index, *_limb_bones(before)]


_ALL = range(len(OUTPUT_JOINTS))
_LIMB_BONES = np.array([[float(j in _limb_bones(index)) for j in _ALL] for index in _ALL])
_ARMS = (LEFT_UPPER_ARM, LEFT_FOREARM, RIGHT_UPPER_ARM, RIGHT_FOREARM)
_IS_ON_ARM = _LIMB_BONES.any(1) & np.array([joint.part in _ARMS for joint in OUTPUT_JOINTS])


class ErrorLaw(msgspec.Struct, frozen=True):
    """How large the errors of one kind of joints are, in units of their matrices.

    Attributes:
        tails: degrees of freedom of the Student law that the weights were fitted as of; fewer have
            more errors that are far too large.
        ellipsoid: squared radius of the ellipsoid that holds `ELLIPSOID_SHARE` of the errors, of
            people whom the proposer has not learnt.
        squared: squares than which `COUNTED_SHARES` of the errors are not larger.
    """

    tails: float
    ellipsoid: float
    squared: tuple[float, ...]


class JointErrors(msgspec.Struct, frozen=True):
    """How much each term counts; of joints that are proposed, and of those that are not.

    Attributes:
        source: what it was fitted on.
        laws: of the kinds of joints (`kinds_of`).
        proposed: of the variance that the proposals state, of joints not behind another person.
        behind: the same of joints behind another person.
        arms_behind: so much more of those on arms, which go where they like.
        apart: of the squared ways from the joint to where the modes have it.
        place_m2: of joints that are not proposed.
        swing_rad2: of these, on limbs: variance of the angle at which the joint is seen from where
            the limb begins.
        unconfirmed_m2: of these, where nothing is seen of them.
        lost_m2: of these, hidden for long by others or things, or out of view.
        most_m2: that the variances which the proposals state come near to, at the most.
    """

    source: str
    laws: tuple[ErrorLaw, ...]
    proposed: float
    behind: float
    arms_behind: float
    apart: float
    place_m2: float
    swing_rad2: float
    unconfirmed_m2: float
    lost_m2: float
    most_m2: float

    @property
    def weights(self) -> Array:
        """[K] of `TERMS`."""
        return np.array(
            [
                *(self.proposed, self.behind, self.arms_behind, self.apart),
                *(self.place_m2, self.swing_rad2, self.unconfirmed_m2, self.lost_m2),
            ]
        )

    def matrices(self, terms: Array) -> Array:
        """[N, 3, 3] of the laws, of [K, N, 3, 3] `TERMS`."""
        return np.einsum("k,knab->nab", self.weights, self.limited(terms))

    def limited(self, terms: Array) -> Array:
        """[K, N, 3, 3] `TERMS`, of which what the proposals state is bounded."""
        return np.concatenate([bounded(terms[:STATED], self.most_m2), terms[STATED:]])

    def ellipsoids_of(self, kinds: NDArray[np.int64]) -> Array:
        """[N] squared radii, in units of the matrices, of the ellipsoids that hold
        `ELLIPSOID_SHARE` of the errors of joints of [N] kinds."""
        return np.array([law.ellipsoid for law in self.laws])[kinds]

    def shares_within(self, squared: Array, kinds: NDArray[np.int64]) -> Array:
        """[N, D] shares of the errors of joints of [N] kinds that are no larger than so many units
        of their matrices; never less or more than the least and the most of `COUNTED_SHARES`."""
        logs, shares = np.log(squared), np.empty(squared.shape)
        for kind, law in enumerate(self.laws):
            is_kind = kinds == kind
            shares[is_kind] = np.interp(logs[is_kind], np.log(law.squared), COUNTED_SHARES)
        return shares


def kinds_of(is_proposed: NDArray[np.bool_], is_behind: NDArray[np.bool_]) -> NDArray[np.int64]:
    """[N] which of `JointErrors.laws` joints follow: that are proposed, or not, in either case not
    behind another person, or behind one."""
    return np.where(is_proposed, 0, 2) + is_behind


@cache
def shipped_joint_errors() -> JointErrors:
    """The one that the package carries."""
    text = resources.files("topview.track").joinpath(JOINT_ERRORS_FILE).read_bytes()
    return msgspec.json.decode(text, type=JointErrors)


@dataclass(frozen=True, slots=True, eq=False)
class JointSigns:
    """What a frame tells of how far one person's joints may be off.

    Attributes:
        joints_camera: [J, 3] metres, as tracked.
        visibility: of the joints.
        hidden_for_s: [J] since each was last visible and some of it confirmed; infinite if never.
        proposals: of the joints, P = 1; None where nothing is proposed.
        familiarity: how far the proposals can be relied on.
    """

    joints_camera: Array
    visibility: Visibility
    hidden_for_s: Array
    proposals: JointProposals | None
    familiarity: Familiarity = FAMILIAR

    @property
    def is_behind(self) -> NDArray[np.bool_]:
        """[J] whether another person hides the joint."""
        return self.visibility.joint_state == JointState.OCCLUDED_BY_PERSON

    def terms(self) -> Array:
        """[K, J, 3, 3] of `TERMS`, square metres in the camera frame."""
        levers_m, unconfirmed = _levers(self.joints_camera), 1.0 - self.visibility.confirmed
        factors = np.array([np.ones(len(levers_m)), levers_m**2, unconfirmed, self._lost])
        places, scales_m, weights = self._proposed()
        terms = np.zeros((len(TERMS), len(levers_m), 3, 3))
        fill_terms(
            self.joints_camera, self.is_behind, _IS_ON_ARM, factors, places, scales_m, weights,
            terms,
        )  # fmt: skip
        return terms

    def _proposed(self) -> tuple[Array, Array, Array]:
        """[M, J, 3] proposed places, their scales as they are trusted, both in metres, and [M] the
        weights of the modes; of none where nothing is proposed."""
        proposals = self.proposals
        if proposals is None:
            nothing = np.zeros((0, *self.joints_camera.shape))
            return nothing, nothing, read_only(np.zeros(0))
        trusted_m = self.familiarity.trusted_scales_m(proposals)
        return *body_joints(proposals, OUTPUT_JOINT_NAMES, trusted_m), proposals.weights[0]

    @property
    def _lost(self) -> Array:
        """[J] 0..1: how long a joint has not been seen; 0 behind the own body, which tells where it
        is."""
        is_behind_own = self.visibility.joint_state == JointState.SELF_OCCLUDED
        return np.where(is_behind_own, 0.0, 1.0) * -np.expm1(-self.hidden_for_s / HIDDEN_MEMORY_S)


def told_errors(
    signs: JointSigns, errors: JointErrors
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """[J, 3, 3] covariances in square metres, camera frame, and [J] confidences, 0..1; NaN and 0
    of joints that are absent."""
    terms = signs.terms()
    kinds = kinds_of(are_proposed(terms), signs.is_behind)
    is_absent = signs.visibility.joint_state == JointState.ABSENT
    covariances = ellipsoid_covariances(errors.matrices(terms), errors.ellipsoids_of(kinds))
    covariances[is_absent] = np.nan
    confidences = np.where(is_absent, 0.0, confidences_of(covariances, kinds, errors))
    return covariances.astype(np.float32), confidences.astype(np.float32)


def are_proposed(terms: Array) -> NDArray[np.bool_]:
    """[N] which joints are proposed, of their [K, N, 3, 3] `TERMS`."""
    return np.asarray(terms[:PROPOSED].any((0, 2, 3)))


def bounded(matrices: Array, most: float) -> Array:
    """[..., 3, 3] matrices as they are where they are small, and nearly `most` along the axes along
    which they are large."""
    less = matrices @ np.linalg.inv(np.eye(3) + matrices / most)
    return 0.5 * (less + np.swapaxes(less, -1, -2))


def ellipsoid_covariances(matrices: Array, ellipsoids: Array) -> Array:
    """[N, 3, 3] covariances whose Gaussian ellipsoids of `ELLIPSOID_SHARE` are those of [N] squared
    radii in units of [N, 3, 3] matrices."""
    return matrices * (ellipsoids / ELLIPSOID)[:, None, None]


def confidences_of(covariances_m2: Array, kinds: NDArray[np.int64], errors: JointErrors) -> Array:
    """[N] probabilities that an error is at most `RIGHT_M`, of [N, 3, 3] `ellipsoid_covariances` of
    joints of [N] kinds; NaN where a covariance is.

    An error is a direction and a length, independent of each other in units of the matrix. The mean
    over directions is taken at 13 of them, which is good to 0.02 for ellipsoids up to four times as
    long as they are thick.
    """
    matrices = covariances_m2 * (ELLIPSOID / errors.ellipsoids_of(kinds))[:, None, None]
    axes = _roots(matrices)
    lengths_m2 = ((axes @ _DIRECTIONS.T) ** 2).sum(-2)
    return errors.shares_within(RIGHT_M**2 / lengths_m2, kinds) @ _SHARES


def _roots(matrices: Array) -> Array:
    """[N, 3, 3] whose product with their own transpose is each matrix; NaN of NaN."""
    is_known = np.isfinite(matrices).all((-2, -1))
    roots = np.full(matrices.shape, np.nan)
    roots[is_known] = np.linalg.cholesky(matrices[is_known])
    return roots


def _levers(joints_camera: Array) -> Array:
    """[J] metres along the bones from where each joint's limb begins; 0 on the trunk."""
    bones_m = lengths(joints_camera - joints_camera[_BONE_TO])
    bones_m[np.isnan(bones_m)] = 0.0
    return _LIMB_BONES @ bones_m
