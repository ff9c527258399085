"""How somebody moves on who comes to be hidden (ours).

What little is seen of a body hardly tells where its trunk goes, and what was estimated from it runs
away. Somebody who walks, or turns, when something comes before goes on so for a while: with the
velocity that was seen last, which fades. Where the head is seen, how it moves adds to that.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.body.parts import UPPER_TORSO
from topview.filter.over_time import share_after
from topview.geometry.rotations import rotations_from_vectors, vectors_from_rotations
from topview.track.evidence import Evidence
from topview.track.pose import Pose

Array = NDArray[np.float64]

# All ours. After which a velocity is by 63 % what the last frames say; and after which 63 % of it
# is gone, once nothing tells it any more.
SEEN_S: Final = 0.15
FADED_S: Final = 0.5


class Walk:
    """One person's velocity, and how fast the trunk turns about the way up."""

    def __init__(self) -> None:
        self._velocity = np.zeros(3)  # metres a second, camera frame
        self._turning_rad_s = 0.0
        self._head_camera: Array | None = None  # where it was seen in the last frame

    def update(self, before: Pose, now: Pose, up_camera: Array, elapsed_s: float) -> None:
        """By two poses of somebody in sight, so long after each other, more than 0 s."""
        turn = now.Rs[UPPER_TORSO] @ before.Rs[UPPER_TORSO].T
        turned_rad = float(vectors_from_rotations(turn[None])[0] @ up_camera)
        self._moved(now.neck_camera - before.neck_camera, elapsed_s)
        change = turned_rad / elapsed_s - self._turning_rad_s
        self._turning_rad_s += share_after(elapsed_s, SEEN_S) * change

    def look_back(self, evidence: Evidence) -> None:
        """A frame is over: where the head was seen in it, if it was."""
        self._head_camera = evidence.head_camera if evidence.head_is_seen else None

    def goes_on(self, pose: Pose, evidence: Evidence, elapsed_s: float) -> Pose:
        """Where somebody is in the next frame, so much later, of whom something is hidden; the
        whole pose moves and turns."""
        if self._head_camera is not None and evidence.head_is_seen and elapsed_s > 0.0:
            self._moved(evidence.head_camera - self._head_camera, elapsed_s)
        faded = share_after(elapsed_s, FADED_S)
        way = FADED_S * faded * self._velocity
        turned_rad = FADED_S * faded * self._turning_rad_s
        self._velocity = (1.0 - faded) * self._velocity
        self._turning_rad_s *= 1.0 - faded
        turn = rotations_from_vectors((turned_rad * evidence.up_camera)[None])[0]
        return Pose(pose.neck_camera + way, turn @ pose.Rs)

    def _moved(self, way: Array, elapsed_s: float) -> None:
        share = share_after(elapsed_s, SEEN_S)
        self._velocity = self._velocity + share * (way / elapsed_s - self._velocity)
