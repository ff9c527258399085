"""Front or back: the cylinders of a body look alike from both, so other things must tell (ours).

Whoever is taken to face the wrong way is a good fit from top to toe, and stays one for as long as
nothing else is asked. Asked are: where the head is carried, which is before the trunk; whether the
same body turned half round would have to bend its joints beyond their limits; where the person
walks to; and, where colour tells, whether the face is seen. What each says is in log odds that the
front is the true one. The weights of the first two are a logistic regression on frames of people
tracked the right and the wrong way round: simulated ones, and real ones of UTD-MHAD.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from topview.body.limits import excess_rad
from topview.body.model import BodyModel
from topview.body.parts import PARTS, UPPER_TORSO
from topview.filter.over_time import begins_turn
from topview.geometry.rotations import horizontal, unit
from topview.track.evidence import Evidence
from topview.track.pose import Pose

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class FacingSettings:
    """Ours, all of it; belief is in log odds.

    Attributes:
        first_every_s, every_s, every_in_doubt_s: from one look to the next, seconds: of the
            first looks, of later ones, and of these while belief is below `doubt`.
        remembered: looks that the belief is a mean of.
        head_weight, head_weight_across: of the head's centre before the trunk's axis, per stature;
            where that is along the line of sight, and where it is across, which is measured better.
        head_cap: more than this counts no more, and twice this not at all: the pose is wrong.
        head_bias: so far, per stature, the measured centre is nearer to the camera.
        limits_weight: of what the body leaves its limits by if it is turned round, less what it
            does as it is, per radian.
        limits_balance_rad: such a difference says nothing; the pose as it is was fitted with more
            care.
        limits_cap_rad: a part counts up to here.
        face_weight, no_face_weight: of a face seen all the time, on somebody taken to face the
            camera, and of none, on somebody taken to face it.
        step_m, step_weight: a way this long across the floor tells where somebody walks to.
        sideways: cosine between that way and the front; below it he steps aside.
        frontal: of somebody who seems to face the camera: most people do.
        surest: the most that is believed, either way.
        turned_round: belief in the front that turns somebody round.
    """

    first_every_s: float = 1 / 30
    every_s: float = 5 / 30
    every_in_doubt_s: float = 2 / 30
    doubt: float = 1.0
    remembered: int = 10
    head_weight: float = 110.0
    head_weight_across: float = 180.0
    head_cap: float = 0.04
    head_bias: float = 0.012
    limits_weight: float = 2.0
    limits_balance_rad: float = 0.6
    limits_cap_rad: float = 0.7
    face_weight: float = 1.0
    no_face_weight: float = 0.5
    step_m: float = 0.25
    step_weight: float = 2.0
    sideways: float = 0.6
    frontal: float = 0.4
    surest: float = 4.0
    turned_round: float = -1.5


class Facing:
    """Somebody's front, over time."""

    def __init__(self, settings: FacingSettings) -> None:
        self.settings = settings
        self.belief = 0.0
        self._looks = 0
        self._asked_s: float | None = None
        self._left_camera: Array | None = None

    def is_due(self, time_s: float) -> bool:
        """Whether it is time to look again; looks are due at the same moments whatever the rate of
        frames."""
        s = self.settings
        every_s = s.every_s if self.belief > s.doubt else s.every_in_doubt_s
        if self._looks < s.remembered:
            every_s = s.first_every_s
        asked_s, self._asked_s = self._asked_s, time_s
        return begins_turn(time_s, asked_s, every_s)

    def step(self, pose: Pose, up_camera: Array) -> None:
        """People walk to their front."""
        s = self.settings
        if self._left_camera is None:
            self._left_camera = pose.neck_camera
        way = horizontal(pose.neck_camera - self._left_camera, up_camera)
        if np.linalg.norm(way) < s.step_m:
            return
        self._left_camera = pose.neck_camera
        cosine = float(unit(way) @ pose.Rs[UPPER_TORSO][:, 2])
        if abs(cosine) > s.sideways:
            self._add(s.step_weight * cosine)

    def look(self, pose: Pose, twin: Pose, model: BodyModel, evidence: Evidence) -> None:
        """Compare the pose with its refined twin, which is turned round."""
        s = self.settings
        front = pose.Rs[UPPER_TORSO][:, 2]
        towards = float(-front @ unit(pose.neck_camera))
        says = s.frontal * towards
        beyond_rad = self._excess_rad(twin) - self._excess_rad(pose)
        says += s.limits_weight * (beyond_rad - s.limits_balance_rad)
        if evidence.head_is_seen:
            before_m = float(front @ (evidence.head_camera - pose.neck_camera))
            before = before_m / model.stature_m - s.head_bias * towards
            if abs(before) < 2.0 * s.head_cap:
                weight = s.head_weight_across + towards**2 * (s.head_weight - s.head_weight_across)
                says += weight * float(np.clip(before, -s.head_cap, s.head_cap))
        if evidence.face_share is not None:
            seen = evidence.face_share
            says += towards * (s.face_weight * seen - s.no_face_weight * (1.0 - seen))
        self._looks += 1
        self._add((says - self.belief) / min(self._looks, s.remembered))

    def _add(self, says: float) -> None:
        surest = self.settings.surest
        self.belief = float(np.clip(self.belief + says, -surest, surest))

    def is_reversed(self) -> bool:
        """True where somebody should be turned round."""
        return self._looks > 2 and self.belief < self.settings.turned_round

    def forget(self) -> None:
        """What was believed turns out to fit worse."""
        self.belief = 0.0

    def turn_round(self) -> None:
        """Front and back have been exchanged."""
        self.belief = -self.belief

    def _excess_rad(self, pose: Pose) -> float:
        """By how much the pose leaves Table 3.2, all parts together."""
        beyond = [
            float(excess_rad(index, pose.Rs[part.parent].T @ pose.Rs[index]))
            for index, part in enumerate(PARTS)
            if part.parent >= 0
        ]
        return float(np.minimum(beyond, self.settings.limits_cap_rad).sum())
