"""Heads by what the recording allows: depth, the colour of skin, faces, or all of it together."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Final, Literal

import cv2
import numpy as np
from numpy.typing import NDArray

from topview.detect.beliefs import Kind
from topview.detect.cloud import Cloud
from topview.detect.faces import CascadeFaces
from topview.detect.faces_and_hands import FacesAndHands, Sight, SkinBlob
from topview.detect.heads import (
    HEAD_RADIUS_M,
    NO_HINTS,
    DepthHeadDetector,
    HeadCandidate,
    Hints,
)
from topview.detect.protocol import HeadDetector
from topview.detect.skin import SkinSettings
from topview.records import Frame, InputError
from topview.timing import StageClock

Vector = NDArray[np.float64]
Mask = NDArray[np.bool_]

DetectorName = Literal["auto", "depth", "skin", "cascade"]

# All ours. A face and a head whose centres are this near are one.
SAME_HEAD_M: Final = 2 * HEAD_RADIUS_M
# Of several heads that are expected within this of a face it may be anyone's.
COMPANY_M: Final = 0.5
# How much of what a head's shape leaves in doubt a face of full belief takes away.
FACE_TELLS: Final = 0.5
# From this belief on a face is a head where its shape tells nothing, with this confidence at most.
SURE_FACE: Final = 0.8
FACE_ALONE: Final = 0.7


class SkinHeads:
    """A `HeadDetector` of faces by their colour (Sec. 4.1).

    Attributes:
        sight: what the last frame's colours told; None before the first.
    """

    def __init__(self, clock: StageClock, skin: SkinSettings | None = None) -> None:
        """The time for colours is counted in the `clock`."""
        self._clock = clock
        self._faces_and_hands = FacesAndHands(skin)
        self._cascade = CascadeFaces()
        self.sight: Sight | None = None

    @property
    def needs_color(self) -> bool:
        return True

    @property
    def colors(self) -> SkinHeads:
        return self

    def detect(
        self, cloud: Cloud, up_camera: Vector, hints: Hints = NO_HINTS
    ) -> list[HeadCandidate]:
        """Heads of faces, most likely first."""
        return [
            HeadCandidate(head, float(face.belief[Kind.FACE]))
            for face, head in self.faces(cloud, hints)
        ]

    def faces(self, cloud: Cloud, hints: Hints) -> list[tuple[SkinBlob, Vector]]:
        """Faces that are seen, most likely first, with the centres of their heads."""
        may_be = None if hints.is_candidate is None else _full_size(cloud, hints.is_candidate)
        with self._clock.stage("colours"):
            self.sight = self._faces_and_hands.update(cloud.image, hints.heads_camera, may_be)
        return [
            (face, head)
            for face in self.sight.most_likely(Kind.FACE)
            if face.is_seen and (head := face.head_camera) is not None
        ]

    def look_round(
        self, frame: Frame, heads_camera: Sequence[Vector]
    ) -> list[tuple[int, bool | None]]:
        """As `CascadeFaces.look_round`."""
        with self._clock.stage("colours"):
            return self._cascade.look_round(frame, heads_camera)

    @property
    def learns_room(self) -> bool:
        """Whether it is time for `learn_room`."""
        return self._faces_and_hands.learns_room

    def learn_room(self, is_somebodys: Mask) -> None:
        """Learn what the room's colours are, from the frame that was looked at last."""
        with self._clock.stage("colours"):
            self._faces_and_hands.learn_room(is_somebodys)


class DepthAndSkinHeads(SkinHeads):
    """A `HeadDetector` of heads by their shape and of faces by their colour, each where the other
    fails; without usable colour it finds what `DepthHeadDetector` does."""

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
        """Heads of both kinds; one that both see is surer."""
        heads = self._depth.detect(cloud, up_camera)
        centers = [head.center_camera for head in heads]
        known = Hints([*hints.heads_camera, *centers], hints.is_candidate)
        for face, center in self.faces(cloud, known):
            if _is_among(hints.heads_camera, center):
                continue
            belief = float(face.belief[Kind.FACE])
            near = [
                index
                for index, head in enumerate(heads)
                if np.linalg.norm(head.center_camera - center) < SAME_HEAD_M
            ]
            for index in near:
                heads[index] = _confirmed(heads[index], belief)
            if not near and belief > SURE_FACE:
                confidence = FACE_ALONE * belief
                heads.append(HeadCandidate(center, confidence, by_face=confidence))
        return sorted(heads, key=lambda head: (head.torso_is_unread, -head.confidence))


def _is_among(heads_camera: Sequence[Vector], center_camera: Vector) -> bool:
    """Whether a face is near to the heads of several people: it may be either's, or both's."""
    offsets = [head - center_camera for head in heads_camera]
    return sum(bool(np.linalg.norm(offset) < COMPANY_M) for offset in offsets) > 1


def _confirmed(head: HeadCandidate, belief: float) -> HeadCandidate:
    gain = (1.0 - head.confidence) * FACE_TELLS * belief
    return replace(head, confidence=head.confidence + gain, by_face=head.by_face + gain)


# How each detector is made, given the clock that counts its time.
DETECTORS: Final[dict[str, Callable[[StageClock], HeadDetector]]] = {
    "auto": DepthAndSkinHeads,
    "depth": lambda clock: DepthHeadDetector(),
    "skin": SkinHeads,
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


def _full_size(cloud: Cloud, mask: Mask) -> Mask:
    """[H, W] of the frame from [h, w] of the cloud, a little wider."""
    camera = cloud.frame.camera
    wider = cv2.dilate(mask.view(np.uint8), np.ones((3, 3), np.uint8))
    size = (mask.shape[1] * cloud.stride, mask.shape[0] * cloud.stride)
    large = cv2.resize(wider, size, interpolation=cv2.INTER_NEAREST)
    return np.asarray(large[: camera.height, : camera.width]).view(np.bool_)
