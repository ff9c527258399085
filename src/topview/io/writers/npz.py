"""`skeletons.npz`: everything that is known about the tracked people."""

from __future__ import annotations

import json
import zipfile
from collections.abc import Callable, Iterator
from os import PathLike
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from topview.files import Archive, naming
from topview.io.camera_values import camera_from, camera_values
from topview.io.writers.earlier import with_ends
from topview.io.writers.joint_frames import bone_lengths_m, joint_frames, parents_of
from topview.io.writers.levelled import T_world_camera
from topview.io.writers.output import written_atomically
from topview.records import JOINT_STATE_NAMES, Camera, InputError
from topview.skeletons import Skeletons, SkeletonSequence, columns_as_slots

# Of the layout that is written. Files without one are version 1; every version is read. In 1 and 2
# everybody has a column of their own, and `person_ids` says who; since 3 there are slots.
FORMAT_VERSION: Final = 3

# Key to stored type; shapes and units are those of `SkeletonSequence`.
OF_FRAMES: Final[dict[str, type[np.number[Any]]]] = {
    "frame_index": np.int64,
    "timestamps_s": np.float64,
    "person_ids": np.int64,
    "joints_camera": np.float64,
    "joint_state": np.uint8,
    "joint_confidence": np.float32,
    "Ts_camera_part": np.float64,
    "joint_covariance_m2": np.float32,
}
OPTIONAL: Final = ("joint_covariance_m2",)  # what older files lack, and is then NaN
OF_PEOPLE: Final[dict[str, type[np.number[Any]]]] = {
    "people_ids": np.int64,
    "heights_m": np.float64,
    "first_frame": np.int64,
    "last_frame": np.int64,
}
OF_ALL: Final[dict[str, type[np.number[Any]]]] = {
    "floor_camera": np.float64,
    "gravity_camera": np.float64,
}
# Of each frame, told by joints and parts, and not read back; in single precision.
OF_JOINT_FRAMES: Final = ("Rs_parent_joint", "offsets_parent_joint_m")
TEXT_KEYS: Final = ("joint_names", "part_names", "joint_state_names", "settings")
SINCE_2: Final = (*OF_ALL, "frame_names", "camera", "topview_version")
SINCE_3: Final = ("people_ids", "first_frame", "last_frame")
IS_SKELETONS: Final = "it must be a skeletons.npz"
BLOCK_FRAMES: Final = 1000  # ours


def write_skeletons_npz(skeletons: Skeletons, path: str | PathLike[str]) -> None:
    """Write `format_version` and all keys, byte for byte the same for equal content; no pickles.
    Frames are gone through in blocks, once for each key.

    `settings` and `camera` are JSON text with sorted keys; a camera is told as in `camera.json`,
    and `null` if it is not known. Members are dated 1980-01-01, as NumPy does it, so that the time
    of writing leaves no trace.

    Raises:
        InputError: it cannot be written; the old file, if any, is then unharmed.
    """
    first = next(skeletons.blocks())
    frames = longest = 0
    for block in skeletons.blocks():
        frames += len(block.frame_index)
        longest = max(longest, *map(len, block.frame_names), 1)
    with (
        written_atomically(Path(path)) as file,
        zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive,
    ):
        for key, dtype in OF_FRAMES.items():
            blocks = (getattr(block, key).astype(dtype) for block in skeletons.blocks())
            _write_member(archive, key, frames, blocks)
        for key in OF_JOINT_FRAMES:
            blocks = (_of_joint_frames(block, key) for block in skeletons.blocks())
            _write_member(archive, key, frames, blocks)
        names = (np.array(block.frame_names, f"<U{longest}") for block in skeletons.blocks())
        _write_member(archive, "frame_names", frames, names)
        about = _about(first) | {"bone_lengths_m": bone_lengths_m(skeletons)}
        for key, array in about.items():
            _write_member(archive, key, None, iter([array]))


