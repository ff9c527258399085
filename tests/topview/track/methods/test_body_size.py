"""A person's stature and thickness are learnt from the surface that is seen."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from rendered_bodies import MODEL, at_frame, evidence_of, standing_pose
from topview.body.model import BodyModel
from topview.body.parts import PARTS
from topview.body.proportions import ANATOMICAL
from topview.body.surface import THINNEST_M, Surface, straight
from topview.geometry.rotations import rotations_from_vectors
from topview.kernels.sizes import N_TOLD, sum_up_surface
from topview.track.bone_lengths import BoneLengths
from topview.track.degrees_of_freedom import DOF_AXIS, DOF_PART, N_DOFS
from topview.track.methods.topview.body_size import (
    N_SIZES,
    OF_STATURE,
    SIZE_GROUPS,
    BodySize,
    _shares,
)
from topview.track.methods.topview.refinement import RefinementSettings, refine
from topview.track.pose import Pose
from topview.track.stature import StatureBelief
from topview.track.surfaces import NearestSurfaces, nearest_surfaces

SETTINGS = RefinementSettings()
POSE = standing_pose()


class Bones(BoneLengths):
    """Of the bodies that are rendered here."""

    def model(self, stature_m: float) -> BodyModel:
        return BodyModel.of(stature_m, ANATOMICAL)


def thickened(by_m: float) -> BodyModel:
    """Of the same bones, as it is rendered and as it is fitted."""
    model = MODEL.thicker(np.full(len(PARTS), by_m))
    return replace(model, radii_m=MODEL.radii_m + by_m)


def learnt(model: BodyModel, belief: StatureBelief, frames: int = 40) -> BodySize:
    """From a body like this that stands still, and is fitted in each frame."""
    size = BodySize(Bones(), belief, SETTINGS)
    evidence = evidence_of(POSE, model)
    pose = POSE
    for frame in range(frames):
        own = size.model(belief.stature_m)
        pose = refine([pose], None, own, evidence, SETTINGS).poses[0]
        size.update(pose, own, at_frame(evidence, 2 * frame))
    return size


def test_whose_surface_is_farther_out_comes_to_be_thicker() -> None:
    thicknesses_m = []
    for by_m in (-0.01, 0.0, 0.02):
        belief = StatureBelief(is_given=True)
        belief.tell(MODEL.stature_m)
        shapes_m = learnt(thickened(by_m), belief).model(MODEL.stature_m).shapes_m
        thicknesses_m.append((shapes_m - MODEL.shapes_m)[:, :4].mean())
    thin_m, as_most_m, thick_m = thicknesses_m
    assert abs(as_most_m) < 0.004
    assert thin_m < as_most_m - 0.004
    assert thick_m > as_most_m + 0.008


@pytest.mark.parametrize("stature_m", [1.62, 1.88])
def test_who_is_smaller_or_larger_than_was_thought_comes_to_have_the_own_stature(
    stature_m: float,
) -> None:
    model, belief = BodyModel.of(stature_m, ANATOMICAL), StatureBelief()
    assert abs(belief.stature_m - stature_m) > 0.09
    learnt(model, belief)
    assert belief.stature_m == pytest.approx(stature_m, abs=0.05)


def test_a_stature_that_was_given_is_not_learnt() -> None:
    belief = StatureBelief(is_given=True)
    belief.tell(1.9)
    learnt(MODEL, belief, frames=5)
    assert belief.stature_m == 1.9


def test_before_anything_is_learnt_a_body_is_as_most_are() -> None:
    size = BodySize(Bones(), StatureBelief(), SETTINGS)
    assert_allclose(size.model(1.8).shapes_m, BodyModel.of(1.8, ANATOMICAL).shapes_m)


def test_nobody_is_thinner_than_bones() -> None:
    thin = MODEL.thicker(np.full(len(PARTS), -1.0))
    assert (thin.shapes_m[:, :4] == THINNEST_M).all()
    assert_allclose(thin.shapes_m[:, 4:], MODEL.shapes_m[:, 4:])


def round_body(stature_m: float) -> BodyModel:
    model = BodyModel.of(stature_m, ANATOMICAL)
    radii_m = np.repeat(model.radii_m.mean(1, keepdims=True), 2, axis=1)
    surface = Surface.of_parts(model.lengths_m, straight(radii_m))
    return replace(model, radii_m=radii_m, surface=surface)


def distances_of(pose: Pose, model: BodyModel, seen: NearestSurfaces, points: np.ndarray):
    """[N] metres of points from the surfaces of the parts that they are of."""
    origins, distances = pose.origins(model), np.full(len(points), np.nan)
    for part in range(len(PARTS)):
        own = seen.labels == part
        one = slice(part, part + 1)
        surface = Surface.of_parts(model.lengths_m[one], model.shapes_m[one])
        distances[own] = nearest_surfaces(
            points[own], pose.Rs[one], origins[one], surface, 0.3
        ).distances_m
    return distances


def moved(pose: Pose, dof: int, by: float) -> Pose:
    if dof < 3:
        return Pose(pose.neck_camera + by * np.eye(3)[dof], pose.Rs)
    relative = pose.relative()
    part, turn = DOF_PART[dof], by * np.eye(3)[DOF_AXIS[dof]]
    relative[part] = relative[part] @ rotations_from_vectors(turn[None])[0]
    return Pose.from_relative(pose.neck_camera, relative)


def test_what_is_summed_up_is_the_derivative_of_the_distances() -> None:
    """Of a body of round cylinders, which distances are exact from, at points on their sides."""
    model, by = round_body(MODEL.stature_m), 1e-5
    origins = POSE.origins(model)
    points = evidence_of(POSE).points_camera
    seen = nearest_surfaces(points, POSE.Rs, origins, model.surface, 0.3)
    ways, lengths_m = POSE.Rs[seen.labels, :, 1], model.lengths_m[seen.labels]
    share = ((points - origins[seen.labels]) * ways).sum(1) / lengths_m
    is_side = (share > 0.01) & (share < 0.99) & (seen.labels >= 0)
    assert is_side.sum() > 100

    def derivative(pose: Pose, other: BodyModel) -> np.ndarray:
        after = distances_of(pose, other, seen, points)
        return ((seen.distances_m - after) / by)[is_side]

    expected = np.zeros((is_side.sum(), N_DOFS + N_SIZES))
    for dof in range(N_DOFS):
        expected[:, dof] = derivative(moved(POSE, dof, by), model)
    larger = round_body(MODEL.stature_m * (1.0 + by))
    expected[:, N_DOFS + OF_STATURE] = derivative(POSE, larger)
    for group, name in enumerate(SIZE_GROUPS):
        by_m = np.array([by * (name in part.name) for part in PARTS])
        expected[:, N_DOFS + group] = derivative(POSE, model.thicker(by_m))

    shares, ways = _shares(POSE, origins), np.ascontiguousarray(POSE.Rs[:, :, 1])
    told = np.empty((is_side.sum(), N_DOFS + N_SIZES))
    for row, index in enumerate(np.flatnonzero(is_side)):
        one, sums = slice(index, index + 1), np.empty((len(PARTS), N_TOLD, N_TOLD))
        sum_up_surface(
            points[one], seen.labels[one], seen.distances_m[one], seen.normals_camera[one], ways,
            POSE.neck_camera, 1e6, sums,
        )  # fmt: skip
        both = (np.swapaxes(shares, 1, 2) @ sums @ shares).sum(0)
        told[row] = both[:-1, -1] / seen.distances_m[index]
    assert_allclose(told, expected, atol=1e-3)
