"""How likely what was seen of a track is, of a person against furniture; fitted, not chosen."""

from __future__ import annotations

from functools import cache, cached_property
from importlib import resources
from math import exp, inf, log, log1p
from typing import Final

import msgspec
import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray

from topview.filter.over_time import share_after
from topview.people.features import FEATURE_NAMES, SHAPE, Features
from topview.people.motion import PAUSE_S

LIKELIHOOD_FILE: Final = "likelihood.json"
# All ours. Over how many seconds evidence is averaged.
EVIDENCE_MEMORY_S: Final = 2.0
# Of what stands still so much changes by noise at its outline, and so much seems to move; who has
# moved, so much more. The two last were chosen on the recordings of the fit.
FLICKER: Final = 0.15
SEEMS_TO_MOVE, MOVES = 0.05, 0.15
# What moves is likelier a person's than what has only just come. Some people move often, some
# seldom: that somebody has not yet is by this power law of the time.
# After the longest nothing more is learnt; of who lies that is so after the shortest.
RESTLESS_S, LONG_S = 1.0, 15.0
# What is cut by the border of the picture tells the less, but never less than so much as in view.
CUT: Final = FEATURE_NAMES.index("cut by the border")
LEAST_CLEAR: Final = 0.1
# The network is asked again about who is in doubt when the answer can change the mean by so much.
NEWS: Final = 0.3
# The network's log-odds count no more than this, frame by frame.
MOST_LOG_ODDS: Final = 5.0
# Nor do those by shape beside them.
MOST_SHAPE_ODDS: Final = 12.0
# What is asked for its body alone may as well be a person as not (ours): no feature speaks for
# either. Asked 322 times about clusters, in recordings of the layer's fit and of simulated people
# in postures, the network named a head in 13; 11 were people's, and of the other two it said 0.6.
BODY_ODDS: Final = 0.0


class Likelihood(msgspec.Struct, frozen=True, dict=True):
    """Log-likelihood ratios of a person against furniture, fitted by `topview train-people`.

    Attributes:
        source: what it was fitted on.
        bias: log-odds of a person by shape where no feature speaks against it.
        weights: of `FEATURE_NAMES`: by how much each lowers the log-odds.
        joint_bias, by_shape, by_network: log-odds where the joint network has looked at the window:
            the bias, and what those by shape and those of the network (`p_person`) count.
        by_stillness: by how much the last feature lowers them there.
    """

    source: str
    bias: float
    weights: dict[str, float]
    joint_bias: float
    by_shape: float
    by_network: float
    by_stillness: float

    def log_odds_of(self, features: Features) -> float:
        """By shape and motion, of [F] `FEATURE_NAMES`."""
        return self.bias - float(self._vector @ features)

    def log_odds_of_shape(self, shape: Features) -> float:
        """By [S] features alone, of what has just come."""
        return self.log_odds_of(_just_come(shape))

    def worst_of(self, features: Features) -> str:
        """The name of the feature that speaks most against a person."""
        return FEATURE_NAMES[int(np.argmax(self._vector[: len(features)] * features))]

    @cached_property
    def _vector(self) -> NDArray[np.float64]:
        return np.array([self.weights[name] for name in FEATURE_NAMES])


@cache
def shipped_likelihood() -> Likelihood:
    """The one that the package carries."""
    text = resources.files("topview.people").joinpath(LIKELIHOOD_FILE).read_bytes()
    return msgspec.json.decode(text, type=Likelihood)