def _of_joint_frames(block: SkeletonSequence, key: str) -> NDArray[np.float32]:
    with np.errstate(over="ignore"):  # of files that hold nonsense
        return getattr(joint_frames(block), key).astype(np.float32)


def _write_member(
    archive: zipfile.ZipFile, key: str, frames: int | None, blocks: Iterator[NDArray[Any]]
) -> None:
    """One array, of blocks along its first axis, `frames` long in all; or of one block alone."""
    with archive.open(f"{key}.npy", "w", force_zip64=True) as member:
        for i, block in enumerate(blocks):
            if i == 0:
                shape = block.shape if frames is None else (frames, *block.shape[1:])
                npy.write_array_header_1_0(
                    member,
                    {
                        "descr": npy.dtype_to_descr(block.dtype),
                        "fortran_order": False,
                        "shape": shape,
                    },
                )
            member.write(block.tobytes())


def _about(sequence: SkeletonSequence) -> dict[str, NDArray[Any]]:
    """What belongs to no frame."""
    camera = None if sequence.camera is None else camera_values(sequence.camera)
    return {
        **{key: getattr(sequence, key).astype(d) for key, d in (OF_PEOPLE | OF_ALL).items()},
        "T_world_camera": T_world_camera(sequence),
        "parents": parents_of(sequence),
        "format_version": np.array(FORMAT_VERSION, np.int64),
        "camera": np.array(json.dumps(camera, sort_keys=True)),
        "topview_version": np.array(sequence.topview_version),
        "joint_names": np.array(sequence.joint_names, dtype=np.str_),
        "part_names": np.array(sequence.part_names, dtype=np.str_),
        "joint_state_names": np.array(JOINT_STATE_NAMES),
        "settings": np.array(json.dumps(sequence.settings, sort_keys=True)),
    }


def read_skeletons_npz(path: str | PathLike[str]) -> SkeletonSequence:
    """Read what `write_skeletons_npz` wrote, by this version of topview or an earlier one.

    Raises:
        InputError: missing, truncated, not a file of skeletons, too large to be unpacked as a
            whole, or of a later version.
    """
    path = Path(path)
    with naming(path, right=IS_SKELETONS), Archive(path, IS_SKELETONS) as archive:
        archive.check_total()
        return next(_sequences(archive, None))


class SkeletonFile:
    """A `skeletons.npz` of any length, as `Skeletons`: a block of its frames is in memory at a
    time. Earlier versions, which are dense, are read as a whole.

    Args:
        path: of the file.
    """

    def __init__(self, path: str | PathLike[str]) -> None:
        self.path = Path(path)

    def blocks(self) -> Iterator[SkeletonSequence]:
        """As `Skeletons.blocks`. Raises InputError as `read_skeletons_npz`."""
        right = IS_SKELETONS
        with naming(self.path, right=right), Archive(self.path, right) as archive:
            yield from _sequences(archive, BLOCK_FRAMES)


def _sequences(archive: Archive, block_frames: int | None) -> Iterator[SkeletonSequence]:
    """Blocks of so many frames, or one of all; at least one."""
    version = format_version(archive)
    of_frames = {key: d for key, d in OF_FRAMES.items() if key in archive or key not in OPTIONAL}
    needed = (*of_frames, "heights_m", *TEXT_KEYS)
    needed += SINCE_2 if version >= 2 else ()
    needed += SINCE_3 if version >= 3 else ()
    missing = [key for key in needed if key not in archive]
    if missing:
        raise InputError(f"has no {', '.join(missing)}; {IS_SKELETONS}")
    state_names = tuple(map(str, archive.read("joint_state_names").tolist()))
    if state_names != JOINT_STATE_NAMES:
        raise InputError(
            f"joint_state_names are {', '.join(state_names)}; "
            f"they must be {', '.join(JOINT_STATE_NAMES)}"
        )
    about = _read_about(archive, version)
    if version < 3:
        yield with_ends(SkeletonSequence(**_of_columns(archive, version), **about))
        return
    about |= {key: _read(archive, key, dtype) for key, dtype in OF_PEOPLE.items()}
    keys = (*of_frames, "frame_names")
    frames = archive.shape("frame_index")[0]
    for key in keys:
        if archive.shape(key)[:1] != (frames,):
            raise InputError(f"has {archive.shape(key)[0]} {key}; it must have {frames}")
    for arrays in zip(*(archive.blocks(key, block_frames) for key in keys), strict=True):
        block: dict[str, Any] = dict(zip(keys, arrays, strict=True))
        block |= {key: _converted(key, block[key], dtype) for key, dtype in of_frames.items()}
        block["frame_names"] = tuple(block["frame_names"].tolist())
        yield with_ends(SkeletonSequence(**block, **about))


