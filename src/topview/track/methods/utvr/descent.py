"""At a frame's end: all parts move together onto the points, and the pose that explains more stays
(ours).

A cylinder that wants points inside stands too near to the camera; one whose surface they are does
not. And only what is placed steers the parts below it, until here. Where the pose still leaves much
unexplained, it is searched anew from stances, and other statures are tried.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.body.model import BodyModel
from topview.body.parts import UPPER_TORSO
from topview.track.evidence import Evidence
from topview.track.methods.topview.lookup import Likeness
from topview.track.methods.topview.refinement import RefinementSettings, refine
from topview.track.methods.topview.usual_poses import usual_poses
from topview.track.methods.utvr.settings import UtvrSettings
from topview.track.pose import Pose
from topview.track.stances import STANCES, Stance, facing, heading, rotations_of
from topview.track.stature import StatureBelief

Array = NDArray[np.float64]

# All ours.
HOLD: Final = 0.5  # against `RefinementSettings`' priors
LEAST_DESCENT_POINTS: Final = 30  # of fewer, parts stay where the filters have them
# A cost is the share of points that a pose leaves unexplained, and of its axes in free space.
NEWS_COST: Final = 0.02  # by which another pose than the last must cost less
# From this on a pose is searched anew, round the yaw of its torso, as `topview` does.
LOST_COST: Final = 0.3
LOST_TURNS_RAD: Final = (0.0, -0.7, 0.7)
ALIKE: Final = 4  # captured bodies that are tried at a time


@dataclass(frozen=True, slots=True, eq=False)
class Held:
    """Where a descent begins.

    Attributes:
        pose: to begin with.
        prior: that it is held to.
    """

    pose: Pose
    prior: Pose


class Descent:
    """The whole body of one person at the ends of frames.

    Attributes:
        stature: which one is believed.
    """

    def __init__(self, settings: UtvrSettings, stature_is_given: bool = False) -> None:
        self.settings = settings
        self.stature = StatureBelief(stature_is_given)

    def end_frame(
        self,
        found: Pose,
        last: Pose | None,
        evidence: Evidence,
        alike: Likeness | None = None,
    ) -> Pose:
        """The pose that was found, the last frame's, a captured one or a stance: whichever explains
        more once all of its parts are moved onto the points together."""
        stature_m = self.stature.stature_m
        poses = [found] if last is None else [found, Pose(found.neck_camera, last.Rs)]
        poses, costs = self._descended(self._held(poses), stature_m, evidence)
        costs[1:] -= NEWS_COST
        pose, cost = poses[int(costs.argmin())], float(costs.min())
        if alike is not None:
            starts = self._held(alike.poses(self.settings.body(stature_m), ALIKE))
            other, other_cost = self._best_start(starts, stature_m, evidence)
            if other_cost < cost - NEWS_COST:
                pose, cost = other, other_cost
        is_lost = cost > LOST_COST
        if is_lost and self.settings.searches_anew:
            other, other_cost = self._best_stance(found, stature_m, evidence, LOST_TURNS_RAD)
            if other_cost < cost - NEWS_COST:
                pose = other
        if self.settings.weighs_stature and self.stature.is_doubted(is_lost):
            self._weigh_stature(pose, is_lost, evidence)
        return pose

    def _weigh_stature(self, pose: Pose, is_lost: bool, evidence: Evidence) -> None:
        """Compare the stature that is believed with another one, of which stances are tried, too,
        where the pose is lost."""
        held, tried_m = self._held([pose]), self.stature.next_m()
        _, (cost,) = self._descended(held, self.stature.stature_m, evidence)
        _, (tried_cost,) = self._descended(held, tried_m, evidence)
        if is_lost:
            tried_cost = min(tried_cost, self._best_stance(pose, tried_m, evidence, (0.0,))[1])
        self.stature.judge(float(cost), float(tried_cost))

    def _best_stance(
        self, pose: Pose, stature_m: float, evidence: Evidence, turns_rad: Sequence[float]
    ) -> tuple[Pose, float]:
        """The best stance below the head, turned so far from where the torso of a pose faces."""
        model, up_camera = self.settings.body(stature_m), evidence.up_camera
        yaw_rad = heading(pose.Rs[UPPER_TORSO], up_camera)
        stances = [
            _stance_held_to_usual(
                stance,
                self.settings.usual,
                facing(yaw_rad + turn_rad, up_camera),
                evidence.head_camera,
                model,
            )
            for turn_rad in turns_rad
            for stance in STANCES
        ]
        return self._best_start(stances, stature_m, evidence)

    def _best_start(
        self, starts: Sequence[Held], stature_m: float, evidence: Evidence
    ) -> tuple[Pose, float]:
        """The start that explains most at a first look, once it is moved onto all points; and what
        it costs."""
        poses, costs = self._descended(starts, stature_m, evidence.thinned())
        best = [poses[int(costs.argmin())]]
        (moved,), (cost,) = self._descended(self._held(best), stature_m, evidence)
        return moved, float(cost)

    def _held(self, poses: Sequence[Pose]) -> list[Held]:
        """Poses, each held to what people usually do who are like it."""
        return [Held(pose, usual_poses().towards(pose, self.settings.usual)) for pose in poses]

    def _descended(
        self, starts: Sequence[Held], stature_m: float, evidence: Evidence
    ) -> tuple[list[Pose], Array]:
        """The poses after the Gauss-Newton steps, and [M] what they cost."""
        model, steps = self.settings.body(stature_m), self.settings.descent
        poses, priors = [held.pose for held in starts], [held.prior for held in starts]
        moved = refine(poses, priors, model, evidence, RefinementSettings(), steps, HOLD)
        return moved.poses, moved.unexplained + moved.in_free_space


@cache
def _usual_rotations(stance: Stance, share: float) -> Array:
    """[11, 3, 3] what a stance is held to, in the frame of `facing`."""
    return usual_poses().towards(Pose(np.zeros(3), rotations_of(stance)), share).Rs


def _stance_held_to_usual(
    stance: Stance, share: float, R_facing: Array, head_camera: Array, model: BodyModel
) -> Held:
    """A stance below a head."""
    pose = Pose.below_head(head_camera, R_facing @ rotations_of(stance), model)
    return Held(pose, Pose(pose.neck_camera, R_facing @ _usual_rotations(stance, share)))
