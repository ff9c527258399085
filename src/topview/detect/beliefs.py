"""Classify blobs as face, left hand or right hand: recursive naive Bayes (Sec. 4.1.4).

H. Baltzakis, M. Pateraki and P. Trahanias, Visual tracking of hands, faces and facial features of
multiple persons (MVA 2012). Besides its five features, depth gives true sizes, and known heads
give places relative to the person. Blobs that are neither face nor hand have a class of their own.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import IntEnum
from io import BytesIO
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from topview.files import naming, read_archive
from topview.kernels.skin import multiply_shares
from topview.records import InputError, read_only

Vector = NDArray[np.float64]


class Kind(IntEnum):
    """The kinds of blobs; left and right are the person's own."""

    FACE = 0
    LEFT_HAND = 1
    RIGHT_HAND = 2
    OTHER = 3


@dataclass(frozen=True, slots=True)
class Feature:
    """A quantity with a 1D look-up table: `bins` of the same width from `low` to `high`; values
    beyond fall into the outermost bin."""

    low: float
    high: float
    bins: int

    def bin(self, value: float) -> int:
        place = int((value - self.low) / (self.high - self.low) * self.bins)
        return 0 if place < 0 else place if place < self.bins else self.bins - 1


FEATURES: Final[Mapping[str, Feature]] = MappingProxyType(
    {
        # Eq. 4.10. Periphery-to-area ratio, made free of scale: perimeter^2 / (4 pi area).
        "complexity": Feature(0.5, 4.5, 16),
        "horizontal_mps": Feature(0.0, 3.0, 15),
        "vertical_mps": Feature(0.0, 3.0, 15),
        "orientation_rad": Feature(-np.pi / 2, np.pi / 2, 12),
        # The location, as shares of the image's width and height.
        "image_x": Feature(0.0, 1.0, 16),
        "image_y": Feature(0.0, 1.0, 16),
        # Ours, from depth: length and breadth of the ellipse's half.
        "major_m": Feature(0.0, 0.30, 20),
        "minor_m": Feature(0.0, 0.15, 20),
        # Ours, with a head of the person: metres to the image's right of it, and down from it.
        "right_of_head_m": Feature(-1.0, 1.0, 20),
        "below_head_m": Feature(-0.8, 1.2, 20),
    }
)
THESIS_FEATURES: Final = (
    "complexity",
    "vertical_mps",
    "horizontal_mps",
    "orientation_rad",
    "image_x",
    "image_y",
)

Features = Mapping[str, float]

DEFAULT_TABLES: Final = Path(__file__).parent / "data" / "faces_and_hands.npz"
# Ours: prior count of every bin of a table.
LEAST_COUNT: Final = 2.0
# Ours: standard deviation, in bins, with which a table is smoothed: other people in other rooms
# differ by more than those that were counted.
TABLE_SMOOTHING_BINS: Final = 1.0
# Ours: a belief never falls below this, so that it can still be won back.
LEAST_BELIEF: Final = 0.005
# Ours: seconds from which on an observation is independent of the one before.
NEW_EVIDENCE_S: Final = 0.15


