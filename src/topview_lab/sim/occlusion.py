"""What hides joints and body parts from the camera: samples of them against an ideal image.

A part's samples are the surface that it would show if nothing else existed: a grid of rays over
its bounds is intersected with its own flesh only. A joint's samples fill a disc that faces the
camera. A sample is hidden where the image of the whole scene shows something in front of it.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.camera.projection import project
from topview.records import Camera, read_only
from topview_lab.sim.bodies import SIM_JOINT_NAMES, SIM_PART_NAMES
from topview_lab.sim.images import FURNITURE, Rendering
from topview_lab.sim.primitives import NEAREST_DRAWN_M, RoundCones

RAYS_PER_SIDE: Final = 12
"""Of the grid over a part's bounds (ours): a part is hit by some 70 of its 144 rays."""
ROOT_M: Final = 0.08
"""Flesh of a part that shares a joint hides only from this far in front, as connected limbs overlap
(ours: about the thickness of an arm)."""
TOUCH_M: Final = 0.005
"""A surface hides a sample only from this far in front, as a ray and its pixel differ (ours)."""
DISC_SHARE: Final = 0.8
"""Radius of a joint's disc, as a share of the flesh's half breadth there (ours)."""

_PARTS_OF_JOINT: Final = {
    "head_top": ("head",), "head": ("head",), "neck": ("head", "upper_torso"),
    "torso": ("upper_torso", "lower_torso"),
    "pelvis": ("lower_torso", "upper_leg_l", "upper_leg_r"),
    "shoulder": ("upper_torso", "upper_arm"), "elbow": ("upper_arm", "forearm"),
    "wrist": ("forearm", "hand"), "hand": ("hand",),
    "hip": ("lower_torso", "upper_leg"), "knee": ("upper_leg", "lower_leg"),
    "ankle": ("lower_leg", "foot"), "foot": ("foot",),
}  # fmt: skip


def _carriers() -> NDArray[np.bool_]:
    """[J, 256] True for the part labels that a joint belongs to."""
    table = np.zeros((len(SIM_JOINT_NAMES), 256), np.bool_)
    for j, name in enumerate(SIM_JOINT_NAMES):
        stem, side = (name[:-2], name[-2:]) if name[-2:] in ("_l", "_r") else (name, "")
        for part in _PARTS_OF_JOINT[stem]:
            label = part if part in SIM_PART_NAMES else part + side
            table[j, SIM_PART_NAMES.index(label)] = True
    return table


def _disc(rings: int = 4) -> NDArray[np.float64]:
    """[K, 2] points that fill the unit disc evenly."""
    radii = (np.arange(rings) + 0.5) / rings
    points = [
        radius * np.array([np.cos(angle), np.sin(angle)])
        for ring, radius in enumerate(radii)
        for angle in 2.0 * np.pi * (np.arange(6 * ring + 3) + 0.5 * ring) / (6 * ring + 3)
    ]
    return np.array(points)


def _part_margins(carriers: NDArray[np.bool_]) -> NDArray[np.float64]:
    """[B, 256] see `Samples.margins_m`."""
    of_part = carriers[:, : len(SIM_PART_NAMES)].astype(int)
    margins_m = np.full((len(SIM_PART_NAMES), 256), TOUCH_M)
    margins_m[:, : len(SIM_PART_NAMES)] = np.where(of_part.T @ of_part > 0, ROOT_M, TOUCH_M)
    np.fill_diagonal(margins_m, np.inf)
    return margins_m


_CARRIERS: Final = read_only(_carriers())
_PART_MARGINS_M: Final = read_only(_part_margins(_CARRIERS))
_DISC: Final = read_only(DISC_SHARE * _disc())


