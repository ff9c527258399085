"""Poses that somebody holds, nearly still, wherever on the body the floor carries them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from topview_lab.sim.actions import Angles, Hand, Side, Style
from topview_lab.sim.actions.act import SIDES
from topview_lab.sim.bodies import Body
from topview_lab.sim.motions import Performance, with_hand
from topview_lab.sim.paths import Path
from topview_lab.sim.skeleton import SEGMENT_NAMES, Pose, angles_array, segment_poses

DRIFT_DEG: Final = 1.0
"""How far each segment drifts about the pose that is held (ours)."""


@dataclass(frozen=True, slots=True)
class HeldPose:
    """What somebody does who keeps a pose.

    Attributes:
        name: of the pose.
        angles: degrees by segment; segments that are not named hang straight. The pelvis's are its
            turn in the room: flexion -90 lies on the back, abduction 90 on the left side.
        hands: what palms reach for.
    """

    name: str
    angles: Angles
    hands: Mapping[Side, Hand] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, eq=False)
class Holding(Performance):
    """One person who holds a pose with the hips over the path's place and does nothing else."""

    held: HeldPose

    @classmethod
    def at(
        cls, held: HeldPose, position_room: tuple[float, float], heading_rad: float, style: Style
    ) -> Holding:
        """At a place.

        Args:
            held: the pose.
            position_room: (x, y) of the hips, metres.
            heading_rad: of the front of the upright body, from x towards y.
            style: of the drifts.
        """
        return cls(Path((position_room,), heading_rad, heading_rad), (), style, held)

    def action_at(self, time_s: float) -> str:
        """The name of the pose."""
        return self.held.name

    def pose(self, body: Body, time_s: float) -> Pose:
        """The pose at a time: the lowest place of the body touches the floor."""
        drifts = [
            [self.style.drift(time_s, 3 * s + k) for k in range(3)]
            for s in range(len(SEGMENT_NAMES))
        ]
        angles = angles_array(self.held.angles) + np.radians(DRIFT_DEG) * np.array(drifts)
        place = self.path.state_at(time_s)
        position, heading_rad = place.position_room, place.heading_rad
        pose = Pose(np.array([*position, 0.0]), heading_rad, angles)
        for side in SIDES:
            if side in self.held.hands:
                pose = with_hand(body, pose, position, side, self.held.hands[side], 1.0)
        lowest_m = body.flesh(segment_poses(body.offsets_m, pose)).lowest().min()
        return Pose(np.array([*position, -lowest_m]), heading_rad, pose.angles_rad)
