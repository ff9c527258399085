"""Track the markers over time in one or both views: assign each spot to a marker, or to none.

The state of a joint is its position, its velocity and the direction to its front marker. Both
markers are predicted from that state, so that a marker is recognised after an occlusion.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from topview.geometry.rotations import unit
from topview_lab.annotate.blobs import Blobs
from topview_lab.annotate.landmarks import (
    BACK,
    DEPTHS,
    FOLLOWS,
    FRONT,
    INDEX,
    NAMES,
    PARENTS,
    PLACES,
)
from topview_lab.annotate.starting import NamedPerson

NO_SPOT: Final = -1
UNDECIDED: Final = -2
J: Final = len(NAMES)

# All ours.
ASIDE_SIGMA_M: Final = 0.035
"""Standard deviation of a marker from its prediction, across the line of sight."""
ALONG_SIGMA_M: Final = 0.05
"""The same along the line of sight, where the depth sensor is coarse."""
UNSEEN_SIGMA_M: Final = 0.012
"""Growth of both for each frame in which the joint was not seen."""
MOST_UNSEEN_SIGMA_M: Final = 0.10
"""Greatest growth."""
GATE_SIGMAS: Final = 3.0
"""Gate of the association."""
TURNED_AWAY_COST: Final = 6.0
"""Cost of a marker that would be on the far side of the body, in squared standard deviations."""
PLACE_GAIN, SPEED_GAIN = 0.75, 0.45
"""alpha, and beta, of the alpha-beta filter over the joints."""
LOST_AFTER_FRAMES: Final = 2
"""After this many frames a joint is re-acquired from any free spot near its parent."""
LOST_REACH_M: Final = 0.9
"""Greatest distance of such a spot from the prediction."""
BONE_SLACK_SHARE, BONE_SLACK_M = 0.22, 0.04
"""Tolerated change of a bone's length: a share of it, plus a constant."""


@dataclass(frozen=True, slots=True, eq=False)
class View:
    """One camera's spots in each of F frames, its pose, and the user's decisions.

    Attributes:
        blobs: the spots of each frame; none where the camera has no frame at that time.
        T_front_view: [4, 4] into the front camera's frame.
        fixed: [F, P, J, 2] the user's decisions: index of a marker's spot, -1 if the marker is not
            visible, -2 if undecided; or None.
        rejected: by frame, the spots that are no markers by the user's decision.
    """

    blobs: Sequence[Blobs]
    T_front_view: NDArray[np.float64]
    fixed: NDArray[np.intp] | None = None
    rejected: Mapping[int, frozenset[int]] = field(default_factory=dict)

    def points(self, frame: int) -> NDArray[np.float64]:
        """[N, 3] spots in the front camera's frame."""
        return transform_points(self.T_front_view, self.blobs[frame].points_camera)


def transform_points(
    T_a_b: NDArray[np.float64], points_b: NDArray[np.float64]
) -> NDArray[np.float64]:
    """[..., 3] points in frame a."""
    return points_b @ T_a_b[:3, :3].T + T_a_b[:3, 3]


@dataclass(frozen=True, slots=True, eq=False)
class Tracks:
    """Tracked markers: V views, F frames, P people, J joints, 2 sides.

    Attributes:
        spots: [V, F, P, J, 2] index of each marker's spot in its frame, -1 for none.
        joints_front: [F, P, J, 3] tracked joints, metres in the front camera's frame.
        outwards_front: [F, P, J, 3] unit vectors from the joints to their front markers.
        depths_m: [P, J] tracked distance from front to back marker.
    """

    spots: NDArray[np.intp]
    joints_front: NDArray[np.float64]
    outwards_front: NDArray[np.float64]
    depths_m: NDArray[np.float64]


