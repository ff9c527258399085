"""What people do: curves of joint angles over time.

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

Side = Literal["l", "r"]
Angles = dict[str, tuple[float, float, float]]
ActionName = Literal["wave", "box", "raise_arms", "reach"]


@dataclass(frozen=True, slots=True, eq=False)
class Style:
    """What is a person's own in the motions.

    Attributes:
        tempo: speed of actions relative to the mean.
        reach: size of movements relative to the mean.
        waves: [K, 3] frequency in Hz, phase in radians and size of the slow drifts of a person who
            only stands.
    """

    tempo: float
    reach: float
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
            waves=waves,
        )

    def drift(self, time_s: float, k: int) -> float:
        """Slow drift number k, about -1 to 1."""
        frequency, phase, size = self.waves[[k, (k + 7) % len(self.waves)]].T
        return float(0.6 * (size * np.sin(2.0 * np.pi * frequency * time_s + phase)).sum())


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
