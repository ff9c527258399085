"""The unified TVR score of Sec. 5.2: every factor on its own, for many hypotheses at once.

`topview.score.definition` says the same in plain NumPy, one hypothesis at a time.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from topview.camera.pyramid import DepthView
from topview.kernels import utvr as kernel

# A hypothesis with fewer points inside has no evidence and no score. Ours: the smallest number
# whose top view can tell an axis.
MIN_POINTS_INSIDE: Final = 6
# Most cells across a part, so that the kernel's top view has room for all of it.
CELLS_ACROSS: Final = kernel.GRID - 2

Factor = Literal["reproj", "align", "discr"]
FACTORS: Final[tuple[Factor, ...]] = ("reproj", "align", "discr")
"""Of f_uTVR, Eq. 5.7."""


@dataclass(frozen=True, slots=True, eq=False)
class UtvrTerms:
    """The factors of Eq. 5.7 - 5.9 of M hypotheses, [M] each; lower is better throughout.

    Attributes:
        counts: [M, 7] of the kernel, which all else follows from.
        n_points: N_3D, the user's points inside.
        n_pixels: N_Dcyl, pixels of the rendered cylinder.
        n_inliers, n_occluded, n_outliers: what the pixels turned out to be (Sec. 5.2.1).
        reproj, align, occl, ovl, coll: the factors; infinite without evidence.
        score: their product f_uTVR.
    """

    counts: NDArray[np.int32]
    n_points: NDArray[np.int32]
    n_pixels: NDArray[np.int32]
    n_inliers: NDArray[np.int32]
    n_occluded: NDArray[np.int32]
    n_outliers: NDArray[np.int32]
    reproj: NDArray[np.float64]
    align: NDArray[np.float64]
    occl: NDArray[np.float64]
    ovl: NDArray[np.float64]
    coll: NDArray[np.float64]
    score: NDArray[np.float64]

    @property
    def has_evidence(self) -> NDArray[np.bool_]:
        """[M] True where a hypothesis has enough points inside, and pixels near its surface."""
        return (self.n_points >= MIN_POINTS_INSIDE) & (self.n_inliers > 0)

    @property
    def discr(self) -> NDArray[np.float64]:
        """[M] the discrepancy term of Eq. 5.8."""
        return self.occl * self.coll * self.ovl

    def product(self, factors: Collection[Factor]) -> NDArray[np.float64]:
        """[M] the score of some of the factors of Eq. 5.7 alone, as Table 6.3 compares them."""
        chosen = [getattr(self, factor) for factor in FACTORS if factor in factors]
        product = chosen.pop() if chosen else np.ones_like(self.score)
        for factor in chosen:
            product = product * factor
        return product

    def btvr(self, hidden_share: float) -> NDArray[np.float64]:
        """[M] f_bTVR (Eq. 5.1): `hidden_share` is P_occl, how much of the user's image area is
        covered by other users, 0 to 1 (Eq. 5.3)."""
        return self.reproj * self.align * (2.0 - hidden_share)

    @classmethod
    def from_counts(cls, counts: NDArray[np.int32]) -> UtvrTerms:
        """[M, 7] counts of the kernel, or of the definition, to factors."""
        n_points, _, n_pixels, n_in, n_occl, n_out, _ = counts.T
        factors = np.empty((kernel.N_FACTORS, len(counts)))
        kernel.fill_factors(counts, factors)
        reproj, align, occl, ovl, coll = factors
        score = reproj * align * occl * ovl * coll  # Eq. 5.7, 5.8
        return cls(
            counts, n_points, n_pixels, n_in, n_occl, n_out, reproj, align, occl, ovl, coll, score
        )


@dataclass(frozen=True, slots=True, eq=False)
class Observed:
    """What hypotheses are scored on.

    Attributes:
        view: the whole scene's depth.
        own: [H, W] uint8, whose pixels are the user's remaining points where they have a reading.
            Each of its bits is a layer: hypotheses that have other points are scored at once.
    """

    view: DepthView
    own: NDArray[np.uint8]

    @classmethod
    def of(cls, view: DepthView, is_own: NDArray[np.bool_]) -> Observed:
        """With one layer of [H, W] pixels that are the user's."""
        return cls(view, np.ascontiguousarray(is_own).view(np.uint8))


FIRST_LAYER: Final = 1


def score_hypotheses(
    Rs_camera_part: NDArray[np.float64],
    origins_camera: NDArray[np.float64],
    length_m: float,
    radii_m: NDArray[np.float64],
    observed: Observed,
    placed: NDArray[np.float32],
    tolerance_m: float,
    threads: int,
    layers: NDArray[np.uint8] | None = None,
) -> UtvrTerms:
    """Score M hypotheses of one part.

    Args: as of `count_hypotheses`.
    """
    counts = count_hypotheses(
        Rs_camera_part, origins_camera, length_m, radii_m, observed, placed, tolerance_m, threads,
        layers,
    )  # fmt: skip
    return UtvrTerms.from_counts(counts)


def count_hypotheses(
    Rs_camera_part: NDArray[np.float64],
    origins_camera: NDArray[np.float64],
    length_m: float,
    radii_m: NDArray[np.float64],
    observed: Observed,
    placed: NDArray[np.float32],
    tolerance_m: float,
    threads: int,
    layers: NDArray[np.uint8] | None = None,
) -> NDArray[np.int32]:
    """[M, 7] counts of `topview.kernels.utvr` that the scores of M hypotheses of one part are made
    of.

    Args:
        Rs_camera_part, origins_camera: [M, 3, 3] and [M, 3] (or [3] for all), metres.
        length_m, radii_m: size of the part.
        observed: the scene, and what is left of the user's points.
        placed: [K, 15] parts already placed, from `placed_parts`.
        tolerance_m: the T of Sec. 5.2.1.
        threads: how many share the work; it does not change the result.
        layers: [M] bit of the layer in which each has its points; None for the first.
    """
    M, view = len(Rs_camera_part), observed.view
    origins = np.empty((M, 3), np.float32)
    origins[:] = origins_camera
    distance_m = float(origins[:, 2].mean()) if M else 1.0
    cell_m = max(view.cell_m(distance_m), 2 * max(radii_m) / CELLS_ACROSS)
    counts = np.empty((M, kernel.N_COUNTS), np.int32)
    f4 = np.float32
    kernel.count_hypotheses(
        view.depth_m,
        observed.own,
        f4(view.fx),
        f4(view.fy),
        f4(view.cx),
        f4(view.cy),
        np.ascontiguousarray(Rs_camera_part, np.float32),
        origins,
        np.full(M, FIRST_LAYER, np.uint8) if layers is None else layers,
        f4(length_m),
        f4(radii_m[0]),
        f4(radii_m[1]),
        f4(cell_m),
        f4(tolerance_m),
        placed,
        max(1, min(threads, M)),
        counts,
    )
    return counts


def placed_parts(
    Rs_camera_part: NDArray[np.float64],
    origins_camera: NDArray[np.float64],
    lengths_m: NDArray[np.float64],
    radii_m: NDArray[np.float64],
) -> NDArray[np.float32]:
    """[K, ...] parts to the [K, 15] rows that the kernel tests for collisions."""
    K = len(Rs_camera_part)
    return np.concatenate(
        [
            Rs_camera_part.reshape(K, 9),
            origins_camera.reshape(K, 3),
            lengths_m.reshape(K, 1),
            1.0 / radii_m.reshape(K, 2) ** 2,
        ],
        axis=1,
    ).astype(np.float32)