def _of_columns(archive: Archive, version: int) -> dict[str, Any]:
    """The frames and people of versions 1 and 2, where everybody has a column."""
    numbers: dict[str, Any] = {
        key: _read(archive, key, dtype)
        for key, dtype in (OF_FRAMES | {"heights_m": np.float64}).items()
        if key not in OPTIONAL
    }
    present = np.asarray(np.isfinite(numbers["joints_camera"]).all(-1).any(-1))
    ids, heights_m = numbers["person_ids"], numbers["heights_m"]
    shape = len(numbers["frame_index"]), len(ids)
    if present.shape != shape or heights_m.shape != ids.shape:
        raise InputError(
            f"joints_camera has shape {numbers['joints_camera'].shape}, heights_m "
            f"{heights_m.shape}; there are {shape[0]} frames and {shape[1]} people"
        )
    names = archive.read("frame_names").tolist() if version >= 2 else ()
    slots = columns_as_slots(ids, present, numbers["frame_index"], heights_m)
    return numbers | slots | {"frame_names": tuple(names)}


def _read_about(archive: Archive, version: int) -> dict[str, Any]:
    """What belongs to no frame and nobody."""
    about: dict[str, Any] = {
        "joint_names": tuple(archive.read("joint_names").tolist()),
        "part_names": tuple(archive.read("part_names").tolist()),
        "settings": _json(archive, "settings"),
    }
    if version >= 2:
        about["camera"] = _json(archive, "camera", _camera)
        about["topview_version"] = str(archive.read("topview_version"))
        about |= {key: _read(archive, key, dtype) for key, dtype in OF_ALL.items()}
    return about


def _camera(values: Any) -> Camera | None:
    return None if values is None else camera_from(values)


def _json(archive: Archive, key: str, convert: Callable[[Any], Any] = lambda value: value) -> Any:
    text = str(archive.read(key))
    try:
        return convert(json.loads(text))
    except (ValueError, TypeError, RecursionError) as error:
        raise InputError(f"has a damaged value ({key}: {error}); {IS_SKELETONS}") from None


def _read(archive: Archive, key: str, dtype: type[np.number[Any]]) -> NDArray[Any]:
    return _converted(key, archive.read(key), dtype)


def _converted(key: str, array: NDArray[Any], dtype: type[np.number[Any]]) -> NDArray[Any]:
    if array.dtype.kind not in "fiu":
        raise InputError(f"has a damaged value ({key} is {array.dtype}); {IS_SKELETONS}")
    return array.astype(dtype)


def format_version(archive: Archive) -> int:
    """Of the layout of an archive's arrays.

    Raises:
        InputError: it is later than what this version of topview knows, or no version.
    """
    version = archive.read("format_version") if "format_version" in archive else np.array(1)
    if version.shape != () or version.dtype.kind not in "iu" or version < 1:
        raise InputError(f"format_version is {version}; it must be 1 to {FORMAT_VERSION}")
    if version > FORMAT_VERSION:
        raise InputError(
            f"format_version is {version}, which a later topview wrote; "
            f"this one reads 1 to {FORMAT_VERSION}"
        )
    return int(version)
