"""How often the intervals hold that the network states for its joints, as it states them and as
they are trusted; and what `topview.track.familiarity` is fitted to.

    python scripts/fit_familiarity.py RENDERED... [--utd-mhad PATH --sequences GLOBS]
        [--weights FILE]

RENDERED are recordings with truth, which the network has not learnt from; FILE is another network
than the one that ships. Constant offsets are taken out, one a joint for each set; each of the
globs, separated by commas, is a set. With both, how errors grow with the residual, with
disagreement and towards cover is what makes all errors likeliest, each set at a level of its own,
hidden joints counting as much as those in view. Then two are found that make intervals hold: with
the doubt's exponent 90 % of UTD-MHAD's 90 % intervals, on the worst axis of the worst set; with the
familiar disagreement so many of those of rendered joints in view that 90 % would be left if the
people had other proportions. For the network knows the rendered people. Their windows, as they are
and stretched at random as it has learnt them, tell how much less holds of people whom it does not
know.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from math import log
from pathlib import Path
from typing import Final, NamedTuple, cast

import numpy as np
from cyclopts import App
from numpy.typing import NDArray
from scipy.optimize import brentq, minimize

from topview.body import OUTPUT_JOINT_NAMES, PART_NAMES
from topview.detect.joints.network import WEIGHTS, opened
from topview.detect.joints.proposals import proposed_of_joints
from topview.skeletons import About, SkeletonSequence, TrackedFrame
from topview.track import Tracker, TrackerSettings
from topview.track.familiarity import (
    COVER_EXPONENT,
    COVER_REACH_M,
    DISAGREEMENT_EXPONENT,
    DOUBT_EXPONENT,
    FAMILIAR_DISAGREEMENT,
    FAMILIAR_RESIDUAL,
    FIT_EXPONENT,
    LEAST_RESIDUAL,
    widening_beside,
    widening_of,
    widening_unsteady,
)
from topview.track.joint_errors import JointSigns
from topview.track.joint_fit import body_joints
from topview_lab.datasets import EvaluatedRecording, find_folder_recordings, find_utd_mhad
from topview_lab.evaluate.run import run_all
from topview_lab.metrics import Evaluation, SequenceErrors, measure_sequence, pool
from topview_lab.metrics.errors import total_share
from topview_lab.metrics.samples import CAUSES
from topview_lab.training.joints.measuring import (
    HALF_WIDTHS,
    HIDDEN_FROM,
    INTERVAL,
    INTERVALS,
    Network,
    answer_to,
)
from topview_lab.training.joints.recordings import Samples, folders_in, gathered, read_labelled
from topview_lab.training.joints.windows import AS_THEY_ARE, Variation

Array = NDArray[np.float64]
RANGE: Final = 0.0, 3.0  # in which the doubt's exponent is looked for
FAMILIAR_RANGE: Final = 0.02, 5.0  # in which the familiar disagreement is
OTHER_PROPORTIONS: Final = replace(AS_THEY_ARE, stretch=Variation().stretch)
COMPARED_WINDOWS: Final = 3000  # with people as they are and stretched
STEP: Final = 0.1  # of exponents and logarithms, at first, where the likeliest are looked for
FAR_M: Final = 100.0  # from others, where there are none
BY_OTHERS = [CAUSES.index(cause) for cause in ("another person", "an object")]
FIRST, SECOND = (0, 0, 1), (1, 2, 2)  # rows and columns beside a diagonal


class Trust(NamedTuple):
    """`topview.track.familiarity`'s parameters."""

    of_residual: float = FIT_EXPONENT
    of_doubt: float = DOUBT_EXPONENT
    of_disagreement: float = DISAGREEMENT_EXPONENT
    of_cover: float = COVER_EXPONENT
    reach_m: float = COVER_REACH_M
    familiar: float = FAMILIAR_DISAGREEMENT

    def of_joints(self, told: Stated) -> Array:
        """[N, J, 3] what scales of N people's joints are multiplied by, whoever the people are."""
        unsteady = widening_unsteady(told.disagreement, self.of_disagreement, self.familiar)
        return unsteady * widening_beside(told.to_cover_m, self.of_cover, self.reach_m)[..., None]

    def widening(self, told: Stated) -> Array:
        """[N, J, 3] of N people's scales."""
        of_person = np.asarray(
            widening_of(told.residual, told.doubt, self.of_residual, self.of_doubt)
        )
        return of_person[:, None, None] * self.of_joints(told)


