"""How often the intervals hold that the network states for its joints, as it states them and
widened where windows look unfamiliar; and what `topview.track.familiarity` is fitted to.

    python scripts/fit_familiarity.py RENDERED... [--utd-mhad PATH --sequences GLOBS]

RENDERED are recordings with truth. Constant offsets are taken out, one a joint for each set. With
both sets the exponents are fitted. That of the residual: the logarithm of a person's mean error in
a frame, in scales, is linear in the logarithms of residual and doubt; each set has half of the
weight. That of the doubt: with it, 90 % of the intervals of the second set hold.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from cyclopts import App
from numpy.typing import NDArray

from topview.body import OUTPUT_JOINT_NAMES, PART_NAMES
from topview.skeletons import About, SkeletonSequence, TrackedFrame
from topview.track import Tracker, TrackerSettings
from topview.track.familiarity import LEAST_DOUBT, LEAST_RESIDUAL, Familiarity
from topview.track.joint_errors import JointSigns
from topview.track.joint_fit import body_joints
from topview_lab.datasets import EvaluatedRecording, find_folder_recordings, find_utd_mhad
from topview_lab.metrics import Evaluation, SequenceErrors, measure_sequence, pool
from topview_lab.metrics.errors import total_share
from topview_lab.metrics.samples import CAUSES
from topview_lab.training.joints.measuring import HALF_WIDTHS, HIDDEN_FROM, INTERVAL, INTERVALS

Array = NDArray[np.float64]
BY_OTHERS = [CAUSES.index(cause) for cause in ("another person", "an object")]


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

    @property
    def features(self) -> Array:
        """[N, 3] what the logarithm of the error is linear in."""
        logs = np.log(self.residual + LEAST_RESIDUAL), np.log(self.doubt + LEAST_DOUBT)
        return np.stack([np.ones(len(self.residual)), *logs], axis=1)

    @property
    def widening(self) -> Array:
        """[N]."""
        told = zip(self.residual.tolist(), self.doubt.tolist(), strict=True)
        return np.array([Familiarity(*own).widening for own in told])


def stated(recordings: Sequence[EvaluatedRecording]) -> Stated:
    """What is stated of the joints of each of these, a frame at a time."""
    of_scales, of_signs = zip(*map(_measured, recordings), strict=True)
    pooled, signs = pool(Evaluation(of_scales)), pool(Evaluation(of_signs)).samples
    samples = pooled.samples
    used = samples.found & np.isfinite(samples.joint_covariance_m2).all((1, 2, 3))
    inverse = np.linalg.inv(_ray_axes(samples.predicted_camera[used]))
    errors_m = pooled.corrected_camera[used] - samples.reference_camera[used]
    along = np.einsum("njab,njb->nja", inverse, errors_m)
    squares = np.einsum("njab,njbc,njac->nja", inverse, samples.joint_covariance_m2[used], inverse)
    told = signs.joint_covariance_m2[used][:, 0]
    hidden = np.nan_to_num(total_share(samples.hidden[used][..., BY_OTHERS]))
    return Stated(along / np.sqrt(squares), told[:, 0, 0], told[:, 1, 1], hidden >= HIDDEN_FROM)


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
    axes = _ray_axes(places[mode])
    squares = np.einsum("jab,jb,jcb->jac", axes, scales_m[mode] ** 2, axes)
    told = np.diag([signs.familiarity.residual, signs.familiarity.doubt, 1.0])
    return places[mode], squares, np.broadcast_to(told, squares.shape)


def _ray_axes(joints_camera: Array) -> Array:
    """[..., 3, 3] whose columns point right, down, and along the ray by a metre of depth."""
    axes = np.broadcast_to(np.eye(3), (*joints_camera.shape, 3)).copy()
    axes[..., 2] = joints_camera / joints_camera[..., 2:]
    return axes


def print_held(name: str, of_set: Stated) -> None:
    """How often 90 % intervals hold, right, down and in depth."""
    half = HALF_WIDTHS[INTERVAL]
    for what, factor in (("as stated", np.ones(len(of_set.errors))), ("widened", of_set.widening)):
        errors = np.abs(of_set.errors) / factor[:, None, None]
        for where, mask in (("in view", ~of_set.is_hidden), ("hidden", of_set.is_hidden)):
            chosen = errors[mask]
            chosen = chosen[np.isfinite(chosen).all(-1)]
            if len(chosen):
                held = ", ".join(f"{100 * share:.1f}" for share in (chosen < half).mean(0))
                print(f"{name}, {where}, {what}: {held} % of {len(chosen)} joints")
    print(f"{name}: median residual {np.median(of_set.residual):.3f}, ", end="")
    print(f"doubt {np.median(of_set.doubt):.4f}, widening {np.median(of_set.widening):.2f}")


def fit(sets: Sequence[Stated]) -> tuple[float, float]:
    """Exponents of residual and doubt."""
    error = np.concatenate([np.log(np.nanmean(np.abs(own.errors), (1, 2))) for own in sets])
    features = np.concatenate([own.features for own in sets])
    weight = np.concatenate([np.full(len(own.errors), len(own.errors) ** -0.5) for own in sets])
    of_residual = float(np.linalg.lstsq(features * weight[:, None], error * weight)[0][1])
    familiar, other = (own.features[:, 1:] for own in sets)
    residual, doubt = (other - np.median(familiar, axis=0)).T

    def held(of_doubt: float) -> float:
        widening = np.maximum(1.0, np.exp(of_residual * residual + of_doubt * doubt))
        errors = np.abs(sets[1].errors) / widening[:, None, None]
        return float((errors[np.isfinite(errors)] < HALF_WIDTHS[INTERVAL]).mean())

    tried = np.arange(0.0, 1.0, 0.005)
    return of_residual, float(min(tried, key=lambda own: abs(held(own) - INTERVALS[INTERVAL])))


def main(*rendered: Path, utd_mhad: Path | None = None, sequences: str = "*_s1_*,*_s2_*") -> None:
    """Print how often intervals hold and, with both sets, the exponents."""
    sets = {}
    if rendered:
        sets["rendered"] = stated(find_folder_recordings(list(rendered)))
    if utd_mhad is not None:
        sets["UTD-MHAD"] = stated(find_utd_mhad(utd_mhad, sequences))
    for name, of_set in sets.items():
        print_held(name, of_set)
    if len(sets) == 2:
        residual, doubt = fit(list(sets.values()))
        print(f"exponents: residual {residual:.3f}, doubt {doubt:.3f}")


if __name__ == "__main__":
    app = App()
    app.default(main)
    app()
