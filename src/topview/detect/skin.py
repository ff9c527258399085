"""Detect skin by its colour: Bayes in the U-V plane, adapted on-line (Sec. 4.1.1 and 4.1.2)."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import Final, Literal, get_args

import cv2
import msgspec
import numpy as np
from numpy.typing import NDArray

from topview.detect.color_view import ColorView
from topview.detect.ellipses import Box, Moments
from topview.files import naming, read_archive
from topview.kernels.skin import (
    connected_regions,
    copy_levels,
    count_bins,
    cut_at_edges,
    look_up_levels,
    mix_levels,
    paint,
)
from topview.records import InputError, check_range, read_only, shown

Mask = NDArray[np.bool_]
Counts = NDArray[np.floating]
BackgroundName = Literal["still", "mixtures", "colors"]

SHIFT: Final = 2
BINS: Final = 256 >> SHIFT
"""Of U and of V each: four levels share a bin, about the noise of a colour camera (ours)."""
COLOR_SMOOTHING_BINS: Final = 1.1
"""Standard deviation with which neighbouring bins are mixed (ours)."""
UNSEEN: Final = 1e-6
"""Prior share of all pixels for every colour, besides its count (ours): a colour that was never
seen is no skin."""
COLORLESS_LEVEL: Final = 18
"""Y below which U and V are noise (ours)."""
DEPTH_EDGE_M: Final = 0.1
"""Neighbouring pixels of one hand or face differ by less than this in depth (ours)."""
PERSON_M2: Final = 0.7
"""Front of a large person: 1.9 m tall, of a mean breadth of 0.37 m (ours)."""
LEAST_READ: Final = 0.1
"""Share of a region's pixels with a reading from which its depth is known (ours)."""
GAMMA: Final = 0.8
"""Weight of the training against the last frames (Eq. 4.2; A. Argyros and M. Lourakis, ECCV
2004)."""
WINDOW_S: Final = 0.15
"""w, seconds that the last frames reach back (same source: 5 frames at 30 a second)."""
LEAST_PIXELS_LEARNT: Final = 100
"""Pixels of skin in the window from which the probability is adapted (ours)."""
LEAST_REGION_PIXELS: Final = 12
"""Smaller regions are noise (ours)."""
LEAST_SKIN_M2: Final = 0.0008
"""Smallest area of a region whose depth is known: half a child's fist, edge on (ours)."""
GREATEST_SKIN_M2: Final = 0.15
"""Greatest area of a region: a bare arm with its hand, or a bare chest, but no wall (ours)."""

DEFAULT_SKIN: Final = Path(__file__).parent / "data" / "skin.npz"


@dataclass(frozen=True, slots=True, eq=False)
class SkinHistograms:
    """Histograms of skin, and of all pixels, in the U-V plane.

    Attributes:
        skin: [BINS, BINS] share of all pixels that are skin and of this (U, V): P(s) P(c|s).
        all: [BINS, BINS] share of all pixels of this (U, V): P(c).
        trained_on: the training data, in words.
    """

    skin: Counts
    all: Counts
    trained_on: str

    def __post_init__(self) -> None:
        for name in ("skin", "all"):
            array = getattr(self, name)
            if array.shape != (BINS, BINS) or not np.isfinite(array).all() or (array < 0).any():
                raise InputError(
                    f"skin histogram {name} is {array.shape}; "
                    f"it must be {(BINS, BINS)} shares of 0 or more"
                )
            read_only(array)

    @property
    def probability(self) -> NDArray[np.float64]:
        """[BINS, BINS] P(s|c) = P(s) P(c|s) / P(c) (Eq. 4.1)."""
        return _smooth(self.skin) / (_smooth(self.all) + UNSEEN)

    @classmethod
    def load(cls, path: Path = DEFAULT_SKIN) -> SkinHistograms:
        """Read what `topview train-skin` wrote.

        Raises:
            InputError: no such file, or it holds something else.
        """
        right = "it must be a skin histogram, as `topview train-skin` writes it"
        with naming(path, right=right):
            file = read_archive(path, right)
            try:
                skin, all_, trained_on = file["skin"], file["all"], str(file["trained_on"])
            except KeyError as error:
                raise InputError(f"has no {error}; {right}") from None
            if not {skin.dtype.kind, all_.dtype.kind} <= set("fiu"):
                raise InputError(f"holds no numbers; {right}")
            return cls(skin.astype(np.float64), all_.astype(np.float64), trained_on)

    def npz(self) -> bytes:
        """A small .npz file."""
        file = BytesIO()
        np.savez_compressed(
            file,
            skin=self.skin.astype(np.float32),
            all=self.all.astype(np.float32),
            trained_on=np.array(self.trained_on),
        )
        return file.getvalue()


