"""The parts of the automatic way, held to what must be so."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from conftest import FRAMES, Marked, simulate_marked
from topview.camera.projection import pixel_rays
from topview.geometry.rotations import rotations_from_vectors, transform
from topview.records import Camera, Frame, InputError
from topview_lab.annotate.automatic import FindOptions
from topview_lab.annotate.blobs import Blobs, MarkerAppearance, find_blobs, pick_marker
from topview_lab.annotate.boards import Board, board_extrinsics
from topview_lab.annotate.cameras import difference
from topview_lab.annotate.joints import JointBasis, hermite, joints_from_markers
from topview_lab.annotate.landmarks import INDEX, NAMES, relative_angles_deg, standing
from topview_lab.annotate.session import Session
from topview_lab.annotate.starting import name_standing
from topview_lab.annotate.tracks import Tracks
from topview_lab.datasets import read_groundtruth

RED = MarkerAppearance(230, 20, 140, 0.025)
CAMERA = Camera(525.0, 525.0, 159.5, 119.5, 320, 240)


def picture(*spots: tuple[int, int, int], depth_m: float = 2.5) -> Frame:
    """A grey wall with discs (u, v, radius in pixels) of the markers' colour."""
    color = np.full((240, 320, 3), 120, np.uint8)
    for u, v, radius in spots:
        cv2.circle(color, (u, v), radius, RED.rgb, -1)
    return Frame(0, 0.0, np.full((240, 320), depth_m, np.float32), CAMERA, color)


def test_spots_are_found_by_colour_and_by_size_in_metres() -> None:
    frame = picture((60, 60, 5), (150, 100, 40), (250, 180, 5), (20, 200, 1))
    blobs = find_blobs(frame, [RED])
    np.testing.assert_allclose(sorted(blobs.pixels.tolist()), [[60, 60], [250, 180]], atol=0.3)
    further = find_blobs(picture((60, 60, 5), depth_m=7.0), [RED])
    assert len(further) == 0  # as large in the image, but much too large for a marker


def test_a_clicked_spot_tells_colour_and_size() -> None:
    look = pick_marker(picture((60, 60, 5)), 61, 59)
    assert look.rgb == RED.rgb
    assert look.radius_m == pytest.approx(5.3 / 525 * 2.5, rel=0.15)
    with pytest.raises(InputError, match="radius of"):
        pick_marker(picture((150, 100, 40)), 150, 100)


@given(st.sampled_from([10.0, 40.0, 85.0]), st.floats(-15, 15), st.floats(0, 25), st.booleans())
def test_a_standing_person_is_named(
    arms: float, yaw_deg: float, tilt_deg: float, behind: bool
) -> None:
    upright = np.diag([-1.0, -1.0, 1.0]) if not behind else np.diag([1.0, -1.0, -1.0])
    turn = rotations_from_vectors(np.radians([tilt_deg, 0.0, 0.0])) @ rotations_from_vectors(
        np.radians([0.0, yaw_deg + 180.0, 0.0])
    )
    person = standing(arms)[:, int(behind)] - (0.0, 0.55, 0.0)
    points = 1.7 * person @ (turn @ upright).T + (0.1, 0.1, 3.0)
    clutter = np.array([[1.9, 0.5, 3.5], [-1.8, 0.2, 3.9]])
    shuffled = np.random.default_rng(0).permutation(len(points))
    everything = np.vstack([points[shuffled], clutter])
    blobs = Blobs(np.zeros((len(everything), 2)), everything, np.full(len(everything), 0.025))
    (start,) = name_standing(blobs, 1, behind)
    assert start.spots.tolist() == np.argsort(shuffled).tolist()
    assert start.stature_m == pytest.approx(1.7, rel=0.03)


def still(joints: np.ndarray, frames: int) -> tuple[np.ndarray, Tracks]:
    """Markers [V, F, P, J, 2, 3] of joints [J, 3] that face the front camera, each seen by the
    camera before it, and their tracks."""
    outwards = np.zeros((frames, 1, len(NAMES), 3))
    outwards[..., 2] = -1.0
    places = np.tile(joints, (frames, 1, 1, 1))
    depths = np.full((1, len(NAMES)), 0.1)
    markers = np.stack([places + 0.05 * outwards, places - 0.05 * outwards], -2)
    spots = np.zeros((2, frames, 1, len(NAMES), 2), np.intp)
    points = np.stack([markers, markers])
    points[0, ..., 1, :] = points[1, ..., 0, :] = np.nan
    return points, Tracks(spots, places, outwards, depths)


