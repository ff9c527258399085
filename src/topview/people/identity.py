"""Users over time: where each is expected, and which head is whose."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from topview.people.height import HeightEstimate

Vector = NDArray[np.float64]

# Ours: how fast the memory of a velocity fades while its user is hidden, seconds.
VELOCITY_DECAY_S = 0.5
# A sprinting start; a head that moves faster is another's.
MAX_SPEED_M_PER_S = 4.0
# How wrong the measured centre of a head may be from one frame to the next, metres; ours.
JITTER_M = 0.15
MAX_GATE_M = 1.2


class KnownUser:
    """What is remembered of a user: the head, how it moves, the stature, the last points.

    Attributes:
        id: identity.
        head_camera: [3] the head's centre when last updated, metres.
        velocity: [3] metres per second.
        time_s: of `head_camera`.
        seen_s: when the head was last seen.
        frames_seen: how many times.
        height: the stature's estimate.
        is_users: [h, w] the cloud pixels of the last frame, or None.
    """

    def __init__(self, id: int, head_camera: Vector, time_s: float) -> None:
        self.id = id
        self.head_camera = head_camera
        self.velocity = np.zeros(3)
        self.time_s = time_s
        self.seen_s = time_s
        self.frames_seen = 1
        self.height = HeightEstimate()
        self.is_users: NDArray[np.bool_] | None = None

    def predicted(self, time_s: float) -> Vector:
        """[3] where the head is expected; a velocity that was not renewed fades."""
        ahead_s = max(time_s - self.time_s, 0.0)
        return self.head_camera + self.velocity * VELOCITY_DECAY_S * (
            1.0 - np.exp(-ahead_s / VELOCITY_DECAY_S)
        )

    def gate_m(self, time_s: float) -> float:
        """How far from the prediction the head may be."""
        hidden_s = max(time_s - self.seen_s, 0.0)
        return min(JITTER_M + MAX_SPEED_M_PER_S * hidden_s, MAX_GATE_M)

    def see(self, head_camera: Vector, time_s: float) -> None:
        """The head has been measured."""
        elapsed_s = time_s - self.time_s
        if elapsed_s > 0.0:
            velocity = (head_camera - self.head_camera) / elapsed_s
            share = 1.0 - np.exp(-elapsed_s / 0.1)
            self.velocity = self.velocity + share * (velocity - self.velocity)
            speed = float(np.linalg.norm(self.velocity))
            self.velocity *= min(1.0, MAX_SPEED_M_PER_S / max(speed, 1e-9))
        self.head_camera = head_camera
        self.time_s = self.seen_s = time_s
        self.frames_seen += 1

    def miss(self, time_s: float) -> None:
        """The head has not been measured: go on as predicted."""
        ahead_s = max(time_s - self.time_s, 0.0)
        self.head_camera = self.predicted(time_s)
        self.velocity = self.velocity * np.exp(-ahead_s / VELOCITY_DECAY_S)
        self.time_s = time_s


def assign(
    known: Sequence[KnownUser], heads_camera: Sequence[Vector], time_s: float
) -> dict[int, int]:
    """Index of a known user to index of a head: the cheapest assignment within every gate."""
    if not known or not heads_camera:
        return {}
    predicted = np.array([user.predicted(time_s) for user in known])
    gates = np.array([user.gate_m(time_s) for user in known])
    distance = np.linalg.norm(predicted[:, None] - np.array(heads_camera)[None], axis=-1)
    too_far = distance > gates[:, None]
    # One who was just seen is surer of a head than one who has long been hidden.
    cost = np.where(too_far, 1e3, distance + 0.1 * gates[:, None])
    rows, columns = linear_sum_assignment(cost)
    return {int(r): int(c) for r, c in zip(rows, columns, strict=True) if not too_far[r, c]}
