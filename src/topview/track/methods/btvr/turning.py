"""The torso's yaw: a belief over all turns, from the ellipses that its points fit (Sec. 5.1.4).

An elliptic torso looks alike from front and back, but for the head, which is before its middle;
and seen from the side, little tells which way it is turned. So every turn is believed in to some
degree (ours), and the belief is carried from frame to frame.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from topview.track.methods.btvr.ellipses import EllipseSettings, fit_ellipses

Array = NDArray[np.float64]

N_TURNS = 60
TURNS_RAD: Array = np.linspace(-np.pi, np.pi, N_TURNS, endpoint=False, dtype=np.float64)
LEAST_POINTS = 15  # ours: fewer tell nothing
MOST_POINTS = 200  # ours: more did not make it better


@dataclass(frozen=True, slots=True)
class Slice:
    """A piece of the torso that is looked at along its axis; shares of the stature, ours.

    Attributes:
        top, bottom: from the neck joint down.
        semi_axes: of its ellipse, across and from back to front.
        reach: points this near to the axis are heeded.
    """

    top: float
    bottom: float
    semi_axes: tuple[float, float]
    reach: float


SHOULDERS = Slice(0.0, 0.07, (0.13, 0.06), 0.16)
TRUNK = Slice(0.08, 0.31, (0.095, 0.065), 0.12)


@dataclass(frozen=True, slots=True)
class TurnSettings:
    """Ours; radians.

    Attributes:
        first_sigma_rad: from facing the camera, of somebody new.
        step_rad: by how much somebody may turn between two frames.
        heed: share of a frame's evidence that counts: frames in a row err alike.
        doubt: share of the evidence for a turn that may be wrong altogether.
        front_limit: by how much a turn may be likelier than its opposite in one frame, in a
            logarithm: only where the head is tells them apart.
        slices: of the torso, which are looked at.
        fit: of the ellipses.
        within_rad: the mean is taken over the turns this near to the likeliest.
    """

    first_sigma_rad: float = 1.2
    step_rad: float = 0.06
    heed: float = 0.2
    doubt: float = 1e-4
    front_limit: float = 0.1
    slices: tuple[Slice, ...] = (SHOULDERS, TRUNK)
    fit: EllipseSettings = field(default_factory=EllipseSettings)
    within_rad: float = 0.6


class TurnFilter:
    """One person's yaw over time, from facing the camera."""

    def __init__(self, settings: TurnSettings) -> None:
        self.settings = settings
        self._belief = _normalised(np.exp(-0.5 * (TURNS_RAD / settings.first_sigma_rad) ** 2))

    @property
    def turn_rad(self) -> float:
        """The mean of the turns around the likeliest one."""
        near = np.convolve(np.tile(self._belief, 3), np.ones(5), "same")[N_TURNS : 2 * N_TURNS]
        middle = TURNS_RAD[int(np.argmax(near))]
        off = _wrapped(TURNS_RAD - middle)
        weights = np.where(np.abs(off) < self.settings.within_rad, self._belief, 0.0)
        return float(_wrapped(middle + (weights @ off) / weights.sum()))

    def update(self, points: Array, stature_m: float, behind: float) -> float:
        """The turn in the next frame.

        Args:
            points: [N, 3] metres in the frame of a torso that faces the camera, from where the
                height of the neck joint crosses the line from the head along the torso.
            stature_m: of its owner.
            behind: share of it by which the torso's middle is behind that line, which tells front
                and back apart.
        """
        s = self.settings
        self._belief = self._moved()
        costs = np.zeros(N_TURNS)
        for piece in s.slices:
            costs += self._costs(points, stature_m, behind, piece)
        log_likelihood = self._limited(-0.5 * s.heed * (costs - costs.min()))
        self._belief = _normalised(self._belief * (np.exp(log_likelihood) + s.doubt))
        return self.turn_rad

    def heed(self, log_likelihood: Array) -> None:
        """Take other evidence into account, [N_TURNS] for `TURNS_RAD`."""
        self._belief = _normalised(self._belief * np.exp(log_likelihood))

    def _limited(self, log_likelihood: Array) -> Array:
        """[N_TURNS] the same, with opposite turns, of which only the head tells the one from the
        other, not too far apart."""
        half = N_TURNS // 2
        opposite = np.roll(log_likelihood, half)
        return np.maximum(log_likelihood, opposite - self.settings.front_limit)

    def _moved(self) -> Array:
        """The belief when everybody may have turned a little."""
        off = _wrapped(TURNS_RAD - TURNS_RAD[0])
        kernel = np.exp(-0.5 * (off / self.settings.step_rad) ** 2)
        moved = np.fft.ifft(np.fft.fft(self._belief) * np.fft.fft(kernel / kernel.sum()))
        return _normalised(np.maximum(np.real(moved), 1e-9))

    def _costs(self, points: Array, stature_m: float, behind: float, piece: Slice) -> Array:
        """[N_TURNS] squares of standard deviations."""
        x, y, z = points.T / stature_m
        inside = (y > piece.top) & (y < piece.bottom) & (np.hypot(x, z) < piece.reach)
        chosen = points[inside][:, [0, 2]]
        if len(chosen) < LEAST_POINTS:
            return np.zeros(N_TURNS)
        semi_axes_m = stature_m * np.array(piece.semi_axes)
        centres = -behind * stature_m * np.stack([np.sin(TURNS_RAD), np.cos(TURNS_RAD)], axis=1)
        step = max(1, len(chosen) // MOST_POINTS)
        return fit_ellipses(chosen[::step], semi_axes_m, TURNS_RAD, centres, self.settings.fit)[0]


def _normalised(belief: Array) -> Array:
    return belief / belief.sum()


def _wrapped(angle_rad: Array) -> Array:
    """The same angles in -180..180 degrees."""
    return (angle_rad + np.pi) % (2 * np.pi) - np.pi
