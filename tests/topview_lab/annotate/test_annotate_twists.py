"""Twists of limbs: found from what two cameras see of an arm that turns, whatever its names."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from topview.geometry.rotations import rotations_from_vectors, unit
from topview_lab.annotate.landmarks import INDEX, NAMES, standing
from topview_lab.annotate.twists import (
    TWIST_STEPS,
    across_bone,
    cheapest_path,
    fronts_of_bent_limbs,
    resolve_twists,
)

ELBOW, HAND, SHOULDER = INDEX["elbow_r"], INDEX["hand_r"], INDEX["shoulder_r"]
EYES = np.array([[0.0, 0.0, 0.0], [0.0, -1.0, 6.0]])
FRAMES = 60
DEPTH_M = 0.1


def person() -> np.ndarray:
    """[F, J, 3] of somebody who stands still, facing the first camera, 3 m away."""
    joints = standing(35.0).mean(1) * (1.7, -1.7, -1.7) + (0.0, 1.0, 3.0)
    return np.tile(joints, (FRAMES, 1, 1))


def turning_arm(turn_rad: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """[F, 3] directions to the front marker of an elbow that twists, and [V, F, J, 2, 3] markers
    of everybody's joints, each seen by the cameras that it faces."""
    joints = person()
    bone = unit(joints[:, HAND] - joints[:, ELBOW])
    first = unit(np.array([0.0, 0.0, -1.0]) + bone * bone[:, 2:])
    R = rotations_from_vectors(turn_rad[:, None] * bone)
    outwards = np.tile([0.0, 0.0, -1.0], (FRAMES, len(NAMES), 1))
    outwards[:, ELBOW] = np.einsum("fij,fj->fi", R, first)
    sides = np.stack([joints + DEPTH_M / 2 * outwards, joints - DEPTH_M / 2 * outwards], 2)
    points = np.stack([sides, sides])
    for v, side, sign in ((0, 0, 1), (0, 1, -1), (1, 0, 1), (1, 1, -1)):
        facing = sign * (outwards * unit(EYES[v] - sides[:, :, side])).sum(-1)
        points[v, :, :, side][facing < 0.0] = np.nan
    return outwards[:, ELBOW], points


def settled(points: np.ndarray, elbow_m: np.ndarray) -> np.ndarray:
    """[F, 3] the elbow, first thought to be elsewhere."""
    joints = person()
    both = np.asarray((~np.isnan(points[..., 0])).any(0).all(-1))
    joints[~both[:, ELBOW], ELBOW] += elbow_m
    depths_m = np.full(len(NAMES), DEPTH_M)
    return resolve_twists(points, EYES, joints, both, depths_m, 30.0)[0][:, ELBOW]


TURN = np.radians(np.concatenate([np.zeros(10), np.linspace(0.0, 160.0, 30), np.full(20, 160.0)]))


@pytest.mark.parametrize("swapped", [False, True])
def test_an_arm_that_turns_keeps_its_elbow(swapped: bool) -> None:
    """Also where the one marker that both cameras see was followed as the other side's."""
    _, points = turning_arm(TURN)
    if swapped:
        points[:, 15:45, ELBOW] = points[:, 15:45, ELBOW, ::-1]
    elbow = settled(points, np.array([0.03, 0.0, 0.02]))
    np.testing.assert_allclose(elbow, person()[:, ELBOW], atol=0.02)


def test_one_marker_of_both_names_is_one_marker() -> None:
    _, points = turning_arm(np.full(FRAMES, np.pi / 2))
    points[0, :, ELBOW, 0] = points[1, :, ELBOW, 1] = person()[:, ELBOW] + (0.0, 0.0, -0.05)
    points[0, :, ELBOW, 1] = points[1, :, ELBOW, 0] = np.nan
    elbow = settled(points, np.zeros(3))
    assert (np.linalg.norm(elbow - points[0, :, ELBOW, 0], axis=-1) > 0.04).all()


@given(st.integers(0, 2**32 - 1))
def test_axes_are_across_the_bone_and_turn_with_the_body(seed: int) -> None:
    rng = np.random.default_rng(seed)
    joints = person() + rng.normal(0.0, 0.02, (FRAMES, len(NAMES), 3))
    axes = across_bone(joints, ELBOW)
    bone = unit(joints[:, HAND] - joints[:, ELBOW])
    np.testing.assert_allclose(np.einsum("fki,fi->fk", axes, bone), 0.0, atol=1e-9)
    unity = np.tile(np.eye(2), (FRAMES, 1, 1))
    np.testing.assert_allclose(axes @ np.swapaxes(axes, 1, 2), unity, atol=1e-9)
    R = rotations_from_vectors(np.outer(np.linspace(0.0, 2.0, FRAMES), [0.1, 1.0, 0.2]))
    turned = across_bone(np.einsum("fij,fkj->fki", R, joints), ELBOW)
    np.testing.assert_allclose(turned[0], axes[0], atol=1e-9)
    np.testing.assert_allclose(turned, np.einsum("fij,fkj->fki", R, axes), atol=1e-6)


@given(st.integers(0, 2**32 - 1))
def test_the_cheapest_path_is_the_cheapest_of_all(seed: int) -> None:
    rng = np.random.default_rng(seed)
    costs, turns = rng.random((4, 3)), rng.random((3, 3))

    def cost(path: tuple[int, ...]) -> float:
        steps = sum(turns[a, b] for a, b in zip(path[:-1], path[1:], strict=True))
        return steps + sum(costs[f, k] for f, k in enumerate(path))

    every = list(np.ndindex(3, 3, 3, 3))
    assert cost(tuple(cheapest_path(costs, turns))) == pytest.approx(min(map(cost, every)))


def test_a_bent_arm_shows_its_front_and_a_straight_one_does_not() -> None:
    joints = person()[0]
    _, straight = fronts_of_bent_limbs(joints)
    joints[HAND] = joints[ELBOW] + (0.0, 0.0, -0.25)
    fronts, bent = fronts_of_bent_limbs(joints)
    assert straight[ELBOW] == 0.0
    assert bent[ELBOW] == 1.0
    upper = unit(joints[ELBOW] - joints[SHOULDER])
    np.testing.assert_allclose(fronts[SHOULDER], unit(np.array([0, 0, -1]) + upper * upper[2]))
    assert TWIST_STEPS % 4 == 0