AS_STATED: Final = Trust(0.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True, eq=False)
class Stated:
    """N person-frames of one set.

    Attributes:
        errors: [N, 16, 3] in scales, to the right, down and along the ray.
        residual, doubt: [N] as in `Familiarity`.
        disagreement: [N, 16, 3] as in `Familiarity`, the familiar one where there is none.
        to_cover_m: [N, 16] as in `JointProposals`.
        is_hidden: [N, 16] by others.
    """

    errors: Array
    residual: Array
    doubt: Array
    disagreement: Array
    to_cover_m: Array
    is_hidden: NDArray[np.bool_]

    def trusted(self, told: Trust) -> Array:
        """[N, 16, 3] errors in scales as they are trusted."""
        return self.errors / told.widening(self)

    def held(self, told: Trust, interval: int = INTERVAL) -> tuple[Array, Array]:
        """[3] shares of the 90 % intervals, or other `INTERVALS`, so trusted, that hold: of joints
        in view, and of those hidden by others; NaN of none."""
        errors = self.trusted(told)
        known = np.isfinite(errors).all(-1)
        nothing = np.full(3, np.nan)
        of = [
            errors[known & is_there] < HALF_WIDTHS[interval]
            for is_there in (~self.is_hidden, self.is_hidden)
        ]
        in_view, hidden = (own.mean(0) if len(own) else nothing for own in of)
        return in_view, hidden


def stated(recordings: Sequence[EvaluatedRecording], weights: Path | None = None) -> Stated:
    """What is stated of the joints of each of these, a frame at a time."""
    done = run_all([partial(_measured, each, weights) for each in recordings])
    if done.problems or done.interrupted:
        raise SystemExit("; ".join(done.problems) or "stopped")
    of_scales, of_signs = zip(*(each for each in done.results if each is not None), strict=True)
    pooled, signs = pool(Evaluation(of_scales)), pool(Evaluation(of_signs)).samples
    samples = pooled.samples
    used = samples.found & np.isfinite(samples.joint_covariance_m2).all((1, 2, 3))
    inverse = np.linalg.inv(ray_axes(samples.predicted_camera[used]))
    errors_m = pooled.corrected_camera[used] - samples.reference_camera[used]
    along = np.einsum("njab,njb->nja", inverse, errors_m)
    squares = np.einsum("njab,njbc,njac->nja", inverse, samples.joint_covariance_m2[used], inverse)
    told = np.diagonal(signs.joint_covariance_m2[used], axis1=-2, axis2=-1)
    hidden = np.nan_to_num(total_share(samples.hidden[used][..., BY_OTHERS]))
    errors = np.abs(along) / np.sqrt(squares)
    residual, doubt, to_cover_m = told[:, 0, 0], told[:, 0, 1], told[..., 2]
    disagreement = signs.joint_covariance_m2[used][..., FIRST, SECOND]
    return Stated(errors, residual, doubt, disagreement, to_cover_m, hidden >= HIDDEN_FROM)


def _measured(
    recording: EvaluatedRecording, weights: Path | None
) -> tuple[SequenceErrors, SequenceErrors]:
    """A recording's likeliest joints as proposed, with the squares of their scales in the place of
    covariances; and with what tells familiarity there."""
    tracker = Tracker(TrackerSettings(method="joints", threads=1, weights=weights))
    about = About(OUTPUT_JOINT_NAMES, PART_NAMES)
    frames: tuple[list[TrackedFrame], list[TrackedFrame]] = [], []
    for frame in recording.open():
        people = [
            (person, signs)
            for person in tracker.update(frame)
            if (signs := tracker.joint_signs[person.id]).proposals is not None
        ]
        for kind, of_kind in enumerate(frames):
            told = []
            for person, signs in people:
                joints_camera, *matrices = _proposed(signs)
                as_told = {
                    "joints_camera": joints_camera.astype(np.float32),
                    "joint_covariance_m2": matrices[kind].astype(np.float32),
                }
                told.append(replace(person, **as_told))
            packed = about.packed(told)
            of_kind.append(TrackedFrame(frame.index, frame.timestamp_s, frame.name, packed))
    reference = recording.reference()
    scales, told = (
        measure_sequence(SkeletonSequence.from_frames(own, about), reference, recording.name)
        for own in frames
    )
    return scales, told


