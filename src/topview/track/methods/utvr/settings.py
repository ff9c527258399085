"""What can be set of the recipe; the defaults, and what is printed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Final

import numpy as np

from topview.body.model import BodyModel
from topview.body.proportions import THESIS, Proportions
from topview.records import InputError, check_range, shown
from topview.score.utvr import FACTORS, Factor
from topview.track.body_tracker import BodyTracker, Needs, Subject

LEAST_TURN_RAD: Final = 0.01  # that a setting may double a score at


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
        coarse_first: whether all rounds of the torso, that of Sec. 5.1 too, and all but the last of
            other parts look at half the resolution, which is faster.
        descent: Gauss-Newton steps, at the end of each frame, of all parts together onto the
            points and out of free space, 0 to 100; of the pose that was found and of the last
            frame's, and the better one is kept. 0 leaves both out, as printed: a part stays where
            it was placed before those below it were looked at.
        usual: in the descent each pose is held to one whose limbs are turned by this share of the
            way to what captured people do; 0 to 1. With 0 it is held to itself.
        searches_anew: whether the descent starts from stances as well, standing, bending and
            sitting ones that face where the torso does, where it leaves much unexplained.
        weighs_stature: whether other statures are tried, too, where it does, and while none is
            measured.
        looks_up: whether captured bodies that look like what is seen tell the torso's yaw, and are
            where the descent begins, too.
        proportions: of a body of cylinders. None for the bones that the default tracker begins
            with, and for the descent the surface of people in clothes.

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
    usual: float = 0.4
    searches_anew: bool = True
    weighs_stature: bool = True
    looks_up: bool = True
    proportions: Proportions | None = None

    needs: ClassVar[Needs] = Needs()

    def __post_init__(self) -> None:
        check_range(self, 1, 100_000, "hypotheses")
        check_range(self, 1, 10, "rounds")
        check_range(self, 0, 100, "descent")
        check_range(self, 0.0, 1.0, "tolerance_m", "usual")
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

    def body(self, stature_m: float) -> BodyModel:
        """The body of somebody of this stature."""
        from topview.track.bone_lengths import dressed_body

        if self.proportions is None:
            return dressed_body(stature_m)
        return BodyModel.of(stature_m, self.proportions)

    def tracker(self, subject: Subject) -> BodyTracker:
        from topview.track.methods.utvr.tracker import UtvrTracker

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
    usual=0.0,
    searches_anew=False,
    weighs_stature=False,
    looks_up=False,
    proportions=THESIS,
)
"""The recipe of Sec. 5.2 and 5.3, but for what docs/method.md names."""
