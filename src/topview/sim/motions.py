"""Performances: a person's path and actions, put together into one pose per moment."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.sim.actions import ACTIONS, ActionName, Angles, Side, Style, standing, walking
from topview.sim.bodies import Body
from topview.sim.paths import COMFORTABLE_MPS, Path, smooth_step
from topview.sim.skeleton import LIMITS_RAD, SEGMENT_INDEX, SEGMENTS, Pose, segment_poses

RAMP_S: Final = 0.45
"""How long a person takes to begin or end an action (ours)."""
STRIDE_SHARE: Final = 0.78
"""Stride length over stature at that speed, at which these curves let the standing foot slide
least (Winter 2009, Ch. 5: about 0.8)."""
STRIDE_POWER: Final = 0.42
"""Stride length grows with this power of the speed (D. Grieve and R. Gear, Ergonomics 9, 1966)."""


@dataclass(frozen=True, slots=True)
class Clip:
    """An action between two moments; it fades in and out within them."""

    action: ActionName
    start_s: float
    end_s: float
    side: Side = "r"

    def weight(self, time_s: float) -> float:
        """How much of the action shows, 0 to 1."""
        return min(
            smooth_step((time_s - self.start_s) / RAMP_S),
            smooth_step((self.end_s - time_s) / RAMP_S),
        )


@dataclass(frozen=True, slots=True, eq=False)
class Performance:
    """What one person does: a path and the actions on it."""

    path: Path
    clips: tuple[Clip, ...]
    style: Style

    def action_at(self, time_s: float) -> str:
        """What shows most at a moment: a clip's action (the last of equals), "walk" or "stand"."""
        shown = [(clip.weight(time_s), k) for k, clip in enumerate(self.clips)]
        weight, k = max(shown, default=(0.0, -1))
        pace = self.path.walked(time_s).pace
        if weight >= 0.5 and weight >= pace:
            return self.clips[k].action
        return "walk" if pace >= 0.5 else "stand"

    def pose(self, body: Body, time_s: float) -> Pose:
        """The pose at a moment, with the soles on the floor."""
        style, walked = self.style, self.path.walked(time_s)
        angles = _as_array(standing(style, time_s))
        if walked.pace > 0.0:
            size = (self.path.speed_mps / COMFORTABLE_MPS) ** STRIDE_POWER
            phase = walked.distance_m / (size * STRIDE_SHARE * body.look.stature_m) + 0.2
            gait = _as_array(walking(style, time_s, phase))
            angles += size * walked.pace * (gait - angles)
        for clip in self.clips:
            weight = clip.weight(time_s)
            if weight > 0.0:
                wanted = ACTIONS[clip.action](style, time_s - clip.start_s, clip.side)
                for name, target in wanted.items():
                    row = angles[SEGMENT_INDEX[name]]
                    row += weight * (np.radians(target) - row)
        _lift_shoulders(angles)
        angles = np.clip(angles, LIMITS_RAD[..., 0], LIMITS_RAD[..., 1])
        x, y = walked.position_room
        at_floor = Pose(np.array([x, y, 0.0]), walked.heading_rad, angles)
        sole = _lowest_sole(body, segment_poses(body.offsets_m, at_floor))
        return Pose(np.array([x, y, -sole]), walked.heading_rad, angles)


def _as_array(angles: Angles) -> NDArray[np.float64]:
    array = np.zeros((len(SEGMENTS), 3))
    for name, degrees in angles.items():
        array[SEGMENT_INDEX[name]] = np.radians(degrees)
    return array


def _lift_shoulders(angles: NDArray[np.float64]) -> None:
    """Raised arms take the shoulder girdle with them, about 1 degree for 6 at the side of the
    trunk and more overhead (after V. Inman et al., J. Bone Joint Surg. 26, 1944)."""
    for side in ("l", "r"):
        raised = np.linalg.norm(angles[SEGMENT_INDEX[f"upper_arm_{side}"], :2])
        angles[SEGMENT_INDEX[f"clavicle_{side}"], 1] += 0.16 * raised**2 / np.pi


SOLE_BLEND_M: Final = 0.008
"""Feet closer in height than this share the floor, so that the hips rise and sink smoothly."""


def _lowest_sole(body: Body, Ts_room_segment: NDArray[np.float64]) -> float:
    """Height of the soles' lowest points, a soft minimum over heels and toes of both feet."""
    flesh = body.flesh(Ts_room_segment)
    feet = np.isin(body.start_segments, [SEGMENT_INDEX["foot_l"], SEGMENT_INDEX["foot_r"]])
    down = flesh.axes[feet, 2, :] * flesh.scales[feet]
    drop = np.linalg.norm(down, axis=-1)
    lows = np.concatenate(
        [
            flesh.starts[feet, 2] - flesh.start_radii[feet] * drop,
            flesh.ends[feet, 2] - flesh.end_radii[feet] * drop,
        ]
    )
    weights = np.exp((lows.min() - lows) / SOLE_BLEND_M)
    return float((weights * lows).sum() / weights.sum())
