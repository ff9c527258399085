"""Search for a limb's pose: hypotheses from memory, motion and data, scored by uTVR (Sec. 5.3).

A limb is a pair of parts, upper and lower, that hangs from the torso. The thesis's particle filter
goes part by part and steers the second part by the best hypothesis of the first alone; a fast arm
is then lost at the elbow. Here (ours) a hypothesis is the pair, 4 degrees of freedom as in Table
5.1, and hypotheses come from three places: the N best of the frame before, the pose predicted from
motion, and the points that no other part explains: a palm or foot among them puts the elbow or
knee on a circle (Eq. 5.4 - 5.6).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from topview.body.kinematics import place_part
from topview.body.limits import LIMITS_RAD
from topview.body.model import BodyModel
from topview.body.parts import (
    HEAD,
    LOWER_TORSO,
    PARTS,
    UPPER_TORSO,
)
from topview.filter.particles import n_best
from topview.geometry.rotations import cross, unit
from topview.kernels import limbs as limb_kernel
from topview.score.utvr import Observed, UtvrTerms, count_hypotheses, placed_parts
from topview.track.evidence import Evidence
from topview.track.methods.topview.hands import Hand, hands_of_arms
from topview.track.pose import HINGE_BENDS, HINGE_PAIRS, Pose
from topview.track.surfaces import NearestSurfaces, nearest_surfaces

Array = NDArray[np.float64]

# Legs first: an arm may lie on a thigh, but a leg hardly lies on an arm.
LIMBS = tuple(sorted((upper for upper, _ in HINGE_PAIRS), reverse=True))

# Ours.
FOLDED_M = 0.02  # a palm comes no nearer to the shoulder than the lengths' difference and this
REST_FORWARD = 0.3  # how far a forearm at rest points forward, against down
STRETCHED = 0.998  # share of its length that a limb stretches to
LABEL_REACH_M = 0.15  # what is farther from every part is of none
EXPLAINED_COLUMN = 0  # the column of `judge_limbs` that counts the points a pose explains


@dataclass(frozen=True, slots=True)
class LimbSettings:
    """Ours where not said otherwise; metres and radians where the name says so.

    Scores are logarithms of f_uTVR, lower is better; weights add to them. "A limb's worth" of
    points is what a whole limb shows, seen from the side.

    Attributes:
        tolerance_m: the T of Sec. 5.2.1.
        clothing_m: added to the radii for the score, so that the points on the surface lie inside.
        collision_share: of the radii of head and torso, when collisions are counted: skin that
            touches does not collide.
        kept: hypotheses that go on to the next frame (Sec. 6.1.3: 10 for mobile parts).
        jittered, jitter_rad: hypotheses drawn around the kept ones, and how widely.
        palms, turns: points taken as ends of the limb, and elbows on each one's circle.
        wide: hypotheses from anywhere.
        settled_unexplained, settled_own: a limb whose present pose leaves fewer points unexplained
            than this share of a limb's worth, and has more than that share of them on its own
            surface, is settled: it is searched only nearby.
        settled_jittered, settled_jitter_rad: as `jittered` and `jitter_rad`, for a limb that is
            settled.
        hidden_share: of places along the limb; a limb with more of them out of sight, the own body
            before it counted, is hidden: what is seen says next to nothing of it.
        hidden_explained: share of a limb's worth of points; a hidden limb keeps its pose relative
            to its parent unless another pose explains so many more.
        outside_share: of places along the limb; a limb of which nothing is known yet, and more than
            this is outside of the image, is taken to be at rest.
        distinct_rad: hypotheses that differ by less in both parts count as one.
        refined: best distinct hypotheses that are refined and scored again.
        refine_iterations: Gauss-Newton steps of each.
        reach_m, scale_m: refinement: points farther off do not pull, and the width of the robust
            weight.
        free_space_margin_m: refinement: how far a part may lie in front of what is seen.
        free_space_weight: refinement: of a place in free space, against a point.
        prior_weight: refinement: of leaving the hypothesis, points per square radian.
        samples_per_part: refinement: places on each part that are tested against free space.
        taken_m: a point this near to another part's surface is that part's.
        exclusive_m: a point farther than this from every other part's surface is one that only
            this limb can explain.
        explained_m: a point this near to the limb's surface is explained by it.
        unexplained_weight: of a limb's worth of unexplained points.
        no_evidence: score of a part without evidence and not in free space.
        free_space_penalty: how such a score grows with the share of pixels in free space.
        coincident_share: how far a pixel on a seen surface counts as one in free space there: a
            part that were at that surface would have points inside.
        motion_rad, motion_weight: a part's turn away from the prediction that begins to count, and
            the weight of its logarithm.
        limit_weight, limit_cap_rad: per radian beyond the limits, and where it stops to grow.
        floor_weight_per_m: of the limb's end below the floor.
        margin: by which another hypothesis must beat the present pose.
        hand_turns: elbows on the circle of a hand that the colour of skin shows.
        hand_weight, hand_m: of a limb that ends off such a hand, and from where on it is all off.
    """

    tolerance_m: float = 0.05
    clothing_m: float = 0.015
    collision_share: float = 0.8
    kept: int = 10
    jittered: int = 80
    jitter_rad: float = 0.5
    palms: int = 10
    turns: int = 8
    wide: int = 40
    settled_unexplained: float = 0.15
    settled_own: float = 0.5
    settled_jittered: int = 24
    settled_jitter_rad: float = 0.25
    hidden_share: float = 0.2
    hidden_explained: float = 0.15
    outside_share: float = 0.5
    distinct_rad: float = 0.35
    refined: int = 16
    refine_iterations: int = 12
    reach_m: float = 0.12
    scale_m: float = 0.04
    free_space_margin_m: float = 0.06
    free_space_weight: float = 6.0
    prior_weight: float = 2.0
    samples_per_part: int = 5
    taken_m: float = 0.04
    exclusive_m: float = 0.08
    explained_m: float = 0.04
    unexplained_weight: float = 8.0
    no_evidence: float = 1.0
    free_space_penalty: float = 5.0
    coincident_share: float = 0.5
    motion_rad: float = 0.7
    motion_weight: float = 0.4
    limit_weight: float = 3.0
    limit_cap_rad: float = 0.5
    floor_weight_per_m: float = 30.0
    margin: float = 0.15
    hand_turns: int = 12
    hand_weight: float = 4.0
    hand_m: float = 0.2


def elbows_on_circle(
    shoulder: Array, palms: Array, length_upper: float, length_lower: float, turns: int
) -> Array:
    """[P, 3] palms, of one shoulder [3] or one each [P, 3], to [P * turns, 2, 3] directions of both
    parts (Eq. 5.4 - 5.6).

    Palms out of reach, or too near, are taken at the nearest distance that the limb can have.
    """
    reach = palms - shoulder
    distance = np.linalg.norm(reach, axis=1)
    axis = unit(reach)
    shortest = abs(length_upper - length_lower) + FOLDED_M
    span = np.clip(distance, shortest, (length_upper + length_lower) * STRETCHED)
    i = (span**2 + length_upper**2 - length_lower**2) / (2 * span)
    r = np.sqrt(np.maximum(length_upper**2 - i**2, 0.0))
    helper = np.where(np.abs(axis[:, 1:2]) < 0.9, [[0.0, 1.0, 0.0]], [[1.0, 0.0, 0.0]])
    v1 = unit(cross(axis, helper))
    v2 = cross(axis, v1)
    t = 2 * np.pi * np.arange(turns) / turns
    across = v1[:, None] * np.cos(t)[None, :, None] + v2[:, None] * np.sin(t)[None, :, None]
    elbows = axis[:, None] * i[:, None, None] + across * r[:, None, None]
    lower = axis[:, None] * span[:, None, None] - elbows
    return unit(np.stack([elbows, lower], axis=2)).reshape(-1, 2, 3)


def spread_points(points: Array, start: Array, count: int) -> Array:
    """Up to `count` of the [N, 3] points, farthest-first: each next one lies farthest from `start`
    and from those already taken."""
    if len(points) == 0:
        return points
    distance = np.linalg.norm(points - start, axis=1)
    taken = np.empty((min(count, len(points)), 3))
    for n in range(len(taken)):
        best = int(distance.argmax())
        taken[n] = points[best]
        distance = np.minimum(distance, np.linalg.norm(points - points[best], axis=1))
    return taken


@dataclass(frozen=True, slots=True, eq=False)
class _Limb:
    """One limb's surroundings in one frame."""

    upper: int  # the upper part; the lower one comes next in the table
    joint_camera: Array  # [3] metres
    lengths_m: Array  # [2]
    radii_m: Array  # [2]
    R_camera_parent: Array  # [3, 3]
    predicted: Array  # [2, 3] directions
    open_points: Array  # [N, 3] that no other part explains well, thinned
    exclusive_points: Array  # [N, 3] that no other part explains at all, thinned
    fine: Observed  # what its hypotheses are scored on
    coarse: Observed  # the same at half the resolution
    placed: NDArray[np.float32]  # [3, 15] head and torso, from `placed_parts`
    hand: Hand | None  # where the colour of skin shows this arm's
    own_count: int  # thinned points on the limb's surface
    full_count: float  # how many thinned points a whole limb shows, seen from the side


