"""Learn tables of the features of faces and hands from recordings with their true places."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.camera import project
from topview.camera.pyramid import Pyramid
from topview.detect.beliefs import BeliefTables, Features, Kind
from topview.detect.faces_and_hands import FacesAndHands, SkinBlob, SkinDetections
from topview.detect.heads import HEAD_RADIUS_M
from topview.detect.skin import SkinHistograms
from topview.files import naming
from topview.io import open_recording
from topview.io.readers.images import decode_color
from topview.records import Camera, Frame, InputError
from topview_lab.datasets.base import check_same_frames
from topview_lab.datasets.folder import GROUNDTRUTH
from topview_lab.datasets.groundtruth import read_groundtruth

Vector = NDArray[np.float64]
Mask = NDArray[np.bool_]

KIND_OF_JOINT: Final[Mapping[str, Kind]] = {
    "head": Kind.FACE,
    "hand_l": Kind.LEFT_HAND,
    "hand_r": Kind.RIGHT_HAND,
}
KIND_OF_OUR_JOINT: Final[Mapping[str, Kind]] = {
    "head": Kind.FACE,
    "left_hand": Kind.LEFT_HAND,
    "right_hand": Kind.RIGHT_HAND,
}
# All ours: a blob is a hand's if the hand projects into, or this near to, its ellipse, at this
# depth or nearer to it; a face's surface lies before the head's centre, which projects well into
# it, but not into the nape of one who is turned away.
NEAR: Final = 1.3
NEAR_FACE: Final = 0.8
DEPTH_M: Final = 0.15
# Ours: standard deviation of a known head's position.
HEAD_ERROR_M: Final = 0.03


@dataclass(frozen=True, slots=True, eq=False)
class LabelledFrame:
    """A frame with the true places of P people's faces and hands.

    Attributes:
        frame: with colour.
        places_camera: [P, 3] of the heads' centres and of the hands, NaN where not present.
        is_somebodys: [H, W] of the full image, if known.
    """

    frame: Frame
    places_camera: Mapping[Kind, Vector]
    is_somebodys: Mask | None


Sequences = Iterable[Iterable[LabelledFrame]]


class LabelledRecording:
    """The frames of a recording folder with colour and a `groundtruth.npz`, and maybe `mask/`.

    Raises:
        InputError: it cannot be read, does not say where heads and hands are, its truth is not of
            the same frames; when it is iterated, it has no colour.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        truth = path / GROUNDTRUTH
        reference = read_groundtruth(truth)
        missing = [name for name in KIND_OF_OUR_JOINT if name not in reference.joint_names]
        if missing:
            raise InputError(f"{truth}: names no {', no '.join(missing)}; it must name them")
        self._recording = open_recording(path)
        with naming(path):
            check_same_frames(self._recording, reference)
        at = np.where(reference.present[..., None, None], reference.joints_camera, np.nan)
        self._places_camera = {
            kind: at[:, :, reference.joint_names.index(name)]
            for name, kind in KIND_OF_OUR_JOINT.items()
        }

    @property
    def problems(self) -> list[str]:
        """What could not be read, one line each."""
        return [f"{self.path}: {problem}" for problem in self._recording.problems]

    def __iter__(self) -> Iterator[LabelledFrame]:
        is_colored = False
        for frame in self._recording:
            if frame.color is None:
                continue
            is_colored = True
            places = {kind: at[frame.index] for kind, at in self._places_camera.items()}
            mask = _mask(self.path / "mask" / f"{frame.index:06d}.png", frame)
            yield LabelledFrame(frame, places, mask)
        if not is_colored:
            raise InputError(f"{self.path}: has no colour images; it must have rgb/000000.png ...")


def _mask(path: Path, frame: Frame) -> Mask | None:
    if not path.is_file():
        return None
    with naming(path):
        is_somebodys: Mask = np.any(decode_color(path.read_bytes()), axis=-1)
        if is_somebodys.shape != frame.depth_m.shape:
            height, width = is_somebodys.shape
            raise InputError(
                f"is {width} x {height} pixels; it must be a mask of {frame.camera.width} x "
                f"{frame.camera.height}"
            )
    return is_somebodys


