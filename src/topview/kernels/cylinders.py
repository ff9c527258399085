"""Scalar leaf functions of closed elliptic cylinders, shared by every loop over hypotheses.

A cylinder lies in its own frame: axis along y from 0 to `length`, semi-axes `rx` and `rz`. The
NumPy definition is `topview.geometry.quadrics.closed_cylinder_depths`.
"""

from __future__ import annotations

from math import sqrt

import numpy as np
from numba import njit

NO_HIT = np.float32(np.inf)


@njit(error_model="numpy", forceinline=True)
def hit_depth(ox, oy, oz, dx, dy, dz, length, inv_rx2, inv_rz2):
    """Depth along a ray `o + t d`, from outside, where it first meets the closed cylinder.

    Nearest root of the side's quadratic (Eq. 4.14) between the end planes, or the facing end disc;
    infinity where the ray misses. Branch-free, so that loops over rays vectorise.
    """
    a = dx * dx * inv_rx2 + dz * dz * inv_rz2
    b = ox * dx * inv_rx2 + oz * dz * inv_rz2
    c = ox * ox * inv_rx2 + oz * oz * inv_rz2 - np.float32(1.0)
    discriminant = b * b - a * c
    t_side = (-b - sqrt(max(discriminant, np.float32(0.0)))) / a
    y_side = oy + t_side * dy
    side = (discriminant >= 0) & (y_side >= 0) & (y_side <= length) & (t_side > 0)
    y_end = np.float32(0.0) if oy < 0 else length
    t_end = (y_end - oy) / dy
    x_end = ox + t_end * dx
    z_end = oz + t_end * dz
    outside_slab = (oy < 0) | (oy > length)
    end = (
        outside_slab
        & (x_end * x_end * inv_rx2 + z_end * z_end * inv_rz2 <= np.float32(1.0))
        & (t_end > 0)
    )
    return t_side if side else (t_end if end else NO_HIT)


@njit(error_model="numpy", forceinline=True)
def is_inside(x, y, z, length, inv_rx2, inv_rz2):
    """True for a point, in the cylinder's frame, within it."""
    return (y >= 0) & (y <= length) & (x * x * inv_rx2 + z * z * inv_rz2 <= np.float32(1.0))


@njit(error_model="numpy", forceinline=True)
def image_box(R, o, length, rx, rz, fx, fy, cx, cy, width, height):
    """Columns u0..u1 and rows v0..v1, ends left out, that a cylinder can cover in an image.

    Args:
        R, o: [3, 3] `R_camera_part` and [3] origin, float32.
        length, rx, rz: float32 metres.
        fx, fy, cx, cy, width, height: of the image, pixels; the intrinsics float32.
    """
    half = np.float32(0.5)
    ex = abs(R[0, 1]) * length * half + rx * abs(R[0, 0]) + rz * abs(R[0, 2])
    ey = abs(R[1, 1]) * length * half + rx * abs(R[1, 0]) + rz * abs(R[1, 2])
    ez = abs(R[2, 1]) * length * half + rx * abs(R[2, 0]) + rz * abs(R[2, 2])
    mx = o[0] + R[0, 1] * length * half
    my = o[1] + R[1, 1] * length * half
    mz = o[2] + R[2, 1] * length * half
    near = max(mz - ez, np.float32(0.05))
    far = max(mz + ez, np.float32(0.05))
    u_low = fx * min((mx - ex) / near, (mx - ex) / far) + cx
    u_high = fx * max((mx + ex) / near, (mx + ex) / far) + cx
    v_low = fy * min((my - ey) / near, (my - ey) / far) + cy
    v_high = fy * max((my + ey) / near, (my + ey) / far) + cy
    u0, u1 = pixels_between(u_low, u_high, width)
    v0, v1 = pixels_between(v_low, v_high, height)
    return u0, u1, v0, v1


@njit(error_model="numpy", forceinline=True)
def pixels_between(low, high, size):
    """The first pixel, and the end, left out, of those from floor(low) to ceil(high) that an image
    of `size` pixels has."""
    limit = np.float32(size)
    first = np.int32(min(max(low, np.float32(0)), limit))
    high = min(max(high, np.float32(-1)), limit)
    below = np.int32(high)
    above = below + np.int32(np.float32(below) < high)
    return first, np.int32(min(above + 1, size))