# Parts of the thinned and of all points.
Labelling = tuple[NearestSurfaces, NearestSurfaces]
# The N best of each limb, [n, 2, 3] directions in the parent's frame, by upper part.
Kept = Mapping[int, Array]


class LimbSearch:
    """Searches one user's limbs."""

    def __init__(self, settings: LimbSettings, threads: int) -> None:
        self.settings = settings
        self.threads = threads

    def search(
        self,
        pose: Pose,
        predicted: Pose,
        model: BodyModel,
        evidence: Evidence,
        generators: Mapping[int, np.random.Generator],
        kept: Kept,
    ) -> tuple[Pose, Kept]:
        """The pose with every limb replaced for which something clearly better was found, and
        the hypotheses that go on to the next frame.

        Args:
            pose, predicted: what is searched around.
            model, evidence, generators: of the frame, and by upper part.
            kept: hypotheses of the frame before.
        """
        s = self.settings
        origins = pose.origins(model)
        labelling = _labelled(pose, origins, model, evidence)
        placed = self._placed(pose, origins, model)
        hands = hands_of_arms(pose, predicted, model, evidence)
        Rs = pose.Rs.copy()
        best_of: dict[int, Array] = {}
        for upper in LIMBS:
            limb = self._surroundings(upper, Pose(pose.neck_camera, Rs), origins, predicted, model,
                                      evidence, labelling, placed, hands.get(upper))  # fmt: skip
            current = Rs[[upper, upper + 1], :, 1]
            if upper not in kept and _outside_share(limb, current, evidence) > s.outside_share:
                rest = _at_rest(limb, evidence.up_camera)
                Rs[[upper, upper + 1]] = self._judged(limb, rest[None], evidence)[0][0]
                continue
            memory = kept[upper] @ limb.R_camera_parent.T if upper in kept else limb.predicted[None]
            needed = self._needed(limb, current, evidence)
            if needed > len(limb.exclusive_points):
                best_of[upper] = memory @ limb.R_camera_parent
                continue
            axes, scores = self._hypotheses(limb, current, memory, evidence, generators[upper])
            best = n_best(scores, s.kept)
            best_of[upper] = axes[best] @ limb.R_camera_parent
            if scores[best[0]] < scores[0] - s.margin:
                (R,), (verdict,) = self._judged(limb, axes[best[:1]], evidence)
                if verdict[EXPLAINED_COLUMN] >= needed:
                    Rs[[upper, upper + 1]] = R
        return Pose(pose.neck_camera, Rs), best_of

    def _surroundings(
        self, upper: int, pose: Pose, origins: Array, predicted: Pose, model: BodyModel,
        evidence: Evidence, labelling: Labelling, placed: NDArray[np.float32], hand: Hand | None,
    ) -> _Limb:  # fmt: skip
        s = self.settings
        parts = [upper, upper + 1]
        parent = PARTS[upper].parent
        joint = place_part(model, upper, pose.Rs[parent], origins[parent])
        lengths, radii = model.lengths_m[parts], model.radii_m[parts, 0]
        (labels, distances, _), (all_labels, all_distances, _) = labelling
        thinned, points = evidence.points_camera, evidence.all_points_camera
        reach = 1.1 * float(lengths.sum())
        open_points, exclusive_points = np.empty_like(thinned), np.empty_like(thinned)
        n_open, n_exclusive, n_own = limb_kernel.share_out_points(
            thinned, labels, distances, joint, reach, upper, s.taken_m, s.exclusive_m,
            open_points, exclusive_points,
        )  # fmt: skip
        fine = Observed.of(evidence.view, np.zeros_like(evidence.user_mask))
        coarse = Observed.of(evidence.coarse_view, np.zeros_like(evidence.user_mask[::2, ::2]))
        limb_kernel.pick_scored(
            points, evidence.pixels, all_labels, all_distances, joint, reach, upper, s.taken_m,
            fine.own, coarse.own,
        )  # fmt: skip
        return _Limb(
            upper,
            joint,
            lengths,
            radii,
            pose.Rs[parent],
            predicted.Rs[parts, :, 1],
            open_points[:n_open],
            exclusive_points[:n_exclusive],
            fine,
            coarse,
            placed,
            hand,
            n_own,
            float(2 * (lengths * radii).sum() / evidence.point_area_m2),
        )

    def _placed(self, pose: Pose, origins: Array, model: BodyModel) -> NDArray[np.float32]:
        """[3, 15] head and torso, from `placed_parts`."""
        trunk = [HEAD, UPPER_TORSO, LOWER_TORSO]
        return placed_parts(
            pose.Rs[trunk],
            origins[trunk],
            model.lengths_m[trunk],
            self.settings.collision_share * model.radii_m[trunk],
        )

    def _hypotheses(
        self,
        limb: _Limb,
        current: Array,
        memory: Array,
        evidence: Evidence,
        rng: np.random.Generator,
    ) -> tuple[Array, Array]:
        """[M, 2, 3] directions and their [M] log scores; the first is the present pose."""
        s = self.settings
        seeds = np.concatenate([current[None], limb.predicted[None], memory])
        is_settled = self._is_settled(limb, current, evidence)
        drawn = self._drawn(limb, seeds, is_settled, rng)
        axes = np.concatenate([seeds, drawn])
        scores = self._scores(limb, axes, evidence, limb.coarse)
        chosen = axes[_distinct(axes, scores, s.refined, s.distinct_rad)]
        refined = chosen.copy()
        view = evidence.view
        limb_kernel.refine_limbs(
            refined, limb.joint_camera, limb.lengths_m, limb.radii_m, limb.open_points,
            view.depth_m, evidence.user_mask, evidence.nearest.columns, evidence.nearest.corner,
            view.fx, view.fy, view.cx, view.cy, evidence.floor, s.reach_m, s.scale_m,
            s.free_space_margin_m, s.free_space_weight, s.prior_weight, s.samples_per_part,
            s.refine_iterations,
        )  # fmt: skip
        axes = np.concatenate([chosen, refined])
        scores = self._scores(limb, axes, evidence, limb.fine)
        scores[0] = min(scores[0], scores[len(chosen)])
        return axes, scores

    def _needed(self, limb: _Limb, current: Array, evidence: Evidence) -> float:
        """Points that a pose must explain to replace the present one: none if the limb is seen."""
        s = self.settings
        if _hidden_share(limb, current, evidence) <= s.hidden_share:
            return 0.0
        return self._explained(limb, current, evidence) + s.hidden_explained * limb.full_count

    def _explained(self, limb: _Limb, axes: Array, evidence: Evidence) -> float:
        """How many exclusive points the pose [2, 3] explains."""
        return float(self._judged(limb, axes[None], evidence)[1][0, EXPLAINED_COLUMN])

    def _is_settled(self, limb: _Limb, current: Array, evidence: Evidence) -> bool:
        """True if the present pose leaves next to nothing unexplained and has its points."""
        s = self.settings
        unexplained = len(limb.exclusive_points) - self._explained(limb, current, evidence)
        return (
            unexplained < s.settled_unexplained * limb.full_count
            and limb.own_count > s.settled_own * limb.full_count
        )

    def _drawn(
        self, limb: _Limb, seeds: Array, is_settled: bool, rng: np.random.Generator
    ) -> Array:
        """[M, 2, 3] hypotheses around the seeds; from the data and from anywhere as well
        unless the limb is settled."""
        s = self.settings
        count, sigma = (s.settled_jittered, s.settled_jitter_rad) if is_settled else (
            s.jittered, s.jitter_rad
        )  # fmt: skip
        parents = rng.integers(0, len(seeds), count)
        groups = [unit(seeds[parents] + sigma * rng.standard_normal((count, 2, 3)))]
        if not is_settled:
            groups.append(unit(rng.standard_normal((s.wide, 2, 3))))
            palms = spread_points(limb.exclusive_points, limb.joint_camera, s.palms)
            if len(palms):
                palms = palms + unit(palms) * limb.radii_m[1]  # from the skin to the axis
                upper_m, lower_m = limb.lengths_m
                groups.append(elbows_on_circle(limb.joint_camera, palms, upper_m, lower_m, s.turns))
        if limb.hand is not None:
            palm = limb.hand.palm_camera[None]
            upper_m, lower_m = limb.lengths_m
            groups.append(elbows_on_circle(limb.joint_camera, palm, upper_m, lower_m, s.hand_turns))
        return np.concatenate(groups)

    def _scores(self, limb: _Limb, axes: Array, evidence: Evidence, observed: Observed) -> Array:
        """[M] log f_uTVR of both parts, with what speaks against a hypothesis besides (ours)."""
        s = self.settings
        Rs, verdicts = self._judged(limb, axes, evidence)
        elbows = limb.joint_camera + axes[:, 0] * limb.lengths_m[0]
        counts = [
            count_hypotheses(
                Rs[:, part],
                origins,
                limb.lengths_m[part],
                np.repeat(limb.radii_m[part] + s.clothing_m, 2),
                observed,
                limb.placed,
                s.tolerance_m,
                self.threads,
            )
            for part, origins in enumerate((limb.joint_camera, elbows))
        ]
        of_both = self._log_score(UtvrTerms.from_counts(np.concatenate(counts)))
        log_score = of_both[: len(axes)] + of_both[len(axes) :]
        explained, turn_upper, turn_lower, beyond, below = verdicts.T
        unexplained = (len(limb.exclusive_points) - explained) / limb.full_count
        if limb.hand is not None:
            ends = elbows + axes[:, 1] * limb.lengths_m[1]
            off_m = np.linalg.norm(ends - limb.hand.palm_camera, axis=1)
            log_score += s.hand_weight * limb.hand.belief * np.minimum(off_m / s.hand_m, 1.0)
        motion = np.log1p((turn_upper / s.motion_rad) ** 2)
        motion += np.log1p((turn_lower / s.motion_rad) ** 2)
        return (
            log_score
            + s.unexplained_weight * unexplained
            + s.motion_weight * motion
            + s.limit_weight * np.minimum(beyond, s.limit_cap_rad)
            + s.floor_weight_per_m * below
        )

    def _judged(self, limb: _Limb, axes: Array, evidence: Evidence) -> tuple[Array, Array]:
        """[M, 2, 3, 3] rotations and [M, 5] verdicts of `judge_limbs`."""
        Rs, verdicts = np.empty((len(axes), 2, 3, 3)), np.empty((len(axes), 5))
        limb_kernel.judge_limbs(
            axes, limb.R_camera_parent[:, 0].copy(), HINGE_BENDS[limb.upper],
            limb.R_camera_parent, LIMITS_RAD[limb.upper : limb.upper + 2], limb.predicted,
            limb.joint_camera, limb.lengths_m, limb.radii_m, evidence.floor,
            limb.exclusive_points, self.settings.explained_m, Rs, verdicts,
        )  # fmt: skip
        return Rs, verdicts

    def _log_score(self, terms: UtvrTerms) -> Array:
        """[M] log f_uTVR; without evidence neither best nor worst, unless in free space."""
        s = self.settings
        not_hidden = terms.n_outliers + s.coincident_share * terms.n_inliers
        in_free_space = not_hidden / np.maximum(terms.n_pixels, 1)
        without = s.no_evidence + np.log1p(s.free_space_penalty * in_free_space)
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.where(terms.has_evidence, np.log(terms.score), without + np.log(terms.coll))