def _proposed(signs: JointSigns) -> tuple[Array, Array, Array]:
    """[J, 3] the likeliest joints, [J, 3, 3] the squares of their scales in the camera frame, and
    [J, 3, 3] residual, doubt and the distance to cover on the diagonal, disagreement beside it."""
    assert signs.proposals is not None
    assert signs.proposals.to_cover_m is not None
    places, scales_m = body_joints(signs.proposals, OUTPUT_JOINT_NAMES)
    mode = int(signs.proposals.weights[0].argmax())
    axes = ray_axes(places[mode])
    squares = np.einsum("jab,jb,jcb->jac", axes, scales_m[mode] ** 2, axes)
    told = np.zeros_like(squares)
    told[:, 0, 0], told[:, 1, 1] = signs.familiarity.residual, signs.familiarity.doubt
    proposed = proposed_of_joints(signs.proposals.joint_names, OUTPUT_JOINT_NAMES)
    told[:, 2, 2] = np.minimum(signs.proposals.to_cover_m[0, mode, proposed], FAR_M)
    disagreement = signs.familiarity.disagreement
    told[:, FIRST, SECOND] = FAMILIAR_DISAGREEMENT
    if disagreement is not None:
        told[:, FIRST, SECOND] = disagreement[proposed]
    return places[mode], squares, told


def ray_axes(joints_camera: Array) -> Array:
    """[..., 3, 3] whose columns point right, down, and along the ray by a metre of depth, of
    [..., 3] joints."""
    axes = np.broadcast_to(np.eye(3), (*joints_camera.shape, 3)).copy()
    axes[..., 2] = joints_camera / joints_camera[..., 2:]
    return axes


def print_held(name: str, of_set: Stated) -> None:
    """How often 90 % intervals hold, right, down and in depth; and all, as trusted."""
    for what, told in (("as stated", AS_STATED), ("as trusted", Trust())):
        for where, held in zip(("in view", "hidden"), of_set.held(told), strict=True):
            if np.isfinite(held).all():
                shares = ", ".join(f"{100 * share:.1f}" for share in held)
                print(f"{name}, {where}, {what}: {shares} % hold")
    for number, interval in enumerate(INTERVALS):
        told = zip(("in view", "hidden"), of_set.held(Trust(), number), strict=True)
        shares = [f"{100 * of.mean():.1f} % {where}" for where, of in told if np.isfinite(of).all()]
        print(f"{name}, {100 * interval:.0f} % as trusted: {', '.join(shares)}")
    joints = np.count_nonzero(of_set.is_hidden), of_set.is_hidden.size
    print(f"{name}: {joints[0]} of {joints[1]} joints are hidden; ", end="")
    print(f"median residual {np.median(of_set.residual):.3f}, doubt {np.median(of_set.doubt):.4f}")


def known_shares(recordings: Samples, weights: Path) -> tuple[float, float]:
    """Shares that have to hold of people as they are for 90 % to hold of those with other
    proportions, of joints in view: of intervals, and of ellipsoids."""
    network = opened(weights.read_bytes()).answers
    known, other = (
        _in_scales(network, recordings, how) for how in (AS_THEY_ARE, OTHER_PROPORTIONS)
    )
    return _share_below(known, other), _share_below(_squared(known), _squared(other))


def _share_below(known: Array, other: Array) -> float:
    return float(np.mean(known < np.quantile(other, INTERVALS[INTERVAL])))


def _squared(errors: Array) -> Array:
    return (errors**2).sum(-1)


