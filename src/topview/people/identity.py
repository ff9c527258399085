"""What is remembered of a user, and how well a head continues it."""

from __future__ import annotations

from collections.abc import Sequence
from math import sqrt

import numpy as np
from numpy.typing import NDArray

from topview.detect.cloud import Cloud
from topview.detect.head_colors import HeadColors
from topview.detect.head_template import HeadTemplate
from topview.detect.heads import HeadCandidate
from topview.people.colors import FaceMemory
from topview.people.height import HeightEstimate
from topview.people.stillness import Stillness

Vector = NDArray[np.float64]

# Ours: how fast the memory of a velocity fades while its user is hidden, seconds.
VELOCITY_DECAY_S = 0.8
# Ours: over which a velocity is smoothed, seconds.
HEAD_VELOCITY_S = 0.1
# Ours: who is hidden goes on as in so many seconds before, if that was faster than this; a head
# that comes to be covered seems to move for a moment.
WALK_S, WALK_M_PER_S = 0.4, 0.3
# A sprinting start; a head that moves faster is another's.
MAX_SPEED_M_PER_S = 4.0
# How much the walk of one who is hidden may change, metres per second; ours.
STRAYING_M_PER_S = 1.5
# How far the measured centre of a head may be from where it is expected, in any frame and besides
# for each second since the frame before; ours.
JITTER_M, JITTER_M_PER_S = 0.11, 1.2
MAX_GATE_M = 1.2
# Who is hidden mostly stays as high as he was: a head is further up or down from where it was by
# no more than that, and this for each second in which it was hidden; ours.
RISING_M_PER_S = 0.02
# Heads of less confidence are only believed where they are expected; ours.
UNEXPECTED_CONFIDENCE = 0.7
# One who was hidden for longer must look like a person again; ours.
BRIEFLY_S = 0.15
# A longer time between two frames is a pause, in which anything may have happened; ours.
PAUSE_S = 0.5
# How a head looks is learnt anew from this confidence on, which one that hangs down has; ours.
VIEW_FROM = 0.25
# From one look at whoever may be furniture, or has not yet proven otherwise, to the next; ours.
SUSPECT_LOOK_S, LOOK_S = 1 / 30, 0.1


