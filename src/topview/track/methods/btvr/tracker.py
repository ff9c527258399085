"""Tracks head, torso and arms of one person from frame to frame (Sec. 5.1)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import ClassVar, Final

import numpy as np
from numpy.typing import NDArray

from topview.body.model import HEAD_CENTRE, BodyModel
from topview.body.parts import (
    HEAD,
    LEFT_UPPER_ARM,
    LOWER_TORSO,
    PARTS,
    RIGHT_UPPER_ARM,
    UPPER_TORSO,
)
from topview.body.proportions import ANATOMICAL, THESIS
from topview.filter.over_time import Pace
from topview.geometry.rotations import transform, unit
from topview.people.height import PRIOR_HEIGHT_M
from topview.track.body_tracker import Needs, Subject
from topview.track.elbows import limb_rotations
from topview.track.evidence import Evidence
from topview.track.methods.btvr.arms import Arm, ArmFilter, ArmSettings
from topview.track.methods.btvr.pixels import UserPixels
from topview.track.methods.btvr.torso import Torso, TorsoFilter, TorsoSettings
from topview.track.methods.btvr.torso_shape import SHOULDER_WIDE
from topview.track.methods.btvr.yaw_cues import YawCues

Array = NDArray[np.float64]

# The arms are those of Table 3.1: from the joint's centre to the palm's.
PROPORTIONS = replace(ANATOMICAL, upper_arm=THESIS.upper_arm, forearm=THESIS.forearm)


@dataclass(frozen=True, slots=True)
class BtvrSettings:
    """The thesis's tracker of the upper body.

    Attributes:
        torso: how its axis is searched.
        arms: how each arm is searched.
    """

    torso: TorsoSettings = field(default_factory=TorsoSettings)
    arms: ArmSettings = field(default_factory=ArmSettings)

    needs: ClassVar[Needs] = Needs(hidden_share=True, unowned_mask=True)

    @property
    def name(self) -> str:
        return "btvr"

    def tracker(self, subject: Subject) -> BtvrTracker:
        return BtvrTracker(subject, self)


BTVR_AS_PRINTED: Final = BtvrSettings(
    torso=TorsoSettings(views=720, shape=SHOULDER_WIDE, best_view=True, ellipse_alone=True)
)
"""The torso of Sec. 5.1 as printed. The arms are ours; so are 720 views, 5 degrees apart."""


@dataclass(frozen=True, slots=True, eq=False)
class BtvrPose:
    """The parts of an upper body: [11, 4, 4] `Ts_camera_part`, NaN for the legs."""

    Ts_camera_part: Array

    def transforms(self, model: BodyModel) -> Array:
        """[11, 4, 4] `Ts_camera_part`; the `model` is in them already."""
        return self.Ts_camera_part


class BtvrTracker:
    """One person's upper body over time."""

    def __init__(self, subject: Subject, settings: BtvrSettings) -> None:
        self.subject = subject
        self.settings = settings
        self.model = BodyModel.of(PRIOR_HEIGHT_M, PROPORTIONS)
        self._torso = TorsoFilter(settings.torso, subject.threads)
        self._yaw_cues = YawCues()
        self._pace = Pace()
        self._arms = [
            ArmFilter(LEFT_UPPER_ARM, -1.0, settings.arms),
            ArmFilter(RIGHT_UPPER_ARM, 1.0, settings.arms),
        ]

    def update(self, evidence: Evidence) -> BtvrPose:
        """The pose in the next frame."""
        if evidence.stature_m is not None:
            self.model = BodyModel.of(evidence.stature_m, PROPORTIONS)
        with self.subject.clock.stage("torso"):
            frames = self._pace.frames(evidence.timestamp_s)
            told = self._yaw_cues.log_likelihood(evidence, self.model.stature_m, frames)
            self._torso.yaw.fuse(told)
            last = self._torso.torso
            torso = self._torso.update(self.model, evidence, frames)
        if last is not None and _is_reversed(torso, last):
            self._arms[0].exchange_sides(self._arms[1])
        with self.subject.clock.stage("arms"):
            arms = self._update_arms(torso, evidence)
        return assemble(self.model, torso, arms, evidence)

    def _update_arms(self, torso: Torso, evidence: Evidence) -> list[Arm]:
        """Both arms, first the one that was found better in the last frame."""
        pixels = UserPixels(torso, self.model, evidence)
        for arm_filter in self._arms:
            if arm_filter.arm is not None:
                self._assign(pixels, arm_filter, arm_filter.arm, torso)
        order = sorted(self._arms, key=lambda a: a.arm.discrepancy if a.arm else np.inf)
        for arm_filter in order:
            rng = self.subject.rng(arm_filter.upper, evidence)
            arm = arm_filter.update(torso, self.model, pixels, evidence, rng)
            self._assign(pixels, arm_filter, arm, torso)
        return [arm_filter.arm for arm_filter in self._arms if arm_filter.arm is not None]

    def _assign(self, pixels: UserPixels, arm_filter: ArmFilter, arm: Arm, torso: Torso) -> None:
        """Give the pixels near an arm to it."""
        parts = [arm_filter.upper, arm_filter.upper + 1]
        steps = arm.axes_torso * self.model.lengths_m[parts, None]
        joints = arm.shoulder_torso + np.concatenate([np.zeros((1, 3)), steps.cumsum(0)])
        joints_camera = torso.neck_camera + joints @ torso.R_camera_torso.T
        pixels.assign(arm_filter.upper, joints_camera, self.model.radii_m[parts, 0])


def _is_reversed(torso: Torso, last: Torso) -> bool:
    """Whether front and back have changed places."""
    return float(torso.R_camera_torso[:, 0] @ last.R_camera_torso[:, 0]) < 0.0


def assemble(model: BodyModel, torso: Torso, arms: Sequence[Arm], evidence: Evidence) -> BtvrPose:
    """The parts' poses from a torso and its arms, the left one first."""
    Ts = np.full((len(PARTS), 4, 4), np.nan)
    R = torso.R_camera_torso
    waist = torso.neck_camera + R[:, 1] * model.lengths_m[UPPER_TORSO]
    Ts[UPPER_TORSO] = transform(R, torso.neck_camera)
    Ts[LOWER_TORSO] = transform(R, waist)
    Ts[HEAD] = _head(model, torso, evidence)
    for upper, arm in zip((LEFT_UPPER_ARM, RIGHT_UPPER_ARM), arms, strict=True):
        shoulder = torso.neck_camera + R @ arm.shoulder_torso
        axes = arm.axes_torso @ R.T
        elbow = shoulder + axes[0] * model.lengths_m[upper]
        Rs = limb_rotations(axes, R, upper)
        Ts[[upper, upper + 1]] = transform(Rs, np.stack([shoulder, elbow]))
    return BtvrPose(Ts)


def _head(model: BodyModel, torso: Torso, evidence: Evidence) -> Array:
    """The head points from its measured centre to the neck joint; one that is not seen goes on
    from the torso."""
    length, R = model.lengths_m[HEAD], torso.R_camera_torso
    y = unit(torso.neck_camera - evidence.head_camera) if evidence.head_is_seen else R[:, 1]
    x = unit(R[:, 0] - y * (R[:, 0] @ y))
    R_head = np.stack([x, y, np.cross(x, y)], axis=1)
    centre = evidence.head_camera
    if not evidence.head_is_seen:
        centre = torso.neck_camera - (1.0 - HEAD_CENTRE) * length * y
    return transform(R_head, centre - HEAD_CENTRE * length * y)
