"""How people move in every scene, and the laws of reaching, repeating and flying."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from topview_lab.sim.actions import ACTIONS, MHAD_ACTIONS, Moment, Style, stepping_round
from topview_lab.sim.appearance import random_appearance
from topview_lab.sim.bodies import SIM_JOINT_NAMES, build_body
from topview_lab.sim.limbs import limb_angles, two_bones
from topview_lab.sim.motions import Clip, Performance
from topview_lab.sim.paths import Path, Route
from topview_lab.sim.scene import Actor, Box, Scene
from topview_lab.sim.scenes import SCENES, scene_by_name
from topview_lab.sim.scenes.stage import TO_CAMERA, stands
from topview_lab.sim.skeleton import (
    SEGMENT_INDEX,
    SEGMENT_LIMITS_RAD,
    heading_rotation,
    segment_poses,
    segment_rotation,
)

FPS = 30.0
VARIED = [name for name, kind in SCENES.items() if kind.has_varied_room]
FEET = [j for j, name in enumerate(SIM_JOINT_NAMES) if name.startswith(("ankle", "foot", "knee"))]
HANDS = [j for j, name in enumerate(SIM_JOINT_NAMES) if name.startswith(("hand", "wrist", "elbow"))]
OTHERS = [j for j in range(len(SIM_JOINT_NAMES)) if j not in FEET + HANDS]
FAST = ("throwing", "throw_to", "catch_from", "boxing")
FLYING = ("jumping_in_place", "jumping_jacks")
MAY_LEAVE = {("enter_and_leave", 1), ("enter_and_leave", 2), ("dummy_occluder", 1)}


def joint(name: str) -> int:
    return SIM_JOINT_NAMES.index(name)


@dataclass(frozen=True)
class Motion:
    """Blocks of consecutive frames of one person: angles, joints and lowest points in the room."""

    scene: Scene
    number: int
    angles: NDArray[np.float64]  # [B, F, S, 3]
    joints: NDArray[np.float64]  # [B, F, J, 3]
    lowest: NDArray[np.float64]  # [B, F]
    actions: list[list[str]]


def lowest_point(actor: Actor, Ts: NDArray[np.float64]) -> float:
    flesh = actor.body.flesh(Ts)
    drop = np.linalg.norm(flesh.axes[:, 2, :] * flesh.scales, axis=-1)
    starts = flesh.starts[:, 2] - flesh.start_radii * drop
    ends = flesh.ends[:, 2] - flesh.end_radii * drop
    return float(min(starts.min(), ends.min()))


def motion(scene: Scene, number: int, blocks: list[range]) -> Motion:
    actor = scene.actors[number]
    poses = [[actor.performance.pose(actor.body, f / FPS) for f in block] for block in blocks]
    Ts = [[segment_poses(actor.body.offsets_m, pose) for pose in block] for block in poses]
    return Motion(
        scene=scene,
        number=number,
        angles=np.array([[pose.angles_rad for pose in block] for block in poses]),
        joints=np.array([[actor.body.joints(T) for T in block] for block in Ts]),
        lowest=np.array([[lowest_point(actor, T) for T in block] for block in Ts]),
        actions=[[actor.performance.action_at(f / FPS) for f in block] for block in blocks],
    )


@pytest.fixture(scope="module", params=VARIED)
def motions(request: pytest.FixtureRequest) -> list[Motion]:
    scene = scene_by_name(request.param, seed=11)
    starts = (8, int(0.4 * scene.frames), int(0.75 * scene.frames))
    blocks = [range(start, start + 20) for start in starts]
    return [motion(scene, number, blocks) for number in range(len(scene.actors))]


def test_every_motion_is_human(motions: list[Motion]) -> None:
    """Joints keep their limits and go from one frame to the next no further than people's do:
    12 cm, a walker's swinging foot 17, hands 14, those that throw or punch 28 (J. Atha et al.,
    Br. Med. J. 291, 1985, measured 30)."""
    for m in motions:
        assert (m.angles >= SEGMENT_LIMITS_RAD[..., 0] - 1e-9).all()
        assert (m.angles <= SEGMENT_LIMITS_RAD[..., 1] + 1e-9).all()
        moved = np.linalg.norm(np.diff(m.joints, axis=1), axis=-1)
        walks = any("walk" in block for block in m.actions)
        is_fast = any(action in FAST for block in m.actions for action in block)
        assert moved[..., OTHERS].max() < 0.12
        assert moved[..., FEET].max() < (0.17 if walks else 0.12)
        assert moved[..., HANDS].max() < (0.28 if is_fast else 0.14)
        acceleration = np.linalg.norm(np.diff(m.joints, 2, axis=1), axis=-1) * FPS**2
        assert acceleration.max() < (220.0 if is_fast else 150.0)


def test_nobody_sinks_into_the_floor_or_floats(motions: list[Motion]) -> None:
    for m in motions:
        assert m.lowest.min() > -0.02
        if m.scene.name not in FLYING:
            assert m.lowest.max() < 0.006


def test_standing_feet_stay(motions: list[Motion]) -> None:
    still = {"stand", "clapping", "bending", "bowing", "leaning", "waving_one_hand", "reaching",
             "waving_two_hands", "crossed_arms", "hands_behind_back", "pointing", "hug",
             "handshake", "sitting", "sit_down", "stand_up", "sit_down_stand_up"}  # fmt: skip
    for m in motions:
        ankles = m.joints[:, :, [joint("ankle_l"), joint("ankle_r")]]
        for block, actions in zip(ankles, m.actions, strict=True):
            if set(actions) <= still and m.scene.name in SCENES and not _turns(m):
                assert np.linalg.norm(np.diff(block, axis=0), axis=-1).max() < 0.002


def _turns(m: Motion) -> bool:
    return not isinstance(m.scene.actors[m.number].performance.path, Path) or m.scene.name in (
        "single_user",
        "dummy_occluder",
    )


def test_everybody_is_in_view_at_a_kinects_distance(motions: list[Motion]) -> None:
    for m in motions:
        if (m.scene.name, m.number) in MAY_LEAVE:
            continue
        T = m.scene.mount.T_camera_room()
        points = m.joints @ T[:3, :3].T + T[:3, 3]
        camera = m.scene.camera
        pixels = points[..., :2] / points[..., 2:] * camera.fx + (camera.cx, camera.cy)
        inside = (pixels >= 0.0) & (pixels <= (camera.width - 1.0, camera.height - 1.0))
        assert inside.all(-1).mean() > 0.985
        assert points[..., joint("pelvis"), 2].min() > 1.8
        assert points[..., joint("pelvis"), 2].max() < 4.2


def test_people_do_not_walk_through_each_other(motions: list[Motion]) -> None:
    for a in motions:
        for b in motions[a.number + 1 :]:
            apart = a.joints[..., joint("torso"), :2] - b.joints[..., joint("torso"), :2]
            assert np.linalg.norm(apart, axis=-1).min() > (0.24 if a.scene.name == "hug" else 0.4)


def single(action: str, seed: int = 0, **more: float) -> Actor:
    rng = np.random.default_rng(seed)
    clip = Clip(action, -1.0, 1e4, seat_m=more.get("seat_m", 0.45))
    return Actor(
        build_body(random_appearance(rng)), Performance(stands(0, 3), (clip,), Style.sample(rng))
    )


def test_all_of_mhads_actions_are_there_in_its_order() -> None:
    assert len(MHAD_ACTIONS) == 11
    assert set(MHAD_ACTIONS) <= set(ACTIONS)
    assert [name for name in SCENES if name in MHAD_ACTIONS] == list(MHAD_ACTIONS)


def test_a_flight_falls_as_gravity_says() -> None:
    actor = single("jumping_in_place", 3)
    dt = 0.01
    times = np.arange(1.0, 5.0, dt)
    heights = np.empty(len(times))
    airborne = np.empty(len(times), bool)
    for k, t in enumerate(times):
        pose = actor.performance.pose(actor.body, float(t))
        heights[k] = pose.root_room[2]
        airborne[k] = lowest_point(actor, segment_poses(actor.body.offsets_m, pose)) > 0.01
    falls = np.diff(heights, 2) / dt**2
    inside = airborne[:-2] & airborne[1:-1] & airborne[2:]
    assert inside.sum() > 50
    np.testing.assert_allclose(falls[inside], -9.81, atol=0.3)
    assert 0.08 < heights.max() - np.median(heights) < 0.45


@pytest.mark.parametrize("seat_m", [0.40, 0.47])
def test_a_seated_person_rests_on_the_seat_with_the_feet_on_the_floor(seat_m: float) -> None:
    actor = single("sitting", 5, seat_m=seat_m)
    body = actor.body
    pose = actor.performance.pose(body, 1.0)
    flesh = body.flesh(segment_poses(body.offsets_m, pose))
    is_seat = body.start_segments == SEGMENT_INDEX["pelvis"]
    under = (flesh.starts[:, 2] - flesh.start_radii)[is_seat].min()
    assert abs(under - seat_m) < 0.04
    assert -0.01 < lowest_point(actor, segment_poses(body.offsets_m, pose)) < 0.005


def test_the_chair_is_under_those_who_sit() -> None:
    for seed in range(3):
        scene = scene_by_name("sitting", seed=seed)
        actor = scene.actors[0]
        seat = scene.furniture[-6]
        assert isinstance(seat, Box)
        hips = actor.performance.pose(actor.body, 1.0).root_room
        assert np.linalg.norm(hips[:2] - seat.center_room[:2]) < 0.12


def test_hands_meet_in_a_handshake() -> None:
    scene = scene_by_name("handshake", seed=2)
    palms = []
    for actor in scene.actors:
        Ts = segment_poses(actor.body.offsets_m, actor.performance.pose(actor.body, 4.2))
        palms.append(actor.body.joints(Ts)[joint("hand_r")])
    assert np.linalg.norm(palms[0] - palms[1]) < 0.08


@pytest.mark.parametrize(
    ("action", "least", "most"),
    [("crossed_arms", 0.06, 0.16), ("hands_behind_back", -0.16, -0.06), ("clapping", 0.12, 0.22)],
)
def test_hands_stay_outside_of_the_trunk(action: str, least: float, most: float) -> None:
    """Palms before or behind the spine, in shares of the stature; trunks are 7 % deep."""
    for seed in range(6):
        actor = single(action, seed)
        Ts = segment_poses(actor.body.offsets_m, actor.performance.pose(actor.body, 2.0))
        chest = Ts[SEGMENT_INDEX["chest"]]
        joints = actor.body.joints(Ts)
        for side in "lr":
            palm = (joints[joint(f"hand_{side}")] - chest[:3, 3]) @ chest[:3, 2]
            assert least < palm / actor.body.appearance.stature_m < most


def test_repetitions_differ_but_the_same_seed_does_the_same() -> None:
    first, again, other = single("boxing", 1), single("boxing", 1), single("boxing", 2)
    poses = [a.performance.pose(a.body, 3.21).angles_rad for a in (first, again, other)]
    np.testing.assert_array_equal(poses[0], poses[1])
    assert np.abs(poses[0] - poses[2]).max() > 0.02
    style = first.performance.style
    lengths = {round(style.repetition(2.0 * k, 1.0).length_s, 4) for k in range(6)}
    assert len(lengths) > 3


@settings(max_examples=40)
@given(st.integers(0, 500), st.floats(0.0, 60.0), st.floats(0.4, 6.0))
def test_a_moment_lies_within_its_repetition(seed: int, time_s: float, period_s: float) -> None:
    style = Style.sample(np.random.default_rng(seed))
    now = style.repetition(time_s, period_s)
    assert -1e-9 <= now.since_s < now.length_s
    assert style.repetition(time_s + 0.05, period_s).k in (now.k, now.k + 1)


coordinates = st.floats(-0.5, 0.5)


@settings(max_examples=60)
@given(st.tuples(coordinates, coordinates, coordinates), st.tuples(coordinates, coordinates))
def test_two_bones_end_where_they_shall(
    end: tuple[float, float, float], bend: tuple[float, float]
) -> None:
    target = np.array(end)
    hint = np.array([*bend, 0.7])
    distance = np.linalg.norm(target)
    if distance < 0.05 or np.linalg.norm(np.cross(target / distance, hint)) < 0.1:
        return
    bones = two_bones(np.zeros(3), target, (0.45, 0.42), hint)
    np.testing.assert_allclose(np.linalg.norm(bones, axis=1), 1.0)
    np.testing.assert_allclose(0.45 * bones[0] + 0.42 * bones[1], target, atol=2e-3)
    for upper, lower in (("thigh_l", "calf_l"), ("upper_arm_r", "forearm_r")):
        angles, flexion = limb_angles(upper, np.eye(3), bones)
        R_upper = segment_rotation(upper, angles)
        R_lower = R_upper @ segment_rotation(lower, np.array([flexion, 0.0, 0.0]))
        np.testing.assert_allclose(R_upper @ (0, -1, 0), bones[0], atol=1e-6)
        np.testing.assert_allclose(R_lower @ (0, -1, 0), bones[1], atol=1e-6)


@pytest.mark.parametrize("action", sorted(ACTIONS))
def test_the_mirror_of_a_mirrored_act_is_the_act(action: str) -> None:
    style = Style.sample(np.random.default_rng(0))
    act = ACTIONS[action](Moment(style, 1.3, 5.0, 1.7, 0.45, (0.1, 2.5, 1.0)))
    assert act.mirrored().mirrored() == act


def test_the_left_hand_does_what_the_right_hand_does() -> None:
    rng = np.random.default_rng(4)
    body, style = build_body(random_appearance(rng)), Style.sample(rng)
    right, left = (
        Performance(stands(0.0, 3.0), (Clip("pointing", -1.0, 9.0, side=side),), style)
        for side in ("r", "l")
    )
    for performance, side in ((right, "r"), (left, "l")):
        joints = body.joints(segment_poses(body.offsets_m, performance.pose(body, 0.2)))
        other = "l" if side == "r" else "r"
        assert joints[joint(f"hand_{side}"), 2] > joints[joint(f"hand_{other}"), 2] + 0.1


@given(st.sampled_from([-360.0, -60.0, 60.0, 170.0, 360.0]), st.floats(0.0, 1.0))
def test_stepping_feet_follow_the_body(turn_deg: float, progress: float) -> None:
    feet = stepping_round(turn_deg, progress)
    assert max(abs(foot.turn_deg) for foot in feet.values()) < 60.0
    assert min(foot.up for foot in feet.values()) >= 0.0
    assert all(abs(foot.turn_deg) < 1e-9 for foot in stepping_round(turn_deg, 1.0).values())


def test_a_route_goes_on_where_its_legs_meet() -> None:
    route = Route(
        (
            Path(((0.0, 3.0), (1.0, 3.0)), TO_CAMERA, TO_CAMERA, 0.5),
            Path(((1.0, 3.0), (0.0, 2.5)), TO_CAMERA, 0.0, 4.0),
        )
    )
    walked = [route.state_at(t) for t in np.arange(0.0, 9.0, 1.0 / FPS)]
    places = np.array([w.position_room for w in walked])
    assert np.linalg.norm(np.diff(places, axis=0), axis=1).max() < 0.06
    fronts = [heading_rotation(w.heading_rad)[:, 2] for w in walked]
    assert np.linalg.norm(np.diff(fronts, axis=0), axis=1).max() < 0.25
    np.testing.assert_allclose(places[-1], (0.0, 2.5))
