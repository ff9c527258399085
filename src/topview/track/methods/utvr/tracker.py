"""The thesis's own tracker: one frame after the other (Sec. 5.3.2)."""

from __future__ import annotations

from math import cos
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.body.parts import HEAD, PARTS, UPPER_TORSO
from topview.filter.over_time import Pace, Turns
from topview.geometry.rotations import rotations_from_angles
from topview.people.height import PRIOR_HEIGHT_M
from topview.track.body_tracker import Subject
from topview.track.evidence import Evidence
from topview.track.methods.btvr.torso import TorsoFilter, TorsoSettings
from topview.track.methods.btvr.yaw_cues import STILL_SHARE, YawCues
from topview.track.methods.topview.lookup import Likeness, shipped_poses
from topview.track.methods.utvr.descent import LEAST_DESCENT_POINTS, Descent
from topview.track.methods.utvr.part_filters import WIDEST, PartFilters
from topview.track.methods.utvr.particles import Particles, elsewhere, turns_rad
from topview.track.methods.utvr.placed_body import TORSO_PARTS, UPPER_LIMBS, PlacedBody, Remaining
from topview.track.methods.utvr.settings import UtvrSettings
from topview.track.pose import HALF_ROUND, OTHER_SIDE, Pose
from topview.track.stances import STANDING, stand

Array = NDArray[np.float64]

# All ours.
START_S: Final = 0.3  # from a person's first frame, while limbs are searched anywhere as well
LOOK_UP_S: Final = 0.1  # from one look through captured bodies to the next


class UtvrTracker:
    """One person's pose over time, by the algorithm of Sec. 5.3.2."""

    def __init__(self, subject: Subject, settings: UtvrSettings) -> None:
        self.subject = subject
        self.settings = settings
        self.model = settings.body(PRIOR_HEIGHT_M)
        self._particles: list[Particles] = []
        self._torso = TorsoFilter(
            TorsoSettings(is_coarse=settings.coarse_first, any_first_yaw=True), subject.threads
        )
        self._yaw_cues = YawCues(with_feet=True)
        self._descent = Descent(settings, subject.stature_is_given)
        self._pace, self._look_pace = Pace(), Pace()
        self._looks = Turns(LOOK_UP_S)
        self._first_s = 0.0
        self._last: Pose | None = None

    def update(self, evidence: Evidence) -> Pose:
        """The pose in the next frame."""
        if evidence.stature_m is not None:
            self._descent.stature.tell(evidence.stature_m)
        if self._descent.stature.stature_m != self.model.stature_m:
            self.model = self.settings.body(self._descent.stature.stature_m)
        if not self._particles:
            self._first_s = evidence.timestamp_s
            self._particles = self._roughly_standing(evidence)
        frames = self._pace.frames(evidence.timestamp_s)
        alike = self._alike(evidence)
        if self.settings.torso_turn_rad is not None and len(evidence.all_points_camera):
            self._propose_torso(evidence, frames, alike)
        if self.settings.neck is not None:
            self._particles[HEAD] = self._roughly_standing(evidence)[HEAD]
        with self.subject.clock.stage("parts"):
            body = self._placed_parts(evidence, frames)
        if self.settings.neck is not None:
            body.turn_head()
        pose = Pose(body.origins[UPPER_TORSO], body.Rs)
        if self.settings.descent and len(evidence.all_points_camera) >= LEAST_DESCENT_POINTS:
            with self.subject.clock.stage("descent"):
                pose = self._descent.end_frame(pose, self._last, evidence, alike)
            self._particles = [  # the next frame is searched around it
                kept if part == HEAD else kept.headed_by(pose.Rs[part], len(kept.Rs))
                for part, kept in enumerate(self._particles)
            ]
        self._last = pose
        return pose

    def _placed_parts(self, evidence: Evidence, frames: float) -> PlacedBody:
        """Every part where its filter has it, from the head down."""
        body, left = PlacedBody(self.model, evidence, self.settings), Remaining.of(evidence)
        starts = evidence.timestamp_s - self._first_s < START_S
        filters = PartFilters(
            self.subject, self.settings, evidence, body, tuple(self._particles), frames, starts
        )
        followed: dict[int, Particles] = {}  # parts below an upper limb that was judged with them
        for part in range(len(PARTS)):
            if part in followed:
                particles = followed[part]
            else:
                particles, tried = filters.filtered(part, left)
                if self.settings.limbs_as_one and part in UPPER_LIMBS:
                    rivals = elsewhere(particles.Rs[0], tried)
                    best, below = filters.best_with_next(part, rivals, left)
                    particles = particles.headed_by(rivals[best], len(particles.Rs) + 1)
                    followed[part + 1] = below
            self._particles[part] = particles
            body.place(part, particles.Rs[0])
            left = body.left_by(part, body.Rs[part, None], left)
        return body

    def _alike(self, evidence: Evidence) -> Likeness | None:
        """How like what is seen captured bodies are; None where it is not time to look."""
        if len(evidence.all_points_camera) < LEAST_DESCENT_POINTS or not self.settings.looks_up:
            return None
        if not self._looks.due(evidence.timestamp_s):
            return None
        with self.subject.clock.stage("lookup"):
            return shipped_poses().likeness(evidence, self.model.stature_m)

    def _propose_torso(self, evidence: Evidence, frames: float, alike: Likeness | None) -> None:
        """The torso of Sec. 5.1 is one more hypothesis, and all are turned about their own axes to
        its yaw, as its ellipses tell that, and how captured bodies face that are like what is seen.
        If front and back change places, so do the limbs."""
        yaw = self._torso.yaw
        yaw.fuse(self._yaw_cues.log_likelihood(evidence, self.model.stature_m, frames))
        if alike is not None:
            share = min(STILL_SHARE * self._look_pace.frames(evidence.timestamp_s), 1.0)
            yaw.fuse(share * alike.yaw_log_likelihood())
        R = self._torso.update(self.model, evidence, frames).R_camera_torso
        turn_rad = float(turns_rad(self._particles[UPPER_TORSO].Rs[0], R[None])[0])
        if cos(turn_rad) < 0.0:
            self._particles = [
                self._particles[other]
                if part in (HEAD, *TORSO_PARTS)
                else self._particles[other].turned(HALF_ROUND)
                for part, other in enumerate(OTHER_SIDE)
            ]
            self._last = self._last and self._last.turned_round()
        R_turn = rotations_from_angles(np.array([0.0, turn_rad, 0.0]))
        for part in TORSO_PARTS:
            self._particles[part] = self._particles[part].turned(R_turn)
        self._particles[UPPER_TORSO] = self._particles[UPPER_TORSO].with_one(R)

    def _roughly_standing(self, evidence: Evidence) -> list[Particles]:
        """Upright below the head, facing the camera: where every filter starts."""
        pose = stand(self.model, evidence.head_camera, STANDING, 0.0, evidence.up_camera)
        return [Particles(R[None], np.ones(1), WIDEST) for R in pose.Rs]
