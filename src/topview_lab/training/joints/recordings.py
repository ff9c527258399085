"""Recordings to learn joints from: folders with depth, masks and truth, cached as plain arrays."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import cv2
import numpy as np
from numpy.typing import NDArray

import topview
from topview.camera.undistortion import undistorted
from topview.detect.joints import PROPOSED_JOINTS
from topview.detect.joints.windows import LEAST_WINDOW_PIXELS
from topview.files import naming, read_archive
from topview.io import write_atomically
from topview.records import InputError

# All ours.
WIDEST_IMAGE: Final = 400  # columns; wider ones are thinned, as a window needs no more
DEPTH_UNITS: Final = 1000.0  # of the cache, a metre
LEAST_JOINTS: Final = 8  # with fewer known joints there is nothing to learn

_LAYOUT: Final = 2  # of the cache
_ARRAYS: Final = ("depth_mm", "masks", "joints_camera", "hidden", "is_present", "ids")
_HIDDEN: Final = "joint_occ_inter"
_SIDES: Final = {"_l": "left_", "_r": "right_"}


@dataclass(frozen=True, slots=True, eq=False)
class LabelledRecording:
    """Frames whose people's joints and pixels are known.

    Attributes:
        name: of its folder.
        depth_mm: [F, H, W] uint16, 0 without a reading.
        masks: [F, H, W] uint8, 0 for nobody, k for person k.
        joints_camera: [F, P, 21, 3] float32 metres, `PROPOSED_JOINTS`; NaN where unknown.
        hidden: [F, P, 21] float32 share of each joint that others and things hide, NaN where
            unknown.
        is_present: [F, P].
        ids: [P] of the persons in `masks`.
        intrinsics: fx, fy, cx, cy in pixels.
    """

    name: str
    depth_mm: NDArray[np.uint16]
    masks: NDArray[np.uint8]
    joints_camera: NDArray[np.float32]
    hidden: NDArray[np.float32]
    is_present: NDArray[np.bool_]
    ids: NDArray[np.int64]
    intrinsics: tuple[float, float, float, float]

    def samples(self) -> NDArray[np.int64]:
        """[N, 2] frame and person of everybody of whom something can be seen and learnt."""
        known = np.isfinite(self.joints_camera).all(axis=-1).sum(axis=-1) >= LEAST_JOINTS
        found = []
        for frame, person in np.argwhere(self.is_present & known):
            is_own = (self.masks[frame] == self.ids[person]) & (self.depth_mm[frame] > 0)
            if np.count_nonzero(is_own) >= LEAST_WINDOW_PIXELS:
                found.append((frame, person))
        return np.array(found, np.int64).reshape(-1, 2)


def cached(folder: Path, cache: Path) -> LabelledRecording:
    """The recording in a folder, read through the cache, and anew where its truth was replaced.

    Raises:
        InputError: no depth, no masks, no truth, unknown joints, ids that no mask has.
    """
    with naming(folder / "groundtruth.npz"):
        written_ns = (folder / "groundtruth.npz").stat().st_mtime_ns
    key = hashlib.sha256(f"{_LAYOUT} {folder.resolve()} {written_ns}".encode()).hexdigest()[:8]
    return kept(cache / f"{folder.name}_{key}", lambda: read_labelled(folder))


def kept(place: Path, make: Callable[[], LabelledRecording]) -> LabelledRecording:
    """The recording that is kept at a place; it is made where there is none."""
    if not (place / "complete.json").exists():
        _store(make(), place)
    described = json.loads((place / "complete.json").read_text())
    arrays: dict[str, Any] = {
        name: np.load(place / f"{name}.npy", mmap_mode="r") for name in _ARRAYS
    }
    fx, fy, cx, cy = described["intrinsics"]
    return LabelledRecording(described["name"], **arrays, intrinsics=(fx, fy, cx, cy))


def _store(recording: LabelledRecording, place: Path) -> None:
    with naming(place):
        place.mkdir(parents=True, exist_ok=True)
        for name in _ARRAYS:
            np.save(place / f"{name}.npy", getattr(recording, name))
    described = {"name": recording.name, "intrinsics": recording.intrinsics}
    write_atomically(place / "complete.json", json.dumps(described).encode())


def read_labelled(folder: Path) -> LabelledRecording:
    """Depth, masks and truth of the frames that have all of them.

    Raises:
        InputError: as for `cached`.
    """
    with naming(folder / "groundtruth.npz"):
        truth = read_archive(folder / "groundtruth.npz")
    for key in ("names", "joints", "present"):
        if key not in truth:
            raise InputError(
                f"{folder / 'groundtruth.npz'} has no {key}; joints can be learnt from names, "
                "joints and present (docs/joints.md)"
            )
    joints, hidden = _our_joints(truth, folder)
    count = joints.shape[1]
    ids = np.asarray(truth.get("ids", np.arange(1, count + 1)), np.int64)
    frames, masks, indices, intrinsics = [], [], [], None
    for frame in topview.open(folder):
        frame = undistorted(frame)
        step = -(-frame.depth_m.shape[1] // WIDEST_IMAGE)
        mask = _mask(folder, frame.index, frame.depth_m.shape)
        frames.append(np.round(frame.depth_m[::step, ::step] * DEPTH_UNITS).astype(np.uint16))
        masks.append(mask[::step, ::step])
        indices.append(frame.index)
        camera = frame.camera
        intrinsics = (camera.fx / step, camera.fy / step, camera.cx / step, camera.cy / step)
    if intrinsics is None or max(indices) >= len(joints):
        raise InputError(
            f"{folder}: its truth has {len(joints)} frames; its depth has more or none"
        )
    owners = np.stack(masks)
    present = np.asarray(truth["present"], bool)[indices]
    if not np.isin(ids, owners).any():
        raise InputError(
            f"{folder}: no mask shows any of the ids {', '.join(map(str, ids))}; a pixel's value "
            "in mask/ must be the id of its person"
        )
    return LabelledRecording(
        folder.name,
        np.stack(frames),
        owners,
        joints[indices],
        hidden[indices],
        present,
        ids,
        intrinsics,
    )


def _our_joints(
    truth: dict[str, NDArray[Any]], folder: Path
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """[F, P, 21, 3] places and [F, P, 21] hidden shares, NaN for what the truth does not name."""
    names = [our_joint_name(str(name)) for name in truth["names"]]
    unknown = [name for name in names if name not in PROPOSED_JOINTS]
    if unknown:
        raise InputError(
            f"{folder / 'groundtruth.npz'}: unknown joints {', '.join(unknown)}; they must be "
            f"among {', '.join(PROPOSED_JOINTS)}"
        )
    given = np.asarray(truth["joints"], np.float32)
    if given.ndim != 4 or given.shape[2:] != (len(names), 3):
        raise InputError(
            f"{folder / 'groundtruth.npz'}: joints is {given.shape}; it must be frames x people x "
            f"{len(names)} x 3"
        )
    joints = np.full((*given.shape[:2], len(PROPOSED_JOINTS), 3), np.nan, np.float32)
    hidden = np.full(joints.shape[:3], np.nan, np.float32)
    columns = [PROPOSED_JOINTS.index(name) for name in names]
    joints[:, :, columns] = given
    if _HIDDEN in truth:
        shares = truth[_HIDDEN]
        if shares.shape != given.shape[:3]:
            raise InputError(
                f"{folder / 'groundtruth.npz'}: {_HIDDEN} is {shares.shape}; it must be "
                f"{given.shape[:3]}"
            )
        hidden[:, :, columns] = shares
    return joints, hidden


def our_joint_name(name: str) -> str:
    side = _SIDES.get(name[-2:], "")
    return side + name[:-2] if side else name


def _mask(folder: Path, index: int, shape: tuple[int, int]) -> NDArray[np.uint8]:
    path = folder / "mask" / f"{index:06d}.png"
    mask = cv2.imread(str(path), cv2.IMREAD_UNCHANGED) if path.exists() else None
    if mask is None or mask.shape != shape:
        raise InputError(
            f"{path} is missing or of another size; every depth image needs its mask of "
            f"{shape[1]} x {shape[0]} pixels (docs/joints.md)"
        )
    return mask.astype(np.uint8)


@dataclass(frozen=True, slots=True, eq=False)
class Samples:
    """Everybody in every frame of some recordings.

    Attributes:
        recordings: R of them.
        index: [N, 3] recording, frame and person.
    """

    recordings: tuple[LabelledRecording, ...]
    index: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.index)


def gathered(recordings: Sequence[LabelledRecording]) -> Samples:
    """All samples of these recordings."""
    index = [
        np.insert(recording.samples(), 0, number, axis=1)
        for number, recording in enumerate(recordings)
    ]
    return Samples(tuple(recordings), np.concatenate(index) if index else np.empty((0, 3), int))


def folders_in(sources: Sequence[Path]) -> Iterator[Path]:
    """Each recording with truth: the folders given, or those in them."""
    for source in sources:
        if (source / "groundtruth.npz").exists():
            yield source
        else:
            inside = sorted(path.parent for path in source.glob("*/groundtruth.npz"))
            if not inside:
                raise InputError(
                    f"{source} has no groundtruth.npz, nor has any folder in it; joints are "
                    "learnt from recordings with truth (docs/joints.md)"
                )
            yield from inside