def follow(
    views: Sequence[View],
    start_frame: int,
    starts: Sequence[NamedPerson],
    T_front_start: NDArray[np.float64],
    fps: float,
) -> Tracks:
    """Track from the start frame to the end, and back to the beginning.

    Args:
        views: one or both.
        start_frame: the frame of `starts`.
        starts: the people, in the frame of the camera that found them.
        T_front_start: [4, 4] from that camera into the front camera's frame.
        fps: frames per second.
    """
    F, P = len(views[0].blobs), len(starts)
    spots = np.full((len(views), F, P, J, 2), NO_SPOT, np.intp)
    joints, outwards = np.zeros((2, F, P, J, 3))
    depths = np.zeros((P, J))
    for frames in (range(start_frame, F), range(start_frame, -1, -1)):
        follower = _Follower(starts, T_front_start, fps)
        for f in frames:
            spots[:, f] = follower.step(views, f)
            joints[f], outwards[f] = follower.joints, follower.outwards
        depths = np.maximum(depths, follower.depths_m)
    return Tracks(spots, joints, outwards, depths)


class _Follower:
    """The state of all people's joints, carried from frame to frame."""

    def __init__(
        self,
        starts: Sequence[NamedPerson],
        T_front_start: NDArray[np.float64],
        fps: float,
    ) -> None:
        markers = np.stack(
            [transform_points(T_front_start, start.markers_camera) for start in starts]
        )
        self.dt = 1.0 / fps
        gap = markers[:, :, FRONT] - markers[:, :, BACK]
        self.outwards = unit(gap)
        self.depths_m = np.stack([start.stature_m * DEPTHS for start in starts])
        self.joints = markers[:, :, FRONT] - PLACES[:, None] * gap
        self.speeds = np.zeros_like(self.joints)
        self.unseen = np.zeros(self.joints.shape[:2])
        self.bones_m = np.linalg.norm(self.joints - self.joints[:, PARENTS], axis=-1)

    def step(self, views: Sequence[View], f: int) -> NDArray[np.intp]:
        """[V, P, J, 2] index of each marker's spot in one frame; advances the state."""
        before = self.joints.copy()
        lasting = np.where(self.unseen > 0, 0.85, 1.0)[..., None]
        self.speeds *= lasting
        predicted = self.joints + self.speeds * self.dt
        lost = (self.unseen > 3) & (PARENTS >= 0)
        carried = predicted[:, PARENTS] + self.joints - self.joints[:, PARENTS]
        predicted = np.where(lost[..., None], carried, predicted)
        spots = np.stack([self._assign(view, f, predicted) for view in views])
        points = self._points(views, f, spots)
        spots = self._reject_wrong_lengths(views, f, spots, points, predicted)
        self._recover(views, f, spots, predicted)
        points = self._points(views, f, spots)
        self._update(points, predicted, before)
        return spots

    def _markers(self, joints: NDArray[np.float64]) -> NDArray[np.float64]:
        """[P, J, 2, 3] places of the markers of joints [P, J, 3]."""
        ahead = (PLACES * self.depths_m)[..., None] * self.outwards
        behind = ((1.0 - PLACES) * self.depths_m)[..., None] * self.outwards
        return np.stack([joints + ahead, joints - behind], 2)

    def _assign(self, view: View, f: int, predicted: NDArray[np.float64]) -> NDArray[np.intp]:
        """[P, J, 2] the cheapest one-to-one assignment of a view's spots to the markers."""
        points = view.points(f)
        P = len(predicted)
        names = np.full(P * J * 2, NO_SPOT, np.intp)
        if not len(points):
            return names.reshape(P, J, 2)
        markers = self._markers(predicted).reshape(-1, 3)
        sight = unit(markers - view.T_front_view[:3, 3])
        off = points[None] - markers[:, None]
        along = np.einsum("mni,mi->mn", off, sight)
        aside2 = (off**2).sum(-1) - along**2
        more = np.minimum(UNSEEN_SIGMA_M * self.unseen, MOST_UNSEEN_SIGMA_M).repeat(2)[:, None]
        cost = aside2 / (ASIDE_SIGMA_M + more) ** 2 + along**2 / (ALONG_SIGMA_M + more) ** 2
        outwards = np.stack([self.outwards, -self.outwards], 2).reshape(-1, 3)
        turned_away = np.maximum((outwards * sight).sum(-1) + 0.1, 0.0)
        cost += TURNED_AWAY_COST * turned_away[:, None]
        cost = np.minimum(cost, GATE_SIGMAS**2)
        cost[:, list(view.rejected.get(f, ()))] = GATE_SIGMAS**2
        if view.fixed is not None:
            decided = view.fixed[f].ravel()
            cost[decided != UNDECIDED] = GATE_SIGMAS**2
            cost[:, decided[decided >= 0]] = GATE_SIGMAS**2
            names[decided >= 0] = decided[decided >= 0]
        rows, columns = linear_sum_assignment(cost)
        good = cost[rows, columns] < GATE_SIGMAS**2
        names[rows[good]] = columns[good]
        return names.reshape(P, J, 2)

    def _points(
        self, views: Sequence[View], f: int, spots: NDArray[np.intp]
    ) -> NDArray[np.float64]:
        """[V, P, J, 2, 3] positions of the assigned spots, NaN for none."""
        points = np.full((*spots.shape, 3), np.nan)
        for v, view in enumerate(views):
            named = spots[v] != NO_SPOT
            points[v][named] = view.points(f)[spots[v][named]]
        return points

    def _reject_wrong_lengths(
        self,
        views: Sequence[View],
        f: int,
        spots: NDArray[np.intp],
        points: NDArray[np.float64],
        predicted: NDArray[np.float64],
    ) -> NDArray[np.intp]:
        """The assignment without spots that would change the length of the bone to the parent."""
        measured = self._measured(points)
        joints = np.where(np.isnan(measured), predicted, measured)
        length = np.linalg.norm(joints - joints[:, PARENTS], axis=-1)
        off = np.abs(length - self.bones_m) > BONE_SLACK_SHARE * self.bones_m + BONE_SLACK_M
        off &= (PARENTS >= 0) & ~np.isnan(measured[..., 0])
        plausible = np.where(off[None, ..., None], NO_SPOT, spots)
        for v, view in enumerate(views):
            if view.fixed is not None:
                plausible[v] = np.where(view.fixed[f] >= 0, view.fixed[f], plausible[v])
        return plausible

    def _recover(
        self,
        views: Sequence[View],
        f: int,
        spots: NDArray[np.intp],
        predicted: NDArray[np.float64],
    ) -> None:
        """Re-acquire lost joints from free spots at a bone's length from their parent; updates
        `spots` and `predicted`."""
        measured = self._measured(self._points(views, f, spots))
        lost = (self.unseen >= LOST_AFTER_FRAMES) & np.isnan(measured[..., 0]) & (PARENTS >= 0)
        for p, j in np.argwhere(lost):
            parent = measured[p, PARENTS[j]]
            bone = self.bones_m[p, j]
            slack = BONE_SLACK_SHARE * bone + BONE_SLACK_M
            best = (np.inf, 0, 0, parent)
            for v, view in enumerate(views):
                points = view.points(f)
                taken = [*spots[v].ravel(), *view.rejected.get(f, ())]
                free = np.setdiff1d(np.arange(len(points)), taken)
                sight = unit(points[free] - view.T_front_view[:3, 3])
                joints = points[free] + 0.5 * self.depths_m[p, j] * sight
                off = np.abs(np.linalg.norm(joints - parent, axis=-1) - bone) / slack
                off = off + np.linalg.norm(joints - predicted[p, j], axis=-1) / LOST_REACH_M
                for k in np.flatnonzero(off < min(best[0], 1.0)):
                    best = (off[k], v, free[k], joints[k])
            cost, v, spot, joint = best
            if not np.isfinite(cost):
                continue
            old, new = self.joints[p, j] - self.joints[p, PARENTS[j]], joint - parent
            outwards = rotate_least(unit(old)[None], unit(new)[None], self.outwards[p, j][None])[0]
            side = FRONT if outwards @ (joint - views[v].T_front_view[:3, 3]) < 0.0 else BACK
            spots[v, p, j, side] = spot
            predicted[p, j] = joint
            self.joints[p, j], self.speeds[p, j] = joint, 0.0
            self.outwards[p, j] = outwards
            measured[p, j] = joint

    def _measured(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """[P, J, 3] joints from [V, P, J, 2, 3] markers, NaN where neither side is seen."""
        front, back = mean_of_views(points)
        ahead = (PLACES * self.depths_m)[..., None] * self.outwards
        behind = ((1.0 - PLACES) * self.depths_m)[..., None] * self.outwards
        both = front + PLACES[:, None] * (back - front)
        one = np.where(np.isnan(front), back + behind, front - ahead)
        return np.where(np.isnan(both), one, both)

    def _update(
        self,
        points: NDArray[np.float64],
        predicted: NDArray[np.float64],
        before: NDArray[np.float64],
    ) -> None:
        measured = self._measured(points)
        seen = ~np.isnan(measured[..., 0])
        off = np.where(seen[..., None], measured - predicted, 0.0)
        self.joints = predicted + PLACE_GAIN * off
        self.speeds = self.speeds + SPEED_GAIN * off / self.dt
        self.unseen = np.where(seen, 0.0, self.unseen + 1.0)
        self.outwards = np.stack(
            [
                carry_outwards(outwards, old, new)
                for outwards, old, new in zip(self.outwards, before, self.joints, strict=True)
            ]
        )
        front, back = mean_of_views(points)
        gap = np.linalg.norm(front - back, axis=-1)
        good = np.abs(gap - self.depths_m) < 0.5 * self.depths_m  # NaN is not
        towards = unit(np.where(good[..., None], front - back, self.outwards))
        self.outwards = unit(self.outwards + towards)
        self.depths_m = np.where(good, 0.95 * self.depths_m + 0.05 * gap, self.depths_m)


def mean_of_views(
    points: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Front and back markers [..., J, 3] of [V, ..., J, 2, 3], the mean of the views that see one;
    NaN where none does."""
    seen = ~np.isnan(points[..., :1])
    count = seen.sum(0)
    mean = np.where(seen, points, 0.0).sum(0) / np.where(count > 0, count, np.nan)
    return mean[..., FRONT, :], mean[..., BACK, :]


def carry_outwards(
    outwards: NDArray[np.float64], old: NDArray[np.float64], new: NDArray[np.float64]
) -> NDArray[np.float64]:
    """[J, 3] directions to the front markers after the body has moved from `old` to `new` [J, 3]:
    they turn with the trunk, and with their limb by the smallest rotation."""
    R = trunk_axes(new) @ trunk_axes(old).T
    carried = outwards @ R.T
    limb = FOLLOWS >= 0
    first = unit((old[FOLLOWS] - old)[limb]) @ R.T
    second = unit((new[FOLLOWS] - new)[limb])
    carried[limb] = rotate_least(first, second, carried[limb])
    return unit(carried)


def trunk_axes(joints: NDArray[np.float64]) -> NDArray[np.float64]:
    """[..., 3, 3] the trunk's left, up and front as columns, of [..., J, 3] joints."""
    left = sum(
        joints[..., INDEX[f"{name}_l"], :] - joints[..., INDEX[f"{name}_r"], :]
        for name in ("shoulder", "hip")
    )
    up = unit(joints[..., INDEX["neck"], :] - joints[..., INDEX["pelvis"], :])
    left = unit(left - (left * up).sum(-1, keepdims=True) * up)
    return np.stack([left, up, np.cross(left, up)], -1)


def rotate_least(
    a: NDArray[np.float64], b: NDArray[np.float64], vectors: NDArray[np.float64]
) -> NDArray[np.float64]:
    """[N, 3] vectors after the smallest rotation that brings unit a to unit b, both [N, 3]."""
    axis = np.cross(a, b)
    cosine = np.clip((a * b).sum(-1, keepdims=True), -0.999, 1.0)
    return (
        cosine * vectors
        + np.cross(axis, vectors)
        + axis * (axis * vectors).sum(-1, keepdims=True) / (1.0 + cosine)
    )
