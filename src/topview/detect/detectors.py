"""Detect heads by what the recording has: depth, the colour of skin, frontal faces, or all."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import dist
from typing import Final, Literal

import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray

from topview.detect.beliefs import Kind
from topview.detect.cloud import Cloud
from topview.detect.color_view import stride_of_colors
from topview.detect.faces import CascadeFaces
from topview.detect.faces_and_hands import FacesAndHands, SkinBlob, SkinDetections
from topview.detect.heads import (
    HEAD_RADIUS_M,
    NO_HINTS,
    DepthHeadDetector,
    HeadCandidate,
    Hints,
)
from topview.detect.protocol import HeadDetector
from topview.detect.skin import SkinSettings
from topview.kernels.skin import widen_mask
from topview.records import Frame, InputError
from topview.timing import StageClock

Vector = NDArray[np.float64]
Mask = NDArray[np.bool_]

DetectorName = Literal["auto", "depth", "skin", "cascade"]

# All ours. A face and a head are one if their centres are nearer than this.
FACE_HEAD_M: Final = 2 * HEAD_RADIUS_M
# A face is ambiguous if several heads are expected within this distance.
AMBIGUOUS_FACE_M: Final = 0.5
# A face of full belief removes this share of the doubt that the shape of a head leaves.
FACE_GAIN: Final = 0.5
# A face without a head of that shape is a head from this belief on, with this confidence at most.
SURE_FACE: Final = 0.8
FACE_ALONE: Final = 0.7


class SkinHeads:
    """A `HeadDetector` by faces that have the colour of skin (Sec. 4.1).

    Attributes:
        skin_detections: of the last frame; None before the first.
    """

    def __init__(self, clock: StageClock, skin: SkinSettings | None = None) -> None:
        """`clock` counts the time that colour takes."""
        self._clock = clock
        self._faces_and_hands = FacesAndHands(skin)
        self._cascade = CascadeFaces()
        self.skin_detections: SkinDetections | None = None

    @property
    def needs_color(self) -> bool:
        return True

    @property
    def colors(self) -> SkinHeads:
        return self

    def detect(
        self, cloud: Cloud, up_camera: Vector, hints: Hints = NO_HINTS
    ) -> list[HeadCandidate]:
        """The heads of the faces, most likely first."""
        return [
            HeadCandidate(head, float(face.belief[Kind.FACE]))
            for face, head in self.faces(cloud, hints)
        ]

    def faces(self, cloud: Cloud, hints: Hints) -> list[tuple[SkinBlob, Vector]]:
        """The faces in a frame, most likely first, with the centres of their heads ([3] metres)."""
        may_be = None if hints.is_candidate is None else _as_colors(cloud, hints.is_candidate)
        with self._clock.stage("colours"):
            self.skin_detections = self._faces_and_hands.update(
                cloud.image, hints.heads_camera, may_be
            )
        return [
            (face, head)
            for face in self.skin_detections.most_likely(Kind.FACE)
            if face.is_seen and (head := face.head_camera) is not None
        ]

    def check_faces_in_turn(
        self, frame: Frame, heads_camera: Sequence[Vector]
    ) -> list[tuple[int, bool | None]]:
        """As `CascadeFaces.check_faces_in_turn`."""
        with self._clock.stage("colours"):
            return self._cascade.check_faces_in_turn(frame, heads_camera)

    @property
    def background_is_due(self) -> bool:
        """Whether it is time for `update_background`."""
        return self._faces_and_hands.background_is_due

    def update_background(self, is_person: Mask) -> None:
        """Learn the background from the last frame, where [H, W] is False."""
        with self._clock.stage("colours"):
            self._faces_and_hands.update_background(is_person)


class DepthAndSkinHeads(SkinHeads):
    """A `HeadDetector` by the shape of heads in depth and by faces that have the colour of skin.
    Without usable colour it detects what `DepthHeadDetector` does."""

    def __init__(
        self,
        clock: StageClock,
        skin: SkinSettings | None = None,
        depth: DepthHeadDetector | None = None,
    ) -> None:
        super().__init__(clock, skin)
        self._depth = depth or DepthHeadDetector()

    @property
    def needs_color(self) -> bool:
        return False

    def detect(
        self, cloud: Cloud, up_camera: Vector, hints: Hints = NO_HINTS
    ) -> list[HeadCandidate]:
        """The heads of both; one that both detect has a higher confidence."""
        heads = self._depth.detect(cloud, up_camera)
        centers = [head.center_camera for head in heads]
        known = Hints([*hints.heads_camera, *centers], hints.is_candidate)
        for face, center in self.faces(cloud, known):
            if _is_ambiguous(hints.heads_camera, center):
                continue
            belief = float(face.belief[Kind.FACE])
            near = [
                index
                for index, head in enumerate(heads)
                if dist(head.place, center.tolist()) < FACE_HEAD_M
            ]
            for index in near:
                heads[index] = _confirmed(heads[index], belief)
            if not near and belief > SURE_FACE:
                confidence = FACE_ALONE * belief
                heads.append(HeadCandidate(center, confidence, by_face=confidence))
        return sorted(heads, key=lambda head: (head.torso_is_unread, -head.confidence))


def _is_ambiguous(heads_camera: Sequence[Vector], center_camera: Vector) -> bool:
    """Whether a face is near the heads of several people, so that it may be either's."""
    center = center_camera.tolist()
    return sum(dist(head.tolist(), center) < AMBIGUOUS_FACE_M for head in heads_camera) > 1


def _confirmed(head: HeadCandidate, belief: float) -> HeadCandidate:
    gain = (1.0 - head.confidence) * FACE_GAIN * belief
    return replace(head, confidence=head.confidence + gain, by_face=head.by_face + gain)


# Makes each detector, given the clock that counts its time.
DETECTORS: Final[dict[str, Callable[[StageClock], HeadDetector]]] = {
    "auto": DepthAndSkinHeads,
    "depth": lambda clock: DepthHeadDetector(),
    "skin": lambda clock: SkinHeads(clock, SkinSettings(background="mixtures")),
    "cascade": lambda clock: CascadeFaces(),
}


def head_detector(name: str, clock: StageClock) -> HeadDetector:
    """The detector of this name; "auto" takes the best that a recording allows.

    Raises:
        InputError: there is no such detector.
    """
    if name not in DETECTORS:
        raise InputError(f"detector is {name!r}; it must be one of {', '.join(DETECTORS)}")
    return DETECTORS[name](clock)


def _as_colors(cloud: Cloud, mask: Mask) -> Mask:
    """[h, w] of the view of colours from that of the cloud, dilated by a pixel of the cloud."""
    camera = cloud.frame.camera
    stride = stride_of_colors(camera)
    wider = np.empty((camera.height // stride, camera.width // stride), np.bool_)
    widen_mask(mask, stride, cloud.stride, wider)
    return wider
