"""How people move: curves of joint angles over time, a path through the room, and what varies.

Angles are written in degrees, as (flexion, abduction, twist) in the senses of
`topview.sim.skeleton.SEGMENTS`. Everything is a smooth function of time and of a `Style`, which a
seed draws once per person.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from topview.records import InputError
from topview.sim.bodies import Body
from topview.sim.skeleton import (
    LIMITS_RAD,
    SEGMENT_INDEX,
    SEGMENTS,
    Pose,
    segment_poses,
)

Side = Literal["l", "r"]
Angles = dict[str, tuple[float, float, float]]
ActionName = Literal["wave", "box", "raise_arms", "reach"]

RAMP_S: Final = 0.45
"""How long a person takes to begin or end an action (ours)."""
TURN_S: Final = 0.7
"""How long a person takes to turn on the spot (ours)."""
SPEED_UP_S: Final = 0.7
"""How long a person takes to reach walking speed (ours)."""
COMFORTABLE_MPS: Final = 1.25
STRIDE_SHARE: Final = 0.78
"""Stride length over stature at that speed, at which these curves let the standing foot slide
least (Winter 2009, Ch. 5: about 0.8)."""
STRIDE_POWER: Final = 0.42
"""Stride length grows with this power of the speed (D. Grieve and R. Gear, Ergonomics 9, 1966)."""


@dataclass(frozen=True, slots=True, eq=False)
class Style:
    """What is a person's own in the motions.

    Attributes:
        tempo: speed of actions relative to the mean.
        reach: size of movements relative to the mean.
        start: a moment that shifts all periodic motion, seconds.
        waves: [K, 3] frequency in Hz, phase in radians and size of the slow drifts of a person who
            only stands.
    """

    tempo: float
    reach: float
    start: float
    waves: NDArray[np.float64]

    @classmethod
    def drawn(cls, rng: np.random.Generator) -> Style:
        """A person's own style."""
        count = 24
        waves = np.stack(
            [
                rng.uniform(0.12, 0.5, count),
                rng.uniform(0.0, 2.0 * np.pi, count),
                rng.uniform(0.4, 1.0, count),
            ],
            -1,
        )
        return cls(
            tempo=float(rng.uniform(0.9, 1.1)),
            reach=float(rng.uniform(0.92, 1.06)),
            start=float(rng.uniform(0.0, 1.0)),
            waves=waves,
        )

    def drift(self, time_s: float, k: int) -> float:
        """Slow drift number k, about -1 to 1."""
        frequency, phase, size = self.waves[[k, (k + 7) % len(self.waves)]].T
        return float(0.6 * (size * np.sin(2.0 * np.pi * frequency * time_s + phase)).sum())


def smooth_step(x: float) -> float:
    """0 below 0, 1 above 1, with no speed at either end."""
    x = min(max(x, 0.0), 1.0)
    return x * x * (3.0 - 2.0 * x)


# --- where: paths -----------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Path:
    """A walk through the room, with a turn before it and after it.

    Attributes:
        points_room: waypoints (x, y) in metres; one alone for a person who stays.
        start_s: when the person starts to walk.
        speed_mps: on the way.
        heading_before_rad, heading_after_rad: where the person looks before and afterwards.
    """

    points_room: tuple[tuple[float, float], ...]
    heading_before_rad: float
    heading_after_rad: float
    start_s: float = 0.0
    speed_mps: float = COMFORTABLE_MPS

    def __post_init__(self) -> None:
        if not self.points_room or self.speed_mps <= 0.0:
            raise InputError(
                f"a path has {len(self.points_room)} points and a speed of {self.speed_mps} m/s; "
                "it must have a point at least and a speed above 0"
            )

    def walked(self, time_s: float) -> Walked:
        """Where the person is, how far along, how fast and where to."""
        if len(self.points_room) == 1:
            return Walked(np.array(self.points_room[0]), self.heading_before_rad, 0.0, 0.0)
        points = np.array(self.points_room)
        knots = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
        curve = CubicSpline(knots, points, bc_type="natural")
        length = float(knots[-1])
        speed = min(self.speed_mps, length / SPEED_UP_S)
        duration = length / speed + SPEED_UP_S
        t = min(max(time_s - self.start_s, 0.0), duration)
        distance = speed * (_ramped(t) - _ramped(t - (duration - SPEED_UP_S)))
        pace = smooth_step(t / SPEED_UP_S) - smooth_step((t - duration) / SPEED_UP_S + 1.0)
        dx, dy = curve(min(distance, length), 1)
        before = smooth_step((time_s - self.start_s) / TURN_S + 0.6)
        after = smooth_step((time_s - self.start_s - duration) / TURN_S + 0.6)
        along = np.arctan2(dy, dx)
        heading = self.heading_before_rad + before * _turn(self.heading_before_rad, along)
        heading += after * _turn(along, self.heading_after_rad)
        return Walked(curve(min(distance, length)), float(heading), distance, float(pace))


