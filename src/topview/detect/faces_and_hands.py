"""Detect faces and hands by the colour of skin, frame after frame (Sec. 4.1)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import pi
from typing import Final

import msgspec
import numpy as np
from numpy.typing import NDArray

from topview.camera.pyramid import Pyramid
from topview.detect.background import BackgroundMixtures, LightChangeDetector, StillBackground
from topview.detect.beliefs import BeliefTables, Features, Kind
from topview.detect.blobs import USUAL_DEPTH_M, Blob, BlobTracker
from topview.detect.color_view import ColorView, Light, Place
from topview.detect.ellipses import Ellipse
from topview.detect.heads import center_behind
from topview.detect.palms import palm_of
from topview.detect.skin import SkinColor, SkinHistograms, SkinLook, SkinSettings, skin_regions
from topview.kernels.skin import nearest_within, perimeter

Vector = NDArray[np.float64]
Mask = NDArray[np.bool_]

# Ours: a hand that is further from a head is another person's: an arm's length and half the
# shoulders' breadth (Table 3.1, of 1.9 m).
HAND_REACH_M: Final = 1.0
# Ours: the colour of skin is adapted to a blob whose belief in a face or a hand is at least this.
ADAPTING_BELIEF: Final = 0.7
# Ours: from this share of pixels that others claim too, the form of a blob is no evidence.
CONFUSED_OVERLAP: Final = 0.5


class SkinBlob(msgspec.Struct, frozen=True, eq=False):
    """A face, a hand, or something else that has the colour of skin.

    Attributes:
        id: lasts while the blob does, counted from 1.
        belief: [4] of the `Kind`s, sums to one.
        ellipse: in the full image.
        surface_camera: [3] metres, the middle of what is seen of it; None if its depth is not
            known.
        palm_camera: [3] metres on the skin, the palm if it is a hand, maybe with its arm; None if
            its depth is not known.
        major_m, minor_m: true semi-axes, 0 if not known.
        is_seen: skin supports it in this frame, else it is predicted.
        skin_probability: mean P(s|c) of its region.
        features: the evidence of this frame; empty where the belief was not updated.
    """

    id: int
    belief: Vector
    ellipse: Ellipse
    surface_camera: Vector | None
    palm_camera: Vector | None
    major_m: float
    minor_m: float
    is_seen: bool
    skin_probability: float
    features: Features

    @property
    def kind(self) -> Kind:
        """Its most likely kind."""
        return Kind(int(np.argmax(self.belief)))

    @property
    def head_camera(self) -> Vector | None:
        """[3] the centre of the head, if it is a face of known depth."""
        if self.kind != Kind.FACE or self.surface_camera is None:
            return None
        return center_behind(self.surface_camera)


@dataclass(frozen=True, slots=True, eq=False)
class SkinDetections:
    """The skin detections of a frame.

    Attributes:
        light: whether skin can be detected; where it is not usable, there are no blobs.
        blobs: faces, hands and others.
        stride: full pixels per pixel of the masks.
        is_foreground: [h, w] where skin was searched: the candidates without the background, or
            what stands before the background.
        skin_probability: [h, w] P(s|c) in 1/255, 0 outside of the foreground.
        is_skin: [h, w] regions of skin.
        light_changed: whether the background is being learnt in a new light.
    """

    light: Light
    blobs: tuple[SkinBlob, ...] = ()
    stride: int = 1
    is_foreground: Mask | None = None
    skin_probability: NDArray[np.uint8] | None = None
    is_skin: Mask | None = None
    light_changed: bool = False

    def most_likely(self, kind: Kind, least_belief: float = 0.5) -> list[SkinBlob]:
        """The blobs of a kind, most likely first."""
        found = [blob for blob in self.blobs if blob.belief[kind] >= least_belief]
        return sorted(found, key=lambda blob: -float(blob.belief[kind]))


class FacesAndHands:
    """Detects faces and hands in one frame after the other.

    Call `update` with each frame, then `update_background` with the pixels of the people found in
    it. Without the second nothing is ever background, and skin is searched in the whole image. If
    candidates are given, the settings say what is background.
    """

    def __init__(
        self,
        settings: SkinSettings | None = None,
        histograms: SkinHistograms | None = None,
        tables: BeliefTables | None = None,
    ) -> None:
        self.settings = settings or SkinSettings()
        self._mixtures = BackgroundMixtures(by_depth=self.settings.background != "colors")
        self._light = LightChangeDetector()
        self._still = StillBackground()
        self._background: BackgroundMixtures | LightChangeDetector = self._mixtures
        self._skin = SkinColor(histograms)
        self._tables = tables or BeliefTables.load()
        self._tracker = BlobTracker()
        self._beliefs: dict[int, Vector] = {}
        self._features: dict[int, Features] = {}
        self._last_s = 0.0
        self._view: ColorView | None = None

    def update(
        self,
        image: Pyramid,
        heads_camera: Sequence[Vector] = (),
        is_candidate: Mask | None = None,
    ) -> SkinDetections:
        """Detect faces and hands in the next frame.

        Args:
            image: maybe without colour.
            heads_camera: [3] each, centres of known heads (from depth, say); the place relative to
                the nearest one is evidence for face or hand.
            is_candidate: [H, W] of the full image, or of the size of the masks, pixels that may be
                a person's by their depth; all before the background if None.
        """
        self._view = view = ColorView.of(image)
        if view is None or view.light != Light.USABLE:
            return SkinDetections(Light.ABSENT if view is None else view.light)
        where = self._searched(view, is_candidate)
        look = self._skin.look(view, where)
        regions, is_skin = skin_regions(view, look.probability, self.settings)
        blobs = self._tracker.update(view, regions)
        middles = middles_of(view, blobs)
        heads = heads_near(middles, heads_camera)
        self._update_beliefs(view, blobs, middles, heads)
        self._adapt_skin(view, blobs, look)
        return SkinDetections(
            view.light,
            tuple(
                self._described(view, blob, middle, head)
                for blob, middle, head in zip(blobs, middles, heads, strict=True)
            ),
            view.stride,
            where,
            look.probability,
            is_skin,
            self._background.light_changed,
        )

    def _searched(self, view: ColorView, is_candidate: Mask | None) -> Mask:
        """[h, w] where skin is searched."""
        kind = self.settings.background
        if is_candidate is not None and kind == "still":
            self._background = self._light
            return self._still.before(view, view.small(is_candidate))
        self._background, where = self._mixtures, self._mixtures.foreground(view)
        if is_candidate is not None and kind == "mixtures":
            where &= view.small(is_candidate)
        return where

    def update_background(self, is_person: Mask) -> None:
        """Learn the background from the last frame outside the people's pixels ([H, W], or of the
        size of the masks); does nothing unless `background_is_due`."""
        if self._view is not None and self.background_is_due:
            is_person = self._view.small(is_person)
            if self._background is self._light:
                self._still.update(self._view, is_person)
            self._background.update(self._view, is_person)

    @property
    def background_is_due(self) -> bool:
        """Whether `update_background` would learn from the last frame."""
        view = self._view
        return (
            view is not None and view.light == Light.USABLE and self._background.is_update_due(view)
        )

    def _update_beliefs(
        self,
        view: ColorView,
        blobs: Sequence[Blob],
        middles: Vector,
        heads: Sequence[Place | None],
    ) -> None:
        now_s = view.frame.timestamp_s
        elapsed_s, self._last_s = max(now_s - self._last_s, 0.0), now_s
        before = self._beliefs
        self._features = {
            blob.id: features_of(view, blob, middle, head)
            for blob, middle, head in zip(blobs, middles.tolist(), heads, strict=True)
            if blob.id not in before
            or (blob.region is not None and blob.overlap < CONFUSED_OVERLAP)
        }
        asked = [before.get(key) for key in self._features]
        after = self._tables.updated(asked, list(self._features.values()), elapsed_s)
        self._beliefs = {blob.id: before[blob.id] for blob in blobs if blob.id in before}
        self._beliefs.update(zip(self._features, after, strict=True))

    def _adapt_skin(self, view: ColorView, blobs: Sequence[Blob], look: SkinLook) -> None:
        """Adapt the colour of skin to the blobs that are surely a face or a hand (Eq. 4.2)."""
        sure = {
            id(blob.region): blob.region.pixels
            for blob in blobs
            if blob.region is not None
            and 1.0 - self._beliefs[blob.id][Kind.OTHER] >= ADAPTING_BELIEF
        }
        self._skin.adapt(look, sure.values(), view.frame.timestamp_s)

    def _described(
        self, view: ColorView, blob: Blob, middle: Vector, head: Place | None
    ) -> SkinBlob:
        metres_per_px = blob.depth_m / view.camera.fx
        surface = palm = None
        if blob.depth_m > 0.0:
            surface, end = middle, palm_of(view, blob, head)
            palm = middle if end is None else np.array(end)
        return SkinBlob(
            id=blob.id,
            belief=self._beliefs[blob.id],
            ellipse=blob.ellipse.scaled(view.stride, (view.stride - 1) / 2),
            surface_camera=surface,
            palm_camera=palm,
            major_m=blob.ellipse.major * metres_per_px,
            minor_m=blob.ellipse.minor * metres_per_px,
            is_seen=blob.region is not None,
            skin_probability=0.0 if blob.region is None else blob.region.probability,
            features=self._features.get(blob.id, {}),
        )


def middles_of(view: ColorView, blobs: Sequence[Blob]) -> Vector:
    """[N, 3] metres, the middle of what is seen of each blob; zeros where its depth is not
    known."""
    places = [view.point_camera(blob.ellipse.x, blob.ellipse.y, blob.depth_m) for blob in blobs]
    return np.array(places, np.float64).reshape(-1, 3)


def heads_near(middles: Vector, heads_camera: Sequence[Vector]) -> list[Place | None]:
    """For each blob (`middles_of`) the nearest of the heads, [3] each, none where its depth is not
    known or no head is within `HAND_REACH_M`."""
    heads = np.array(heads_camera, np.float64).reshape(-1, 3)
    nearest = nearest_within(middles, heads, HAND_REACH_M).tolist()
    places = [(x, y, z) for x, y, z in heads.tolist()]
    is_known = (middles[:, 2] > 0.0).tolist()
    return [
        places[index] if index >= 0 and is_its else None
        for index, is_its in zip(nearest, is_known, strict=True)
    ]


def features_of(
    view: ColorView, blob: Blob, middle: Sequence[float], head: Place | None
) -> Features:
    """The observation O_t of a blob (Sec. 4.1.4), whose middle is at [3] metres (`middles_of`);
    features from depth where that is known.

    `head` is the nearest one (`heads_near`)."""
    camera, ellipse = view.camera, blob.ellipse
    depth_m = blob.depth_m
    metres_per_px = (depth_m or USUAL_DEPTH_M) / camera.fx
    horizontal_px_s, vertical_px_s = blob.velocity_px_s
    features = {
        "complexity": perimeter(blob.pixels) ** 2 / (4.0 * pi * len(blob.pixels)),
        "horizontal_mps": abs(horizontal_px_s) * metres_per_px,
        "vertical_mps": abs(vertical_px_s) * metres_per_px,
        "orientation_rad": ellipse.angle,
        "image_x": ellipse.x / camera.width,
        "image_y": ellipse.y / camera.height,
    }
    if depth_m > 0.0:
        features["major_m"] = ellipse.major * metres_per_px
        features["minor_m"] = ellipse.minor * metres_per_px
        if head is not None:
            features["right_of_head_m"] = middle[0] - head[0]
            features["below_head_m"] = middle[1] - head[1]
    return features
