"""Pose of the rear camera from a chessboard or ChArUco board that both cameras see."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from topview.geometry.rotations import transform
from topview.records import Camera, Frame, InputError
from topview_lab.annotate.cameras import Extrinsics

MARKERS: Final = cv2.aruco.DICT_5X5_100
"""Of ChArUco boards: OpenCV's dictionary of 100 markers of 5 x 5 bits."""
LEAST_BOARDS: Final = 3
MOST_RESIDUAL_M: Final = 0.05
"""Greatest residual; beyond it the boards of different frames contradict each other (ours)."""


@dataclass(frozen=True, slots=True)
class Board:
    """A board, as `--board` says it.

    Attributes:
        columns, rows: inner corners of a chessboard; squares of a ChArUco board.
        square_m: side of a square.
        marker_m: side of a marker of a ChArUco board, 0 for a chessboard.
    """

    columns: int
    rows: int
    square_m: float
    marker_m: float = 0.0

    @classmethod
    def parse(cls, text: str) -> Board:
        """From "9x6:0.03" (inner corners, metres) or "charuco:7x5:0.04:0.03".

        Raises:
            InputError: anything else.
        """
        count, number = "([0-9]{1,4})", r"([0-9]*\.?[0-9]+)"
        chess = re.fullmatch(rf"{count}x{count}:{number}", text)
        charuco = re.fullmatch(rf"charuco:{count}x{count}:{number}:{number}", text)
        match = chess or charuco
        if match is not None:
            columns, rows = int(match[1]), int(match[2])
            square_m, marker_m = float(match[3]), float(match[4]) if charuco else 0.0
            if min(columns, rows) >= 3 and 0.0 <= marker_m < square_m <= 0.5:
                return cls(columns, rows, square_m, marker_m)
        raise InputError(
            f"--board is {text!r}; it must be COLUMNSxROWS:METRES of a chessboard's inner corners, "
            "such as 9x6:0.03, or charuco:COLUMNSxROWS:SQUARE:MARKER, such as charuco:7x5:0.04:0.03"
        )

    def corners(self, color: NDArray[np.uint8]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """[N, 2] pixels and [N, 3] places on the board of the corners seen, N = 0 for none."""
        grey = np.asarray(cv2.cvtColor(color, cv2.COLOR_RGB2GRAY), np.uint8)
        if self.marker_m:
            return self._charuco_corners(grey)
        flags = cv2.CALIB_CB_NORMALIZE_IMAGE | cv2.CALIB_CB_ACCURACY
        found, pixels = cv2.findChessboardCornersSB(grey, (self.columns, self.rows), flags=flags)
        if not found:
            return np.zeros((0, 2)), np.zeros((0, 3))
        across, down = np.meshgrid(np.arange(self.columns), np.arange(self.rows))
        grid = np.stack([across.ravel(), down.ravel(), np.zeros(across.size)], 1)
        places = np.asarray(self.square_m * grid, np.float64)
        return np.asarray(pixels, np.float64).reshape(-1, 2), places

    def _charuco_corners(
        self, grey: NDArray[np.uint8]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        board = cv2.aruco.CharucoBoard(
            (self.columns, self.rows),
            self.square_m,
            self.marker_m,
            cv2.aruco.getPredefinedDictionary(MARKERS),
        )
        pixels, ids, _, _ = cv2.aruco.CharucoDetector(board).detectBoard(grey)
        if ids is None or len(ids) < 6:
            return np.zeros((0, 2)), np.zeros((0, 3))
        places = np.asarray(board.getChessboardCorners(), np.float64)[
            np.asarray(ids, np.intp).ravel()
        ]
        return np.asarray(pixels, np.float64).reshape(-1, 2), places


def board_extrinsics(pairs: Iterable[tuple[Frame, Frame]], board: Board) -> Extrinsics:
    """Pose of the rear camera, from simultaneous frames of both cameras.

    A chessboard looks the same upside down. Of its two readings, the one with both cameras upright
    is used.

    Raises:
        InputError: both cameras see the board too seldom, or its frames contradict each other.
    """
    found: list[NDArray[np.float64]] = []
    corners = 0
    for front, rear in pairs:
        of_front, of_rear = _pose(front, board), _pose(rear, board)
        if of_front is None or of_rear is None:
            continue
        (T_front_board, n), (T_rear_board, _) = of_front, of_rear
        turns = [np.eye(4)] if board.marker_m else [np.eye(4), _upside_down(board)]
        options = [T_front_board @ turn @ np.linalg.inv(T_rear_board) for turn in turns]
        found.append(max(options, key=lambda T: T[1, 1]))
        corners += n
    if len(found) < LEAST_BOARDS:
        raise InputError(
            f"--board: both cameras see the board at the same time in {len(found)} frames; "
            f"they must in at least {LEAST_BOARDS}"
        )
    Ts = np.stack(found)
    T = _mean(Ts)
    near = np.linalg.norm(Ts[:, :3, 3] - np.median(Ts[:, :3, 3], axis=0), axis=-1)
    residual_m = float(np.median(near))
    if residual_m > MOST_RESIDUAL_M:
        raise InputError(
            f"--board: its {len(found)} frames place the rear camera {100 * residual_m:.0f} cm "
            f"apart; they must agree within {100 * MOST_RESIDUAL_M:.0f} cm: are the sizes right, "
            "and the cameras in step?"
        )
    return Extrinsics(T, residual_m, corners)


def _pose(frame: Frame, board: Board) -> tuple[NDArray[np.float64], int] | None:
    """T_camera_board and the number of corners, None where the board is not seen."""
    if frame.color is None:
        return None
    pixels, places = board.corners(frame.color)
    if len(pixels) < 6:
        return None
    good, turn, origin = cv2.solvePnP(places, pixels, _matrix(frame.camera), np.zeros(5))
    if not good:
        return None
    R, _ = cv2.Rodrigues(turn)
    return transform(np.asarray(R, np.float64), np.asarray(origin, np.float64).ravel()), len(pixels)


def _matrix(camera: Camera) -> NDArray[np.float64]:
    return np.array([[camera.fx, 0.0, camera.cx], [0.0, camera.fy, camera.cy], [0.0, 0.0, 1.0]])


def _upside_down(board: Board) -> NDArray[np.float64]:
    """[4, 4] half a turn of the chessboard about its middle."""
    T = np.diag([-1.0, -1.0, 1.0, 1.0])
    T[:2, 3] = board.square_m * (board.columns - 1), board.square_m * (board.rows - 1)
    return T


def _mean(Ts: NDArray[np.float64]) -> NDArray[np.float64]:
    """The middle of [N, 4, 4] poses: median place, mean rotation nearest to a rotation."""
    U, _, Vt = np.linalg.svd(Ts[:, :3, :3].sum(0))
    flip = np.diag([1.0, 1.0, np.sign(np.linalg.det(U @ Vt))])
    return transform(U @ flip @ Vt, np.median(Ts[:, :3, 3], axis=0))