@dataclass(frozen=True, slots=True, eq=False)
class Walked:
    """A moment on a path: position in the room (x, y), heading, metres walked, pace in 0..1."""

    position_room: NDArray[np.float64]
    heading_rad: float
    distance_m: float
    pace: float


def _ramped(t: float) -> float:
    """Seconds of full speed that t seconds with a smooth start are worth."""
    if t <= 0.0:
        return 0.0
    if t >= SPEED_UP_S:
        return t - 0.5 * SPEED_UP_S
    x = t / SPEED_UP_S
    return SPEED_UP_S * (x**3 - 0.5 * x**4)


def _turn(from_rad: float, to_rad: float) -> float:
    """The shorter way round."""
    return (to_rad - from_rad + np.pi) % (2.0 * np.pi) - np.pi


# --- what: curves of joint angles -------------------------------------------------------------


def standing(style: Style, time_s: float) -> Angles:
    """At ease: arms hang a little away from the body, everything drifts by a degree or two."""
    d = [style.drift(time_s, k) for k in range(12)]
    angles: Angles = {
        "pelvis": (1.0 + d[0], 0.0, 1.5 * d[1]),
        "abdomen": (d[2], 0.8 * d[3], d[4]),
        "chest": (2.0 + d[5], 0.0, 1.5 * d[6]),
        "neck": (6.0 + 2.0 * d[7], d[8], 4.0 * d[9]),
        "head": (-6.0 + 2.0 * d[10], d[11], 4.0 * d[1]),
    }
    for k, side in enumerate(("l", "r")):
        angles |= {
            f"upper_arm_{side}": (2.0 + 2.0 * d[k], 9.0 + 1.5 * d[k + 2], 10.0),
            f"forearm_{side}": (16.0 + 3.0 * d[k + 4], 0.0, 15.0),
            f"hand_{side}": (0.0, -6.0 + 2.0 * d[k + 6], 0.0),
            f"thigh_{side}": (2.0, 3.0, -6.0),
            f"calf_{side}": (4.0 + d[k + 8], 0.0, 0.0),
            f"foot_{side}": (2.0, -1.0, 0.0),
        }
    return angles


def _cycle(*degrees: float) -> CubicSpline:
    """A periodic curve through equidistant values of one gait cycle."""
    return CubicSpline(np.linspace(0.0, 1.0, len(degrees) + 1), [*degrees, degrees[0]],
                       bc_type="periodic")  # fmt: skip


# From heel strike to heel strike in tenths, after Winter (2009), Fig. 5.36 and Table A, smoothed so
# that the standing foot hardly slides.
_HIP = _cycle(27, 22, 13, 3, -6, -13, -10, 5, 20, 28)
_KNEE = _cycle(4, 13, 13, 9, 6, 12, 38, 62, 53, 20)
_ANKLE = _cycle(-1, -5, 2, 6, 9, 8, -14, -9, 0, 2)


def walking(style: Style, time_s: float, phase: float) -> Angles:
    """Level gait; arms swing against the legs. The phase counts strides, left heel first."""
    swing = np.cos(2.0 * np.pi * phase) * style.reach
    angles = standing(style, time_s) | {
        "pelvis": (3.0, 3.0 * np.sin(2.0 * np.pi * phase), -5.0 * swing),
        "abdomen": (1.0, -2.0 * np.sin(2.0 * np.pi * phase), 4.0 * swing),
        "chest": (2.0, 0.0, 6.0 * swing),
    }
    for side, p, s in (("l", phase, 1.0), ("r", phase + 0.5, -1.0)):
        back = -s * swing  # the arm is behind while the leg of its side is in front
        angles |= {
            f"thigh_{side}": (float(_HIP(p % 1.0)), 1.0, -4.0),
            f"calf_{side}": (float(_KNEE(p % 1.0)), 0.0, 0.0),
            f"foot_{side}": (float(_ANKLE(p % 1.0)), 0.0, 0.0),
            f"upper_arm_{side}": (2.0 + 22.0 * back, 9.0, 8.0),
            f"forearm_{side}": (24.0 + 12.0 * back, 0.0, 15.0),
        }
    return angles


