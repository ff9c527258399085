"""Ellipses of known size and turn, moved onto points by Gauss-Newton steps."""

from __future__ import annotations

from math import cos, sin, sqrt

from numba import njit


@njit(cache=True, error_model="numpy", nogil=True)
def move_ellipses(
    points, semi_axes, turns, expected, weight, scale, prior_weight, iterations, costs, centres
):
    """Fill `costs` [K] and `centres` [K, 2].

    Args:
        points: [N, 2] metres.
        semi_axes: [2] metres, the first along (cos, -sin) of the turn.
        turns: [K] radians.
        expected: [K, 2] metres, where the centres are expected.
        weight: of a point's squared distance, 1 / m^2.
        scale: metres, width of the robust weight.
        prior_weight: of a centre's squared distance from where it is expected, 1 / m^2.
        iterations: steps.
    """
    for k in range(len(turns)):
        centres[k] = expected[k]
        for iteration in range(iterations + 1):
            off_x, off_z = centres[k, 0] - expected[k, 0], centres[k, 1] - expected[k, 1]
            cost, b_x, b_z, a_xx, a_xz, a_zz = _normal_equations(
                points, semi_axes, cos(turns[k]), sin(turns[k]), centres[k], weight, scale
            )
            costs[k] = cost + prior_weight * (off_x**2 + off_z**2)
            if iteration < iterations:
                a_xx, a_zz = a_xx + prior_weight, a_zz + prior_weight
                b_x, b_z = b_x + prior_weight * off_x, b_z + prior_weight * off_z
                determinant = a_xx * a_zz - a_xz * a_xz
                centres[k, 0] -= (a_zz * b_x - a_xz * b_z) / determinant
                centres[k, 1] -= (a_xx * b_z - a_xz * b_x) / determinant


@njit(error_model="numpy", fastmath={"reassoc"})  # sums of several points at once
def _normal_equations(points, semi_axes, c, s, centre, weight, scale):
    """The weighted squares of all points' distances from one ellipse, and its gradient and
    approximate Hessian, halved, by the ellipse's centre."""
    cost = b_x = b_z = a_xx = a_xz = a_zz = 0.0
    inv_x, inv_z, inv_scale = 1.0 / semi_axes[0], 1.0 / semi_axes[1], 1.0 / scale
    for i in range(len(points)):
        x, z = points[i, 0] - centre[0], points[i, 1] - centre[1]
        own_x, own_z = c * x - s * z, s * x + c * z
        unit_x, unit_z = own_x * inv_x, own_z * inv_z
        size = max(sqrt(unit_x * unit_x + unit_z * unit_z), 1e-6)
        slope_x, slope_z = unit_x * inv_x, unit_z * inv_z
        inv_slope = 1.0 / max(sqrt(slope_x * slope_x + slope_z * slope_z), 1e-6)
        gap = (size - 1.0) * size * inv_slope
        n_x, n_z = slope_x * inv_slope, slope_z * inv_slope
        d_x, d_z = -(c * n_x + s * n_z), s * n_x - c * n_z
        robust = 1.0 / (1.0 + gap * inv_scale * (gap * inv_scale))
        cost += weight * robust * gap * gap
        pull = weight * robust * robust
        b_x += pull * d_x * gap
        b_z += pull * d_z * gap
        a_xx += pull * d_x * d_x
        a_xz += pull * d_x * d_z
        a_zz += pull * d_z * d_z
    return cost, b_x, b_z, a_xx, a_xz, a_zz
