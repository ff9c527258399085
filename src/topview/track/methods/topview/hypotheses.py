"""Other hypotheses of a body that is searched for, kept until time decides (ours).

Which of two poses costs less is noise in one frame where both explain what is seen about as well.
So what was tried for the trunk or for a limb, and is nearly as cheap, goes on beside the pose that
is told: it is refined in each search, and how much less it costs is averaged. What leads is told
instead, and what was told before goes on as a hypothesis.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence, Set
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.body.model import BodyModel
from topview.body.parts import UPPER_TORSO
from topview.filter.over_time import share_after
from topview.track.pose import TREE_PARENT, TRUNK_PARTS, Pose

Array = NDArray[np.float64]

# All ours, chosen on `one`, `turn` and `sit` 0 to 7. So many are kept, apart from what is told and
# from each other by so much at one end of a part at least, and no farther behind on average than
# the cost given; an average goes back so far.
MOST_HYPOTHESES: Final = 8
DISTINCT_M: Final = 0.1
MOST_BEHIND: Final = 0.02
JUDGED_S: Final = 0.6


@dataclass(frozen=True, slots=True, eq=False)
class Hypothesis:
    """Another trunk, or another limb.

    Attributes:
        part: the upper torso, or the limb's upper part.
        pose: a whole pose with it.
        lead: how much less a body costs with it than without, on average.
    """

    part: int
    pose: Pose
    lead: float


class Hypotheses:
    """Of one person."""

    def __init__(self) -> None:
        self._kept: list[Hypothesis] = []

    def __len__(self) -> int:
        return len(self._kept)

    def poses(self, told: Pose) -> list[Pose]:
        """The pose that is told with each one's part."""
        return _with_parts(told, self._kept).apart()

    def judge(
        self, poses: Sequence[Pose], gains: Sequence[float], elapsed_s: float
    ) -> dict[int, int]:
        """Take over `poses`, refined, and by how much less each costs than the pose that is told;
        by part, the number of the cheapest of those that lead, now and on average."""
        share = share_after(elapsed_s, JUDGED_S)
        self._kept = [
            Hypothesis(one.part, pose, one.lead + share * (gain - one.lead))
            for one, pose, gain in zip(self._kept, poses, gains, strict=True)
        ]
        leading = [k for k, one in enumerate(self._kept) if one.lead > 0.0 and gains[k] > 0.0]
        return {self._kept[k].part: k for k in sorted(leading, key=gains.__getitem__)}

    def keep(
        self,
        told: Pose,
        before: Pose,
        changed: Set[int],
        tried: Mapping[int, Sequence[tuple[Pose, float]]],
        model: BodyModel,
        handicap: float,
    ) -> None:
        """Go on with those that differ from the pose that is told from now on.

        Args:
            told: that pose.
            before: the one that was told until now.
            changed: the parts of it that changed.
            tried: by part, what was tried besides, and by how much less it costs.
            model: the body's size.
            handicap: how far behind what is new begins.
        """
        known = [
            replace(one, lead=min(one.lead, 0.0) - handicap) if one.part in changed else one
            for one in sorted(self._kept, key=lambda one: -one.lead)
        ]
        new = sorted(
            (-gain, number, part, pose)
            for part, own in tried.items()
            for number, (pose, gain) in enumerate(own)
            if gain > -MOST_BEHIND
        )
        several = [
            *(Hypothesis(part, before, -handicap) for part in changed),
            *(one for one in known if one.lead > -MOST_BEHIND),
            *(Hypothesis(part, pose, -handicap) for _, _, part, pose in new),
        ]
        self._kept = _distinct(told, several, model)


def _distinct(told: Pose, several: Sequence[Hypothesis], model: BodyModel) -> list[Hypothesis]:
    """The first of these that differ from the pose that is told, and from each other."""
    wholes = _with_parts(told, several)
    places = np.concatenate([wholes.origins(model), wholes.ends(model)])
    own = Pose.together([told])
    told_places = np.concatenate([own.origins(model), own.ends(model)])
    kept: list[int] = []
    for k in range(len(several)):
        if len(kept) == MOST_HYPOTHESES:
            break
        others = np.concatenate([told_places, places[:, kept]], axis=1)
        off_m = np.linalg.norm(places[:, k, None] - others, axis=-1).max(0)
        if (off_m > DISTINCT_M).all():
            kept.append(k)
    return [several[k] for k in kept]


def _with_parts(told: Pose, several: Sequence[Hypothesis]) -> Pose:
    """M poses: the one that is told, each with a hypothesis's trunk, all else pointing where it
    does, or with its limb as that hangs from the trunk."""
    necks = np.repeat(told.neck_camera[None], len(several), axis=0)
    Rs = np.repeat(told.Rs[:, None], len(several), axis=1)
    for k, one in enumerate(several):
        if one.part == UPPER_TORSO:
            necks[k], Rs[TRUNK_PARTS, k] = one.pose.neck_camera, one.pose.Rs[TRUNK_PARTS]
        else:
            own = slice(one.part, one.part + 2)
            carrier = TREE_PARENT[one.part]
            Rs[own, k] = told.Rs[carrier] @ one.pose.Rs[carrier].T @ one.pose.Rs[own]
    return Pose(necks, Rs)
