"""Bodies of people of whom no joints are proposed: candidates from everywhere, one cost (ours).

A candidate is the last pose as it has moved on, a captured body that looks like what is seen, a
stance where the pose is lost, a pose with its trunk elsewhere, or one with limbs as those of
captured bodies are. What is taken is what the whole body costs least with.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import chain, islice
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.body.model import BodyModel
from topview.body.parts import (
    HEAD,
    LEFT_LOWER_LEG,
    LEFT_UPPER_ARM,
    LEFT_UPPER_LEG,
    LOWER_TORSO,
    PARTS,
    RIGHT_LOWER_LEG,
    RIGHT_UPPER_ARM,
    RIGHT_UPPER_LEG,
    UPPER_TORSO,
)
from topview.filter.over_time import FRAME_S, share_after
from topview.geometry.rotations import rotations_from_vectors
from topview.track.body_tracker import Subject
from topview.track.evidence import Evidence
from topview.track.methods.topview.body_size import BodySize
from topview.track.methods.topview.facing import FacingBelief
from topview.track.methods.topview.hypotheses import Hypotheses
from topview.track.methods.topview.lookup import SHARES, shipped_poses
from topview.track.methods.topview.posture import known_of
from topview.track.methods.topview.refinement import RefinementSettings, refine
from topview.track.methods.topview.usual_limbs import LimbScan, usual_limbs
from topview.track.methods.topview.usual_poses import (
    how_unusual,
    usual_poses,
    usual_where_hidden,
)
from topview.track.methods.topview.whole_body import (
    Found,
    FrameContext,
    beyond_tolerance,
    costs_of,
    firmness,
    of_what_is_seen,
    parts_out_of_sight,
)
from topview.track.pose import LIMBS, TRUNK_PARTS, Pose
from topview.track.stances import heading, stand_all
from topview.track.stature import StatureBelief, adults_cost

Array = NDArray[np.float64]

# All ours.
# From one look for poses elsewhere, and for other trunks and limbs, to the next. The latter are
# searched for before their turn where something is hidden, and where what was found costs so much
# more than what was found by the last search.
LOOK_S: Final = 0.1
SURPRISE: Final = 0.01
LIFT_WEIGHT_PER_M: Final = 0.3  # of both feet off the floor, beyond `LIFT_M`
LIFT_M: Final = 0.15
USUAL_S: Final = 0.15  # after which a prior's limbs are by 63 % where people usually have them
UNUSUAL_COST: Final = 0.02  # of who is hidden in part, per square of `how_unusual`
OCCLUDED_PRIOR_SCALE: Final = 30.0  # of the prior, per share that is hidden
SETTLING_HOLD: Final = 0.1  # of what holds a pose at last, of whom nothing is hidden
SEARCH_LOST_COST: Final = 0.38  # of a lost pose; normals, as they are noisy, make some 0.08
# Poses from elsewhere are refined in so many steps at a first look, and the best so many of them
# once more, and at every so many-th look the best of those that face the other way, with other
# limbs. One is taken that explains so much more of a whole body than the pose that has moved on,
# and of which, unless the person is hidden, no more is hidden than a share of the body.
LOOKED_UP: Final = 6
LOOKED_UP_ITERATIONS: Final = 5
LOOKED_AT_AGAIN: Final = 2
TURNED_EVERY: Final = 4
NEWS_MARGIN: Final = 0.02
LOOKED_UP_HIDDEN: Final = 0.05
# The trunk is drawn so often round where it is, in each search: its two parts' turns about their
# own axes, and the neck's place, as widely as found trunks are off that true ones would beat. Of
# arms, and in every so many-th search of legs, those of so many captured bodies and a share of the
# usual ones are looked at. So many that differ are tried, if the body costs no more than this
# beyond what it does (of those that, refined, explained enough more 94 %, seeds 0 to 5). All are
# refined in so many steps, and taken where they explain so much more of a whole body.
TRUNKS: Final = 4
TRUNK_DRAWN_RAD: Final = np.radians([[5.0, 9.0, 4.0], [8.0, 7.0, 4.0]])
TRUNK_DRAWN_M: Final = 0.02
LENDERS: Final = 5
UPPER_ARMS: Final = LEFT_UPPER_ARM, RIGHT_UPPER_ARM
UPPER_LEGS: Final = LEFT_UPPER_LEG, RIGHT_UPPER_LEG
LEGS_EVERY: Final = 2
LIMBS_TRIED: Final = 2
UNREFINED_MARGIN: Final = 0.02
TRIED_ITERATIONS: Final = 3
TRIED_MARGIN: Final = 0.005
HIDDEN_MARGIN: Final = 4.0  # times that more, of a limb that is out of sight
STARTING_ROUNDS: Final = 3  # of that, for a first pose


class Search:
    """One person's poses over time.

    Attributes:
        facing: which yaw is believed.
    """

    def __init__(
        self,
        refinement: RefinementSettings,
        subject: Subject,
        stature: StatureBelief,
        size: BodySize,
    ) -> None:
        """`stature`: which one is believed; it is judged here where it is doubted. `size`: of the
        body, which is learnt here."""
        self.facing = FacingBelief()
        self._refinement = refinement
        self._subject = subject
        self._stature = stature
        self._size = size
        self._searches = self._looks = 0  # until now
        self._unsearched_s = self._unlooked_s = 0.0  # since the last one
        self._cost = np.inf  # after the last search
        self._lenders: list[Pose] = []  # of limbs: bodies that looked like what was seen
        self._hypotheses = Hypotheses()

    def update(
        self,
        look: FrameContext,
        moved_on: tuple[Pose, Pose] | None,
        hidden: float,
        statures_m: Sequence[float],
        is_due: bool,
        is_known: bool,
    ) -> Found:
        """The cheapest pose of the next frame.

        Args:
            look: the frame, with normals.
            moved_on: the last pose, and where it is thought to be by now; None if there is none.
            hidden: share of the body, beyond what is tolerated.
            statures_m: that the person may have.
            is_due: whether it is time to look elsewhere.
            is_known: whether the last pose is known better than what is seen tells; it moves on.
        """
        evidence = look.evidence
        look = replace(look, is_hidden=hidden > 0.0)
        self._unlooked_s += look.elapsed_s
        self._unsearched_s += look.elapsed_s
        bodies: list[Pose] = []
        if moved_on is None or is_due:
            with look.clock.stage("lookup"):
                bodies = self._look_up(look, is_first=moved_on is None)
        found = self._followed(moved_on, hidden, look) if moved_on else None
        if found is None or is_due:
            with look.clock.stage("body"):
                found = self._or_elsewhere(found, bodies, hidden, statures_m, look)
            self._lenders = bodies[:LENDERS]
        if not is_known:
            if moved_on is None or is_due or hidden > 0.0 or self._surprises(found, look):
                found = self._searched(found, moved_on is None, look)
            found = self._settled(found, look)
        # Legs out of view say nothing of a trunk that is seen.
        out = parts_out_of_sight(found.pose, found.model, evidence)
        seen_hidden = min(found.hidden, 2.0 * float(out[[HEAD, UPPER_TORSO, LOWER_TORSO]].mean()))
        found = replace(found, hidden=beyond_tolerance(max(seen_hidden, evidence.hidden_share)))
        if is_due and not found.is_new:
            return self._with_size(found, look)
        return found

    def _surprises(self, found: Found, look: FrameContext) -> bool:
        """Whether what was found explains less than what was found by the last search."""
        return found.cost > self._cost + of_what_is_seen(SURPRISE, look)

    def _searched(self, found: Found, is_first: bool, look: FrameContext) -> Found:
        """What was found, or that with another trunk or other limbs."""
        rng = self._subject.rng(UPPER_TORSO, look.evidence)
        limbs = limbs_in_turn(None if is_first else self._searches)
        with look.clock.stage("limbs"):
            for _ in range(STARTING_ROUNDS if is_first else 1):
                found = self._or_otherwise(found, limbs, rng, look)
        self._searches, self._unsearched_s = self._searches + 1, 0.0
        self._cost = found.cost
        return found

    def _look_up(self, look: FrameContext, is_first: bool) -> list[Pose]:
        """Bodies that look like what is seen, of a share of the table in turn, or of all of it at
        first; how alike they are tells the yaw."""
        share = None if is_first else self._looks % SHARES
        alike = shipped_poses().likeness(look.evidence, look.model.stature_m, share)
        self.facing.update(alike, self._unlooked_s)
        self._looks, self._unlooked_s = self._looks + 1, 0.0
        return alike.poses(look.model, 2 * LOOKED_UP if is_first else LOOKED_UP)

    def _followed(self, moved_on: tuple[Pose, Pose], hidden: float, look: FrameContext) -> Found:
        """The last pose, or where it has moved to, whichever is better at a first look, refined;
        held to the last one, whose limbs and head are drawn to what bodies usually do, as is the
        torso of whom something is hidden."""
        share = share_after(max(look.elapsed_s, FRAME_S), USUAL_S)
        known = known_of(moved_on[0], look.model, look.evidence)
        shares = np.full(len(PARTS), share)
        shares[UPPER_TORSO] *= hidden > 0.0
        prior = usual_poses().towards(moved_on[0], shares, known)
        hold = firmness(look.elapsed_s) * (1.0 + OCCLUDED_PRIOR_SCALE * hidden)
        with look.clock.stage("body"):
            first = self._founds(moved_on, _thinned(look), TRIED_ITERATIONS, prior, hold)
            (found,) = self._founds([min(first, key=_cost).pose], look, prior=prior, hold=hold)
        return found

    def _or_elsewhere(
        self,
        found: Found | None,
        bodies: list[Pose],
        hidden: float,
        statures_m: Sequence[float],
        look: FrameContext,
    ) -> Found:
        """What was found, that turned half round, or one of the bodies that look like what is seen,
        their hidden parts as is usual; where the pose is lost, or there is none, a stance, too."""
        is_lost = found is None or _is_lost(found)
        is_hidden = found is not None and hidden > 0.0
        evidence = look.evidence
        others: list[Found] = []
        for stature_m in statures_m:
            model, alike = look.model, bodies
            if stature_m != model.stature_m:
                model = self._size.model(stature_m)
                alike = shipped_poses().likeness(evidence, stature_m).poses(model, len(bodies))
            sized = replace(look, model=model)
            starts = [usual_where_hidden(pose, sized) if is_hidden else pose for pose in alike]
            if found is not None:
                starts.append(found.pose.turned_round())
            if is_lost:
                yaws_rad = [self.facing.likeliest_rad]
                starts += stand_all(model, evidence.head_camera, yaws_rad, evidence.up_camera)
            others += self._best_of(starts, found and found.pose, sized)
        if len(statures_m) > 1:
            others = [_with_stature_cost(other) for other in others]
            found = found and _with_stature_cost(found)
        best = min(others, key=_cost)
        if found is not None:
            is_doubtful = best.hidden > LOOKED_UP_HIDDEN and not is_hidden
            if is_doubtful or best.cost > found.cost - of_what_is_seen(NEWS_MARGIN, look):
                return found
        return replace(best, is_new=True)

    def _best_of(
        self, starts: Sequence[Pose], found: Pose | None, look: FrameContext
    ) -> list[Found]:
        """The best poses at a first look, refined once more, and now and then the best of those
        that face the other way than what was found, whose limbs are found anew."""
        thinned = _thinned(look)
        first = [
            one.pose
            for one in sorted(self._founds(starts, thinned, LOOKED_UP_ITERATIONS), key=_cost)
        ]
        again = first[:LOOKED_AT_AGAIN]
        if found is not None and self._looks % TURNED_EVERY == 0:
            opposite = [pose for pose in first if _is_opposite(pose, found)]
            again += [self._with_likeliest_limbs(pose, thinned) for pose in opposite[:1]]
        return self._founds(again, look)

    def _with_likeliest_limbs(self, pose: Pose, look: FrameContext) -> Pose:
        """A pose with the limbs with which the whole body costs least, one after the other."""
        for upper in LIMBS:
            usual = usual_limbs(upper)[self._looks // TURNED_EVERY % SHARES :: SHARES]
            likeliest = LimbScan(pose, look, self._refinement).likeliest(upper, usual, 1, 0.0)
            pose = next(iter(_with_limbs(pose, upper, likeliest)), pose)
        return pose

    def _or_otherwise(
        self,
        found: Found,
        limbs: Mapping[int, Array],
        rng: np.random.Generator,
        look: FrameContext,
    ) -> Found:
        """What was found, or that with its trunk elsewhere, or with limbs of bodies that look like
        what is seen or one of [M, 2, 3, 3] `limbs` by upper part, where all of it is cheaper."""
        look = replace(look, model=found.model)
        first = _thinned(look)
        groups = self._alternatives(found.pose, limbs, rng, first)
        kept = self._hypotheses.poses(found.pose)
        starts = [found.pose, *kept, *chain.from_iterable(groups.values())]
        as_it_is, *others = self._founds(starts, first, TRIED_ITERATIONS)
        each = iter(others)
        leading = self._judged(as_it_is, list(islice(each, len(kept))))
        tried = {part: list(islice(each, len(own))) for part, own in groups.items()}
        out = parts_out_of_sight(found.pose, look.model, look.evidence)
        better = leading | _better(as_it_is, tried, leading, out)
        after = self._cheaper(found, as_it_is, better, look) if better else found
        gains = {
            part: [(other.pose, as_it_is.cost - other.cost) for other in own]
            for part, own in tried.items()
        }
        changed = better.keys() if after is not found else set()
        self._hypotheses.keep(after.pose, found.pose, changed, gains, look.model, TRIED_MARGIN)
        return after

    def _settled(self, found: Found, look: FrameContext) -> Found:
        """What was found, refined once more and held less to where it was: while poses are tried
        each is held so firmly that points pull it but a part of the way. Of whom something is
        hidden nothing pulls that part, and it would stray."""
        if max(found.hidden, look.evidence.hidden_share) > 0.0:
            return found
        hold = SETTLING_HOLD * firmness(look.elapsed_s)
        with look.clock.stage("body"):
            (settled,) = self._founds([found.pose], replace(look, model=found.model), hold=hold)
        return replace(found, pose=settled.pose)

    def _alternatives(
        self, pose: Pose, limbs: Mapping[int, Array], rng: np.random.Generator, look: FrameContext
    ) -> dict[int, list[Pose]]:
        """By part, poses with another trunk, or with one of the limbs that are likeliest."""
        groups = {UPPER_TORSO: drawn_trunks(pose, rng)}
        lent = [lender.relative() for lender in self._lenders]
        scan = LimbScan(pose, look, self._refinement)
        for upper, usual in limbs.items():
            several = np.concatenate([usual, *(own[None, upper : upper + 2] for own in lent)])
            likeliest = scan.likeliest(upper, several, LIMBS_TRIED, UNREFINED_MARGIN)
            groups[upper] = _with_limbs(pose, upper, likeliest)
        return groups

    def _judged(self, as_it_is: Found, others: Sequence[Found]) -> dict[int, Found]:
        """The hypotheses that lead, by part, of a frame in which they are refined to `others`."""
        gains = [as_it_is.cost - other.cost for other in others]
        poses = [other.pose for other in others]
        leading = self._hypotheses.judge(poses, gains, self._unsearched_s)
        return {part: others[number] for part, number in leading.items()}

    def _cheaper(
        self, found: Found, as_it_is: Found, better: Mapping[int, Found], look: FrameContext
    ) -> Found:
        """What was found, or the best of what explains more of a part, or that with all these
        parts, if all are refined and that is cheaper; of whom little is seen, by a margin."""
        others = [min(better.values(), key=_cost).pose]
        if len(better) > 1:
            others.append(_with_limbs_of(as_it_is.pose, better))
        before, *after = self._founds([found.pose, *others], look)
        best = min(after, key=_cost)
        gain = before.cost - best.cost
        if gain <= of_what_is_seen(TRIED_MARGIN, look) - TRIED_MARGIN:
            return found
        return replace(found, pose=best.pose, cost=found.cost - gain)

    def _founds(
        self,
        starts: Sequence[Pose],
        look: FrameContext,
        iterations: int | None = None,
        prior: Pose | None = None,
        hold: float = 1.0,
    ) -> list[Found]:
        """Poses, refined, each held to a prior or to where it starts, and all that speaks against
        it."""
        evidence = look.evidence
        refined = refine(
            starts, prior, look.model, evidence, self._refinement, iterations, hold,
            is_hidden=look.is_hidden,
        )  # fmt: skip
        costs = costs_of(refined)
        costs = costs + self.facing.costs(refined.together.Rs[UPPER_TORSO], evidence.up_camera)
        costs = costs + _lift_costs(refined.together, look.model, evidence)
        if look.is_hidden:
            unusual_cost = of_what_is_seen(UNUSUAL_COST, look)
            costs = costs + unusual_cost * how_unusual(refined.together, look)
        return [
            Found(pose, look.model, cost, hidden)
            for pose, cost, hidden in zip(
                refined.poses, costs.tolist(), refined.hidden.tolist(), strict=True
            )
        ]

    def _with_size(self, found: Found, look: FrameContext) -> Found:
        """What was found, of a size that is learnt from it; where it is lost another stature may
        explain more."""
        if found.hidden > 0.0:
            return found
        if _is_lost(found):
            if self._stature.unlearn():
                self._size.forget()
                return replace(found, model=self._size.model(self._stature.stature_m))
            is_doubted = self._stature.is_doubted(is_lost=True)
            return self._with_stature(found, look) if is_doubted else found
        with look.clock.stage("size"):
            self._size.update(found.pose, found.model, look.evidence)
        return replace(found, model=self._size.model(self._stature.stature_m))

    def _with_stature(self, found: Found, look: FrameContext) -> Found:
        """What was found, or a pose of another stature if that is believed from now on."""
        believed_m, tried_m = self._stature.stature_m, self._stature.next_m()
        _, cost = self._of_stature(found, found.model.stature_m, look)
        pose, tried_cost = self._of_stature(found, tried_m, look)
        self._stature.judge(cost, tried_cost)
        if self._stature.stature_m == believed_m:
            return found
        self._size.forget()
        return replace(found, pose=pose, model=self._size.model(tried_m))

    def _of_stature(self, found: Found, stature_m: float, look: FrameContext) -> tuple[Pose, float]:
        """The pose that was found, a stance, or a body that looks like what is seen, of a stature,
        and what it costs."""
        model, evidence = self._size.model(stature_m), look.evidence
        alike = shipped_poses().likeness(evidence, stature_m)
        poses = [found.pose, *alike.poses(model, LOOKED_UP)]
        with look.clock.stage("body"):
            yaw_rad = heading(found.pose.Rs[UPPER_TORSO], evidence.up_camera)
            poses += stand_all(model, evidence.head_camera, [yaw_rad], evidence.up_camera)
            refined = refine(
                poses, None, model, evidence.thinned(), self._refinement, LOOKED_UP_ITERATIONS
            )
            costs = costs_of(refined)
        return refined.poses[int(np.argmin(costs))], float(costs.min())


def _cost(found: Found) -> float:
    return found.cost


def _better(
    as_it_is: Found, tried: Mapping[int, list[Found]], leading: Mapping[int, Found], out: Array
) -> dict[int, Found]:
    """Of each part the cheapest that was tried, where it is cheaper than what leads, and than what
    was found by a margin, which is wider for what is out of sight [11]."""
    better: dict[int, Found] = {}
    for part, own in tried.items():
        cheapest = min(own, key=_cost, default=as_it_is)
        out_of_sight = float(out[part : part + 2].mean()) if part in LIMBS else 0.0
        margin = TRIED_MARGIN * (1.0 + HIDDEN_MARGIN * out_of_sight)
        if cheapest.cost < min(as_it_is.cost - margin, _cost(leading.get(part, as_it_is))):
            better[part] = cheapest
    return better


def _is_opposite(pose: Pose, other: Pose) -> bool:
    """Whether their torsos face away from each other."""
    return float(pose.Rs[UPPER_TORSO, :, 2] @ other.Rs[UPPER_TORSO, :, 2]) < 0.0


def _is_lost(found: Found) -> bool:
    return found.cost > SEARCH_LOST_COST


def limbs_in_turn(search: int | None) -> dict[int, Array]:
    """By upper part, [M, 2, 3, 3] usual poses of limbs that are looked at in the search of this
    number, all of them if there is none."""
    if search is None:
        return {upper: usual_limbs(upper) for upper in LIMBS}
    limbs = {upper: usual_limbs(upper)[search % SHARES :: SHARES] for upper in UPPER_ARMS}
    turns, turn = divmod(search, LEGS_EVERY)
    if turn == 0:
        limbs |= {upper: usual_limbs(upper)[turns % SHARES :: SHARES] for upper in UPPER_LEGS}
    return limbs


def drawn_trunks(pose: Pose, rng: np.random.Generator) -> list[Pose]:
    """A pose with its trunk drawn round where it is; all else keeps its directions."""
    turns = rotations_from_vectors(TRUNK_DRAWN_RAD * rng.standard_normal((TRUNKS, 2, 3)))
    moves = TRUNK_DRAWN_M * rng.standard_normal((TRUNKS, 3))
    drawn = []
    for turn, move in zip(turns, moves, strict=True):
        Rs = pose.Rs.copy()
        Rs[TRUNK_PARTS] = Rs[TRUNK_PARTS] @ turn
        drawn.append(Pose(pose.neck_camera + move, Rs))
    return drawn


def _with_limbs(pose: Pose, upper: int, limbs: Array) -> list[Pose]:
    """A pose with each of [M, 2, 3, 3] poses of a limb."""
    mixed = np.repeat(pose.relative()[:, None], len(limbs), axis=1)
    mixed[upper : upper + 2] = np.swapaxes(limbs, 0, 1)
    necks_camera = np.broadcast_to(pose.neck_camera, (len(limbs), 3))
    return Pose.from_relative(necks_camera, mixed).apart()


def _with_limbs_of(pose: Pose, others: Mapping[int, Found]) -> Pose:
    """A pose with those limbs of others, by upper part."""
    relative = pose.relative()
    for upper in others.keys() & set(LIMBS):
        relative[upper : upper + 2] = others[upper].pose.relative()[upper : upper + 2]
    return Pose.from_relative(pose.neck_camera, relative)


def _thinned(look: FrameContext) -> FrameContext:
    """The frame with fewer points, for a first look."""
    return replace(look, evidence=look.evidence.thinned())


def _with_stature_cost(found: Found) -> Found:
    return replace(found, cost=found.cost + adults_cost(found.model.stature_m))


def _lift_costs(poses: Pose, model: BodyModel, evidence: Evidence) -> Array:
    """[M] what speaks against those of M poses whose feet are both off the floor."""
    if not evidence.floor.any():
        return np.zeros(len(poses.neck_camera))
    soles = poses.ends(model)[[LEFT_LOWER_LEG, RIGHT_LOWER_LEG]]
    soles = np.ascontiguousarray(np.swapaxes(soles, 0, 1))
    lowest_m = evidence.above_floor_m(soles).min(1)
    return LIFT_WEIGHT_PER_M * np.maximum(0.0, lowest_m - LIFT_M)
