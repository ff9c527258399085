"""The thesis's own tracker: part by part from the head down, a particle filter each (Sec. 5.3).

`UtvrTracker.update` is the whole recipe; `topview.track.methods.topview` is what this project makes
of it. `AS_PRINTED` is the recipe without what we add to it; docs/method.md says what that is, and
what each addition brings. Where the thesis leaves a point open:

- The depth image does not show the turn of a circular cylinder about its own axis. An upper arm or
  upper leg is scored by its direction alone. Its turn follows from the direction in which the
  forearm or lower leg bends; that part's hypotheses are valid where both parts keep within Table
  3.2.
- A part without evidence keeps its direction of the frame before.
- Only what is placed steers the parts below it. So at a frame's end all parts descend together.
- Collisions are counted with placed parts: the same person's, and those of whoever stands nearer.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import cos, sqrt
from typing import ClassVar, Final

import numpy as np
from numpy.typing import NDArray

from topview.body.kinematics import place_part
from topview.body.limits import LIMITS_RAD
from topview.body.model import HEAD_CENTRE, BodyModel
from topview.body.parts import HEAD, LOWER_TORSO, PARTS, UPPER_TORSO
from topview.body.proportions import THESIS, THESIS_ABOVE_HIPS, Proportions
from topview.camera.pyramid import DepthView
from topview.filter.over_time import Pace
from topview.filter.particles import importance_weights, n_best, systematic_resample
from topview.geometry.rotations import rotations_from_angles, unit
from topview.kernels.limits import hinge_excess, part_excess
from topview.people.height import PRIOR_HEIGHT_M
from topview.records import InputError, check_range, shown
from topview.score.utvr import (
    FACTORS,
    MIN_POINTS_INSIDE,
    Factor,
    UtvrTerms,
    placed_parts,
    score_hypotheses,
)
from topview.track.body_tracker import Needs, Subject
from topview.track.evidence import Evidence, columns
from topview.track.methods.btvr.torso import (
    NO_PARTS,
    VIEW_SHARPNESS,
    TorsoFilter,
    TorsoSettings,
    turned_to,
    views_around,
)
from topview.track.methods.btvr.yaw_cues import YawCues
from topview.track.methods.topview.refinement import RefinementSettings, refine
from topview.track.pose import HALF_ROUND, HINGE_BENDS, OTHER_SIDE, FittedBody, Pose
from topview.track.stances import STANDING, stand

Array = NDArray[np.float64]

# All ours.
# How far hypotheses are turned about a part's x, y and z in the first round, in radians; those of
# the torso go for the head as well.
TORSO_SIGMA_RAD: Final = (0.06, 0.08, 0.06)
LIMB_SIGMA_RAD: Final = (0.35, 0.0, 0.35)
SPREADING: Final = 1.3  # in `FRAME_S` a part without evidence comes to be searched so much wider
WIDEST: Final = 2.0  # up to this, which is also how wide a person's first frame is searched
# Of the radii of placed parts, when collisions are counted: skin that touches does not collide.
# Adjoining parts share a joint and are left out.
COLLISION_SHARE: Final = 0.8
START_S: Final = 0.3  # from a person's first frame, while limbs are searched anywhere as well
LEAST_TURN_RAD: Final = 0.01
KNOWN_BEND: Final = 0.1  # sine of the bend from which on it tells the hinge better than memory does
# Of an upper limb that is judged together with the part below it: hypotheses that point elsewhere
# by this angle at least, and how many of them.
ELSEWHERE_RAD: Final = 0.4
MOST_ELSEWHERE: Final = 4

# Of the descent at a frame's end. The surface of rendered people's torsos, clothes and all, is an
# ellipse of 10 to 12 % of the stature across and 8 to 11 % from back to front, about a point 1 to 2
# % before the spine (seeds 100 to 103 of `turn`); these semi-axes are at its lower end.
TORSO_SURFACE: Final = (0.098, 0.09)
DESCENT_HOLD: Final = 0.1  # against `RefinementSettings`' priors, which hold to the pose found
NEWS_COST: Final = 0.02  # of points and axes that another pose than the last must explain better
LEAST_DESCENT_POINTS: Final = 30  # of fewer, parts stay where the filters have them

NO_ROTATIONS: Final = np.empty((0, 3, 3))

_TORSO = (UPPER_TORSO, LOWER_TORSO)
_HEAD_AND_TORSO = (HEAD, *_TORSO)
_UPPER_LIMBS = frozenset(part.parent for part in PARTS if part.is_hinge)


@dataclass(frozen=True, slots=True)
class UtvrSettings:
    """The thesis's full-body tracker; the defaults are ours, as the thesis leaves them open.

    Attributes:
        hypotheses: of each part in each round, 1 to 100000; the time grows with them.
        rounds: of sampling and evaluation in each frame, each half as wide as the one before; 1
            to 10.
        tolerance_m: the T of Sec. 5.2.1, 0 to 1 metre.
        clothing_m: added to the radii, so that points on the surface, with their noise, lie inside;
            0 to 0.2 metres.
        torso_reach_m: points so near to the placed torso's surface are no limb's; 0 to 0.2 metres.
        torso_below_hips: how far the torso's cylinders reach below the hips' joints, as the seat
            does; share of the stature, 0 to 0.2.
        torso_ahead: how far the torso's cylinders lie before the line of its joints, as the spine
            is in the back; share of the stature, 0 to 0.2.
        neck: how far the neck's joint is below the head's centre, halfway between upright and the
            torso's axis, and behind it as the torso faces; shares of the stature, 0 to 0.2. A head
            is too round to show its axis: it stands upright, and does not limit the torso. None
            has the neck on the axis of the head, as printed.
        torso_turn_rad: a turn of the torso about its own axis, from what its ellipses tell (Sec.
            5.1.4), that doubles the score; 0.01 to pi. f_uTVR is flat in that turn. The torso of
            Sec. 5.1 is then a hypothesis of each frame. None leaves both out, as printed.
        torso_lean_rad: a lean of the torso from upright that doubles the score; 0.01 to pi. A head
            and a torso that is seen from the side tell little of it. The torso is then the mean of
            all hypotheses, weighted by their scores, as that of Sec. 5.1 is. None leaves both out:
            the torso is the best hypothesis, as printed.
        limbs_as_one: whether an upper limb is judged together with the part below it: of its best
            hypothesis and the best that point elsewhere, the one for which f_uTVR of both parts, as
            one thing, is best.
        factors: of Eq. 5.7 that choose hypotheses; Table 6.3 leaves one out to show its share.
        n_best: hypotheses of every part that go on to the next frame, 1 to `hypotheses`; None for
            those of Sec. 6.1.3, which `topview.body.parts` holds. What `limbs_as_one` chooses
            goes on besides.
        coarse_first: whether all rounds but the last, and the torso of Sec. 5.1, look at half the
            resolution, which is faster.
        descent: Gauss-Newton steps, at the end of each frame, of all parts together onto the
            points and out of free space, 0 to 100; of the pose that was found and of the last
            frame's, and the better one is kept. 0 leaves both out, as printed: a part stays where
            it was placed before those below it were looked at.
        proportions: of the body. Table 3.1's torso ends where the trunk does, but the joints of the
            hips lie higher, and knees with them.

    Raises:
        InputError: a value out of range, or no factors.
    """

    hypotheses: int = 120
    rounds: int = 2
    tolerance_m: float = 0.05
    clothing_m: float = 0.015
    torso_reach_m: float = 0.05
    torso_below_hips: float = 0.05
    torso_ahead: float = 0.025
    neck: tuple[float, float] | None = (0.07, 0.03)
    torso_turn_rad: float | None = 0.3
    torso_lean_rad: float | None = 0.7
    limbs_as_one: bool = True
    factors: tuple[Factor, ...] = FACTORS
    n_best: int | None = None
    coarse_first: bool = True
    descent: int = 8
    proportions: Proportions = THESIS_ABOVE_HIPS

    needs: ClassVar[Needs] = Needs()

    def __post_init__(self) -> None:
        check_range(self, 1, 100_000, "hypotheses")
        check_range(self, 1, 10, "rounds")
        check_range(self, 0, 100, "descent")
        check_range(self, 0.0, 1.0, "tolerance_m")
        check_range(
            self, 0.0, 0.2, "clothing_m", "torso_reach_m", "torso_below_hips", "torso_ahead"
        )
        for name in ("torso_turn_rad", "torso_lean_rad"):
            if getattr(self, name) is not None:
                check_range(self, LEAST_TURN_RAD, np.pi, name)
        if self.neck is not None and not _are_shares(self.neck):
            raise InputError(
                f"neck is {shown(self.neck)}; it must be two shares of 0 to 0.2, or None"
            )
        if self.n_best is not None:
            check_range(self, 1, self.hypotheses, "n_best")
        if not self.factors or not set(self.factors) <= set(FACTORS):
            raise InputError(
                f"factors is {', '.join(self.factors) or 'empty'}; "
                f"it must name some of {', '.join(FACTORS)}"
            )

    @property
    def name(self) -> str:
        return "utvr"

    def tracker(self, subject: Subject) -> UtvrTracker:
        return UtvrTracker(subject, self)


def _are_shares(neck: object) -> bool:
    return (
        isinstance(neck, tuple)
        and len(neck) == 2
        and all(isinstance(share, float) and 0.0 <= share <= 0.2 for share in neck)
    )


AS_PRINTED: Final = UtvrSettings(
    torso_reach_m=0.015,
    torso_below_hips=0.0,
    torso_ahead=0.0,
    neck=None,
    torso_turn_rad=None,
    torso_lean_rad=None,
    limbs_as_one=False,
    coarse_first=False,
    descent=0,
    proportions=THESIS,
)
"""The recipe of Sec. 5.2 and 5.3, but for what docs/method.md names."""


@dataclass(frozen=True, slots=True, eq=False)
class _Particles:
    """The N best of one part, best first.

    Attributes:
        Rs: [N, 3, 3] `Rs_camera_part`.
        scores: [N] f_uTVR, lower is better.
        spread: how wide to search around them, 1 while there is evidence.
    """

    Rs: Array
    scores: Array
    spread: float

    def turned(self, R: Array) -> _Particles:
        """All turned in their own frames."""
        return replace(self, Rs=self.Rs @ R)

    def headed_by(self, R: Array, most: int) -> _Particles:
        """One before all others, `most` altogether; it becomes a parent as often as the best."""
        Rs = np.concatenate([R[None], self.Rs])[:most]
        return replace(self, Rs=Rs, scores=np.append(self.scores.min(), self.scores)[:most])

    def with_one(self, R: Array) -> _Particles:
        """One more, which becomes a parent as often as the best."""
        Rs, scores = np.concatenate([self.Rs, R[None]]), np.append(self.scores, self.scores.min())
        return replace(self, Rs=Rs, scores=scores)


@dataclass(frozen=True, slots=True, eq=False)
class _Cloud:
    """The points that no part has taken yet, and the scene at their resolution.

    Attributes:
        points_camera: [N, 3] metres.
        is_coarse: [N] which of them half the resolution shows, too.
        view: the scene's depth.
    """

    points_camera: Array
    is_coarse: NDArray[np.bool_]
    view: DepthView

    @classmethod
    def of(cls, evidence: Evidence) -> _Cloud:
        return cls(evidence.all_points_camera, evidence.is_coarse, evidence.view)

    def __getitem__(self, chosen: NDArray[np.bool_]) -> _Cloud:
        return replace(
            self, points_camera=self.points_camera[chosen], is_coarse=self.is_coarse[chosen]
        )

    def coarse(self, evidence: Evidence) -> _Cloud:
        """At half the resolution."""
        return replace(self[self.is_coarse], view=evidence.coarse_view)


class UtvrTracker:
    """One person's pose over time, by the algorithm of Sec. 5.3.2."""

    def __init__(self, subject: Subject, settings: UtvrSettings) -> None:
        self.subject = subject
        self.settings = settings
        self.model = BodyModel.of(PRIOR_HEIGHT_M, settings.proportions)
        self._particles: list[_Particles] = []
        self._torso = TorsoFilter(TorsoSettings(is_coarse=settings.coarse_first), subject.threads)
        self._yaw_cues = YawCues()
        self._pace = Pace()
        self._first_s = 0.0
        self._last: Pose | None = None

    def update(self, evidence: Evidence) -> Pose:
        """The pose in the next frame."""
        if evidence.stature_m is not None:
            self.model = BodyModel.of(evidence.stature_m, self.settings.proportions)
        if not self._particles:
            self._first_s = evidence.timestamp_s
            self._particles = self._roughly_standing(evidence)
        frames = self._pace.frames(evidence.timestamp_s)
        if self.settings.torso_turn_rad is not None and len(evidence.all_points_camera):
            self._propose_torso(evidence, frames)
        body = _Body(self.model, evidence, self.settings)
        cloud = _Cloud.of(evidence)
        followed: dict[int, _Particles] = {}  # parts below an upper limb that was judged with them
        with self.subject.clock.stage("parts"):
            for part in range(len(PARTS)):
                if part in followed:
                    particles = followed[part]
                else:
                    particles, tried = self._filtered(part, body, cloud, evidence, frames)
                    if self.settings.limbs_as_one and part in _UPPER_LIMBS:
                        rivals = _elsewhere(particles.Rs[0], tried)
                        best, below = self._best_with_next(
                            part, rivals, body, cloud, evidence, frames
                        )
                        particles = particles.headed_by(rivals[best], len(particles.Rs) + 1)
                        followed[part + 1] = below
                self._particles[part] = particles
                body.place(part, particles.Rs[0])
                cloud = cloud[~body.has_inside(part, cloud.points_camera)]
        if self.settings.neck is not None:
            body.turn_head()
        pose = Pose(body.origins[UPPER_TORSO], body.Rs)
        if self.settings.descent and len(evidence.all_points_camera) >= LEAST_DESCENT_POINTS:
            pose = self._descended(pose, evidence)
        self._last = pose
        return pose

    def _descended(self, found: Pose, evidence: Evidence) -> Pose:
        """The pose that was found, or the last frame's, whichever explains more once all of its
        parts are moved onto the points together; the next frame is searched around it.

        A cylinder that wants points inside stands too near to the camera; one whose surface they
        are does not.
        """
        proportions = replace(
            self.settings.proportions,
            upper_torso_radii=TORSO_SURFACE,
            lower_torso_radii=TORSO_SURFACE,
        )
        surface = BodyModel.of(self.model.stature_m, proportions)
        poses = [found]
        if self._last is not None:
            poses.append(Pose(found.neck_camera, self._last.Rs))
        with self.subject.clock.stage("descent"):
            moved = refine(
                poses, None, surface, evidence, RefinementSettings(), self.settings.descent,
                DESCENT_HOLD,
            )  # fmt: skip
        costs = moved.unexplained + moved.in_free_space
        costs[1:] -= NEWS_COST
        pose = moved.poses[int(costs.argmin())]
        self._particles = [
            kept if part == HEAD else kept.headed_by(pose.Rs[part], len(kept.Rs))
            for part, kept in enumerate(self._particles)
        ]
        return pose

    def _propose_torso(self, evidence: Evidence, frames: float) -> None:
        """The torso of Sec. 5.1 is one more hypothesis, and all are turned about their own axes to
        its yaw, as its ellipses tell that. If front and back change places, so do the limbs."""
        told = self._yaw_cues.log_likelihood(evidence, self.model.stature_m, frames)
        self._torso.yaw.fuse(told)
        R = self._torso.update(self.model, evidence, frames).R_camera_torso
        turn_rad = float(_turns_rad(self._particles[UPPER_TORSO].Rs[0], R[None])[0])
        if cos(turn_rad) < 0.0:
            self._particles = [
                self._particles[other]
                if part in _HEAD_AND_TORSO
                else self._particles[other].turned(HALF_ROUND)
                for part, other in enumerate(OTHER_SIDE)
            ]
            self._last = self._last and self._last.turned_round()
        R_turn = rotations_from_angles(np.array([0.0, turn_rad, 0.0]))
        for part in _TORSO:
            self._particles[part] = self._particles[part].turned(R_turn)
        self._particles[UPPER_TORSO] = self._particles[UPPER_TORSO].with_one(R)

    def _roughly_standing(self, evidence: Evidence) -> list[_Particles]:
        """Upright below the head, facing the camera: where every filter starts."""
        pose = stand(self.model, evidence.head_camera, STANDING, 0.0, evidence.up_camera)
        return [_Particles(R[None], np.ones(1), WIDEST) for R in pose.Rs]

    def _best_with_next(
        self,
        part: int,
        Rs: Array,
        body: _Body,
        cloud: _Cloud,
        evidence: Evidence,
        frames: float,
    ) -> tuple[int, _Particles]:
        """Which hypothesis [M, 3, 3] of an upper limb is best together with the best one of the
        part below it, and that part's particles then."""
        scores, belows = np.zeros(len(Rs)), []
        for index, R in enumerate(Rs):
            body.place(part, R)
            left = cloud[~body.has_inside(part, cloud.points_camera)]
            below, _ = self._filtered(part + 1, body, left, evidence, frames)
            belows.append(below)
            if len(Rs) > 1:
                both = self._terms(part, R[None], cloud, body).together_with(
                    self._terms(part + 1, below.Rs[:1], left, body)
                )
                scores[index] = both.product(self.settings.factors)[0]
        best = int(scores.argmin())
        return best, belows[best]

    def _filtered(
        self, part: int, body: _Body, cloud: _Cloud, evidence: Evidence, frames: float
    ) -> tuple[_Particles, Array]:
        """One part's filter: sample, evaluate, keep the N best; and the hypotheses of the first
        round, [M, 3, 3], best first. Without evidence, keep those of the last frame that the part
        above allows, and search wider in the next frame. `frames` of `FRAME_S` have gone by: a part
        turns like a random walk. All rounds but the last look at half the resolution, unless that
        shows too little of the part."""
        s = self.settings
        rng = self.subject.rng(part, evidence)
        before = particles = self._particles[part]
        if part == HEAD and s.neck is not None:
            return self._roughly_standing(evidence)[HEAD], NO_ROTATIONS
        most = s.n_best or PARTS[part].n_best
        width = min(before.spread * sqrt(frames), max(before.spread, WIDEST))
        tried = NO_ROTATIONS
        for halvings in range(s.rounds):
            Rs = self._sampled(part, particles, width / 2**halvings, body, rng)
            if self._starts(part, evidence):
                Rs = np.concatenate([Rs, self._anywhere(part, body, rng)])
            known, scores = Rs[:0], np.empty(0)
            if s.coarse_first and halvings < s.rounds - 1:
                known, scores = self._evaluated(part, Rs, cloud.coarse(evidence), body)
            if not len(known):
                known, scores = self._evaluated(part, Rs, cloud, body)
            if not len(known):
                allowed = Rs[: min(len(before.Rs), most)]
                spread = min(SPREADING**frames * before.spread, WIDEST)
                return _Particles(allowed, np.ones(len(allowed)), spread), NO_ROTATIONS
            best = n_best(scores, most)
            particles = _Particles(known[best], scores[best], 1.0)
            if halvings == 0:
                tried = known[n_best(scores, len(scores))]
            if part in _TORSO and s.torso_lean_rad is not None:
                particles = particles.headed_by(_mean_rotation(known, scores), most)
        return particles, tried

    def _starts(self, part: int, evidence: Evidence) -> bool:
        """Whether a part's first place may be anywhere: standing is only the likeliest one."""
        return part != HEAD and evidence.timestamp_s - self._first_s < START_S

    def _anywhere(self, part: int, body: _Body, rng: np.random.Generator) -> Array:
        """[M, 3, 3] hypotheses of a part from all over its configurations: within Table 3.2, and of
        a torso that hangs from a free neck, over the half sphere below it."""
        count = self.settings.hypotheses
        if part == UPPER_TORSO and self.settings.neck is not None:
            axes = views_around(-body.up_camera, count, np.pi / 2)
            return turned_to(axes, self._particles[part].Rs[0])
        return body.anywhere(part, count, rng)

    def _sampled(
        self, part: int, kept: _Particles, spread: float, body: _Body, rng: np.random.Generator
    ) -> Array:
        """[M, 3, 3] hypotheses: the kept ones, and ones turned away from them (SIR).

        The kept ones are parents in proportion to their weights. Twice as many hypotheses as wanted
        are drawn, and those beyond the limits are eliminated; if all are, those stay that exceed
        the limits least.
        """
        sigma_rad = TORSO_SIGMA_RAD if part in _HEAD_AND_TORSO else LIMB_SIGMA_RAD
        hypotheses = self.settings.hypotheses
        count = 2 * hypotheses - len(kept.Rs)
        parents = systematic_resample(importance_weights(kept.scores), count, rng)
        turns = rotations_from_angles(spread * rng.standard_normal((count, 3)) * sigma_rad)
        Rs = np.concatenate([kept.Rs, kept.Rs[rng.permutation(parents)] @ turns])
        excess_rad = body.excess_rad(part, Rs)
        return Rs[excess_rad <= excess_rad.min()][:hypotheses]

    def _evaluated(self, part: int, Rs: Array, cloud: _Cloud, body: _Body) -> tuple[Array, Array]:
        """Those hypotheses for which there is evidence, and their score (Eq. 5.7)."""
        s = self.settings
        terms = self._terms(part, Rs, cloud, body)
        products = terms.product(s.factors)
        is_known = (terms.n_points >= MIN_POINTS_INSIDE) & np.isfinite(products)
        Rs, scores = Rs[is_known], products[is_known]
        if part in _TORSO and s.torso_turn_rad is not None:
            turns_rad = _turns_rad(self._particles[part].Rs[0], Rs)
            scores = scores * (1.0 + (turns_rad / s.torso_turn_rad) ** 2)
        if part in _TORSO and s.torso_lean_rad is not None:
            leans_rad = np.arccos(np.clip(-Rs[:, :, 1] @ body.up_camera, -1.0, 1.0))
            scores = scores * (1.0 + (leans_rad / s.torso_lean_rad) ** 2)
        return Rs, scores

    def _terms(self, part: int, Rs: Array, cloud: _Cloud, body: _Body) -> UtvrTerms:
        """Of hypotheses [M, 3, 3] of one part that hangs from those placed."""
        origins = body.cylinders_of(part, Rs, body.joints_of(part, Rs))
        points = cloud.points_camera
        near = points[self._is_near(part, origins, points, body)]
        return score_hypotheses(
            Rs,
            origins,
            body.lengths_m[part],
            self.model.radii_m[part] + self.settings.clothing_m,
            columns(near),
            cloud.view,
            body.obstacles(part),
            self.settings.tolerance_m,
            self.subject.threads,
        )

    def _is_near(self, part: int, origins: Array, cloud: Array, body: _Body) -> NDArray[np.bool_]:
        """[N] points that may lie inside some hypothesis."""
        reach_m = body.lengths_m[part] + self.model.radii_m[part].max()
        reach_m += self.settings.clothing_m + np.ptp(origins, axis=0).max()
        return ((cloud - origins[0]) ** 2).sum(1) < reach_m**2