@dataclass(frozen=True, slots=True, eq=False)
class BeliefTables:
    """P(feature | kind), one table each, and P(kind) of a new blob.

    Attributes:
        prior: [4] of the kinds.
        tables: by the feature's name, [4, bins]; rows sum to one.
        trained_on: the training data, in words.
    """

    prior: Vector
    tables: Mapping[str, Vector]
    trained_on: str
    _known: tuple[str, ...] = field(init=False, repr=False)
    _ranges: Vector = field(init=False, repr=False)
    _columns: Vector = field(init=False, repr=False)

    def __post_init__(self) -> None:
        for name, table in (("prior", self.prior[None]), *self.tables.items()):
            shape = (1, len(Kind)) if name == "prior" else (len(Kind), FEATURES[name].bins)
            if table.shape != shape or not np.allclose(table.sum(1), 1.0, atol=1e-4):
                raise InputError(
                    f"table of {name} is {table.shape}; it must be {shape} with rows of sum 1"
                )
            read_only(table)
        known = [(name, feature) for name, feature in FEATURES.items() if name in self.tables]
        most = max((feature.bins for _, feature in known), default=0)
        columns = np.ones((len(known), most, len(Kind)))
        for row, (name, feature) in enumerate(known):
            columns[row, : feature.bins] = self.tables[name].T
        ranges = [(feature.low, feature.high, feature.bins) for _, feature in known]
        object.__setattr__(self, "_known", tuple(name for name, _ in known))
        object.__setattr__(self, "_ranges", np.array(ranges, np.float64).reshape(-1, 3))
        object.__setattr__(self, "_columns", columns)

    def likelihoods(self, observations: Sequence[Features]) -> Vector:
        """[N, 4] P(O | kind), the products over the features that are known (Eq. 4.10)."""
        values = [[seen.get(name, np.nan) for name in self._known] for seen in observations]
        places = np.array(values, np.float64).reshape(len(observations), len(self._known))
        products = np.empty((len(places), len(Kind)))
        multiply_shares(places, self._ranges, self._columns, products)
        return products

    def updated(
        self, before: Sequence[Vector | None], observations: Sequence[Features], elapsed_s: float
    ) -> Vector:
        """[N, 4] B_t of B_{t-1}, [4] each, None of what is new, and an observation of each
        (Eq. 4.9); rows sum to one.

        An observation weighs less the sooner it follows the one before: at 30 frames a second,
        consecutive ones are far from independent.
        """
        likelihoods = self.likelihoods(observations)
        is_new = np.array([belief is None for belief in before], np.bool_)
        weighed = likelihoods ** min(elapsed_s / NEW_EVIDENCE_S, 1.0)
        weighed[is_new] = likelihoods[is_new]
        known = [self.prior if belief is None else belief for belief in before]
        posterior = np.array(known).reshape(weighed.shape) * weighed
        shares = posterior / np.maximum(posterior.sum(1, keepdims=True), 1e-300)
        beliefs = np.maximum(shares, LEAST_BELIEF)
        return beliefs / beliefs.sum(1, keepdims=True)

    def only(self, names: Sequence[str]) -> BeliefTables:
        """The tables of these features alone."""
        tables = {name: table for name, table in self.tables.items() if name in names}
        return BeliefTables(self.prior.copy(), tables, self.trained_on)

    @classmethod
    def learn(
        cls, observations: Sequence[Features], kinds: Sequence[Kind], trained_on: str
    ) -> BeliefTables:
        """Count labelled observations."""
        from scipy.ndimage import gaussian_filter1d  # slow; only training needs it

        tables = {}
        for name, feature in FEATURES.items():
            table = np.full((len(Kind), feature.bins), LEAST_COUNT)
            for features, kind in zip(observations, kinds, strict=True):
                if name in features:
                    table[kind, feature.bin(features[name])] += 1.0
            around = "wrap" if name == "orientation_rad" else "nearest"
            table = gaussian_filter1d(table, TABLE_SMOOTHING_BINS, axis=1, mode=around)
            tables[name] = table / table.sum(axis=1, keepdims=True)
        prior = np.full(len(Kind), 1.0 / len(Kind))  # how many others there are, the scene decides
        return cls(prior, tables, trained_on)

    @classmethod
    def load(cls, path: Path = DEFAULT_TABLES) -> BeliefTables:
        """Read what `topview train-hands` wrote.

        Raises:
            InputError: no such file, or it holds something else.
        """
        right = "it must hold tables of hands, as `topview train-hands` writes them"
        with naming(path, right=right):
            file = read_archive(path, right)
            try:
                tables = {name: file[name].astype(np.float64) for name in FEATURES}
                prior, trained_on = file["prior"].astype(np.float64), str(file["trained_on"])
            except (KeyError, ValueError) as error:
                raise InputError(f"has no usable {error}; {right}") from None
            return cls(prior, tables, trained_on)

    def npz(self) -> bytes:
        """A small .npz file."""
        file = BytesIO()
        arrays: dict[str, Any] = {
            name: table.astype(np.float32) for name, table in self.tables.items()
        }
        arrays["prior"] = self.prior.astype(np.float32)
        np.savez_compressed(file, **arrays, trained_on=np.array(self.trained_on))
        return file.getvalue()