def _labelled(pose: Pose, origins: Array, model: BodyModel, evidence: Evidence) -> Labelling:
    thinned, points = evidence.points_camera, evidence.all_points_camera
    body = pose.Rs, origins, model.lengths_m, model.shapes_m, LABEL_REACH_M
    of_thinned = nearest_surfaces(thinned, *body)
    step = -(-len(points) // max(len(thinned), 1))
    guess = np.repeat(of_thinned.labels, step)[: len(points)]  # a neighbour has the same part
    return of_thinned, nearest_surfaces(points, *body, guess)


def _places(limb: _Limb, current: Array) -> Array:
    """[8, 3] places along the limb."""
    along = (np.arange(4) + 0.5)[:, None] / 4
    upper, lower = current * limb.lengths_m[:, None]
    return limb.joint_camera + np.concatenate([along * upper, upper + along * lower])


def _hidden_share(limb: _Limb, current: Array, evidence: Evidence) -> float:
    """Share of places along the limb that are out of sight, also behind the own body."""
    places = _places(limb, current)
    return float(evidence.out_of_sight(places, limb.radii_m.max(), own_body_hides=True).mean())


def _outside_share(limb: _Limb, current: Array, evidence: Evidence) -> float:
    """Share of places along the limb that are outside of the image."""
    return 1.0 - float(evidence.is_in_image(_places(limb, current)).mean())


def _at_rest(limb: _Limb, up_camera: Array) -> Array:
    """[2, 3] directions of a limb that hangs down, or stands, with a forearm a little forward."""
    down = -up_camera
    is_arm = HINGE_BENDS[limb.upper] > 0
    forward = REST_FORWARD * limb.R_camera_parent[:, 2] if is_arm else 0.0
    return np.stack([down, unit(down + forward)])


def _distinct(axes: Array, scores: Array, count: int, apart_rad: float) -> list[int]:
    """The present pose, and the best hypotheses that differ from each other."""
    cosine = np.cos(apart_rad)
    upper, lower = np.ascontiguousarray(axes[:, 0]), np.ascontiguousarray(axes[:, 1])
    chosen = [0]
    is_left = np.ones(len(axes), np.bool_)
    for index in np.argsort(scores, kind="stable"):
        if len(chosen) >= count:
            break
        if is_left[index] or len(chosen) == 1:
            newest = chosen[-1]
            is_left &= (upper @ upper[newest] < cosine) | (lower @ lower[newest] < cosine)
        if is_left[index]:
            chosen.append(int(index))
    return chosen