@dataclass(frozen=True, slots=True, eq=False)
class Samples:
    """S samples of each of N joints or parts of one person.

    Attributes:
        pixels: [N, S, 2] where they appear in the image plane.
        depth_m: [N, S] how far away, inf for samples that do not count.
        margins_m: [N, 256] how far in front the own flesh of each part label must be to hide them.
        other_margin_m: the same for everything that is not the own body.
        area: [N] of all samples that count, as seen by the camera, in squared z = 1 units.
    """

    pixels: NDArray[np.float64]
    depth_m: NDArray[np.float64]
    margins_m: NDArray[np.float64]
    other_margin_m: float
    area: NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class OcclusionShares:
    """Shares 0..1 of [...] joints, parts or people that are hidden, by cause.

    Attributes:
        by: [..., P] hidden by each person, 0 for the person itself.
        by_furniture, by_self, outside: [...] hidden by furniture or the own body, or outside of
            the image.
    """

    by: NDArray[np.float64]
    by_furniture: NDArray[np.float64]
    by_self: NDArray[np.float64]
    outside: NDArray[np.float64]

    @classmethod
    def stacked(cls, hidden: list[OcclusionShares]) -> OcclusionShares:
        """Stack several along a new first axis."""
        return cls(*(np.stack([getattr(h, field.name) for h in hidden]) for field in fields(cls)))

    def mean(self, weights: NDArray[np.float64]) -> OcclusionShares:
        """The weighted mean over the last axis; weights are [..., N]."""
        weights = weights / np.maximum(weights.sum(-1, keepdims=True), np.finfo(float).tiny)
        return OcclusionShares(
            np.einsum("...n,...np->...p", weights, self.by),
            *((weights * s).sum(-1) for s in (self.by_furniture, self.by_self, self.outside)),
        )


def joint_samples(
    joints_camera: NDArray[np.float64], radii_m: NDArray[np.float64], camera: Camera
) -> Samples:
    """Camera-facing discs around joints [J, 3] whose flesh has half breadths [J]."""
    points = np.repeat(joints_camera[:, None], len(_DISC), axis=1)
    points[..., :2] += radii_m[:, None, None] * _DISC
    return Samples(
        pixels=project(points, camera),
        depth_m=points[..., 2],
        # The near hip hides the far one in profile, and belongs to the same lower torso.
        margins_m=2.0 * radii_m[:, None] * _CARRIERS,
        other_margin_m=0.0,
        area=np.pi * (DISC_SHARE * radii_m / joints_camera[:, 2]) ** 2,
    )


def part_samples(solids: RoundCones, parts: NDArray[np.uint8], camera: Camera) -> Samples:
    """Points of the surface that each part would show if it were alone.

    Args:
        solids: [N] pieces of one person's flesh in the camera frame.
        parts: [N] the part of each.
        camera: whose image the samples are for.
    """
    low, high = _bounds(solids, parts)
    steps = (np.arange(RAYS_PER_SIDE) + 0.5) / RAYS_PER_SIDE
    grid = np.stack(np.meshgrid(steps, steps), -1).reshape(-1, 2)
    slopes = low[:, None] + (high - low)[:, None] * grid
    rays = np.concatenate([slopes, np.ones((*slopes.shape[:2], 1))], -1)
    depth_m = np.full(rays.shape[:2], np.inf)
    np.minimum.at(depth_m, parts, _entries(solids, rays[parts]))
    hits = np.isfinite(depth_m).sum(-1)
    return Samples(
        pixels=project(rays, camera),
        depth_m=depth_m,
        margins_m=_PART_MARGINS_M,
        other_margin_m=TOUCH_M,
        area=hits * np.prod(high - low, axis=-1) / len(grid),
    )


