"""Fit what tells people from furniture, and measure it."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray
from scipy.optimize import minimize
from scipy.special import expit

from topview.people.existence import CONFIRMED
from topview.people.features import FEATURE_NAMES, SHAPE
from topview.people.likelihood import MOST_SHAPE_ODDS, Evidence, Likelihood
from topview.records import InputError
from topview_lab.metrics.statistics import share
from topview_lab.training.people import TrackRows
from topview_lab.training.people_windows import WindowRows
from topview_lab.training.person_head import PersonHead, fitted_head

Vector = NDArray[np.float64]
Mask = NDArray[np.bool_]

# All ours. Penalties on the squares of how far weights are from what is taken for them before:
# features were scaled so that each speaks as much against a person; of things that are in no
# recording, as lamps at a ceiling, that is all that is known.
SHAPE_PENALTY, SHAPE_PRIOR = 1e-3, -1.0
JOINT_PENALTY: Final = 1e-4
# It is fitted to more digits than are written.
PRECISION: Final = {"ftol": 1e-13, "gtol": 1e-9}
# Of what is written.
WRITTEN_DIGITS: Final = 3
# Of one kind of recording; more are not told one by one.
MOST_SEEDS: Final = 6
# In a source, before that of what motion tells.
OF_MOTION: Final = "; what motion tells: "


def fit_likelihood(rows: TrackRows, source: str) -> Likelihood:
    """Two logistic regressions, in which each row counts the same: of the features, which may only
    speak against a person; and of the log-odds by shape that come of it, the network's, and
    stillness.

    Raises:
        InputError: there are no people, or no furniture, or the network has looked at none of them.
    """
    check_both_kinds(rows.is_person, "was followed")
    check_both_kinds(rows.is_person[rows.is_asked], "was shown to the joint network")
    bias, against = _logistic(
        rows.features, rows.is_person, SHAPE_PENALTY, SHAPE_PRIOR, may_speak_for=False
    )
    weights = {name: _rounded(-weight) for name, weight in zip(FEATURE_NAMES, against, strict=True)}
    alone = Likelihood(source, _rounded(bias), weights, 0.0, 0.0, 0.0, 0.0)
    asked = rows.is_asked
    shapes = rows.features[asked, : len(SHAPE)]
    by_shape = np.array([alone.log_odds_of_shape(shape) for shape in shapes])
    by_shape = np.clip(by_shape, -MOST_SHAPE_ODDS, MOST_SHAPE_ODDS)
    joint_bias, counts = _logistic(
        np.stack([by_shape, rows.network[asked], -rows.features[asked, -1]], axis=1),
        rows.is_person[asked],
        JOINT_PENALTY,
    )
    of_shape, of_network, of_stillness = map(_rounded, counts)
    return replace(
        alone,
        joint_bias=_rounded(joint_bias),
        by_shape=of_shape,
        by_network=of_network,
        by_stillness=of_stillness,
    )


def fit_motion(rows: TrackRows, before: Likelihood, source: str) -> Likelihood:
    """What motion tells alone: to have moved may only speak for a person, and not to have moved
    against one. All else is as before, and so are the log-odds of what has just come.

    Raises:
        InputError: there are no people, or no furniture.
    """
    check_both_kinds(rows.is_person, "was followed")
    just_come = [before.log_odds_of_shape(own[: len(SHAPE)]) for own in rows.features]
    still, unmoved = rows.features[:, len(SHAPE) :].T
    _, (by_motion, by_rest) = _logistic(
        np.stack([1.0 - still, -unmoved], axis=1),
        rows.is_person,
        JOINT_PENALTY,
        may_speak_against=False,
        known=np.array(just_come),
    )
    moving, resting = FEATURE_NAMES[len(SHAPE) :]
    bias = before.bias - before.weights[moving] + by_motion
    weights = before.weights | {moving: _rounded(by_motion), resting: _rounded(by_rest)}
    of_all_else = before.source.split(OF_MOTION)[0]
    source = f"{of_all_else}{OF_MOTION}{source}"
    return replace(before, source=source, bias=_rounded(bias), weights=weights)


def fit_person_head(before: PersonHead, rows: WindowRows) -> PersonHead:
    """The joint network's head that tells people, learnt on from another; what the tracker asked
    about and what was varied count the same.

    Raises:
        InputError: the tracker asked about no person, or about no furniture.
    """
    asked = ~rows.is_varied
    check_both_kinds(rows.is_person[asked], "was shown to the joint network")
    sizes = np.where(asked, asked.sum(), max(rows.is_varied.sum(), 1))
    return fitted_head(before, rows.seen, rows.is_person, 1.0 / sizes)


def check_both_kinds(is_person: Mask, what_for: str) -> None:
    """Raises InputError where one kind is lacking among these [N]."""
    for count, kind in (
        (is_person.sum(), "person's head"),
        ((~is_person).sum(), "piece of furniture"),
    ):
        if not count:
            raise InputError(
                f"no {kind} {what_for}; give more recordings: people and furniture "
                "that is taken for them must both be in them"
            )


def _rounded(value: float) -> float:
    return round(float(value), WRITTEN_DIGITS) + 0.0  # no -0.0


def _logistic(
    values: Vector,
    is_true: Mask,
    penalty: float,
    prior: float = 0.0,
    may_speak_for: bool = True,
    may_speak_against: bool = True,
    known: Vector | None = None,
) -> tuple[float, Vector]:
    """Bias and [K] weights of a logistic regression.

    Args:
        values: [N, K].
        is_true: [N].
        penalty: on the sum of the squares of how far the weights are from the prior.
        prior: what each weight is taken to be before.
        may_speak_for, may_speak_against: if not, no weight is above 0, or below.
        known: [N] log-odds to which the rest is added, without a bias; None where all is to learn.
    """
    before = 0.0 if known is None else known

    def loss(place: Vector) -> tuple[float, Vector]:
        log_odds = before + place[0] + values @ place[1:]
        rates = np.logaddexp(0.0, log_odds) - is_true * log_odds
        errors = (expit(log_odds) - is_true) / len(is_true)
        off = place[1:] - prior
        slope = np.append(errors.sum(), values.T @ errors + 2.0 * penalty * off)
        return float(rates.mean() + penalty * off @ off), slope

    of_bias = (None, None) if known is None else (0.0, 0.0)
    of_weight = None if may_speak_against else 0.0, None if may_speak_for else 0.0
    bounds = [of_bias, *[of_weight] * values.shape[1]]
    start = np.append(0.0, np.full(values.shape[1], prior))
    fitted = minimize(loss, start, jac=True, bounds=bounds, method="L-BFGS-B", options=PRECISION)
    return float(fitted.x[0]), fitted.x[1:]


@dataclass(frozen=True, slots=True)
class CalledPeople:
    """How much of what is truly one kind is confirmed.

    Attributes:
        frames: how many, summed over tracks.
        by_shape: share that is called a person by shape and motion alone.
        with_network: the same with the network, of those frames in which it had looked.
    """

    frames: int
    by_shape: float
    with_network: float


def called_people(likelihood: Likelihood, rows: TrackRows) -> tuple[CalledPeople, CalledPeople]:
    """Of people, and of furniture."""
    by_shape = np.array([likelihood.log_odds_of(features) for features in rows.features])
    joint = np.array(
        [
            Evidence(features, network=network, asked_s=1.0).log_odds(likelihood)
            for features, network in zip(rows.features, rows.network.tolist(), strict=True)
        ]
    )
    least = np.log(CONFIRMED / (1.0 - CONFIRMED))
    people, furniture = (
        CalledPeople(
            int(is_kind.sum()),
            share(float((by_shape[is_kind] > least).sum()), int(is_kind.sum())),
            share(
                float((joint[is_kind & rows.is_asked] > least).sum()),
                int((is_kind & rows.is_asked).sum()),
            ),
        )
        for is_kind in (rows.is_person, ~rows.is_person)
    )
    return people, furniture


def windows_called_right(
    rows: WindowRows, head: PersonHead, is_varied: bool
) -> tuple[float, float]:
    """Shares of the windows with a person, and of those without, of which the network's head says
    the likelier; of those that were varied, or of the others."""
    right = (head.log_odds(rows.seen) > 0.0) == rows.is_person
    kinds = (rows.is_person, ~rows.is_person)
    of_kinds = [right[is_kind & (rows.is_varied == is_varied)] for is_kind in kinds]
    people, others = (share(float(own.sum()), len(own)) for own in of_kinds)
    return people, others


def described(names: Iterable[str]) -> str:
    """Recordings in words, by kind: `cross_000` and `cross_060_tof` are `cross 0, 60`; of more than
    `MOST_SEEDS` seeds the first, the last and how many."""
    by_kind: dict[str, list[str]] = {}
    for name in names:
        found = re.match(r"(.+?)_(\d+)", name)
        kind, seed = (found[1], str(int(found[2]))) if found else (name, "")
        by_kind.setdefault(kind, []).append(seed)
    count = sum(map(len, by_kind.values()))
    kinds = (
        f"{kind} {_in_words(sorted(own, key=int))}" if all(own) else kind
        for kind, own in by_kind.items()
    )
    return f"{count} recordings: {'; '.join(kinds)}"


def _in_words(seeds: Sequence[str]) -> str:
    if len(seeds) <= MOST_SEEDS:
        return ", ".join(seeds)
    return f"{seeds[0]} to {seeds[-1]} ({len(seeds)} of them)"
