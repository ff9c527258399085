"""The particle filters of the parts in one frame: sample, evaluate, keep the N best (Sec. 5.3.2).

Where the thesis leaves a point open:

- The depth image does not show the turn of a circular cylinder about its own axis. An upper arm or
  upper leg is scored by its direction alone. Its turn follows from the direction in which the
  forearm or lower leg bends; that part's hypotheses are valid where both parts keep within Table
  3.2.
- A part without evidence keeps its direction of the frame before.
- Collisions are counted with placed parts: the same person's, and those of whoever stands nearer.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import sqrt
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.body.parts import HEAD, PARTS, UPPER_TORSO
from topview.filter.particles import importance_weights, n_best, systematic_resample
from topview.geometry.rotations import rotations_from_angles
from topview.score.utvr import MIN_POINTS_INSIDE, UtvrTerms, score_hypotheses
from topview.track.body_tracker import Subject
from topview.track.evidence import Evidence, columns
from topview.track.methods.btvr.torso import turned_to, views_around
from topview.track.methods.utvr.particles import Particles, mean_rotation, turns_rad
from topview.track.methods.utvr.placed_body import TORSO_PARTS, Cloud, PlacedBody
from topview.track.methods.utvr.settings import UtvrSettings

Array = NDArray[np.float64]

# All ours.
# How far hypotheses are turned about a part's x, y and z in the first round, in radians; those of
# the torso go for the head as well.
TORSO_SIGMA_RAD: Final = (0.06, 0.08, 0.06)
LIMB_SIGMA_RAD: Final = (0.35, 0.0, 0.35)
SPREADING: Final = 1.3  # in `FRAME_S` a part without evidence comes to be searched so much wider
WIDEST: Final = 2.0  # up to this, which is also how wide a person's first frame is searched

NO_ROTATIONS: Final = np.empty((0, 3, 3))


class PartFilters:
    """The filters of one person's parts, in one frame.

    Attributes:
        body: the parts that are placed so far.
    """

    def __init__(
        self,
        subject: Subject,
        settings: UtvrSettings,
        evidence: Evidence,
        body: PlacedBody,
        before: Sequence[Particles],
        frames: float,
        starts: bool,
    ) -> None:
        """
        Args:
            before: of each part, what the last frame has kept.
            frames: of `FRAME_S` that have gone by: a part turns like a random walk.
            starts: whether the first place of parts may be anywhere.
        """
        self.subject = subject
        self.settings = settings
        self.body = body
        self._evidence = evidence
        self._before = before
        self._frames = frames
        self._starts = starts
        self._first: dict[int, tuple[np.random.Generator, Array]] = {}  # draws of first rounds

    def best_with_next(self, part: int, Rs: Array, cloud: Cloud) -> tuple[int, Particles]:
        """Which hypothesis [M, 3, 3] of an upper limb is best together with the best one of the
        part below it in its first round, and that part's particles after all rounds."""
        best = 0
        if len(Rs) > 1:
            uppers = self._terms(part, Rs, cloud).counts
            lowers = np.empty_like(uppers)
            for index, R in enumerate(Rs):
                left = self._left_by(part, R, cloud)
                below, _ = self.filtered(part + 1, left, rounds=1)
                lowers[index] = self._terms(part + 1, below.Rs[:1], left).counts[0]
            both = UtvrTerms.from_counts(uppers + lowers)
            best = int(both.product(self.settings.factors).argmin())
        below, _ = self.filtered(part + 1, self._left_by(part, Rs[best], cloud))
        return best, below

    def _left_by(self, part: int, R: Array, cloud: Cloud) -> Cloud:
        """Place a part, and what it leaves over of the points."""
        self.body.place(part, R)
        return cloud[~self.body.has_inside(part, cloud.points_camera)]

    def filtered(
        self, part: int, cloud: Cloud, rounds: int | None = None
    ) -> tuple[Particles, Array]:
        """One part's filter: sample, evaluate, keep the N best; and the hypotheses of the first
        round, [M, 3, 3], best first. Without evidence, keep those of the last frame that the part
        above allows, and search wider in the next frame. All rounds but the last look at half the
        resolution, unless that shows too little of the part. `rounds`: no more than these."""
        s = self.settings
        before = particles = self._before[part]
        if part == HEAD and s.neck is not None:
            return before, NO_ROTATIONS
        most = s.n_best or PARTS[part].n_best
        width = min(before.spread * sqrt(self._frames), max(before.spread, WIDEST))
        if part not in self._first:  # whichever rival it hangs from
            rng = self.subject.rng(part, self._evidence)
            self._first[part] = rng, _turned(part, before, width, 2 * s.hypotheses, rng)
        rng, drawn = self._first[part]
        tried = NO_ROTATIONS
        for halvings in range(min(rounds or s.rounds, s.rounds)):
            if halvings:
                drawn = _turned(part, particles, width / 2**halvings, 2 * s.hypotheses, rng)
            Rs = self._allowed(part, drawn)
            if self._starts and part != HEAD:
                Rs = np.concatenate([Rs, self._anywhere(part, rng)])
            known, scores = Rs[:0], np.empty(0)
            if s.coarse_first and halvings < s.rounds - 1:
                known, scores = self._evaluated(part, Rs, cloud.coarse(self._evidence))
            if not len(known):
                known, scores = self._evaluated(part, Rs, cloud)
            if not len(known):
                allowed = Rs[: min(len(before.Rs), most)]
                spread = min(SPREADING**self._frames * before.spread, WIDEST)
                return Particles(allowed, np.ones(len(allowed)), spread), NO_ROTATIONS
            best = n_best(scores, most)
            particles = Particles(known[best], scores[best], 1.0)
            if halvings == 0:
                tried = known[n_best(scores, len(scores))]
            if part in TORSO_PARTS and s.torso_lean_rad is not None:
                particles = particles.headed_by(mean_rotation(known, scores), most)
        return particles, tried

    def _anywhere(self, part: int, rng: np.random.Generator) -> Array:
        """[M, 3, 3] hypotheses of a part from all over its configurations: within Table 3.2, and of
        a torso that hangs from a free neck, over the half sphere below it."""
        count = self.settings.hypotheses
        if part == UPPER_TORSO and self.settings.neck is not None:
            axes = views_around(-self.body.up_camera, count, np.pi / 2)
            return turned_to(axes, self._before[part].Rs[0])
        return self.body.anywhere(part, count, rng)

    def _allowed(self, part: int, Rs: Array) -> Array:
        """[M, 3, 3] hypotheses of [2 M, 3, 3]: those beyond the limits are eliminated; if all are,
        those stay that exceed the limits least."""
        excess_rad = self.body.excess_rad(part, Rs)
        return Rs[excess_rad <= excess_rad.min()][: self.settings.hypotheses]

    def _evaluated(self, part: int, Rs: Array, cloud: Cloud) -> tuple[Array, Array]:
        """Those hypotheses for which there is evidence, and their score (Eq. 5.7)."""
        s = self.settings
        terms = self._terms(part, Rs, cloud)
        products = terms.product(s.factors)
        is_known = (terms.n_points >= MIN_POINTS_INSIDE) & np.isfinite(products)
        Rs, scores = Rs[is_known], products[is_known]
        if part in TORSO_PARTS and s.torso_turn_rad is not None:
            off_rad = turns_rad(self._before[part].Rs[0], Rs)
            scores = scores * (1.0 + (off_rad / s.torso_turn_rad) ** 2)
        if part in TORSO_PARTS and s.torso_lean_rad is not None:
            leans_rad = np.arccos(np.clip(-Rs[:, :, 1] @ self.body.up_camera, -1.0, 1.0))
            scores = scores * (1.0 + (leans_rad / s.torso_lean_rad) ** 2)
        return Rs, scores

    def _terms(self, part: int, Rs: Array, cloud: Cloud) -> UtvrTerms:
        """Of hypotheses [M, 3, 3] of one part that hangs from those placed."""
        origins = self.body.cylinders_of(part, Rs, self.body.joints_of(part, Rs))
        points = cloud.points_camera
        near = points[self._is_near(part, origins, points)]
        return score_hypotheses(
            Rs,
            origins,
            self.body.lengths_m[part],
            self.body.model.radii_m[part] + self.settings.clothing_m,
            columns(near),
            cloud.view,
            self.body.obstacles(part),
            self.settings.tolerance_m,
            self.subject.threads,
        )

    def _is_near(self, part: int, origins: Array, cloud: Array) -> NDArray[np.bool_]:
        """[N] points that may lie inside some hypothesis."""
        reach_m = self.body.lengths_m[part] + self.body.model.radii_m[part].max()
        reach_m += self.settings.clothing_m + np.ptp(origins, axis=0).max()
        away_m = cloud - origins[0]
        return np.einsum("ni,ni->n", away_m, away_m) < reach_m**2


def _turned(
    part: int, kept: Particles, spread: float, count: int, rng: np.random.Generator
) -> Array:
    """[count, 3, 3] hypotheses: the kept ones, and ones turned away from them (SIR).

    The kept ones are parents in proportion to their weights.
    """
    sigma_rad = TORSO_SIGMA_RAD if part in (HEAD, *TORSO_PARTS) else LIMB_SIGMA_RAD
    count -= len(kept.Rs)
    parents = systematic_resample(importance_weights(kept.scores), count, rng)
    turns = rotations_from_angles(spread * rng.standard_normal((count, 3)) * sigma_rad)
    return np.concatenate([kept.Rs, kept.Rs[rng.permutation(parents)] @ turns])
