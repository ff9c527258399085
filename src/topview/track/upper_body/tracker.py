"""Tracks head, torso and arms of one person from frame to frame (Sec. 5.1)."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from topview.body.model import HEAD_CENTRE, BodyModel
from topview.body.parts import HEAD, LOWER_TORSO, PARTS, UPPER_TORSO
from topview.body.proportions import ANATOMICAL
from topview.filter.particles import generator
from topview.geometry.rotations import transform, unit
from topview.people.height import PRIOR_HEIGHT_M
from topview.track.evidence import Evidence
from topview.track.timing import StageClock
from topview.track.upper_body.torso import Torso, TorsoFilter, TorsoSettings

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class UpperBodySettings:
    """How torso and arms are tracked."""

    torso: TorsoSettings = field(default_factory=TorsoSettings)


@dataclass(frozen=True, slots=True, eq=False)
class UpperBodyPose:
    """The parts of an upper body; [11, 4, 4] `Ts_camera_part`, NaN for the legs."""

    Ts_camera_part: Array

    def transforms(self, model: BodyModel) -> Array:
        """[11, 4, 4] `Ts_camera_part`; the `model` is in them already."""
        return self.Ts_camera_part


class UpperBodyTracker:
    """One person's upper body over time."""

    def __init__(self, person: int, seed: int, settings: UpperBodySettings, threads: int) -> None:
        self.person = person
        self.seed = seed
        self.settings = settings
        self.model = BodyModel.of(PRIOR_HEIGHT_M, ANATOMICAL)
        self._torso = TorsoFilter(settings.torso, threads)

    def update(
        self, stature_m: float | None, evidence: Evidence, frame: int, clock: StageClock
    ) -> UpperBodyPose:
        """The pose in the next frame; `stature_m` is None while nobody could measure it."""
        if stature_m is not None:
            self.model = BodyModel.of(stature_m, ANATOMICAL)
        rng = generator(self.seed, self.person, UPPER_TORSO, frame)
        with clock.stage("torso"):
            torso = self._torso.update(self.model, evidence, rng)
        return self._pose(torso, evidence)

    def _pose(self, torso: Torso, evidence: Evidence) -> UpperBodyPose:
        model = self.model
        Ts = np.full((len(PARTS), 4, 4), np.nan)
        R = torso.R_camera_torso
        waist = torso.neck_camera + R[:, 1] * model.lengths_m[UPPER_TORSO]
        Ts[UPPER_TORSO] = transform(R, torso.neck_camera)
        Ts[LOWER_TORSO] = transform(R, waist)
        Ts[HEAD] = self._head(torso, evidence)
        for u in (3, 5):
            Ts[u] = transform(R, torso.neck_camera + R @ model.joints_parent[u])
            Ts[u + 1] = transform(R, Ts[u][:3, 3] + R[:, 1] * model.lengths_m[u])
        return UpperBodyPose(Ts)

    def _head(self, torso: Torso, evidence: Evidence) -> Array:
        """The head points from its measured centre to the neck joint; one that is not seen goes on
        from the torso."""
        length, R = self.model.lengths_m[HEAD], torso.R_camera_torso
        y = unit(torso.neck_camera - evidence.head_camera) if evidence.head_is_seen else R[:, 1]
        x = unit(R[:, 0] - y * (R[:, 0] @ y))
        R_head = np.stack([x, y, np.cross(x, y)], axis=1)
        centre = evidence.head_camera
        if not evidence.head_is_seen:
            centre = torso.neck_camera - (1.0 - HEAD_CENTRE) * length * y
        return transform(R_head, centre - HEAD_CENTRE * length * y)