@dataclass(frozen=True, slots=True, eq=False)
class Observation:
    """An observed skin blob, with its beliefs and its true kind."""

    blob: SkinBlob
    kind: Kind

    @property
    def features(self) -> Features:
        return self.blob.features


def observe(
    frames: Iterable[LabelledFrame],
    histograms: SkinHistograms,
    tables: BeliefTables,
    *,
    know_heads: bool = True,
    seed: int = 0,
) -> Iterator[Observation]:
    """Blobs with their true kinds; ambiguous ones are left out."""
    finder = FacesAndHands(histograms=histograms, tables=tables)
    rng = np.random.default_rng(seed)
    for labelled in frames:
        heads = labelled.places_camera[Kind.FACE]
        heads = heads[np.isfinite(heads).all(axis=1)]
        known = [head + rng.normal(0.0, HEAD_ERROR_M, 3) for head in heads] if know_heads else []
        detections = finder.update(Pyramid(labelled.frame), known)
        if labelled.is_somebodys is not None:
            finder.update_background(labelled.is_somebodys)
        yield from _labelled(detections, labelled)


def _labelled(detections: SkinDetections, labelled: LabelledFrame) -> Iterator[Observation]:
    for blob in detections.blobs:
        if not blob.is_seen or not blob.features:
            continue
        kinds = {
            kind
            for kind, places in labelled.places_camera.items()
            for place in places
            if _is_at(blob, kind, place, labelled.frame.camera)
        }
        if len(kinds) <= 1:
            yield Observation(blob, kinds.pop() if kinds else Kind.OTHER)


def _is_at(blob: SkinBlob, kind: Kind, place_camera: Vector, camera: Camera) -> bool:
    if not np.isfinite(place_camera).all() or place_camera[2] <= 0.1:
        return False
    if blob.surface_camera is not None:
        surface_m = place_camera[2] - (HEAD_RADIUS_M if kind == Kind.FACE else 0.0)
        if abs(blob.surface_camera[2] - surface_m) > DEPTH_M:
            return False
    near = NEAR_FACE if kind == Kind.FACE else NEAR
    return bool(blob.ellipse.distance(project(place_camera[None], camera))[0] < near)


NO_TABLES: Final = BeliefTables.learn((), (), "nothing")


def learn_beliefs(
    sequences: Sequences, histograms: SkinHistograms, trained_on: str
) -> BeliefTables:
    """Tables of P(feature | kind) from labelled recordings (Sec. 4.1.4).

    Raises:
        InputError: no face or no hand is seen in any of them.
    """
    found = [
        observation
        for s, frames in enumerate(sequences)
        for observation in observe(frames, histograms, NO_TABLES, seed=s)
    ]
    unseen = sorted(set(KIND_OF_JOINT.values()) - {observation.kind for observation in found})
    if unseen:
        kinds = ", ".join(kind.name.lower().replace("_", " ") for kind in unseen)
        raise InputError(
            f"{trained_on}: on no spot of skin in them is a {kinds}; "
            "there must be some of each to learn from"
        )
    return BeliefTables.learn(
        [observation.features for observation in found],
        [observation.kind for observation in found],
        trained_on,
    )


@dataclass(frozen=True, slots=True, eq=False)
class BeliefScore:
    """[4, 4] how often a blob of a kind (row) was believed to be one (column)."""

    counts: NDArray[np.int64]

    @property
    def accuracy(self) -> Vector:
        """[4] share of the blobs of each kind that were recognised."""
        return np.diag(self.counts) / np.maximum(self.counts.sum(axis=1), 1)

    @property
    def precision(self) -> Vector:
        """[4] share of the blobs believed to be of each kind that are."""
        return np.diag(self.counts) / np.maximum(self.counts.sum(axis=0), 1)


def score_beliefs(
    sequences: Sequences,
    histograms: SkinHistograms,
    tables: BeliefTables,
    *,
    know_heads: bool = True,
) -> BeliefScore:
    """The confusion of believed and true kinds of blobs."""
    counts = np.zeros((len(Kind), len(Kind)), np.int64)
    for s, frames in enumerate(sequences):
        for seen in observe(frames, histograms, tables, know_heads=know_heads, seed=s):
            counts[seen.kind, seen.blob.kind] += 1
    return BeliefScore(counts)