def _smooth(counts: Counts) -> NDArray[np.float64]:
    return np.asarray(cv2.GaussianBlur(counts, (0, 0), COLOR_SMOOTHING_BINS), np.float64)


def count_colors(yuv: NDArray[np.uint8], where: Mask) -> Counts:
    """[BINS, BINS] how many of the pixels `where` have each colour."""
    _, u, v = (yuv[where] >> SHIFT).T.astype(np.intp)
    counts = np.bincount(u * BINS + v, minlength=BINS**2)
    return counts.reshape(BINS, BINS).astype(np.float64)


@dataclass(frozen=True, slots=True)
class SkinSettings:
    """Where skin is searched (Sec. 4.1), and from what probability on a pixel is skin (Sec. 4.1.2);
    the defaults are ours.

    Attributes:
        seed_probability: T_max, from which a pixel starts a region, 0 to 1.
        growth_probability: T_min, from which it joins one that it touches, 0 to `seed_probability`.
        background: what is no skin whatever its colour, where candidates for people are known by
            their depth: "still" all but the candidates, and what keeps still among them;
            "mixtures" all but the candidates, and what an adaptive Gaussian mixture of each pixel's
            depth, or of its colour where there is no reading, explains; "colors" what the mixture
            of its colour explains, and nothing else, as printed. The camera must stand still.

    Raises:
        InputError: a value out of range, or an unknown background.
    """

    seed_probability: float = 0.3
    growth_probability: float = 0.2
    background: BackgroundName = "still"

    def __post_init__(self) -> None:
        if self.background not in get_args(BackgroundName):
            known = ", ".join(get_args(BackgroundName))
            raise InputError(f"background is {shown(self.background)}; it must be one of {known}")
        check_range(self, 0.0, 1.0, "seed_probability")
        check_range(self, 0.0, self.seed_probability, "growth_probability")


@dataclass(frozen=True, slots=True, eq=False)
class SkinLook:
    """A frame's colours.

    Attributes:
        probability: [h, w] P(s|c) in 1/255, 0 where skin is not searched and where it is too dark
            for colour.
        bin_of: [h, w] flat index of the colour in the U-V plane, where skin is searched.
        seen: [BINS, BINS] how many of the pixels that are searched have each colour.
    """

    probability: NDArray[np.uint8]
    bin_of: NDArray[np.int32]
    seen: Counts


class SkinColor:
    """P(s|c) of pixels, from training and from the last frames (Eq. 4.2)."""

    def __init__(self, histograms: SkinHistograms | None = None) -> None:
        self._trained = (histograms or SkinHistograms.load()).probability
        self._window: deque[tuple[float, Counts, Counts]] = deque()
        self._skin, self._seen = np.zeros((BINS, BINS)), np.zeros((BINS, BINS))
        self._table = self._trained_table = np.asarray(np.rint(255.0 * self._trained), np.uint8)

    def look(self, view: ColorView, where: Mask) -> SkinLook:
        """P(s|c) among the pixels `where`, [h, w]."""
        probability, bin_of = np.empty(where.shape, np.uint8), np.empty(where.shape, np.int32)
        seen = np.zeros((BINS, BINS))
        look_up_levels(
            view.color, view.step, where, self._table, SHIFT, COLORLESS_LEVEL,
            probability, bin_of, seen.ravel(),
        )  # fmt: skip
        return SkinLook(probability, bin_of, seen)

    def adapt(
        self, look: SkinLook, skin_pixels: Iterable[NDArray[np.float32]], now_s: float
    ) -> None:
        """Learn from a frame's detections, [N, 2] pixels (x, y) each, among those that were
        searched (Eq. 4.2).

        A colour that is not among the last frames keeps its trained probability.
        """
        skin, seen = np.zeros((BINS, BINS)), look.seen
        for pixels in skin_pixels:
            count_bins(pixels, look.bin_of, skin.ravel())
        self._window.append((now_s, skin, seen))
        self._skin += skin
        self._seen += seen
        while not 0.0 <= now_s - self._window[0][0] <= WINDOW_S:
            _, skin, seen = self._window.popleft()
            self._skin -= skin
            self._seen -= seen
        if self._skin.sum() >= LEAST_PIXELS_LEARNT:
            self._table = np.empty((BINS, BINS), np.uint8)
            recent = _smooth(self._skin), _smooth(self._seen)
            mix_levels(self._trained, *recent, GAMMA, self._table)
        else:
            self._table = self._trained_table