def waving(style: Style, time_s: float, side: Side) -> Angles:
    """One hand beside the head swings from the elbow and the shoulder, about 1.2 times a second."""
    beat = np.sin(2.0 * np.pi * (1.2 * style.tempo * time_s))
    return {
        f"upper_arm_{side}": (28.0 + 4.0 * beat, 74.0 * style.reach + 6.0 * beat, -72.0),
        f"forearm_{side}": (92.0 - 24.0 * style.reach * beat, 0.0, 10.0),
        f"hand_{side}": (0.0, 4.0 - 14.0 * beat, 0.0),
        "chest": (0.0, 3.0 if side == "r" else -3.0, 4.0 if side == "l" else -4.0),
    }


def boxing(style: Style, time_s: float, side: Side) -> Angles:
    """Guard before the chin, and straight punches that take turns; `side` leads."""
    beat = time_s * 0.9 * style.tempo
    angles: Angles = {}
    twist = 0.0
    for hand, shift, outwards in ((side, 0.0, 1.0), ("r" if side == "l" else "l", 0.5, -1.0)):
        out = np.clip(np.sin(2.0 * np.pi * (beat + shift)), 0.0, None) ** 1.5 * style.reach
        out = min(float(out), 1.0)
        angles |= {
            f"upper_arm_{hand}": (30.0 + 56.0 * out, 12.0 + 4.0 * out, 8.0 + 10.0 * out),
            f"forearm_{hand}": (126.0 - 116.0 * out, 0.0, 20.0 + 40.0 * out),
            f"hand_{hand}": (0.0, 0.0, 0.0),
        }
        twist += outwards * 14.0 * out
    if side == "l":
        twist = -twist
    return angles | {
        "pelvis": (3.0, 0.0, 0.2 * twist),
        "abdomen": (4.0, 0.0, 0.3 * twist),
        "chest": (6.0, 0.0, 0.7 * twist),
        "neck": (8.0, 0.0, -0.7 * twist),
    }


def raising_arms(style: Style, time_s: float, side: Side) -> Angles:
    """Both arms go up sideways and down again, every three seconds."""
    del side
    up = 0.5 - 0.5 * np.cos(2.0 * np.pi * time_s * style.tempo / 3.0)
    angles: Angles = {}
    for hand in ("l", "r"):
        angles |= {
            f"upper_arm_{hand}": (8.0 * up, 10.0 + 142.0 * style.reach * up, 10.0 - 20.0 * up),
            f"forearm_{hand}": (16.0 - 8.0 * up, 0.0, 10.0),
        }
    return angles


def reaching(style: Style, time_s: float, side: Side) -> Angles:
    """One arm reaches forward and up, the trunk follows; back again, every three seconds."""
    far = (0.5 - 0.5 * np.cos(2.0 * np.pi * time_s * style.tempo / 3.0)) * style.reach
    to_side = 1.0 if side == "l" else -1.0
    return {
        "abdomen": (9.0 * far, 0.0, -5.0 * to_side * far),
        "chest": (8.0 * far, 0.0, -10.0 * to_side * far),
        "neck": (-4.0 * far, 0.0, 4.0 * to_side * far),
        f"upper_arm_{side}": (6.0 + 92.0 * far, 10.0 + 6.0 * far, 12.0 - 20.0 * far),
        f"forearm_{side}": (18.0 + 42.0 * far * (1.0 - far), 0.0, 15.0),
    }


ACTIONS: Final[dict[ActionName, Callable[[Style, float, Side], Angles]]] = {
    "wave": waving,
    "box": boxing,
    "raise_arms": raising_arms,
    "reach": reaching,
}


# --- together ---------------------------------------------------------------------------------


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
