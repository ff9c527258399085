"""Track skin regions over time as ellipses (Sec. 4.1.3).

A. Argyros and M. Lourakis, Real-time tracking of multiple skin-colored objects with a possibly
moving camera (ECCV 2004); predictions by H. Baltzakis and A. Argyros, Propagation of pixel
hypotheses for multiple objects tracking (ISVC 2009): a blob's pixels are propagated with it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import exp
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from topview.detect.color_view import ColorView
from topview.detect.ellipses import Ellipse, Moments
from topview.detect.skin import SkinRegion
from topview.kernels.skin import move_onto, paint, share_pixels, shift_pixels

Pixels = NDArray[np.float32]


# All ours.
# Seconds that a blob coasts without support; at most as long as it was supported.
GRACE_S: Final = 0.4
# Standard deviation of a blob's speed from the predicted one, metres a second; and the greatest
# standard deviation of its predicted place, metres.
SPREAD_MPS: Final = 0.75
GREATEST_SPREAD_M: Final = 0.06
# Metres, of a blob whose depth is not known.
USUAL_DEPTH_M: Final = 2.5
# Seconds over which a velocity is averaged, and in which the velocity of a coasting blob decays.
BLOB_VELOCITY_S: Final = 0.06
COASTING_S: Final = 0.4
# Metres: a pixel goes to blobs whose depth differs from its own by less than this, if any.
SAME_DEPTH_M: Final = 0.10
# If others claim more than this share of a blob's pixels, it keeps its form and follows them with a
# gain that falls with the overlap, to this one at least.
SHARED_OVERLAP: Final = 0.2
LEAST_GAIN: Final = 0.2
# If others claim more than this share of a blob's pixels, and it lies inside an older one, it is
# pruned after so many seconds.
MERGED_OVERLAP: Final = 0.8
MERGED_S: Final = 1.0


@dataclass(slots=True, eq=False)
class Blob:
    """One skin-coloured object: an ellipse hypothesis and the pixels that carry it.

    Attributes:
        id: lasts while it lives, counted from 1.
        pixels: [N, 2] (x, y) in the small image.
        moments: of them.
        ellipse: of these.
        velocity_px_s: along x and y.
        depth_m: median of its pixels' readings, 0 if not known.
        born_s, seen_s: when it was first and last supported.
        region: supports it in this frame; None while it coasts.
        overlap: share of its pixels that other blobs claim too.
        merged_since_s: since when it has been merged with an older one; None if it is not.
    """

    id: int
    pixels: Pixels
    moments: Moments
    ellipse: Ellipse
    depth_m: float
    born_s: float
    seen_s: float
    region: SkinRegion | None
    velocity_px_s: tuple[float, float] = (0.0, 0.0)
    overlap: float = 0.0
    merged_since_s: float | None = None

    def move_onto(
        self, elapsed_s: float, spread_px: float, label_of: NDArray[np.int32], labels: int
    ) -> int:
        """Propagate its pixels; the ellipse grows by the uncertainty of their places. Gives the
        label, up to `labels`, in [h, w] on which most of them land, 0 where none does."""
        vx, vy = self.velocity_px_s
        dx, dy = vx * elapsed_s, vy * elapsed_s
        self.moments = self.moments.moved(dx, dy)
        self.ellipse = Ellipse.of_moments(self.moments, spread_px)
        return move_onto(self.pixels, dx, dy, label_of, labels)

    def shift(self, dx: float, dy: float) -> None:
        """Move its pixels, in place."""
        shift_pixels(self.pixels, dx, dy)
        self.moments = self.moments.moved(dx, dy)

    def slow_down(self, kept: float) -> None:
        """Keep a share of its velocity."""
        vx, vy = self.velocity_px_s
        self.velocity_px_s = kept * vx, kept * vy


class Seen(NamedTuple):
    """What a frame shows of a blob.

    Attributes:
        region: supports it.
        pixels: [N, 2] (x, y), those of the region's that are its own.
        moments: of them.
        depth_m: median of their readings, 0 if not known.
        overlap: share of them that other blobs claim too.
    """

    region: SkinRegion
    pixels: Pixels
    moments: Moments
    depth_m: float
    overlap: float


class BlobTracker:
    """Tracks blobs from frame to frame."""

    def __init__(self) -> None:
        self.blobs: list[Blob] = []
        self._next_id = 1
        self._last_s: float | None = None

    def update(self, view: ColorView, regions: Sequence[SkinRegion]) -> list[Blob]:
        """The blobs in the next frame; those whose `seen_s` is earlier are predicted."""
        now_s = view.frame.timestamp_s
        elapsed_s = 0.0 if self._last_s is None else max(now_s - self._last_s, 0.0)
        self._last_s = now_s
        supports = self._supports(view, regions, elapsed_s)
        for r, blobs in supports.items():
            self._assign(view, regions[r], blobs, elapsed_s)
        for blob in self.blobs:
            if blob.region is None:
                blob.slow_down(exp(-elapsed_s / COASTING_S))
                blob.ellipse = Ellipse.of_moments(blob.moments)
        self._prune(now_s)
        for r, region in enumerate(regions):
            if r not in supports and not any(
                blob.ellipse.is_near(region.box) and blob.ellipse.count(region.pixels)
                for blob in self.blobs
            ):  # Eq. 4.5
                self.blobs.append(self._new(region, now_s))
        return self.blobs

    def _new(self, region: SkinRegion, now_s: float) -> Blob:
        blob = Blob(
            id=self._next_id,
            pixels=region.pixels,
            moments=region.moments,
            ellipse=Ellipse.of_moments(region.moments),
            depth_m=region.depth_m,
            born_s=now_s,
            seen_s=now_s,
            region=region,
        )
        self._next_id += 1
        return blob

    def _supports(
        self, view: ColorView, regions: Sequence[SkinRegion], elapsed_s: float
    ) -> dict[int, list[Blob]]:
        """Propagate the blobs; gives those that each region supports, by the region's index.

        A blob keeps the region on which most of its propagated pixels land, or takes the one with
        which its ellipse shares most pixels.
        """
        label_of = np.zeros(view.depth_m.shape, np.int32)
        for r, region in enumerate(regions):
            paint(region.pixels, r + 1, label_of)
        supports: dict[int, list[Blob]] = {}
        for blob in self.blobs:
            focal_px = view.camera.fx / (blob.depth_m or USUAL_DEPTH_M)
            unseen_s = max(view.frame.timestamp_s - blob.seen_s, 0.0)
            spread_m = min(SPREAD_MPS * unseen_s, GREATEST_SPREAD_M)
            blob.region = None
            label = blob.move_onto(elapsed_s, spread_m * focal_px, label_of, len(regions))
            label = label or blob.ellipse.label_inside(label_of, len(regions))
            if label:
                supports.setdefault(label - 1, []).append(blob)
        return supports

    def _assign(
        self, view: ColorView, region: SkinRegion, blobs: list[Blob], elapsed_s: float
    ) -> None:
        """Assign a region's pixels to its blobs and update each with its own."""
        if len(blobs) == 1:
            seen = Seen(region, region.pixels, region.moments, region.depth_m, 0.0)
            _update_blob(blobs[0], seen, elapsed_s, view.frame.timestamp_s)
            return
        # To all in whose ellipses they lie, or to the nearest; among the blobs at their depth, if
        # there are any.
        pixels, starts, values = share_pixels(
            region.pixels,
            view.depth_m,
            np.array([blob.ellipse.parameters for blob in blobs]),
            np.array([blob.depth_m for blob in blobs]),
            SAME_DEPTH_M,
        )
        ends = starts.tolist()
        for blob, start, end, (overlap, median_m, *moments) in zip(
            blobs, ends[:-1], ends[1:], values.tolist(), strict=True
        ):
            if start < end:
                depth_m = median_m or region.depth_m
                seen = Seen(region, pixels[start:end], Moments(*moments), depth_m, overlap)
                _update_blob(blob, seen, elapsed_s, view.frame.timestamp_s)

    def _prune(self, now_s: float) -> None:
        """Remove blobs that have coasted, or been merged with an older one, for too long."""
        kept: list[Blob] = []
        for blob in self.blobs:  # oldest first
            if now_s - blob.seen_s > min(GRACE_S, blob.seen_s - blob.born_s):
                continue
            is_merged = blob.overlap > MERGED_OVERLAP and any(
                other.ellipse.contains_center_of(blob.ellipse) for other in kept
            )
            if not is_merged:
                blob.merged_since_s = None
            elif blob.merged_since_s is None:
                blob.merged_since_s = now_s
            elif now_s - blob.merged_since_s > MERGED_S:
                continue
            kept.append(blob)
        self.blobs = kept


def _update_blob(blob: Blob, seen: Seen, elapsed_s: float, now_s: float) -> None:
    moved = seen.moments.x - blob.moments.x, seen.moments.y - blob.moments.y
    if seen.overlap > SHARED_OVERLAP:
        gain = max(1.0 - seen.overlap, LEAST_GAIN)
        blob.shift(gain * moved[0], gain * moved[1])
        blob.slow_down(exp(-elapsed_s * seen.overlap / COASTING_S))
    else:
        blob.pixels, blob.moments, blob.depth_m = seen.pixels, seen.moments, seen.depth_m
        if elapsed_s > 0.0:
            rate = elapsed_s / (BLOB_VELOCITY_S + elapsed_s) / elapsed_s
            vx, vy = blob.velocity_px_s
            blob.velocity_px_s = vx + moved[0] * rate, vy + moved[1] * rate
    blob.ellipse = Ellipse.of_moments(blob.moments)
    blob.region, blob.overlap, blob.seen_s = seen.region, seen.overlap, now_s