class SkinRegion(msgspec.Struct, frozen=True, eq=False):
    """A connected patch of skin.

    Attributes:
        pixels: [N, 2] (x, y) in the small image.
        box: of them.
        depth_m: median of its readings, 0 if it has none.
        area_m2: its true size, 0 if its depth is not known.
        probability: mean P(s|c) of its pixels.
        moments: of its pixels.
    """

    pixels: NDArray[np.float32]
    box: Box
    depth_m: float
    area_m2: float
    probability: float
    moments: Moments


def skin_regions(
    view: ColorView, probability: NDArray[np.uint8], settings: SkinSettings
) -> tuple[list[SkinRegion], Mask]:
    """Skin by hysteresis and size (Sec. 4.1.2), and [h, w] where it is.

    A region is a set of connected pixels above T_min, at least one of them above T_max. One that is
    too large is cut at depth edges: a hand before wood. One that is still too large, but smaller
    than a person, is thresholded at T_max alone: skin beside cloth of nearly its colour.
    """
    regions: list[SkinRegion] = []
    is_skin = np.zeros(probability.shape, np.bool_)
    levels = probability
    box = 0, 0, probability.shape[1] - 1, probability.shape[0] - 1
    for cut in (None, _cut_at_edges, _cut_to_seeds):
        if cut is not None:
            levels = cut(view, levels, settings, box)
        too_large: list[SkinRegion] = []
        for region in _connected(view, levels, settings, box):
            if region.area_m2 <= GREATEST_SKIN_M2:
                regions.append(region)
                paint(region.pixels, True, is_skin)
            elif cut is None or region.area_m2 < PERSON_M2:
                too_large.append(region)
        if not too_large:
            break
        levels = np.zeros_like(probability)
        box = _around([region.box for region in too_large])
        for region in too_large:
            copy_levels(region.pixels, probability, levels)
    return regions, is_skin


def _around(boxes: Sequence[Box]) -> Box:
    """The box that holds some."""
    lefts, tops, rights, bottoms = zip(*boxes, strict=True)
    return min(lefts), min(tops), max(rights), max(bottoms)


def _cut_at_edges(
    view: ColorView, probability: NDArray[np.uint8], settings: SkinSettings, box: Box
) -> NDArray[np.uint8]:
    cut = np.zeros_like(probability)
    cut_at_edges(probability, view.depth_m, DEPTH_EDGE_M, box, cut)
    return cut


def _cut_to_seeds(
    view: ColorView, probability: NDArray[np.uint8], settings: SkinSettings, box: Box
) -> NDArray[np.uint8]:
    """The pixels above T_max, without specks."""
    left, top, right, bottom = box
    # Specks are told by their surroundings: with a border of one pixel.
    near = np.s_[max(top - 1, 0) : bottom + 2, max(left - 1, 0) : right + 2]
    is_seed = (probability[near] > 255.0 * settings.seed_probability).view(np.uint8)
    kept = cv2.morphologyEx(is_seed, cv2.MORPH_OPEN, np.ones((3, 3), np.uint8))
    cut = np.zeros_like(probability)
    cut[near] = probability[near] * np.asarray(kept)
    return cut


def _connected(
    view: ColorView, probability: NDArray[np.uint8], settings: SkinSettings, box: Box
) -> Iterator[SkinRegion]:
    """Regions of connected pixels above T_min with a seed among them, without the small ones."""
    pixels, starts, boxes, means = connected_regions(
        probability,
        view.depth_m,
        int(255.0 * settings.growth_probability),
        int(255.0 * settings.seed_probability),
        LEAST_REGION_PIXELS,
        box,
    )
    m2_per_px_at_1_m = 1.0 / (view.camera.fx * view.camera.fy)
    ends = starts.tolist()
    for start, end, (left, top, right, bottom), (level, read, median_m, *moments) in zip(
        ends[:-1], ends[1:], boxes.tolist(), means.tolist(), strict=True
    ):
        depth_m = median_m if read >= LEAST_READ else 0.0
        area_m2 = (end - start) * depth_m * depth_m * m2_per_px_at_1_m
        if area_m2 == 0.0 or area_m2 >= LEAST_SKIN_M2:
            own, around = pixels[start:end], (left, top, right, bottom)
            yield SkinRegion(own, around, depth_m, area_m2, level / 255.0, Moments(*moments))