KNEE = INDEX["knee_l"]
EYES = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 6.0]])
"""Where the two cameras are."""


@given(st.integers(2, 11), st.booleans())
def test_one_side_and_short_gaps_give_the_same_joint(gap: int, front_left: bool) -> None:
    """To 2 mm: the markers do not lie quite across the bone."""
    joints = standing(8.0).mean(1) * (1.7, -1.7, 1.7) + (0.0, 1.0, 3.0)
    points, tracks = still(joints, 40)
    whole = joints_from_markers(points, EYES, tracks, 30.0).places_front
    points[:, 5:15, 0, KNEE, 0 if front_left else 1] = np.nan
    points[:, 20 : 20 + gap, 0, KNEE] = np.nan
    result = joints_from_markers(points, EYES, tracks, 30.0)
    np.testing.assert_allclose(result.places_front, whole, atol=2e-3)
    assert (result.seen[5:15, 0, KNEE] == JointBasis.ONE_SIDE).all()
    assert (result.seen[20 : 20 + gap, 0, KNEE] == JointBasis.INTERPOLATED).all()


def test_long_gaps_stay_open() -> None:
    points, tracks = still(standing(8.0).mean(1), 60)
    points[:, 10:40, 0, KNEE] = np.nan
    result = joints_from_markers(points, EYES, tracks, 30.0)
    assert np.isnan(result.places_front[10:40, 0, KNEE]).all()
    assert (result.seen[10:40, 0, KNEE] == JointBasis.MISSING).all()


@given(st.lists(st.floats(-2, 2), min_size=6, max_size=6))
def test_gaps_in_straight_motion_are_closed_straight(numbers: list[float]) -> None:
    start, speed = np.split(np.array(numbers), 2)
    places = start + np.arange(20.0)[:, None] * speed
    np.testing.assert_allclose(hermite(places, 6, 13), places[7:13], atol=1e-9)


@given(st.floats(0, 180))
def test_relative_angles_do_not_change_when_everything_moves(bend_deg: float) -> None:
    joints = standing(8.0).mean(1)
    arm = [INDEX[f"{name}_l"] for name in ("shoulder", "elbow", "hand")]
    joints[arm] = [[0, 0, 0], [0, -0.3, 0],
                   [0.25 * np.sin(np.radians(bend_deg)), -0.3 - 0.25 * np.cos(np.radians(bend_deg)), 0]]  # fmt: skip  # noqa: E501
    R = rotations_from_vectors(np.array([0.4, -1.1, 0.3]))
    angles, moved = relative_angles_deg(joints), relative_angles_deg(joints @ R.T + (1, 2, 3))
    np.testing.assert_allclose(angles, moved, atol=1e-4)
    assert angles[3] == pytest.approx(bend_deg, abs=1e-4)


def board_frame(T_camera_board: np.ndarray, board: Board) -> Frame:
    """A camera's view of the chessboard."""
    side = board.square_m
    width, height = board.columns + 1, board.rows + 1
    color = np.full((240, 320, 3), 235, np.uint8)
    camera = Camera(300.0, 300.0, 159.5, 119.5, 320, 240)
    rays = pixel_rays(camera).astype(np.float64)
    T_board_camera = np.linalg.inv(T_camera_board)
    directions = rays @ T_board_camera[:3, :3].T
    origin = T_board_camera[:3, 3]
    on_board = origin + directions * (-origin[2] / directions[..., 2])[..., None]
    column = np.floor(on_board[..., 0] / side + 1).astype(int)
    row = np.floor(on_board[..., 1] / side + 1).astype(int)
    inside = (column >= 0) & (column < width) & (row >= 0) & (row < height)
    color[inside & ((column + row) % 2 == 0)] = 20
    return Frame(0, 0.0, np.ones((240, 320), np.float32), camera, color)