def _bounds(
    solids: RoundCones, parts: NDArray[np.uint8]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """[B, 2] least and greatest x / z, y / z of each part, a little too wide; empty where a part
    lies behind the camera."""
    reach = np.linalg.norm(solids.axes * solids.scales[:, None, :], axis=-1)
    low = np.full((len(SIM_PART_NAMES), 2), np.inf)
    high = -low
    for centres, radii in (
        (solids.starts, solids.start_radii),
        (solids.ends, solids.end_radii),
    ):
        extent = reach * radii[:, None]
        near, far = (
            np.maximum(centres[:, 2] + sign * extent[:, 2], NEAREST_DRAWN_M)[:, None]
            for sign in (-1.0, 1.0)
        )
        first, last = centres[:, :2] - extent[:, :2], centres[:, :2] + extent[:, :2]
        np.minimum.at(low, parts, np.minimum(first / near, first / far))
        np.maximum.at(high, parts, np.maximum(last / near, last / far))
    return low, high


def _entries(solids: RoundCones, rays: NDArray[np.float64]) -> NDArray[np.float64]:
    """[N, S] depth at which rays [N, S, 3] with z = 1 enter each solid, inf where they miss.

    After I. Quilez, "round cone" (iquilezles.org/articles/intersectors).
    """
    maps = solids.local_maps()
    d = rays @ np.swapaxes(maps, -1, -2)
    start, end = (np.einsum("nij,nj->ni", maps, at) for at in (solids.starts, solids.ends))
    dd = (d * d).sum(-1)

    def ball(centre: NDArray[np.float64], radius: NDArray[np.float64]) -> NDArray[np.float64]:
        dc = np.einsum("nsi,ni->ns", d, centre)
        return _first_root(dd, -dc, ((centre**2).sum(-1) - radius**2)[:, None])

    axis, radius = end - start, solids.start_radii
    taper = radius - solids.end_radii
    length2 = (axis**2).sum(-1)
    side2 = length2 - taper**2
    along, da = -(axis * start).sum(-1), np.einsum("nsi,ni->ns", d, axis)
    k2 = side2[:, None] * dd - da**2
    k1 = (radius * taper - along)[:, None] * da - side2[:, None] * np.einsum("nsi,ni->ns", d, start)
    k0 = side2 * (start**2).sum(-1) - along**2 + radius * (2.0 * taper * along - length2 * radius)
    t = _first_root(k2, k1, k0[:, None])
    with np.errstate(invalid="ignore"):
        height = (along - radius * taper)[:, None] + t * da
        t[~((height > 0.0) & (height < side2[:, None]))] = np.inf
    return np.minimum(t, np.minimum(ball(start, radius), ball(end, solids.end_radii)))


def _first_root(
    k2: NDArray[np.float64], k1: NDArray[np.float64], k0: NDArray[np.float64]
) -> NDArray[np.float64]:
    """The lesser root of k2 t^2 + 2 k1 t + k0 where it lies in front of the camera, else inf."""
    with np.errstate(invalid="ignore", divide="ignore"):
        t = (-k1 - np.sqrt(k1 * k1 - k0 * k2)) / k2
        return np.where(t > NEAREST_DRAWN_M, t, np.inf)


def hidden_shares(
    samples: Samples, person: int, people: int, rendering: Rendering, camera: Camera
) -> OcclusionShares:
    """The share of one person's joints or parts that is hidden, by each cause.

    Args:
        samples: of N joints or parts.
        person: number of that person, counted from 1.
        people: number of people in the scene.
        rendering: the noise-free images of the whole scene.
        camera: of these images.
    """
    counts = np.isfinite(samples.depth_m)
    beyond = (camera.width - 0.5, camera.height - 0.5)
    is_inside = counts & np.all((samples.pixels >= -0.5) & (samples.pixels < beyond), axis=-1)
    u, v = np.where(is_inside[..., None], np.rint(samples.pixels), 0).astype(np.intp).T
    u, v = u.T, v.T
    instance, part = rendering.instance[v, u], rendering.part[v, u]
    ahead_m = np.where(is_inside, samples.depth_m - rendering.depth_m[v, u], -np.inf)

    margin_m = samples.margins_m[np.arange(len(part))[:, None], part]
    is_own, is_front = instance == person, ahead_m > samples.other_margin_m
    total = np.maximum(counts.sum(-1), 1)
    by = [
        (is_front & (instance == k) & (k != person)).sum(-1) / total for k in range(1, people + 1)
    ]
    return OcclusionShares(
        by=np.stack(by, -1),
        by_furniture=(is_front & (instance == FURNITURE)).sum(-1) / total,
        by_self=(is_own & (ahead_m > margin_m)).sum(-1) / total,
        outside=np.where(counts.any(-1), (counts & ~is_inside).sum(-1) / total, 1.0),
    )