class KnownUser:
    """What is remembered of a user: the head, how it moves, the stature, the last points.

    Attributes:
        id: identity, 0 as long as it may be furniture.
        head_camera: [3] the head's centre when last updated, metres.
        velocity, walk: [3] metres per second: now, and of late.
        time_s: of `head_camera`.
        first_camera, found_s: [3] where, and when, the head was first seen.
        seen_camera, seen_s: where and when it was last seen.
        there_s: when it, or enough of the body, last was.
        missed_s: since when neither has been, None while it is there.
        frames_seen: how many times.
        height: the stature's estimate.
        face: how much of it is in view of late.
        confidence_now: that what is followed is the head, 0 while it is not seen.
        view: what the head looked like when it was last seen.
        body_m: [h, w] distance of the user's points from the head in the last frame, or None.
        rival_since_s: since when something else has looked more like it, None if nothing does.
        doubted_frames: in how many it looked as furniture may, before it was followed.
        undoubted_looks: for how many looks it lately has not.
        is_suspect: whether it may be furniture, until something of it has moved.
        stillness: of one who may be furniture, or has not yet proven otherwise; else None.
        colors: histogram of the clothes (`people.looks`), None while unknown.
        head_colors: what colours the head has, None while unknown.
        company: whom it may have been taken for, of late.
    """

    def __init__(self, id: int, head: HeadCandidate, view: HeadTemplate, time_s: float) -> None:
        self.id = id
        self.head_camera = self.seen_camera = head.center_camera
        self.confidence_now = head.confidence
        self.view = view
        self.velocity = np.zeros(3)
        self.walk = np.zeros(3)
        self.time_s = time_s
        self.first_camera = head.center_camera
        self.found_s = time_s
        self.missed_s: float | None = None
        self.seen_s = self.there_s = time_s
        self.frames_seen = 1
        self.height = HeightEstimate()
        self.face = FaceMemory()
        self.rival_since_s: float | None = None
        self.doubted_frames = 0
        self.undoubted_looks = 0.0
        self.is_suspect = False
        self.stillness: Stillness | None = None
        self.colors: NDArray[np.float32] | None = None
        self.head_colors: HeadColors | None = None
        self.company: set[KnownUser] = set()
        self.body_m: NDArray[np.float32] | None = None

    def watch(
        self, cloud: Cloud, is_body: NDArray[np.bool_], time_s: float, watched_s: float = 0.0
    ) -> None:
        """Wait from now on for something of its [h, w] body to move, as for so long before."""
        look_s, noise = SUSPECT_LOOK_S if self.is_suspect else LOOK_S, cloud.camera.noise
        self.stillness = Stillness(cloud.depth_m, is_body, time_s, look_s, noise, watched_s)

    def exchange(self, other: KnownUser) -> None:
        """The two were taken for one another: what is known of each goes to the other's head."""
        for name in ("id", "height", "face", "colors", "head_colors"):
            own = getattr(self, name)
            setattr(self, name, getattr(other, name))
            setattr(other, name, own)

    def predicted(self, time_s: float) -> Vector:
        """[3] where the head is expected; a velocity that was not renewed fades."""
        ahead_s = max(time_s - self.time_s, 0.0)
        return self.head_camera + self.velocity * VELOCITY_DECAY_S * (
            1.0 - np.exp(-ahead_s / VELOCITY_DECAY_S)
        )

    def was_hidden(self, time_s: float) -> bool:
        """Whether the head has been missed, or nobody has looked, for more than a moment."""
        is_missed = self.confidence_now == 0.0 or time_s - self.time_s > PAUSE_S
        return is_missed and time_s - self.seen_s > BRIEFLY_S

    def step_s(self, time_s: float) -> float:
        """Since the frame before; of a pause only the beginning counts."""
        return min(max(time_s - self.time_s, 0.0), PAUSE_S)

    def scores(
        self, heads: Sequence[HeadCandidate], up_camera: Vector, time_s: float
    ) -> list[float]:
        """How well each head continues this user's: its confidence less its distance from the
        prediction in gates; -inf outside of the gate."""
        expected = self.predicted(time_s)
        hidden_s = max(time_s - self.seen_s, 0.0)
        jitter_m = JITTER_M + JITTER_M_PER_S * self.step_s(time_s)
        gate_m = min(jitter_m + STRAYING_M_PER_S * hidden_s, MAX_GATE_M)
        level_m = jitter_m + RISING_M_PER_S * hidden_s
        scores: list[float] = []
        for head in heads:
            offset = head.center_camera - expected
            moved_m = sqrt(offset @ offset)
            is_near = moved_m < (gate_m if head.confidence > UNEXPECTED_CONFIDENCE else jitter_m)
            is_near = is_near and abs(offset @ up_camera) < level_m
            scores.append(head.confidence - moved_m / gate_m if is_near else -np.inf)
        return scores

    def score(self, head: HeadCandidate, up_camera: Vector, time_s: float) -> float:
        """The same of one head."""
        return self.scores([head], up_camera, time_s)[0]

    def see(self, head: HeadCandidate, view: HeadTemplate, time_s: float) -> None:
        """The head has been measured."""
        head_camera = head.center_camera
        self.confidence_now = head.confidence
        if head.confidence > VIEW_FROM:
            self.view = view
        elapsed_s = time_s - self.time_s
        if elapsed_s > 0.0:
            velocity = (head_camera - self.head_camera) / elapsed_s
            self.velocity = _blend(self.velocity, velocity, elapsed_s / HEAD_VELOCITY_S)
            self.walk = _blend(self.walk, velocity, elapsed_s / WALK_S)
            speed = float(np.linalg.norm(self.velocity))
            self.velocity *= min(1.0, MAX_SPEED_M_PER_S / max(speed, 1e-9))
        self.head_camera = self.seen_camera = head_camera
        self.time_s = self.seen_s = time_s
        self.frames_seen += 1

    def jump(self, head: HeadCandidate, view: HeadTemplate, time_s: float) -> None:
        """What was followed was not the head; this is."""
        self.head_camera = self.seen_camera = head.center_camera
        self.velocity = np.zeros(3)
        self.confidence_now = head.confidence
        self.view = view
        self.time_s = self.seen_s = time_s
        self.rival_since_s = None

    def miss(self, time_s: float, up_camera: Vector, way_on: Vector | None) -> None:
        """The head has not been measured: go on as predicted, as high as it was, and by `way_on`
        [3]; stay if that is None, as nothing hides it."""
        ahead_s = max(time_s - self.time_s, 0.0)
        if self.confidence_now > 0.0:
            speed = float(np.linalg.norm(self.walk))
            self.velocity = self.walk if speed > WALK_M_PER_S else np.zeros(3)
        self.confidence_now = 0.0
        self.velocity = self.velocity - (self.velocity @ up_camera) * up_camera
        if way_on is not None:
            self.head_camera = self.predicted(time_s) + way_on
        self.velocity = self.velocity * np.exp(-ahead_s / VELOCITY_DECAY_S)
        self.time_s = time_s


def _blend(old: Vector, new: Vector, times: float) -> Vector:
    """[3] a mean that moves to the new; `times` the memory's length have gone by."""
    return old + (1.0 - np.exp(-times)) * (new - old)


def distance_m(one: KnownUser, other: KnownUser) -> float:
    """Between two heads."""
    return float(np.linalg.norm(one.head_camera - other.head_camera))


def nearest_m(user: KnownUser, users: Sequence[KnownUser]) -> float:
    """To the nearest other head."""
    return min((distance_m(user, other) for other in users if other is not user), default=np.inf)


def assign(scores: NDArray[np.float64]) -> dict[int, int]:
    """Row to column of the assignment with the highest sum of [users, heads] scores; pairs whose
    score is -inf are never made."""
    if not scores.size:
        return {}
    from scipy.optimize import linear_sum_assignment  # slow; not before it is needed

    rows, columns = linear_sum_assignment(np.where(np.isfinite(scores), -scores, 1e3))
    return {
        int(row): int(column)
        for row, column in zip(rows, columns, strict=True)
        if np.isfinite(scores[row, column])
    }
