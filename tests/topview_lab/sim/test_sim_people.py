"""Bodies and motions: constant bones, human limits, smooth movement, feet on the floor."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from topview.records import InputError
from topview_lab.sim.anthropometry import hip_share
from topview_lab.sim.appearance import Proportions, random_appearance
from topview_lab.sim.bodies import SIM_JOINT_NAMES, build_body
from topview_lab.sim.paths import Path
from topview_lab.sim.scene import Actor
from topview_lab.sim.scenes import scene_by_name
from topview_lab.sim.scenes.classic import CLASSIC
from topview_lab.sim.skeleton import SEGMENT_LIMITS_RAD, SEGMENTS, Pose, segment_poses

LIMBS = (("shoulder", "elbow", "wrist", "hand"), ("hip", "knee", "ankle", "foot"))
BONES = [
    ("head", "head_top"),
    ("hip_l", "hip_r"),
    *(
        (f"{upper}_{side}", f"{lower}_{side}")
        for side in "lr"
        for limb in LIMBS
        for upper, lower in pairwise(limb)
    ),
]
FPS = 30.0


def joints_over_time(actor: Actor, frames: int) -> np.ndarray:
    """[F, J, 3] in the room."""
    body = actor.body
    return np.stack(
        [
            body.joints(segment_poses(body.offsets_m, actor.performance.pose(body, f / FPS)))
            for f in range(frames)
        ]
    )


@pytest.fixture(scope="module", params=sorted(CLASSIC))
def actor(request: pytest.FixtureRequest) -> Actor:
    return scene_by_name(request.param, seed=5).actors[-1]


def test_bones_keep_their_length(actor: Actor) -> None:
    joints = joints_over_time(actor, 100)
    for a, b in BONES:
        bone = joints[:, SIM_JOINT_NAMES.index(a)] - joints[:, SIM_JOINT_NAMES.index(b)]
        length = np.linalg.norm(bone, axis=-1)
        np.testing.assert_allclose(length, length[0], rtol=1e-9, err_msg=f"{a} to {b}")


def test_motion_is_smooth_and_human(actor: Actor) -> None:
    joints = joints_over_time(actor, 120)
    speed = np.linalg.norm(np.diff(joints, axis=0), axis=-1) * FPS
    acceleration = np.linalg.norm(np.diff(joints, 2, axis=0), axis=-1) * FPS**2
    assert speed.max() < 9.0  # a fast punch: J. Atha et al., Br. Med. J. 291 (1985), 8.9 m/s
    assert acceleration.max() < 150.0
    for f in range(0, 120, 7):
        angles = actor.performance.pose(actor.body, f / FPS).angles_rad
        assert (angles >= SEGMENT_LIMITS_RAD[..., 0]).all()
        assert (angles <= SEGMENT_LIMITS_RAD[..., 1]).all()


def test_feet_stand_on_the_floor(actor: Actor) -> None:
    for f in range(0, 120, 5):
        pose = actor.performance.pose(actor.body, f / FPS)
        flesh = actor.body.flesh(segment_poses(actor.body.offsets_m, pose))
        drop = np.linalg.norm(flesh.axes[:, 2, :] * flesh.scales, axis=-1)
        lowest = min(
            (flesh.starts[:, 2] - flesh.start_radii * drop).min(),
            (flesh.ends[:, 2] - flesh.end_radii * drop).min(),
        )
        assert -0.012 < lowest < 0.001


@settings(max_examples=30)
@given(st.integers(0, 10_000), st.floats(1.2, 2.0))
def test_standing_as_tall_as_the_stature_says(seed: int, stature_m: float) -> None:
    appearance = replace(random_appearance(np.random.default_rng(seed)), stature_m=stature_m)
    body = build_body(appearance)
    hips = np.array([0.0, 0.0, stature_m * hip_share(appearance)])
    upright = Pose(hips, 0.0, np.zeros((len(SEGMENTS), 3)))
    joints = dict(
        zip(SIM_JOINT_NAMES, body.joints(segment_poses(body.offsets_m, upright)), strict=True)
    )
    assert joints["head_top"][2] == pytest.approx(stature_m, rel=1e-3)
    assert joints["torso"][2] - joints["pelvis"][2] == pytest.approx(0.1 * stature_m)
    # heading 0: the front is x, so the left is y
    assert joints["shoulder_l"][1] > 0.05 * stature_m > joints["shoulder_r"][1]
    assert joints["foot_l"][0] > 0.05 * stature_m


def test_adults_have_the_published_segment_lengths() -> None:
    appearance = replace(random_appearance(np.random.default_rng(0), "man"), stature_m=1.756)
    appearance = replace(appearance, proportions=Proportions())
    body = build_body(appearance)
    upright = Pose(np.zeros(3), 0.0, np.zeros((len(SEGMENTS), 3)))
    joints = body.joints(segment_poses(body.offsets_m, upright))

    def share(a: str, b: str) -> float:
        bone = joints[SIM_JOINT_NAMES.index(a)] - joints[SIM_JOINT_NAMES.index(b)]
        return float(np.linalg.norm(bone)) / 1.756

    # Winter (2009), Fig. 4.1; hips: Bell et al. (1989)
    assert share("shoulder_l", "elbow_l") == pytest.approx(0.186)
    assert share("elbow_l", "wrist_l") == pytest.approx(0.146)
    assert share("hip_l", "knee_l") == pytest.approx(0.245)
    assert share("knee_l", "ankle_l") == pytest.approx(0.246)
    assert 0.085 < 0.5 * 1.756 * share("hip_l", "hip_r") < 0.095


def test_a_heavy_person_is_broader_and_a_loose_shirt_wider() -> None:
    appearance = random_appearance(np.random.default_rng(3))
    thin, heavy = (build_body(replace(appearance, girth=girth)) for girth in (0.85, 1.2))
    assert heavy.start_radii_m.mean() > 1.1 * thin.start_radii_m.mean()
    tight, loose = (
        build_body(replace(appearance, clothes=replace(appearance.clothes, looseness=looseness)))
        for looseness in (0.0, 1.0)
    )
    assert (loose.start_radii_m >= tight.start_radii_m).all()
    assert loose.start_radii_m.max() > tight.start_radii_m.max()


def test_walking_feet_stay_where_they_stand() -> None:
    """Of the lower foot's ball, half of the steps move less than a third of what the body does."""
    scene = scene_by_name("pass_by", seed=2)
    joints = joints_over_time(scene.actors[1], 75)[25:]
    balls = joints[:, [SIM_JOINT_NAMES.index("foot_l"), SIM_JOINT_NAMES.index("foot_r")]]
    lower = balls[:-1, :, 2].argmin(1)
    moved = np.linalg.norm(np.diff(balls, axis=0), axis=-1)[np.arange(len(lower)), lower]
    pelvis = np.linalg.norm(np.diff(joints[:, SIM_JOINT_NAMES.index("pelvis")], axis=0), axis=-1)
    assert np.median(moved) < 0.34 * np.median(pelvis)