class Evidence(msgspec.Struct, frozen=True, eq=False):
    """What has been seen of a track, averaged over the last seconds.

    Attributes:
        features: [F] mean of `FEATURE_NAMES`.
        still: 1 while what is seen of the body has not moved, 0 once it has.
        seen_s: how long it has been looked at; what is cut counts less.
        shape_s: of which time its shape is that of what is followed now.
        looked_s: when it was last looked at.
        clear: how much that look counts, 0..1.
        network: mean log-odds of `p_person`.
        asked_s: how long the network has looked; what is cut counts less.
        answered_s: of which time it last answered.
        by_body: whether no upright head is to be expected, so that the lack of one tells little.
        was_upright: whether one was followed before, so that what its body looks like counts.
    """

    features: Features
    still: float = 1.0
    seen_s: float = 0.0
    shape_s: float = 0.0
    looked_s: float = 0.0
    clear: float = 1.0
    network: float = 0.0
    asked_s: float = 0.0
    answered_s: float = -inf
    by_body: bool = False
    was_upright: bool = True

    @classmethod
    def starting_with(cls, shape: Features, time_s: float) -> Evidence:
        """With [S] features of the first frame."""
        return cls(_just_come(shape), looked_s=time_s, clear=_clear(shape))

    def with_shape(self, shape: Features, moved: float, time_s: float) -> Evidence:
        """With [S] features of another frame, and the share of the body that has moved since it was
        first seen."""
        clear = _clear(shape)
        elapsed_s = clear * min(max(time_s - self.looked_s, 0.0), PAUSE_S)
        before = self.shape
        mean = before + share_of_new(self.shape_s, elapsed_s) * (shape - before)
        still = min(self.still, max(1.0 - (moved - SEEMS_TO_MOVE) / MOVES, 0.0))
        seen_s = self.seen_s + elapsed_s
        unmoved = still * log1p(min(seen_s, LONG_S) / RESTLESS_S)
        return replace(
            self,
            features=np.append(mean, [still, unmoved]),
            still=still,
            seen_s=seen_s,
            shape_s=self.shape_s + elapsed_s,
            looked_s=time_s,
            clear=clear,
        )

    @property
    def shape(self) -> Features:
        """[S] mean of those of one frame."""
        return self.features[: len(SHAPE)]

    def of_another_head(self) -> Evidence:
        """The shape until now was of something else than what is followed from now on."""
        return replace(self, shape_s=0.0)

    def with_network(self, log_odds: float, elapsed_s: float, time_s: float) -> Evidence:
        """With what the network said of another frame, at a time, and of those since it was last
        asked, if nothing new was to be expected of them."""
        now = min(max(log_odds, -MOST_LOG_ODDS), MOST_LOG_ODDS)
        since_s = min(time_s - self.answered_s, self._answer_holds_s + elapsed_s)
        clear_s = self.clear * max(since_s, elapsed_s)
        share = share_of_new(self.asked_s, clear_s) if self.asked_s else 1.0
        mean = self.network + share * (now - self.network)
        return replace(self, network=mean, asked_s=self.asked_s + clear_s, answered_s=time_s)

    def is_to_be_asked(self, time_s: float, is_at_rest: bool = False) -> bool:
        """Whether another answer of the network would be news; of what is at rest it says the same
        until that is forgotten."""
        holds_s = EVIDENCE_MEMORY_S if is_at_rest else self._answer_holds_s
        return time_s - self.answered_s >= holds_s

    @property
    def _answer_holds_s(self) -> float:
        return NEWS * min(self.asked_s, EVIDENCE_MEMORY_S)

    def log_odds(self, likelihood: Likelihood) -> float:
        """That it is a person's."""
        if not self.asked_s:
            return likelihood.log_odds_of(self.features)
        by_shape = likelihood.log_odds_of_shape(self.shape)
        shape = likelihood.by_shape * min(max(by_shape, -MOST_SHAPE_ODDS), MOST_SHAPE_ODDS)
        unmoved = float(self.features[-1])
        if self.by_body:
            shape = max(shape, BODY_ODDS) if self.was_upright else BODY_ODDS
            unmoved = min(unmoved, log(2.0))
        said = likelihood.by_network * self.network - likelihood.by_stillness * unmoved
        return likelihood.joint_bias + shape + said


def _just_come(shape: Features) -> Features:
    """[F] of [S] features that are the first."""
    return np.append(shape, [1.0, 0.0])


def _clear(shape: Features) -> float:
    return max(1.0 - float(shape[CUT]), LEAST_CLEAR)


def share_of_new(before_s: float, elapsed_s: float) -> float:
    """In a mean over all that was seen, and after `EVIDENCE_MEMORY_S` one that forgets."""
    over_all = elapsed_s / max(before_s + elapsed_s, 1e-9) if before_s + elapsed_s else 1.0
    return max(over_all, share_after(elapsed_s, EVIDENCE_MEMORY_S))


def probability(log_odds: float) -> float:
    """0..1."""
    return 1.0 / (1.0 + exp(-min(max(log_odds, -50.0), 50.0)))
