"""Where somebody may be whose head is not seen: samples of the place, and what is seen there.

Free space that is seen where somebody should be speaks against it, and so does a place that is
another's or behind the room's end; one behind cover, or out of the picture, does not. So the
samples that are left say where the person is, how sure that is, and whether the person is there at
all.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import hypot, log, pi, sqrt
from typing import Final

import msgspec
import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray

from topview.detect.heads import HEAD_RADIUS_M, right_of
from topview.filter.particles import generator, systematic_resample, time_key
from topview.people.motion import PAUSE_S, Motion
from topview.room.scene import Scene

Vector = NDArray[np.float64]

# All ours.
SAMPLES: Final = 64
# How different a hidden person's velocity may be from that of the walk that was seen (Student's
# law: some turn as they come to be hidden). So that as many are near the place as is stated: of
# rendered people of whom nothing was seen (seeds 100 to 103, 110 to 117, 130 to 137) 92 % were
# within `PLACE_M` after 0.5 s, 87 % after 0.8 s. Half of the samples walk on, half stop: over
# which times their walks fade.
SPEED_M_PER_S, TURN_FREEDOM = 0.25, 3
WALK_ON_S, STOP_S = 4.0, 0.4
# Who stands sets out again so often, and walks so fast (standard deviation along each axis).
SETS_OUT_PER_S, WALK_M_PER_S = 0.2, 0.7
# How soon it is noticed that a head is not where it would be seen, per second: in free space; at a
# surface that is no head; behind cover; and how soon somebody out of the picture has gone for good.
FREE_PER_S, SURFACE_PER_S, HIDDEN_PER_S, OUTSIDE_PER_S = 15.0, 2.0, 0.02, 0.1
# Two heads that are told from each other are not nearer, seen from above; a shoulder is nearer to
# its own head. In no hug are their centres nearer than a head is broad.
HEADS_APART_M, SAME_HEAD_M = 0.33, 0.2
# What random numbers are for.
BEGIN, STEP, RESAMPLE = range(3)
# A head that comes back is this far from one of the samples; up and down it is nearer.
SPREAD_M, RISE_M = 0.2, 0.06
# By so much hidden heads rise and sink in a second, and as the root of longer times (of rendered
# people, seeds 0 to 6, of whom less than 30 % was seen: 6 cm in 1 s, 9 cm in 2 s).
RISE_M_PER_ROOT_S: Final = 0.065
# For so long an error of where a body, or a hidden head, is seen stays the same.
ALIKE_S: Final = 0.15
# The width of the Gaussian that each sample stands for, as a share of their spread (the best for
# two dimensions, were they one Gaussian).
KERNEL: Final = SAMPLES ** (-1 / 6)
# Samples that are all less likely than this were wrong: they are moved.
LEAST_LIKELY: Final = 1e-3
# Whoever was seen a moment ago, or whose body is, is there so surely.
SURELY_THERE: Final = 0.99
# "There" is no farther away than this; two people who touch are.
PLACE_M: Final = 0.4


class Places(msgspec.Struct, frozen=True, eq=False):
    """Samples of the place of one head on the overview.

    Attributes:
        overview_m: [K, 2] metres to the right and forward.
        velocity: [K, 2] metres per second.
        memory_s: [K] over which the velocity fades.
        rise_m: [K] by how much each head is higher than `height_m`.
        weights: [K], which sum to 1.
        height_m: of the head, along up.
        height_sigma_m: its standard deviation.
        presence: probability that the person is at one of the places, and not gone.
        outside: share of the places that are out of the picture.
    """

    overview_m: Vector
    velocity: Vector
    memory_s: Vector
    rise_m: Vector
    weights: Vector
    height_m: float
    height_sigma_m: float
    presence: float = SURELY_THERE
    outside: float = 0.0

    @classmethod
    def around(cls, scene: Scene, motion: Motion, key: int) -> Places:
        """Of a head that was seen until now; `key` tells one track's random numbers from
        another's."""
        random = _generator(scene, key, BEGIN)
        noise = random.standard_normal((SAMPLES, 3))
        turns = random.standard_t(TURN_FREEDOM, (SAMPLES, 2))
        overview_m = scene.overview_of(motion.position_camera)
        velocity = scene.overview_of(motion.walk)
        return cls(
            overview_m + motion.sigma_m * noise[:, :2],
            velocity + SPEED_M_PER_S * turns,
            np.where(np.arange(SAMPLES) % 2, WALK_ON_S, STOP_S),
            RISE_M * noise[:, 2],
            np.full(SAMPLES, 1.0 / SAMPLES),
            scene.height_of(motion.position_camera),
            motion.sigma_m,
        )

    def seen(
        self, scene: Scene, elapsed_s: float, key: int, others_camera: Sequence[Vector] = ()
    ) -> Places:
        """Some time later, with what the scene shows at each of them, and where others' heads are,
        [3] each."""
        step_s = min(max(elapsed_s, 0.0), PAUSE_S)
        kept = np.exp(-step_s / self.memory_s)[:, None]
        random = _generator(scene, key, STEP)
        sets_out = random.random(SAMPLES) < 1.0 - np.exp(-SETS_OUT_PER_S * step_s)
        walk = WALK_M_PER_S * random.standard_normal((SAMPLES, 2))
        moved = replace(
            self,
            overview_m=self.overview_m + step_s * self.velocity,
            velocity=np.where(sets_out[:, None], walk, kept * self.velocity),
            memory_s=np.where(sets_out, WALK_ON_S, self.memory_s),
            height_sigma_m=hypot(self.height_sigma_m, RISE_M_PER_ROOT_S * sqrt(step_s)),
        )
        depth_m, z_m, is_inside = moved._looked_up(scene)
        is_in_room = is_inside & (z_m < scene.room_ends_m)
        is_read = is_in_room & (depth_m > 0.0)
        is_hidden = is_in_room & moved._is_covered(scene)
        is_surface = is_read & ~is_hidden & (depth_m < z_m + 2 * HEAD_RADIUS_M)
        rates = np.where(
            is_inside,
            np.where(is_hidden, HIDDEN_PER_S, np.where(is_surface, SURFACE_PER_S, FREE_PER_S)),
            OUTSIDE_PER_S,
        )
        for other in others_camera:
            aside_m = np.linalg.norm(moved.overview_m - scene.overview_of(other), axis=1)
            above_m = self.height_m + self.rise_m - scene.height_of(other)
            rates[np.hypot(aside_m, above_m) < SAME_HEAD_M] = FREE_PER_S
        likely = self.weights * np.exp(-rates * step_s)
        left = float(likely.sum())
        presence = self.presence * left / (1.0 - self.presence + self.presence * left)
        weights = likely / max(left, 1e-300)
        outside = float(weights[~is_inside].sum())
        if 1.0 / float(weights @ weights) > 0.5 * SAMPLES:
            return replace(moved, weights=weights, presence=presence, outside=outside)
        kept_ones = systematic_resample(weights, SAMPLES, _generator(scene, key, RESAMPLE))
        return replace(
            moved,
            overview_m=moved.overview_m[kept_ones],
            velocity=moved.velocity[kept_ones],
            memory_s=moved.memory_s[kept_ones],
            rise_m=moved.rise_m[kept_ones],
            weights=np.full(SAMPLES, 1.0 / SAMPLES),
            presence=presence,
            outside=outside,
        )

    def drawn_to(
        self, overview_m: Vector, height_m: float | None, sigma_m: float, elapsed_s: float
    ) -> Places:
        """Where the body is seen, the head is over it ([2] metres) but for an error, which is much
        the same from frame to frame: so somebody is there. Its height counts as surely, if told.

        Each sample stands for all places near it, as a Gaussian (the regularized particle filter:
        Musso, Oudjane, Le Gland 2001), whose mean moves: no sample may be where the head is.
        """
        offsets = self.overview_m - overview_m
        variance_m2 = repeated_m(sigma_m, elapsed_s) ** 2
        drawn = replace(self, presence=SURELY_THERE)
        if height_m is not None:
            kept = variance_m2 / (self.height_sigma_m**2 + variance_m2)
            drawn = replace(
                drawn,
                height_m=kept * self.height_m + (1.0 - kept) * height_m,
                height_sigma_m=sqrt(kept) * self.height_sigma_m,
            )
        own_m2 = (KERNEL * self.sigma_m) ** 2
        squares = np.einsum("ij,ij->i", offsets, offsets) / (variance_m2 + own_m2)
        likely = self.weights * np.exp(-0.5 * squares)
        total = float(likely.sum())
        if total < LEAST_LIKELY:
            shifted = self.overview_m + (overview_m - self.weights @ self.overview_m)
            return replace(drawn, overview_m=shifted)
        moved = self.overview_m - own_m2 / (variance_m2 + own_m2) * offsets
        return replace(drawn, overview_m=moved, weights=likely / total)

    def best(self, scene: Scene) -> tuple[Vector, float]:
        """[3] the head's most likely place, and the probability that it is within `PLACE_M`
        of there."""
        offsets = self.overview_m[:, None] - self.overview_m
        is_near = np.einsum("ijk,ijk->ij", offsets, offsets) < PLACE_M**2
        share = is_near @ self.weights
        best = int(np.argmax(share))
        mean = (self.weights * is_near[best]) @ self.overview_m / share[best]
        return scene.point_at(mean, self.height_m), float(share[best])

    @property
    def sigma_m(self) -> float:
        """Standard deviation along each axis of the floor."""
        offsets = self.overview_m - self.weights @ self.overview_m
        return float(np.sqrt(0.5 * (self.weights @ np.square(offsets).sum(axis=1))))

    def log_density(self, scene: Scene, head_camera: Vector) -> float:
        """Of a head measured at [3], per cubic metre."""
        offsets = scene.overview_of(head_camera) - self.overview_m
        squares = np.einsum("ij,ij->i", offsets, offsets) / SPREAD_M**2
        across = float(self.weights @ np.exp(-0.5 * squares)) / (2.0 * pi * SPREAD_M**2)
        rise_m = hypot(self.height_sigma_m, RISE_M)
        up = (scene.height_of(head_camera) - self.height_m) / rise_m
        return log(max(across, 1e-300)) - 0.5 * up**2 - 0.5 * log(2.0 * pi * rise_m**2)

    def _is_covered(self, scene: Scene) -> NDArray[np.bool_]:
        """[K] whether something nearer hides the head at each place, or one side of it."""
        aside = HEAD_RADIUS_M * right_of(scene.up_camera)
        is_covered = np.zeros(SAMPLES, np.bool_)
        for offset in (-aside, 0.0 * aside, aside):
            depth_m, z_m, is_inside = self._looked_up(scene, offset)
            is_covered |= is_inside & (depth_m > 0.0) & (depth_m < z_m - 2 * HEAD_RADIUS_M)
        return is_covered

    def _looked_up(
        self, scene: Scene, offset: Vector | float = 0.0
    ) -> tuple[NDArray[np.float32], Vector, NDArray[np.bool_]]:
        """[K] the depth seen in the direction of each place, or [3] beside it, its own depth, and
        whether it is in the picture."""
        points = scene.point_at(self.overview_m, self.height_m) + offset
        points += self.rise_m[:, None] * scene.up_camera
        depth_m, is_inside = scene.cloud.lookup(points.T)
        return depth_m, points[:, 2], is_inside & (points[:, 2] > HEAD_RADIUS_M)


def repeated_m(sigma_m: float, elapsed_s: float) -> float:
    """The standard deviation, in each of several frames, of a measurement whose error stays the
    same for a while: so that together they know no more than one that is so exact."""
    return sigma_m / sqrt(min(max(elapsed_s, 1e-3) / ALIKE_S, 1.0))


def _generator(scene: Scene, key: int, purpose: int) -> np.random.Generator:
    """Of random numbers that belong to a track, a moment and what they are for."""
    return generator(0, key, time_key(scene.time_s), purpose)