def test_a_path_is_walked_from_end_to_end() -> None:
    path = Path(((0.0, 2.0), (1.0, 2.0), (1.5, 3.0)), 0.0, np.pi / 2, start_s=1.0)
    before, after = path.state_at(0.0), path.state_at(20.0)
    np.testing.assert_allclose(before.position_room, (0.0, 2.0))
    np.testing.assert_allclose(after.position_room, (1.5, 3.0))
    assert before.distance_m == 0.0
    assert after.heading_rad == pytest.approx(np.pi / 2)
    distances = [path.state_at(t).distance_m for t in np.arange(0.0, 5.0, 0.05)]
    assert (np.diff(distances) >= 0.0).all()


def test_other_seeds_give_other_people() -> None:
    first, second = (scene_by_name("stand", seed=seed).actors[0].body.appearance for seed in (0, 1))
    assert first != second


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"name": "no_such"}, r"scene 'no_such' is not known; it must be one of pass_by"),
        ({"seed": -1}, "seed is -1; it must be 0 or more"),
        ({"people": 0}, "people is 0; it must be 1 to 6"),
        ({"people": 7}, "people is 7; it must be 1 to 6"),
        ({"frames": 0}, "frames is 0; it must be 1 or more"),
    ],
)
def test_wrong_wishes_are_refused(wrong: dict[str, Any], message: str) -> None:
    wishes: dict[str, Any] = {"name": "pass_by"} | wrong
    with pytest.raises(InputError, match=message):
        scene_by_name(**wishes)


@pytest.mark.parametrize("people", [1, 2, 6])
def test_as_many_people_as_asked_for(people: int) -> None:
    assert len(scene_by_name("pass_by", people=people).actors) == people


def test_a_stature_that_nobody_has_is_refused() -> None:
    with pytest.raises(InputError, match=r"stature is 3\.0 m; it must be 1 to 2\.2 m"):
        replace(random_appearance(np.random.default_rng(0)), stature_m=3.0)
