"""Bodies smoothed over time, for whoever wants quiet skeletons and can wait for them.

The 1 Euro filter of G. Casiez, N. Roussel and D. Vogel, "1 Euro filter" (CHI 2012): a mean that
forgets the faster, the faster something moves. Of a body it takes where the neck is, how each part
is turned and where it hangs on its parent. Joints and parts are then put together again, so
that bones keep their lengths and joints stay on their parts.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import pi
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.body.parts import HEAD, LOWER_TORSO, OUTPUT_JOINTS, PARTS, UPPER_TORSO
from topview.filter.over_time import share_after
from topview.geometry.rotations import rotations_from_vectors, transform, vectors_from_rotations
from topview.records import Person
from topview.track.pose import FROM_UPPER_TORSO, TREE_PARENT

Array = NDArray[np.float64]

SPEED_MEMORY_S: Final = 1.0 / (2.0 * pi)  # Casiez et al.: the speed's own filter cuts off at 1 Hz
MOST_LAG_M: Final = 0.05  # ours; behind which a body that keeps its speed never falls
MOST_LAG_RAD: Final = 0.15  # ours; the same of a part's turn
# Ours: what moves so far from one frame to the next has jumped, and is taken as it is.
LEAP_M, LEAP_RAD = 0.5, 1.2

_PARENTS = np.array(TREE_PARENT)
_HOLDERS = [HEAD if part == HEAD else parent for part, parent in enumerate(TREE_PARENT)]
_TRUNK = [UPPER_TORSO, LOWER_TORSO]
_PART_OF_JOINT = np.array([joint.part for joint in OUTPUT_JOINTS])


@dataclass(frozen=True, slots=True, eq=False)
class Shape:
    """A body that is taken apart.

    Attributes:
        neck_camera: [3] origin of the upper torso, metres.
        Rs_camera_part: [B, 3, 3].
        offsets_m: [B, 3] from its parent's origin to each part's, in the parent's frame; the head's
            in its own, as it begins at the crown.
    """

    neck_camera: Array
    Rs_camera_part: Array
    offsets_m: Array

    @classmethod
    def of(cls, Ts_camera_part: Array) -> Shape:
        Rs, origins = Ts_camera_part[:, :3, :3], Ts_camera_part[:, :3, 3]
        ways = origins - origins[_PARENTS]
        offsets_m = np.einsum("pba,pb->pa", Rs[_HOLDERS], ways)
        return cls(origins[UPPER_TORSO], Rs, offsets_m)

    def transforms(self) -> Array:
        """[B, 4, 4] `Ts_camera_part`."""
        origins = np.empty_like(self.offsets_m)
        origins[UPPER_TORSO] = self.neck_camera
        for part, parent in FROM_UPPER_TORSO:
            way = self.Rs_camera_part[_HOLDERS[part]] @ self.offsets_m[part]
            origins[part] = origins[parent] + way
        return transform(self.Rs_camera_part, origins)


def joints_moved_with(Ts_camera_part: Array, before: Array, joints_camera: Array) -> Array:
    """[J, 3] joints on parts that have gone from [B, 4, 4] `before` to `Ts_camera_part`."""
    raw, own = before[_PART_OF_JOINT], Ts_camera_part[_PART_OF_JOINT]
    on_part = np.einsum("jba,jb->ja", raw[:, :3, :3], joints_camera - raw[:, :3, 3])
    return np.einsum("jab,jb->ja", own[:, :3, :3], on_part) + own[:, :3, 3]


class _SmoothedBody:
    """One person's body over time."""

    def __init__(self, person: Person, time_s: float, smoothing_s: float) -> None:
        self._smoothing_s = smoothing_s
        self._start(Shape.of(person.Ts_camera_part), time_s)

    def _start(self, shape: Shape, time_s: float) -> None:
        self._last = self._smooth = shape
        self._velocity_m_s = np.zeros(3)
        self._turning_rad_s = np.zeros((len(PARTS), 3))
        self._time_s = time_s

    def update(self, person: Person, time_s: float) -> Person:
        """The person, smoothed; states and confidences are those of the joints as they were."""
        shape = Shape.of(person.Ts_camera_part)
        if np.linalg.norm(shape.neck_camera - self._last.neck_camera) < LEAP_M:
            self._move(shape, time_s - self._time_s)
            self._last, self._time_s = shape, time_s
        else:
            self._start(shape, time_s)
        Ts = self._smooth.transforms()
        joints = joints_moved_with(Ts, person.Ts_camera_part, person.joints_camera)
        return replace(person, joints_camera=joints, Ts_camera_part=Ts)

    def _move(self, shape: Shape, elapsed_s: float) -> None:
        smooth = self._smooth
        rates_hz = self._rates_hz(shape, elapsed_s)
        memories_s = self._smoothing_s / (1.0 + rates_hz * self._smoothing_s)
        shares = np.array([share_after(elapsed_s, memory_s) for memory_s in memories_s.tolist()])
        behind_rad = _turns(smooth.Rs_camera_part, shape.Rs_camera_part)
        Rs = rotations_from_vectors(shares[:, None] * behind_rad) @ smooth.Rs_camera_part
        has_jumped = ~(np.linalg.norm(behind_rad, axis=-1) < LEAP_RAD)  # or was not known
        Rs[has_jumped] = shape.Rs_camera_part[has_jumped]
        self._turning_rad_s[has_jumped] = 0.0
        slow = share_after(elapsed_s, self._smoothing_s)
        offsets_m = smooth.offsets_m + slow * (shape.offsets_m - smooth.offsets_m)
        self._smooth = Shape(
            smooth.neck_camera + shares[UPPER_TORSO] * (shape.neck_camera - smooth.neck_camera),
            Rs,
            np.where(np.isfinite(offsets_m), offsets_m, shape.offsets_m),
        )

    def _rates_hz(self, shape: Shape, elapsed_s: float) -> Array:
        """[B] speeds over the lags that are allowed; the trunk has one, or its ends would drift
        apart."""
        share = share_after(elapsed_s, SPEED_MEMORY_S)
        step_m = shape.neck_camera - self._last.neck_camera
        steps_rad = _turns(self._last.Rs_camera_part, shape.Rs_camera_part)
        self._velocity_m_s += share * (step_m / elapsed_s - self._velocity_m_s)
        self._turning_rad_s += share * (steps_rad / elapsed_s - self._turning_rad_s)
        rates_hz = np.linalg.norm(self._turning_rad_s, axis=-1) / MOST_LAG_RAD
        of_place_hz = float(np.linalg.norm(self._velocity_m_s)) / MOST_LAG_M
        rates_hz[_TRUNK] = max(of_place_hz, float(rates_hz[_TRUNK].max()))
        return rates_hz


class Smoothing:
    """Smooths everybody who is there; whoever comes back after an absence starts anew.

    Args:
        smoothing_s: memory of the mean while nothing moves, and so the longest delay, seconds.
    """

    def __init__(self, smoothing_s: float) -> None:
        self._smoothing_s = smoothing_s
        self._bodies: dict[int, _SmoothedBody] = {}

    def update(self, people: Sequence[Person], time_s: float) -> list[Person]:
        """The people of the next frame, later than the one before; those given are left alone."""
        known = self._bodies
        self._bodies = {
            person.id: known.get(person.id) or _SmoothedBody(person, time_s, self._smoothing_s)
            for person in people
        }
        return [
            self._bodies[person.id].update(person, time_s) if person.id in known else person
            for person in people
        ]


def _turns(Rs_before: Array, Rs_after: Array) -> Array:
    """[B, 3] axis times angle that takes each rotation to the other; NaN where one is not known."""
    return vectors_from_rotations(Rs_after @ np.swapaxes(Rs_before, -1, -2))