def test_a_chessboard_places_the_rear_camera() -> None:
    board = Board.parse("7x5:0.06")
    T_front_rear = transform(
        rotations_from_vectors(np.array([0.1, 0.9, 0.05])), np.array([-1.2, 0.1, 0.5])
    )
    pairs = []
    for k in range(4):
        turn = rotations_from_vectors(np.array([0.2 - 0.1 * k, 0.45, 0.05 * k]))
        T_front_board = transform(turn, np.array([-0.3 + 0.03 * k, -0.1, 1.3]))
        T_rear_board = np.linalg.inv(T_front_rear) @ T_front_board
        pairs.append((board_frame(T_front_board, board), board_frame(T_rear_board, board)))
    found = board_extrinsics(pairs, board)
    metres, degrees = difference(found.T_front_rear, T_front_rear)
    assert metres < 0.02
    assert degrees < 1.0
    with pytest.raises(InputError, match="in 0 frames"):
        board_extrinsics([(picture(), picture())], board)


@pytest.mark.parametrize("text", ["9x6", "2x6:0.03", "9x6:0.9", "charuco:7x5:0.03:0.04", "x"])
def test_boards_that_are_none_are_refused(text: str) -> None:
    with pytest.raises(InputError, match="--board is"):
        Board.parse(text)


def angle_errors(session: Session, marked: Marked) -> np.ndarray:
    assert session.joints is not None
    return np.abs(
        relative_angles_deg(session.joints.places_front) - relative_angles_deg(marked.joints)
    )


def test_the_automatic_part_is_near_the_truth(session: Session, marked: Marked) -> None:
    assert session.found is not None
    assert session.joints is not None
    assert session.found.offset_frames == 0
    errors = np.linalg.norm(session.joints.places_front - marked.joints, axis=-1)
    assert np.isfinite(errors).all()
    assert errors.mean() < 0.02
    assert (session.joints.seen == JointBasis.BOTH_SIDES).mean() > 0.85
    session.accept()
    truth = read_groundtruth(session.folder / "groundtruth.npz")
    assert truth.joints_camera.shape[:2] == (FRAMES, 1)


@pytest.mark.slow
def test_two_centimetres_and_three_degrees(tmp_path: Path) -> None:
    marked = simulate_marked(tmp_path, 120)
    session = Session(marked.front, marked.rear, tmp_path / "out", FindOptions())
    session.pick(0, 0, *marked.pixel("torso"), add=False)
    session.run(lambda doing, done, total: None)
    assert session.joints is not None
    errors = np.linalg.norm(session.joints.places_front - marked.joints, axis=-1)
    assert errors.mean() < 0.02
    assert angle_errors(session, marked).mean() < 3.0


def late(marked: Marked, folder: Path, frames: int) -> Path:
    """The rear recording begun so many frames later."""
    for name in ("depth", "rgb"):
        (folder / name).mkdir(parents=True)
        for f in range(frames, FRAMES):
            data = (marked.rear / name / f"{f:06d}.png").read_bytes()
            (folder / name / f"{f - frames:06d}.png").write_bytes(data)
    (folder / "camera.json").write_bytes((marked.rear / "camera.json").read_bytes())
    return folder


def test_a_rear_camera_that_started_later_is_put_in_step(marked: Marked, tmp_path: Path) -> None:
    session = Session(marked.front, late(marked, tmp_path / "rear", 3), tmp_path, FindOptions())
    session.pick(0, 0, *marked.pixel("torso"), add=False)
    session.run(lambda doing, done, total: None)
    assert session.found is not None
    assert session.found.offset_frames == -3


def test_bad_input_is_one_line(marked: Marked, session: Session, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="is the front recording too"):
        Session(marked.front, marked.front, tmp_path / "a", FindOptions())
    session.close()
    with pytest.raises(InputError, match="was begun with 1 people"):
        Session(marked.front, marked.rear, session.folder, FindOptions(people=2))
    foreign = tmp_path / "foreign"
    foreign.mkdir()
    np.savez(foreign / "groundtruth.npz", joints=np.zeros(3))
    with pytest.raises(InputError, match="was not made by topview annotate"):
        Session(marked.front, marked.rear, foreign, FindOptions())
    project = session.folder / "annotation.json"
    project.write_text("{}")
    with pytest.raises(InputError, match=r"annotation\.json: is not an annotation project"):
        Session(marked.front, marked.rear, session.folder, FindOptions())
    project.unlink()
    with pytest.raises(InputError, match="not been found yet"):
        Session(marked.front, marked.rear, session.folder, FindOptions()).accept()
