"""Cache of the automatic part's result, kept beside the project file."""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import fields
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from topview.files import read_archive
from topview.io import write_atomically
from topview.records import InputError
from topview_lab.annotate.automatic import FoundMarkers
from topview_lab.annotate.blobs import Blobs, MarkerAppearance
from topview_lab.annotate.cameras import Extrinsics
from topview_lab.annotate.starting import NamedPerson
from topview_lab.annotate.tracks import Tracks

FOUND_FILE: Final = "annotation-found.npz"
VERSION: Final = 1


def save_found(found: FoundMarkers, looks: Sequence[MarkerAppearance], path: Path) -> None:
    arrays: dict[str, Any] = {
        "version": VERSION,
        "looks": _looks(looks),
        "rear_frames": found.rear_frames,
        "start_frame": found.start_frame,
        "offset_frames": found.offset_frames,
        "T_front_rear": found.extrinsics.T_front_rear,
        "residual_m": found.extrinsics.residual_m,
        "pairs": found.extrinsics.pairs,
        "start_spots": np.stack([start.spots for start in found.starts]),
        "start_markers": np.stack([start.markers_camera for start in found.starts]),
        "start_sizes": np.array([(start.stature_m, start.cost_m) for start in found.starts]),
        **{f"tracks_{f.name}": getattr(found.tracks, f.name) for f in fields(Tracks)},
    }
    for view, blobs in enumerate(found.blobs):
        arrays[f"counts_{view}"] = np.array([len(b) for b in blobs])
        for f in fields(Blobs):
            arrays[f"{f.name}_{view}"] = np.concatenate([getattr(b, f.name) for b in blobs])
    buffer = io.BytesIO()
    np.savez_compressed(buffer, **arrays)
    write_atomically(path, buffer.getvalue())


def load_found(path: Path, looks: Sequence[MarkerAppearance], frames: int) -> FoundMarkers | None:
    """The cached result; None if it is missing, or of other colours, recordings or another
    version."""
    try:
        data = read_archive(path)
        if int(data["version"]) != VERSION or not np.array_equal(data["looks"], _looks(looks)):
            return None
        if len(data["rear_frames"]) != frames:
            return None
        return _found(data)
    except (InputError, OSError, ValueError, KeyError):
        return None


def _found(data: dict[str, NDArray[Any]]) -> FoundMarkers:
    blobs = [
        [
            Blobs(pixels, points, radii)
            for pixels, points, radii in zip(
                *(
                    np.split(data[f"{f.name}_{view}"], np.cumsum(data[f"counts_{view}"])[:-1])
                    for f in fields(Blobs)
                ),
                strict=True,
            )
        ]
        for view in range(2)
    ]
    starts = [
        NamedPerson(spots, markers, float(stature_m), float(cost_m))
        for spots, markers, (stature_m, cost_m) in zip(
            data["start_spots"], data["start_markers"], data["start_sizes"], strict=True
        )
    ]
    return FoundMarkers(
        blobs=(blobs[0], blobs[1]),
        rear_frames=data["rear_frames"],
        start_frame=int(data["start_frame"]),
        starts=starts,
        offset_frames=int(data["offset_frames"]),
        extrinsics=Extrinsics(data["T_front_rear"], float(data["residual_m"]), int(data["pairs"])),
        tracks=Tracks(**{f.name: data[f"tracks_{f.name}"] for f in fields(Tracks)}),
    )


def _looks(looks: Sequence[MarkerAppearance]) -> NDArray[np.float64]:
    return np.array([(*look.rgb, look.radius_m) for look in looks]).reshape(-1, 4)
