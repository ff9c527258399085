"""An elliptic cylinder of known size, fitted to points of which only a side may be seen.

Seen along its axis it is the ellipse of Fig. 5.3 a, which tells yaw and place. Here (ours) the
ellipse may also slide along the axis a little: where its points lie too near at one end and too
far at the other, the axis leans.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class FitSettings:
    """Ours; metres and radians.

    Attributes:
        scale_m: width of the robust weight: sleeves and folds of cloth are off the cylinder.
        iterations: Gauss-Newton steps.
        worth: how many independent readings a wholly seen side is worth: neighbouring points err
            alike, as the body is no cylinder.
        noise_m: of such a reading.
        centre_sigma_m, lean_sigma_rad, turn_sigma_rad: how far the cylinder may be from where it
            is expected: across its axis, in the axis itself, and about it.
    """

    scale_m: float = 0.05
    iterations: int = 8
    worth: float = 30.0
    noise_m: float = 0.02
    centre_sigma_m: float = 0.03
    lean_sigma_rad: float = 0.12
    turn_sigma_rad: float = 0.15


@dataclass(frozen=True, slots=True, eq=False)
class FittedCylinder:
    """Where the cylinder is, in the frame in which it was expected.

    Attributes:
        centre: [2] metres, x and z of the axis at y = 0.
        lean: [2] by how much the axis goes on along x and z for each metre along y.
        turn_rad: about y.
        cost: lower where it fits better.
    """

    centre: Array
    lean: Array
    turn_rad: float
    cost: float


def fit_cylinder(
    points: Array,
    semi_axes_m: Array,
    turn_rad: float,
    seen_share: float,
    settings: FitSettings,
    expected_turn_rad: float | None = None,
    hold: float = 1.0,
) -> FittedCylinder:
    """Move, lean and turn a cylinder of fixed size onto points.

    Args:
        points: [N, 3] metres, in the frame in which the cylinder is expected along y.
        semi_axes_m: [2] along x and z.
        turn_rad: where the search starts.
        seen_share: of the visible side that has points, 0 to 1; what is not seen does not pull.
        settings: of the fit.
        expected_turn_rad: what the turn is held to; None leaves it free.
        hold: how many times more firmly all is held than the settings say.
    """
    s = settings
    is_free = expected_turn_rad is None
    state = np.array([0.0, 0.0, 0.0, 0.0, turn_rad])
    held = np.array([0.0, 0.0, 0.0, 0.0, turn_rad if is_free else expected_turn_rad])
    sigmas = [s.centre_sigma_m] * 2 + [s.lean_sigma_rad] * 2 + [s.turn_sigma_rad]
    holds = hold**2 * np.array(sigmas) ** -2.0
    if is_free:
        holds[4] = 1e-3  # so that a circle can be solved for
    weight = s.worth * min(seen_share, 1.0) / (max(len(points), 1) * s.noise_m**2)
    cost = 0.0
    for iteration in range(s.iterations + 1):
        gaps, slopes = _gaps(points, semi_axes_m, state)
        robust = 1.0 / (1.0 + (gaps / s.scale_m) ** 2)
        off = state - held
        cost = float(weight * (robust * gaps**2).sum() + (holds * off**2).sum())
        if iteration < s.iterations:
            pull = weight * robust**2
            A = (slopes * pull[:, None]).T @ slopes + np.diag(holds)
            step = np.linalg.solve(A, slopes.T @ (pull * gaps) + holds * off)
            state = state - np.asarray(step, np.float64)
    return FittedCylinder(state[:2], state[2:4], float(state[4]), cost)


def _gaps(points: Array, semi_axes_m: Array, state: Array) -> tuple[Array, Array]:
    """[N] signed distances to the surface, to first order, and their [N, 5] slopes by the state."""
    c, s = np.cos(state[4]), np.sin(state[4])
    R = np.array([[c, -s], [s, c]])  # from the expected axes to the ellipse's own
    along = points[:, 1:2]
    own = (points[:, [0, 2]] - state[:2] - along * state[2:4]) @ R.T
    size = np.maximum(np.sqrt(((own / semi_axes_m) ** 2).sum(1)), 1e-6)
    gradient = own / semi_axes_m**2 / size[:, None]
    steepness = np.maximum(np.linalg.norm(gradient, axis=1), 1e-6)
    normal = gradient / steepness[:, None]
    by_turn = normal[:, 1] * own[:, 0] - normal[:, 0] * own[:, 1]
    by_centre = -normal @ R
    return (size - 1.0) / steepness, np.concatenate(
        [by_centre, along * by_centre, by_turn[:, None]], axis=1
    )
