"""Bodies of people of whom something is hidden, and of whose joints none are proposed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from rendered_bodies import (
    CAMERA,
    MODEL,
    UP,
    at_frame,
    evidence_in,
    joints_of,
    render,
    standing_pose,
    subject,
)
from topview.body import JOINT_NAMES
from topview.body.parts import (
    HEAD,
    LEFT_FOREARM,
    LEFT_LOWER_LEG,
    LEFT_UPPER_ARM,
    LEFT_UPPER_LEG,
    LOWER_TORSO,
    RIGHT_FOREARM,
    RIGHT_LOWER_LEG,
    RIGHT_UPPER_ARM,
    RIGHT_UPPER_LEG,
    UPPER_TORSO,
)
from topview.geometry.rotations import rotations_from_angles
from topview.track.evidence import Evidence
from topview.track.methods.topview import TopviewSettings
from topview.track.methods.topview.posture import known_of
from topview.track.methods.topview.usual_poses import usual_where_hidden
from topview.track.methods.topview.whole_body import (
    FrameContext,
    of_what_is_seen,
    parts_out_of_sight,
)
from topview.track.pose import Pose
from topview.track.stances import Stance, heading, stand

COVER_M = 1.6  # how far away it is
ANKLES = [JOINT_NAMES.index(f"{side}_ankle") for side in ("left", "right")]
SEATED = Stance(hip=85, knee=85)
ABOVE = [HEAD, UPPER_TORSO, LOWER_TORSO, LEFT_UPPER_ARM, RIGHT_UPPER_ARM]


def behind(pose: Pose, is_covered: NDArray[np.bool_]) -> Evidence:
    """Somebody of whom something in front covers these pixels, on a floor."""
    depth = render(pose)
    depth[is_covered] = COVER_M
    head = pose.neck_camera - 0.5 * MODEL.lengths_m[0] * pose.Rs[0][:, 1]
    soles_m = joints_of(pose)[ANKLES, 1].max() + 0.08
    evidence = evidence_in(depth, (depth > 0) & (depth != np.float32(COVER_M)), head)
    return replace(evidence, floor=np.array([*UP, soles_m]))


def pixels_beside(column: float) -> NDArray[np.bool_]:
    return np.broadcast_to(np.arange(CAMERA.width) > column, (CAMERA.height, CAMERA.width))


def pixels_below(row: float) -> NDArray[np.bool_]:
    return np.broadcast_to((np.arange(CAMERA.height) > row)[:, None], (CAMERA.height, CAMERA.width))


def middle_column(pose: Pose) -> float:
    return CAMERA.fx * pose.neck_camera[0] / pose.neck_camera[2] + CAMERA.cx


def hips_row(pose: Pose) -> float:
    hip = joints_of(pose)[JOINT_NAMES.index("left_hip")]
    return CAMERA.fy * hip[1] / hip[2] + CAMERA.cy


def neck_row(pose: Pose) -> float:
    return CAMERA.fy * pose.neck_camera[1] / pose.neck_camera[2] + CAMERA.cy


def tracked(start: Pose, evidence: Evidence, frames: int) -> Pose:
    """Where somebody ends who was thought to be elsewhere."""
    tracker = TopviewSettings().tracker(subject())
    tracker.update(evidence)
    pose = tracker.pose = start
    for frame in range(1, frames):
        pose = tracker.update(at_frame(evidence, frame))
    return pose


def looked_at(evidence: Evidence) -> FrameContext:
    return FrameContext(MODEL, evidence, subject().clock, 1 / 30)


def test_a_part_is_out_of_sight_by_the_share_of_its_axis_that_is() -> None:
    pose = standing_pose()
    evidence = behind(pose, pixels_below(hips_row(pose) + 10))
    origins, shares = pose.origins(MODEL), np.array([0.125, 0.375, 0.625, 0.875])
    expected = []
    for part, length_m in enumerate(MODEL.lengths_m):
        places = origins[part] + length_m * shares[:, None] * pose.Rs[part, :, 1]
        expected.append(evidence.out_of_sight(places, float(MODEL.radii_m[part].min())).mean())
    assert len({0.0, 1.0, *expected}) > 2
    np.testing.assert_allclose(parts_out_of_sight(pose, MODEL, evidence), expected)


def test_which_parts_are_out_of_sight():
    pose = standing_pose(0.0)
    out = parts_out_of_sight(pose, MODEL, behind(pose, pixels_beside(middle_column(pose) + 3)))
    np.testing.assert_array_equal(out[[LEFT_UPPER_ARM, LEFT_FOREARM]], 1.0)
    np.testing.assert_array_equal(out[[LEFT_UPPER_LEG, LEFT_LOWER_LEG]], 1.0)
    np.testing.assert_array_equal(out[[RIGHT_UPPER_ARM, RIGHT_FOREARM]], 0.0)
    np.testing.assert_array_equal(out[[RIGHT_UPPER_LEG, RIGHT_LOWER_LEG]], 0.0)


def test_hidden_parts_of_a_body_that_is_looked_up_are_as_is_usual_and_others_stay():
    pose = standing_pose()
    head = pose.neck_camera - 0.5 * MODEL.lengths_m[0] * pose.Rs[0][:, 1]
    seated = stand(MODEL, head, SEATED, 0.3, UP)
    look = looked_at(behind(pose, pixels_below(hips_row(pose) - 1)))
    legs = [LEFT_UPPER_LEG, LEFT_LOWER_LEG, RIGHT_UPPER_LEG, RIGHT_LOWER_LEG]
    seen = known_of(seated, look.model, look.evidence).seen
    np.testing.assert_array_equal(seen[legs], 0.0)
    np.testing.assert_array_equal(seen[ABOVE], 1.0)
    usual = usual_where_hidden(seated, look)
    np.testing.assert_allclose(usual.Rs[ABOVE], seated.Rs[ABOVE], atol=1e-9)
    assert (seated.Rs[legs[::2], :, 1] @ -UP < 0.2).all()
    assert (usual.Rs[legs[::2], :, 1] @ -UP > 0.85).all()


def test_a_stature_that_was_not_measured_tells_no_height():
    look = looked_at(behind(standing_pose(), pixels_below(200)))
    head_m = look.evidence.floor @ np.append(look.evidence.head_camera, 1.0)
    assert known_of(standing_pose(), look.model, look.evidence).head_height == pytest.approx(
        head_m / 1.75
    )
    guessed = replace(look, evidence=replace(look.evidence, stature_m=None))
    assert known_of(standing_pose(), guessed.model, guessed.evidence).head_height is None


def test_who_shows_a_tenth_must_be_explained_better_by_ten_times_as_much():
    evidence = evidence_in(render(standing_pose()), render(standing_pose()) > 0, np.zeros(3))
    whole_m2 = 2.0 * (MODEL.lengths_m * MODEL.radii_m.mean(1)).sum()
    points = np.zeros((100, 3))
    all_of_it = replace(evidence, points_camera=points, point_area_m2=whole_m2 / 100)
    a_tenth = replace(all_of_it, points_camera=points[:10])
    assert of_what_is_seen(0.02, looked_at(all_of_it)) == pytest.approx(0.02)
    assert of_what_is_seen(0.02, looked_at(a_tenth)) == pytest.approx(0.2)


def test_who_stands_behind_a_counter_has_legs_below():
    pose = standing_pose()
    evidence = behind(pose, pixels_below(hips_row(pose)))
    head = pose.neck_camera - 0.5 * MODEL.lengths_m[0] * pose.Rs[0][:, 1]
    seated = stand(MODEL, head, SEATED, 0.3, UP)
    off_m = np.linalg.norm(joints_of(seated)[ANKLES] - joints_of(pose)[ANKLES], axis=1)
    found = tracked(seated, evidence, 30)
    left_m = np.linalg.norm(joints_of(found)[ANKLES] - joints_of(pose)[ANKLES], axis=1)
    assert off_m.min() > 0.4
    assert left_m.max() < 0.25


@pytest.mark.parametrize("turned_deg", [-60.0, 60.0])
def test_half_a_trunk_tells_how_it_is_turned(turned_deg):
    """But for front and back, which are alike of cylinders."""
    pose = standing_pose(0.0)
    evidence = behind(pose, pixels_below(0.5 * (hips_row(pose) + neck_row(pose))))
    turn = rotations_from_angles(np.radians([0.0, turned_deg, 0.0]))
    found = tracked(Pose(pose.neck_camera, turn @ pose.Rs), evidence, 30)
    off_rad = heading(found.Rs[UPPER_TORSO], UP) - heading(pose.Rs[UPPER_TORSO], UP)
    assert abs(np.cos(off_rad)) > np.cos(np.radians(15.0))