def _in_scales(network: Network, samples: Samples, how: Variation) -> Array:
    """[N, 3] errors of windows' joints in view, in scales, offsets out."""
    off, scales = [], []
    for number in range(0, len(samples), max(1, len(samples) // COMPARED_WINDOWS)):
        answer = answer_to(network, samples, number, how)
        is_hidden = answer.window.hidden >= HIDDEN_FROM
        off.append(np.where(is_hidden[:, None], np.nan, answer.off))
        scales.append(answer.scales)
    errors = np.abs(off - np.nanmean(off, axis=0)) / scales
    return errors.reshape(-1, 3)[np.isfinite(errors).all(-1).ravel()]


def fit(rendered: Stated, others: Sequence[Stated], known_held: float) -> Trust:
    """What makes errors likeliest; then what makes intervals hold, so many of rendered people."""
    likeliest = likeliest_trust([rendered, *others])

    def too_many(familiar: float, told: Trust) -> float:
        return float(rendered.held(told._replace(familiar=familiar))[0].mean()) - known_held

    def with_doubt(of_doubt: float) -> Trust:
        told = likeliest._replace(of_doubt=of_doubt)
        return told._replace(familiar=cast(float, brentq(too_many, *FAMILIAR_RANGE, (told,))))

    def excess(of_doubt: float) -> float:
        told = with_doubt(of_doubt)
        return min(own.held(told)[0].min() for own in others) - INTERVALS[INTERVAL]

    if excess(RANGE[0]) > 0.0 or excess(RANGE[1]) < 0.0:
        raise SystemExit(
            f"no exponent of the doubt in {RANGE} makes 90 % of the worst set's intervals hold: fit"
            " the network's layers that tell people first (topview train-people)"
        )
    found = with_doubt(cast(float, brentq(excess, *RANGE)))
    return Trust(*(round(float(value), 3) for value in found))


def likeliest_trust(sets: Sequence[Stated]) -> Trust:
    """What makes the errors likeliest, without the doubt, each set at a level of its own and all
    sets of the same weight."""

    def trust_of(parameters: Array) -> Trust:
        of_residual, of_disagreement, of_cover, log_reach = parameters[:4]
        return Trust(of_residual, 0.0, of_disagreement, of_cover, float(np.exp(log_reach)))

    def surprise(parameters: Array) -> float:
        told = trust_of(parameters)
        return sum(map(_surprise, sets, [told] * len(sets), parameters[4:]))

    exponents = [FIT_EXPONENT, DISAGREEMENT_EXPONENT, COVER_EXPONENT, np.log(COVER_REACH_M)]
    start = np.array([*exponents, *np.zeros(len(sets))])
    simplex = {"initial_simplex": [start, *(start + STEP * np.eye(len(start)))]}
    return trust_of(minimize(surprise, start, method="Nelder-Mead", options=simplex).x)


def _surprise(of_set: Stated, told: Trust, level: float) -> float:
    """Negative logarithm of the logistic law's density (see `HALF_WIDTHS`) of the errors, the mean
    of the means over joints in view and hidden ones."""
    residual = (of_set.residual + LEAST_RESIDUAL) / (FAMILIAR_RESIDUAL + LEAST_RESIDUAL)
    log_scales = level + told.of_residual * np.log(residual)[:, None, None]
    log_scales = log_scales + np.log(told.of_joints(of_set))
    z = of_set.errors / np.exp(log_scales) * (log(3.0) / log(2.0))
    surprises = z + 2.0 * np.log1p(np.exp(-z)) + log_scales
    where = [~of_set.is_hidden, of_set.is_hidden]
    return float(np.mean([np.nanmean(surprises[there]) for there in where if there.any()]))


def main(
    *rendered: Path,
    utd_mhad: Path | None = None,
    sequences: str = "*_s1_*,*_s2_*",
    weights: Path | None = None,
) -> None:
    """Print how often intervals hold and, with both kinds of sets, what is fitted."""
    own = stated(find_folder_recordings(list(rendered)), weights) if rendered else None
    if own is not None:
        print_held("rendered", own)
    others = []
    if utd_mhad is not None:
        for glob in sequences.split(","):
            others.append(stated(find_utd_mhad(utd_mhad, glob), weights))
            print_held(f"UTD-MHAD {glob}", others[-1])
    if own is not None and others:
        samples = gathered([read_labelled(each) for each in folders_in(rendered)])
        known_held, in_ellipsoids = known_shares(samples, weights or WEIGHTS)
        print(f"{100 * known_held:.1f} % have to hold of people whom the network knows,")
        print(f"{100 * in_ellipsoids:.1f} % of ellipsoids (`KNOWN_HELD` of train-confidence)")
        print(f"fitted: {fit(own, others, known_held)}")


if __name__ == "__main__":
    app = App()
    app.default(main)
    app()
