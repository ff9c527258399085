"""Skin regions followed over time as ellipses (Sec. 4.1.3).

A. Argyros and M. Lourakis, Real-time tracking of multiple skin-colored objects with a possibly
moving camera (ECCV 2004); predictions by H. Baltzakis and A. Argyros, Propagation of pixel
hypotheses for multiple objects tracking (ISVC 2009): a blob's pixels move on with it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from topview.detect.ellipses import Ellipse
from topview.detect.seeing import ColorView
from topview.detect.skin import SkinRegion

Pixels = NDArray[np.float32]


@dataclass(frozen=True, slots=True)
class BlobSettings:
    """How blobs are followed; all ours.

    Attributes:
        grace_s: how long a blob lives on without support; at most as long as it had some.
        spread_mps: standard deviation of the speed with which a blob moves other than predicted.
        greatest_spread_m: of a blob's predicted place.
        usual_depth_m: of a blob whose depth is not known.
        velocity_s: time over which a velocity is averaged.
        coasting_s: time in which a velocity that nothing supports fades.
        same_depth_m: a pixel belongs to blobs that are as near, if there are any.
        shared: share of a blob's pixels that others claim too, from which it keeps its own form.
        least_gain: with which a blob follows pixels that all are others' too.
        merged: share of its pixels that others claim too, from which a blob may be theirs.
        merged_s: how long it may be so, inside an older one, until it goes.
    """

    grace_s: float = 0.4
    spread_mps: float = 0.75
    greatest_spread_m: float = 0.06
    usual_depth_m: float = 2.5
    velocity_s: float = 0.06
    coasting_s: float = 0.4
    same_depth_m: float = 0.10
    shared: float = 0.2
    least_gain: float = 0.2
    merged: float = 0.8
    merged_s: float = 1.0


@dataclass(slots=True, eq=False)
class Blob:
    """One skin-coloured object: an ellipse hypothesis and the pixels that carry it.

    Attributes:
        id: lasts while it lives, counted from 1.
        pixels: [N, 2] (x, y) in the small image.
        ellipse: of them.
        velocity_px_s: [2].
        depth_m: median of its pixels' readings, 0 if not known.
        born_s, seen_s: when it first and last had support.
        region: what supports it in this frame, None if nothing does.
        overlap: share of its pixels that other blobs claim too.
        merged_since_s: since when an older one has claimed nearly all of it.
    """

    id: int
    pixels: Pixels
    ellipse: Ellipse
    depth_m: float
    born_s: float
    seen_s: float
    region: SkinRegion | None
    velocity_px_s: NDArray[np.float64] = field(default_factory=lambda: np.zeros(2))
    overlap: float = 0.0
    merged_since_s: float | None = None

    def move(self, elapsed_s: float, spread_px: float) -> None:
        """Propagate its pixels; the ellipse is as much wider as their places are uncertain."""
        self.pixels = self.pixels + (self.velocity_px_s * elapsed_s).astype(np.float32)
        self.ellipse = Ellipse.of_pixels(self.pixels, spread_px)


class BlobTracker:
    """Follows blobs from frame to frame."""

    def __init__(self, settings: BlobSettings | None = None) -> None:
        self.settings = settings or BlobSettings()
        self.blobs: list[Blob] = []
        self._next_id = 1
        self._last_s: float | None = None

    def update(self, view: ColorView, regions: Sequence[SkinRegion]) -> list[Blob]:
        """The blobs after the next frame; those with `seen_s` before it are only predicted."""
        now_s = view.frame.timestamp_s
        elapsed_s = 0.0 if self._last_s is None else max(now_s - self._last_s, 0.0)
        self._last_s = now_s
        for blob in self.blobs:
            focal_px = view.camera.fx / (blob.depth_m or self.settings.usual_depth_m)
            unseen_s = max(now_s - blob.seen_s, 0.0)
            spread_m = min(self.settings.spread_mps * unseen_s, self.settings.greatest_spread_m)
            blob.move(elapsed_s, spread_m * focal_px)
            blob.region = None
        supports = self._supports(view, regions)
        for r, blobs in supports.items():
            self._follow(view, regions[r], blobs, elapsed_s)
        for blob in self.blobs:
            if blob.region is None:
                blob.velocity_px_s *= np.exp(-elapsed_s / self.settings.coasting_s)
                blob.ellipse = Ellipse.of_pixels(blob.pixels)
        self._eliminate(now_s)
        for r, region in enumerate(regions):
            if r not in supports and not any(
                blob.ellipse.count(region.pixels, region.box) for blob in self.blobs
            ):  # Eq. 4.5
                self.blobs.append(self._new(region, now_s))
        return self.blobs

    def _new(self, region: SkinRegion, now_s: float) -> Blob:
        ellipse = Ellipse.of_pixels(region.pixels)
        blob = Blob(
            self._next_id, region.pixels, ellipse, region.depth_m, now_s, now_s, region
        )  # fmt: skip
        self._next_id += 1
        return blob

    def _supports(self, view: ColorView, regions: Sequence[SkinRegion]) -> dict[int, list[Blob]]:
        """The blobs that each region supports, by the region's index.

        A blob keeps the region on which most of its propagated pixels land, or takes the one with
        which its ellipse shares most pixels.
        """
        height, width = view.depth_m.shape
        region_of = np.zeros((height, width), np.int32)
        for r, region in enumerate(regions):
            columns, rows = region.pixels.astype(np.intp).T
            region_of[rows, columns] = r + 1
        supports: dict[int, list[Blob]] = {}
        for blob in self.blobs:
            columns, rows = np.rint(blob.pixels).astype(np.intp).T
            is_in = (columns >= 0) & (columns < width) & (rows >= 0) & (rows < height)
            landed = np.bincount(region_of[rows[is_in], columns[is_in]], minlength=2)[1:]
            if not landed.any():
                landed = np.array(
                    [blob.ellipse.count(region.pixels, region.box) for region in regions] or [0]
                )
            if landed.any():
                supports.setdefault(int(np.argmax(landed)), []).append(blob)
        return supports

    def _follow(
        self, view: ColorView, region: SkinRegion, blobs: list[Blob], elapsed_s: float
    ) -> None:
        """Share a region's pixels among its blobs and move each to its own."""
        belongs = self._share(view, region, blobs)
        claims = belongs.sum(axis=0)
        for blob, is_its in zip(blobs, belongs, strict=True):
            if not is_its.any():
                continue
            overlap = float((claims[is_its] > 1).mean())
            self._see(blob, region, region.pixels[is_its], overlap, elapsed_s, view)

    def _share(self, view: ColorView, region: SkinRegion, blobs: list[Blob]) -> NDArray[np.bool_]:
        """[K, N] which of a region's pixels belong to which of its blobs: to all in whose
        ellipses they lie, else to the nearest one's; of those at its depth, if there are any."""
        if len(blobs) == 1:
            return np.ones((1, len(region.pixels)), np.bool_)
        distance = np.stack([blob.ellipse.distance(region.pixels) for blob in blobs])
        columns, rows = region.pixels.astype(np.intp).T
        depth_m = view.depth_m[rows, columns]
        of_blobs_m = np.array([blob.depth_m for blob in blobs])[:, None]
        is_near = np.abs(depth_m - of_blobs_m) < self.settings.same_depth_m
        is_near |= (depth_m == 0.0) | (of_blobs_m == 0.0)
        distance[~is_near & is_near.any(axis=0)] = np.inf
        belongs = distance <= 1.0
        is_outside = ~belongs.any(axis=0)
        belongs[distance.argmin(axis=0)[is_outside], np.nonzero(is_outside)[0]] = True
        return belongs

    def _see(
        self,
        blob: Blob,
        region: SkinRegion,
        pixels: Pixels,
        overlap: float,
        elapsed_s: float,
        view: ColorView,
    ) -> None:
        settings = self.settings
        predicted = blob.pixels.mean(axis=0, dtype=np.float64)
        moved = pixels.mean(axis=0, dtype=np.float64) - predicted
        if overlap > settings.shared:
            gain = max(1.0 - overlap, settings.least_gain)
            blob.pixels = blob.pixels + (gain * moved).astype(np.float32)
            blob.velocity_px_s *= np.exp(-elapsed_s * overlap / settings.coasting_s)
        else:
            blob.pixels = pixels
            if elapsed_s > 0.0:
                share = elapsed_s / (settings.velocity_s + elapsed_s)
                blob.velocity_px_s = blob.velocity_px_s + share * moved / elapsed_s
            columns, rows = pixels.astype(np.intp).T
            depths = view.depth_m[rows, columns]
            depths = depths[depths > 0.0]
            blob.depth_m = float(np.median(depths)) if len(depths) else region.depth_m
        blob.ellipse = Ellipse.of_pixels(blob.pixels)
        blob.region, blob.overlap = region, overlap
        blob.seen_s = view.frame.timestamp_s

    def _eliminate(self, now_s: float) -> None:
        """Let go what has had no support for long, or none of its own inside an older one."""
        kept: list[Blob] = []
        for blob in self.blobs:  # oldest first
            if now_s - blob.seen_s > min(self.settings.grace_s, blob.seen_s - blob.born_s):
                continue
            is_merged = blob.overlap > self.settings.merged and any(
                other.ellipse.holds(blob.ellipse) for other in kept
            )
            if not is_merged:
                blob.merged_since_s = None
            elif blob.merged_since_s is None:
                blob.merged_since_s = now_s
            elif now_s - blob.merged_since_s > self.settings.merged_s:
                continue
            kept.append(blob)
        self.blobs = kept
