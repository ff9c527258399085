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
from dataclasses import dataclass
from math import sqrt
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.body.parts import HEAD, PARTS, UPPER_TORSO
from topview.filter.particles import importance_weights, n_best, systematic_resample
from topview.kernels.rotations import turn_parents
from topview.score.utvr import (
    FIRST_LAYER,
    MIN_POINTS_INSIDE,
    Observed,
    UtvrTerms,
    score_hypotheses,
)
from topview.track.body_tracker import Subject
from topview.track.evidence import Evidence
from topview.track.methods.btvr.torso import turned_to, views_around
from topview.track.methods.utvr.particles import Particles, mean_rotation, turns_rad
from topview.track.methods.utvr.placed_body import TORSO_PARTS, PlacedBody, Remaining
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


@dataclass(frozen=True, slots=True, eq=False)
class Round:
    """One round of a part's filter.

    Attributes:
        drawn: [M, 3, 3] all hypotheses.
        Rs: [N, 3, 3] those for which there is evidence.
        scores: [N] f_uTVR, lower is better.
    """

    drawn: Array
    Rs: Array
    scores: Array


@dataclass(frozen=True, slots=True, eq=False)
class Branch:
    """Hypotheses of a part that hangs from one way to place the part above it.

    Attributes:
        Rs: [M, 3, 3].
        origins: [M, 3] of their cylinders, metres.
        layer: which of the layers has the points that are left.
    """

    Rs: Array
    origins: Array
    layer: int = 0


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
        self._obstacles: dict[int, NDArray[np.float32]] = {}

    def best_with_next(self, part: int, Rs: Array, left: Remaining) -> tuple[int, Particles]:
        """Which hypothesis [M, 3, 3] of an upper limb is best together with the best one of the
        part below it in its first round, and that part's particles after all rounds."""
        lefts = self.body.left_by(part, Rs, left)
        branches: list[Branch] = []
        for layer, R in enumerate(Rs):
            self.body.place(part, R)
            branches.append(self._branch(part + 1, self._hypotheses(part + 1), layer))
        rounds = self._rounds(part + 1, branches, lefts, 0)
        best = 0
        if len(Rs) > 1:
            uppers = self._terms(part, [self._branch(part, Rs)], left.fine).counts
            lowers = self._terms(part + 1, _best_of_each(branches, rounds), lefts.fine).counts
            both = UtvrTerms.from_counts(uppers + lowers)
            best = int(both.product(self.settings.factors).argmin())
        self.body.place(part, Rs[best])
        below, _ = self.filtered(part + 1, lefts.layer(best), rounds[best])
        return best, below

    def filtered(
        self, part: int, left: Remaining, first: Round | None = None
    ) -> tuple[Particles, Array]:
        """One part's filter: sample, evaluate, keep the N best; and the hypotheses of the first
        round, [M, 3, 3], best first. Without evidence, keep those of the last frame that the part
        above allows, and search wider in the next frame. `first`: that round, if it is done."""
        s = self.settings
        before = particles = self._before[part]
        if part == HEAD and s.neck is not None:
            return before, NO_ROTATIONS
        most = s.n_best or PARTS[part].n_best
        tried = NO_ROTATIONS
        for halvings in range(s.rounds):
            if halvings == 0 and first is not None:
                done = first
            else:
                drawn = self._hypotheses(part, particles, halvings)
                (done,) = self._rounds(part, [self._branch(part, drawn)], left, halvings)
            if not len(done.Rs):
                allowed = done.drawn[: min(len(before.Rs), most)]
                spread = min(SPREADING**self._frames * before.spread, WIDEST)
                return Particles(allowed, np.ones(len(allowed)), spread), NO_ROTATIONS
            order = n_best(done.scores, len(done.scores))
            best = order[:most]
            particles = Particles(done.Rs[best], done.scores[best], 1.0)
            if halvings == 0:
                tried = done.Rs[order]
            if part in TORSO_PARTS and s.torso_lean_rad is not None:
                particles = particles.headed_by(mean_rotation(done.Rs, done.scores), most)
        return particles, tried

    def _hypotheses(self, part: int, kept: Particles | None = None, halvings: int = 0) -> Array:
        """[M, 3, 3] hypotheses of a part below those placed, for the first round, or for a later
        one from what the last has kept."""
        width = self._width(part) / 2**halvings
        count = 2 * self.settings.hypotheses
        if part not in self._first:  # whichever rival it hangs from
            rng = self.subject.rng(part, self._evidence)
            self._first[part] = rng, _turned(part, self._before[part], width, count, rng)
        rng, drawn = self._first[part]
        if halvings and kept is not None:
            drawn = _turned(part, kept, width, count, rng)
        Rs = self._allowed(part, drawn)
        if self._starts and part != HEAD:
            Rs = np.concatenate([Rs, self._anywhere(part, rng)])
        return Rs

    def _width(self, part: int) -> float:
        """How wide a part is searched in the first round."""
        spread = self._before[part].spread
        return min(spread * sqrt(self._frames), max(spread, WIDEST))

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

    def _branch(self, part: int, Rs: Array, layer: int = 0) -> Branch:
        """Hypotheses [M, 3, 3] of a part that hangs from those placed."""
        return Branch(Rs, self.body.cylinders_of(part, Rs, self.body.joints_of(part, Rs)), layer)

    def _rounds(
        self, part: int, branches: Sequence[Branch], left: Remaining, halvings: int
    ) -> list[Round]:
        """One round of each branch. The torso is large enough for half the resolution; other parts
        are looked at so in all rounds but the last, unless that shows too little."""
        s = self.settings
        is_coarse = part in TORSO_PARTS or halvings < s.rounds - 1
        if not (s.coarse_first and is_coarse):
            return self._evaluated(part, branches, left.fine)
        rounds = self._evaluated(part, branches, left.coarse)
        unseen = [index for index, done in enumerate(rounds) if not len(done.Rs)]
        if unseen:
            anew = self._evaluated(part, [branches[index] for index in unseen], left.fine)
            for index, done in zip(unseen, anew, strict=True):
                rounds[index] = done
        return rounds

    def _evaluated(self, part: int, branches: Sequence[Branch], observed: Observed) -> list[Round]:
        """Of each branch the hypotheses for which there is evidence, and their scores (Eq. 5.7)."""
        terms = self._terms(part, branches, observed)
        products = terms.product(self.settings.factors)
        is_known = (terms.n_points >= MIN_POINTS_INSIDE) & np.isfinite(products)
        rounds, first = [], 0
        for branch in branches:
            own = slice(first, first := first + len(branch.Rs))
            Rs, scores = branch.Rs[is_known[own]], products[own][is_known[own]]
            rounds.append(Round(branch.Rs, Rs, scores * self._doubled(part, Rs)))
        return rounds

    def _doubled(self, part: int, Rs: Array) -> Array | float:
        """[N] what the scores of a torso [N, 3, 3] that turns or leans are multiplied by."""
        s = self.settings
        factors = 1.0
        if part in TORSO_PARTS and s.torso_turn_rad is not None:
            off_rad = turns_rad(self._before[part].Rs[0], Rs)
            factors = factors * (1.0 + (off_rad / s.torso_turn_rad) ** 2)
        if part in TORSO_PARTS and s.torso_lean_rad is not None:
            leans_rad = np.arccos(np.clip(-Rs[:, :, 1] @ self.body.up_camera, -1.0, 1.0))
            factors = factors * (1.0 + (leans_rad / s.torso_lean_rad) ** 2)
        return factors

    def _terms(self, part: int, branches: Sequence[Branch], observed: Observed) -> UtvrTerms:
        """Of all hypotheses of all branches of one part, one after the other."""
        if part not in self._obstacles:
            self._obstacles[part] = self.body.obstacles(part)
        counts = [len(branch.Rs) for branch in branches]
        bits = np.array([FIRST_LAYER << branch.layer for branch in branches], np.uint8)
        return score_hypotheses(
            np.concatenate([branch.Rs for branch in branches]),
            np.concatenate([branch.origins for branch in branches]),
            self.body.lengths_m[part],
            self.body.model.radii_m[part] + self.settings.clothing_m,
            observed,
            self._obstacles[part],
            self.settings.tolerance_m,
            self.subject.threads,
            np.repeat(bits, counts),
        )


def _best_of_each(branches: Sequence[Branch], rounds: Sequence[Round]) -> list[Branch]:
    """The best hypothesis of each branch after one round, or its first without evidence."""
    best = []
    for branch, done in zip(branches, rounds, strict=True):
        R = done.Rs[done.scores.argmin()] if len(done.Rs) else done.drawn[0]
        best.append(Branch(R[None], branch.origins[:1], branch.layer))
    return best


def _turned(
    part: int, kept: Particles, spread: float, count: int, rng: np.random.Generator
) -> Array:
    """[count, 3, 3] hypotheses: the kept ones, and ones turned away from them (SIR).

    The kept ones are parents in proportion to their weights.
    """
    sigma_rad = TORSO_SIGMA_RAD if part in (HEAD, *TORSO_PARTS) else LIMB_SIGMA_RAD
    out = np.empty((count, 3, 3))
    first = len(kept.Rs)
    parents = systematic_resample(importance_weights(kept.scores), count - first, rng)
    angles_rad = spread * rng.standard_normal((count - first, 3)) * sigma_rad
    out[:first] = kept.Rs
    turn_parents(kept.Rs, rng.permutation(parents), angles_rad, out[first:])
    return out
