"""Learn skin histograms from labelled images, and score them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from topview.detect.color_view import ColorView
from topview.detect.skin import (
    BINS,
    SkinColor,
    SkinHistograms,
    SkinSettings,
    count_colors,
    skin_regions,
)
from topview.records import Camera, Frame

Mask = NDArray[np.bool_]

NOT_SKIN, UNKNOWN, IS_SKIN = 0, 128, 255
"""The values of a label image."""


@dataclass(frozen=True, slots=True, eq=False)
class LabelledImage:
    """[H, W, 3] RGB, [H, W] of `NOT_SKIN`, `UNKNOWN`, `IS_SKIN`, and the class of the skin's tone.

    `frame` has its depth, where that is known; `is_foreground` [H, W] where skin is sought, None:
    everywhere.
    """

    rgb: NDArray[np.uint8]
    label: NDArray[np.uint8]
    tone: str = ""
    frame: Frame | None = None
    is_foreground: Mask | None = None


def as_frame(rgb: NDArray[np.uint8]) -> Frame:
    """An image of unknown depth and focal length."""
    height, width = rgb.shape[:2]
    focal_px = 0.82 * width  # a field of view of 63 degrees (ours)
    camera = Camera(focal_px, focal_px, (width - 1) / 2, (height - 1) / 2, width, height)
    return Frame(0, 0.0, np.zeros((height, width), np.float32), camera, rgb.copy())


def learn_skin(images: Iterable[LabelledImage], trained_on: str) -> SkinHistograms:
    """Count labelled pixels; every image weighs the same."""
    skin, known, count = np.zeros((BINS, BINS)), np.zeros((BINS, BINS)), 0
    for image in images:
        view = ColorView.from_frame(image.frame or as_frame(image.rgb))
        assert view is not None
        label = _small(image.label, view)
        is_known = label != UNKNOWN
        total = max(int(np.count_nonzero(is_known)), 1)
        skin += count_colors(view.yuv, label == IS_SKIN) / total
        known += count_colors(view.yuv, is_known) / total
        count += 1
    return SkinHistograms(skin / max(count, 1), known / max(count, 1), trained_on)


def corrected(
    histograms: SkinHistograms, correction: SkinHistograms, weight: float
) -> SkinHistograms:
    """Blend a correction into histograms with a weight 0..1 (Sec. 4.1.2)."""
    return SkinHistograms(
        (1.0 - weight) * histograms.skin + weight * correction.skin,
        (1.0 - weight) * histograms.all + weight * correction.all,
        f"{histograms.trained_on}; corrected by {correction.trained_on}",
    )


def find_skin(
    frame: Frame,
    histograms: SkinHistograms,
    is_foreground: Mask | None = None,
) -> tuple[ColorView, NDArray[np.uint8], Mask]:
    """The view of a single frame, P(s|c) in 1/255 and the regions of skin in it, [h, w] each."""
    view = ColorView.from_frame(frame)
    assert view is not None
    if is_foreground is None:
        is_foreground = np.ones(frame.depth_m.shape, np.bool_)
    where = _small(is_foreground, view)
    probability = SkinColor(histograms).look(view, where).probability
    _, is_skin = skin_regions(view, probability, SkinSettings())
    return view, probability, is_skin


@dataclass(frozen=True, slots=True)
class SkinScore:
    """Of the labelled pixels of images of one tone: the share of skin that was found, and the
    share of what was found that is skin."""

    tone: str
    recall: float
    precision: float


def score_skin(histograms: SkinHistograms, images: Iterable[LabelledImage]) -> list[SkinScore]:
    """Recall and precision after hysteresis and size filter, by tone."""
    counts: dict[str, NDArray[np.int64]] = {}
    for image in images:
        view, _, is_found = find_skin(
            image.frame or as_frame(image.rgb), histograms, image.is_foreground
        )
        label = _small(image.label, view)
        of_tone = counts.setdefault(image.tone, np.zeros(3, np.int64))
        of_tone += (
            np.count_nonzero(is_found & (label == IS_SKIN)),
            np.count_nonzero(label == IS_SKIN),
            np.count_nonzero(is_found & (label != UNKNOWN)),
        )
    return [
        SkinScore(tone, float(hit / max(skin, 1)), float(hit / max(found, 1)))
        for tone, (hit, skin, found) in counts.items()
    ]


def _small(image: NDArray[Any], view: ColorView) -> NDArray[Any]:
    height, width = view.depth_m.shape
    return image[:: view.stride, :: view.stride][:height, :width]