class _Body:
    """The parts that are placed in this frame, from the head down.

    Attributes:
        lengths_m: [11] of the cylinders.
    """

    def __init__(self, model: BodyModel, evidence: Evidence, settings: UtvrSettings) -> None:
        self.model = model
        self.lengths_m = np.array(model.lengths_m)
        self.lengths_m[LOWER_TORSO] += settings.torso_below_hips * model.stature_m
        self.head_camera = evidence.head_camera
        self._settings = settings
        self.up_camera = evidence.up_camera
        self._nearer_parts = np.concatenate(
            [NO_PARTS, *(_parts_of(body) for body in evidence.nearer_bodies)]
        )
        self.Rs = np.empty((len(PARTS), 3, 3))
        self.origins = np.empty((len(PARTS), 3))

    def joints_of(self, part: int, Rs: Array) -> Array:
        """[M, 3] proximal joints in metres, camera frame, of a part turned like `Rs` [M, 3, 3]:
        the crown above the measured head, the neck below it, any other joint on the part above."""
        if part == HEAD:
            return self.head_camera - HEAD_CENTRE * self.model.lengths_m[HEAD] * Rs[:, :, 1]
        parent = PARTS[part].parent
        if part == UPPER_TORSO and self._settings.neck is not None:
            below, behind = self._settings.neck
            downwards = unit(Rs[:, :, 1] - self.up_camera)
            away = below * downwards - behind * Rs[:, :, 2]
            return self.head_camera + self.model.stature_m * away
        joint = place_part(self.model, part, self.Rs[parent], self.origins[parent])
        return np.broadcast_to(joint, (len(Rs), 3))

    def cylinders_of(self, part: int, Rs: Array, joints: Array) -> Array:
        """[M, 3] origins of the cylinders of a part with these proximal joints."""
        if part not in _TORSO:
            return joints
        return joints + self._settings.torso_ahead * self.model.stature_m * Rs[:, :, 2]

    def place(self, part: int, R: Array) -> None:
        """Fix a part; a forearm or lower leg turns the part above about its own axis, so that it
        bends about the hinge."""
        self.origins[part] = self.joints_of(part, R[None])[0]
        self.Rs[part] = R
        if PARTS[part].is_hinge:
            upper = PARTS[part].parent
            self.Rs[[upper, part]] = self._bent(part, R[None])[0]

    def turn_head(self) -> None:
        """Let the head face where the torso does, on an axis from its measured centre to the
        neck."""
        to_neck = unit(self.origins[UPPER_TORSO] - self.head_camera)[None]
        self.Rs[HEAD] = _frames(_across(self.Rs[UPPER_TORSO, :, 0][None], to_neck), to_neck)[0]

    def anywhere(self, part: int, count: int, rng: np.random.Generator) -> Array:
        """[M, 3, 3] hypotheses of a part from all over the limits of Table 3.2, `count` at the
        most."""
        low, high = LIMITS_RAD[part].T
        Rs = self.Rs[PARTS[part].parent]
        if PARTS[part].is_hinge:  # whichever way the part above it is turned about its own axis
            turns_rad = np.zeros((count, 3))
            least_rad, most_rad = LIMITS_RAD[PARTS[part].parent, 1]
            turns_rad[:, 1] = rng.uniform(least_rad, most_rad, count)
            Rs = Rs @ rotations_from_angles(turns_rad)
        Rs = Rs @ rotations_from_angles(rng.uniform(low, high, (count, 3)))
        return Rs[self.excess_rad(part, Rs) <= 0.0]

    def excess_rad(self, part: int, Rs: Array) -> Array:
        """[M] by how much hypotheses [M, 3, 3] leave the limits of Table 3.2."""
        if part == HEAD or (part == UPPER_TORSO and self._settings.neck is not None):
            return np.zeros(len(Rs))
        parent = PARTS[part].parent
        beyond_rad = np.empty(len(Rs))
        if PARTS[part].is_hinge:
            hinge_excess(
                Rs, self.Rs[parent], self.Rs[PARTS[parent].parent], LIMITS_RAD[parent],
                float(np.abs(LIMITS_RAD[part, 0]).max()), HINGE_BENDS[parent], KNOWN_BEND,
                beyond_rad,
            )  # fmt: skip
        else:  # an upper limb's turn about its own axis is not searched
            part_excess(Rs, self.Rs[parent], LIMITS_RAD[part], part not in _UPPER_LIMBS, beyond_rad)
        return beyond_rad

    def _bent(self, lower: int, Rs: Array) -> Array:
        """[M, 2, 3, 3] rotations of an upper limb and the part below it, for each hypothesis of
        where the latter points: the hinge is perpendicular to both; a straight limb keeps it."""
        R_upper = self.Rs[PARTS[lower].parent]
        ys_lower = Rs[:, :, 1]
        ys_upper = np.broadcast_to(R_upper[:, 1], ys_lower.shape)
        hinges = HINGE_BENDS[PARTS[lower].parent] * np.cross(ys_upper, ys_lower)
        hinges += KNOWN_BEND * R_upper[:, 0]
        xs_upper = _across(hinges, ys_upper)
        return np.stack(
            [_frames(xs_upper, ys_upper), _frames(_across(xs_upper, ys_lower), ys_lower)], axis=1
        )

    def obstacles(self, part: int) -> NDArray[np.float32]:
        """[K, 15] placed parts that do not adjoin this one, shrunk, and those of nearer users, for
        f_coll (Eq. 5.9)."""
        parent = PARTS[part].parent
        others = [
            other for other in range(part) if other != parent and PARTS[other].parent != parent
        ]
        own = placed_parts(
            self.Rs[others],
            self.origins[others],
            self.lengths_m[others],
            COLLISION_SHARE * self.model.radii_m[others],
        )
        return np.concatenate([own, self._nearer_parts])

    def has_inside(self, part: int, points: Array) -> NDArray[np.bool_]:
        """[N] True for the [N, 3] points that are a placed part's: those inside, and of the torso
        those near it."""
        R = self.Rs[part]
        origin = self.cylinders_of(part, R[None], self.origins[part][None])[0]
        x, y, z = ((points - origin) @ R).T
        s = self._settings
        rx, rz = self.model.radii_m[part] + (s.torso_reach_m if part in _TORSO else s.clothing_m)
        is_between = (y >= 0.0) & (y <= self.lengths_m[part])
        return is_between & ((x / rx) ** 2 + (z / rz) ** 2 <= 1.0)


