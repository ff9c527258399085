"""How often the intervals hold that the network states for its joints, as it states them and as
they are trusted; and what `topview.track.familiarity` is fitted to.

    python scripts/fit_familiarity.py RENDERED... [--utd-mhad PATH --sequences GLOBS]

RENDERED are recordings with truth, which the network has not learnt from. Constant offsets are
taken out, one a joint for each set; each of the globs, separated by commas, is a set. With both,
the exponents are fitted: that of the residual is how errors grow with it; with that of the doubt
90 % of the 90 % intervals of the other sets hold on the worst axis of the worst.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final, NamedTuple, cast

import numpy as np
from cyclopts import App
from numpy.typing import NDArray
from scipy.optimize import brentq

from topview.body import OUTPUT_JOINT_NAMES, PART_NAMES
from topview.skeletons import About, SkeletonSequence, TrackedFrame
from topview.track import Tracker, TrackerSettings
from topview.track.familiarity import (
    DOUBT_EXPONENT,
    FIT_EXPONENT,
    LEAST_RESIDUAL,
    widening_of,
)
from topview.track.joint_errors import JointSigns, ray_axes
from topview.track.joint_fit import body_joints
from topview_lab.datasets import EvaluatedRecording, find_folder_recordings, find_utd_mhad
from topview_lab.metrics import Evaluation, SequenceErrors, measure_sequence, pool
from topview_lab.metrics.errors import total_share
from topview_lab.metrics.samples import CAUSES
from topview_lab.training.joints.measuring import HALF_WIDTHS, HIDDEN_FROM, INTERVAL, INTERVALS

Array = NDArray[np.float64]
RANGE: Final = 0.0, 3.0  # in which the doubt's exponent is looked for
BY_OTHERS = [CAUSES.index(cause) for cause in ("another person", "an object")]


class Trust(NamedTuple):
    """`topview.track.familiarity`'s exponents."""

    of_residual: float = FIT_EXPONENT
    of_doubt: float = DOUBT_EXPONENT


AS_STATED: Final = Trust(0.0, 0.0)


@dataclass(frozen=True, slots=True, eq=False)
class Stated:
    """N person-frames of one set.

    Attributes:
        errors: [N, 16, 3] in scales, to the right, down and along the ray.
        residual, doubt: [N] as in `Familiarity`.
        is_hidden: [N, 16] by others.
    """

    errors: Array
    residual: Array
    doubt: Array
    is_hidden: NDArray[np.bool_]

    def trusted(self, told: Trust) -> Array:
        """[N, 16, 3] errors in scales as they are trusted."""
        widening = np.asarray(widening_of(self.residual, self.doubt, *told))
        return self.errors / widening[:, None, None]

    def held(self, told: Trust) -> tuple[Array, Array]:
        """[3] shares of the 90 % intervals, so trusted, that hold: of joints in view, and of those
        hidden by others; NaN of none."""
        errors = self.trusted(told)
        known = np.isfinite(errors).all(-1)
        nothing = np.full(3, np.nan)
        of = [
            errors[known & is_there] < HALF_WIDTHS[INTERVAL]
            for is_there in (~self.is_hidden, self.is_hidden)
        ]
        in_view, hidden = (own.mean(0) if len(own) else nothing for own in of)
        return in_view, hidden


def stated(recordings: Sequence[EvaluatedRecording]) -> Stated:
    """What is stated of the joints of each of these, a frame at a time."""
    of_scales, of_signs = zip(*map(_measured, recordings), strict=True)
    pooled, signs = pool(Evaluation(of_scales)), pool(Evaluation(of_signs)).samples
    samples = pooled.samples
    used = samples.found & np.isfinite(samples.joint_covariance_m2).all((1, 2, 3))
    inverse = np.linalg.inv(ray_axes(samples.predicted_camera[used]))
    errors_m = pooled.corrected_camera[used] - samples.reference_camera[used]
    along = np.einsum("njab,njb->nja", inverse, errors_m)
    squares = np.einsum("njab,njbc,njac->nja", inverse, samples.joint_covariance_m2[used], inverse)
    told = signs.joint_covariance_m2[used][:, 0]
    hidden = np.nan_to_num(total_share(samples.hidden[used][..., BY_OTHERS]))
    errors = np.abs(along) / np.sqrt(squares)
    return Stated(errors, told[:, 0, 0], told[:, 1, 1], hidden >= HIDDEN_FROM)


def _measured(recording: EvaluatedRecording) -> tuple[SequenceErrors, SequenceErrors]:
    """A recording's likeliest joints as proposed, with the squares of their scales in the place of
    covariances; and with what tells familiarity there."""
    tracker = Tracker(TrackerSettings(method="joints", threads=1))
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
    [J, 3, 3] residual and doubt on the diagonal."""
    assert signs.proposals is not None
    places, scales_m = body_joints(signs.proposals, OUTPUT_JOINT_NAMES)
    mode = int(signs.proposals.weights[0].argmax())
    axes = ray_axes(places[mode])
    squares = np.einsum("jab,jb,jcb->jac", axes, scales_m[mode] ** 2, axes)
    told = np.diag([signs.familiarity.residual, signs.familiarity.doubt, 1.0])
    return places[mode], squares, np.broadcast_to(told, squares.shape)


def print_held(name: str, of_set: Stated) -> None:
    """How often 90 % intervals hold, right, down and in depth."""
    for what, told in (("as stated", AS_STATED), ("as trusted", Trust())):
        for where, held in zip(("in view", "hidden"), of_set.held(told), strict=True):
            if np.isfinite(held).all():
                shares = ", ".join(f"{100 * share:.1f}" for share in held)
                print(f"{name}, {where}, {what}: {shares} % hold")
    joints = np.count_nonzero(of_set.is_hidden), of_set.is_hidden.size
    print(f"{name}: {joints[0]} of {joints[1]} joints are hidden; ", end="")
    print(f"median residual {np.median(of_set.residual):.3f}, doubt {np.median(of_set.doubt):.4f}")


def fit(rendered: Stated, others: Sequence[Stated]) -> Trust:
    """How errors grow with the residual; then what makes 90 % of the others' intervals hold."""
    of_residual = residual_exponent([rendered, *others])

    def excess(of_doubt: float) -> float:
        told = Trust(of_residual, of_doubt)
        return min(own.held(told)[0].min() for own in others) - INTERVALS[INTERVAL]

    of_doubt = cast(float, brentq(excess, *RANGE))
    return Trust(round(of_residual, 3), round(of_doubt, 3))


def residual_exponent(sets: Sequence[Stated]) -> float:
    """The logarithm of a person's mean error in a frame, in scales, is linear in the logarithm of
    the residual; each set has a level of its own and counts alike."""
    slopes = [
        np.polyfit(np.log(own.residual + LEAST_RESIDUAL), np.log(np.nanmean(own.errors, (1, 2))), 1)
        for own in sets
    ]
    return float(np.mean(slopes, axis=0)[0])


def main(*rendered: Path, utd_mhad: Path | None = None, sequences: str = "*_s1_*,*_s2_*") -> None:
    """Print how often intervals hold and, with both kinds of sets, what is fitted."""
    own = stated(find_folder_recordings(list(rendered))) if rendered else None
    if own is not None:
        print_held("rendered", own)
    others = []
    if utd_mhad is not None:
        for glob in sequences.split(","):
            others.append(stated(find_utd_mhad(utd_mhad, glob)))
            print_held(f"UTD-MHAD {glob}", others[-1])
    if own is not None and others:
        print(f"fitted: {fit(own, others)}")


if __name__ == "__main__":
    app = App()
    app.default(main)
    app()