CORNERS = np.array(
    [(x, y, z) for y in (0, 1) for x, z in ((-1, -1), (-1, 1), (1, 1), (1, -1))], np.float32
)
"""Of the box round a cylinder, in its semi-axes and its length."""
EDGES = np.array(
    [(k, (k + 1) % 4) for k in range(4)]
    + [(k + 4, (k + 1) % 4 + 4) for k in range(4)]
    + [(k, k + 4) for k in range(4)]
)
"""Of that box, as pairs of corners."""


@njit(error_model="numpy")
def outline(R, o, length, rx, rz, fx, fy, cx, cy, u0, u1, v0, v1, corners, span):
    """Fill the rows v0..v1 of `span` [2, H] with the least and greatest column of the box round a
    cylinder; with all columns u0..u1, ends left out, for a box that reaches behind the camera.

    A convex outline is cut by a row where its edges are. `corners` [2, 8] is scratch.
    """
    us, vs = corners[0], corners[1]
    first_column, last_column = np.float32(u0), np.float32(u1 - 1)
    nearest = np.float32(np.inf)
    for k in range(8):
        x, y, z = CORNERS[k, 0] * rx, CORNERS[k, 1] * length, CORNERS[k, 2] * rz
        px = o[0] + R[0, 0] * x + R[0, 1] * y + R[0, 2] * z
        py = o[1] + R[1, 0] * x + R[1, 1] * y + R[1, 2] * z
        pz = o[2] + R[2, 0] * x + R[2, 1] * y + R[2, 2] * z
        nearest = min(nearest, pz)
        us[k] = fx * px / pz + cx
        vs[k] = fy * py / pz + cy
    is_before = nearest > np.float32(0.05)
    for v in range(v0, v1):
        span[0, v] = last_column + np.float32(1) if is_before else first_column
        span[1, v] = first_column - np.float32(1) if is_before else last_column
    if not is_before:
        return
    for e in range(12):
        a, b = EDGES[e, 0], EDGES[e, 1]
        if vs[a] > vs[b]:
            a, b = b, a
        slope = (us[b] - us[a]) / max(vs[b] - vs[a], np.float32(1e-6))
        first = max(v0, np.int32(np.ceil(vs[a])))
        last = min(v1, np.int32(np.floor(vs[b])) + 1)
        for v in range(first, last):
            u = us[a] + (np.float32(v) - vs[a]) * slope
            span[0, v] = min(span[0, v], u)
            span[1, v] = max(span[1, v], u)


@njit(error_model="numpy")
def may_touch(R, o, length, radius, part):
    """Whether a cylinder and a placed part (`placed_parts`) may have a place in common: their axes
    come as near as their radii."""
    reach = radius + np.float32(1.0) / sqrt(min(part[13], part[14]))
    ax, ay, az = R[0, 1] * length, R[1, 1] * length, R[2, 1] * length
    bx, by, bz = part[1] * part[12], part[4] * part[12], part[7] * part[12]
    gx, gy, gz = o[0] - part[9], o[1] - part[10], o[2] - part[11]
    aa = ax * ax + ay * ay + az * az
    bb = bx * bx + by * by + bz * bz
    ab = ax * bx + ay * by + az * bz
    ag = ax * gx + ay * gy + az * gz
    bg = bx * gx + by * gy + bz * gz
    zero, one = np.float32(0.0), np.float32(1.0)
    s = min(max((ab * bg - ag * bb) / max(aa * bb - ab * ab, np.float32(1e-9)), zero), one)
    t = (ab * s + bg) / bb
    if t < zero or t > one:
        t = min(max(t, zero), one)
        s = min(max((ab * t - ag) / aa, zero), one)
    dx, dy, dz = gx + s * ax - t * bx, gy + s * ay - t * by, gz + s * az - t * bz
    return dx * dx + dy * dy + dz * dz <= reach * reach