def _parts_of(body: FittedBody) -> NDArray[np.float32]:
    """[K, 15] the tracked parts of another user, shrunk."""
    Ts = body.Ts_camera_part
    is_tracked = np.isfinite(Ts).all((1, 2))
    return placed_parts(
        Ts[is_tracked, :3, :3],
        Ts[is_tracked, :3, 3],
        body.model.lengths_m[is_tracked],
        COLLISION_SHARE * body.model.radii_m[is_tracked],
    )


def _turns_rad(R: Array, Rs: Array) -> Array:
    """[M] how far rotations [M, 3, 3] are turned from `R` about its y."""
    turns = R.T @ Rs
    return np.arctan2(turns[:, 0, 2] - turns[:, 2, 0], turns[:, 0, 0] + turns[:, 2, 2])


def _elsewhere(R: Array, Rs: Array) -> Array:
    """[K, 3, 3] a rotation, and those of [M, 3, 3] that point elsewhere than it and each other."""
    chosen = [R]
    for other in Rs:
        if max(other[:, 1] @ each[:, 1] for each in chosen) < cos(ELSEWHERE_RAD):
            chosen.append(other)
        if len(chosen) == MOST_ELSEWHERE:
            break
    return np.array(chosen)


def _mean_rotation(Rs: Array, scores: Array) -> Array:
    """[3, 3] the mean of rotations [M, 3, 3] of one part, weighted by their scores."""
    weights = (scores.min() / scores) ** VIEW_SHARPNESS
    y = unit(weights @ Rs[:, :, 1])[None]
    return _frames(_across((weights @ Rs[:, :, 0])[None], y), y)[0]


def _across(xs: Array, ys: Array) -> Array:
    """[M, 3] the components of `xs` perpendicular to the unit vectors `ys`, as unit vectors."""
    return unit(xs - ys * (xs * ys).sum(1, keepdims=True))


def _frames(xs: Array, ys: Array) -> Array:
    """[M, 3] axes x and y to [M, 3, 3] rotations."""
    return np.stack([xs, ys, np.cross(xs, ys)], axis=2)
