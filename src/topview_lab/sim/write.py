"""Simulated recordings on disk, in the folder layout that `topview track` reads."""

from __future__ import annotations

import os
import re
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import Any, Final

import cv2
import msgspec
import numpy as np
from numpy.typing import NDArray

from topview.records import InputError
from topview_lab.sim.recording import SimulatedRecording
from topview_lab.sim.scene import Scene
from topview_lab.sim.truth import FrameTruth, GroundTruth, stack_truth

IMAGES: Final = ("depth", "rgb", "mask", "part")
CAMERA_FILE, GROUNDTRUTH_FILE = "camera.json", "groundtruth.npz"


def write_scene(
    scene: Scene,
    folder: Path | str,
    on_frame: Callable[[int], None] | None = None,
    threads: int | None = None,
    force: bool = False,
) -> GroundTruth:
    """Simulate a scene into a folder: `depth/`, `rgb/`, `mask/` (person k), `part/` (1 + index of
    the body part), `camera.json`, `groundtruth.npz`.

    Args:
        scene: what to simulate.
        folder: made where it is missing.
        on_frame: called with each frame's number, in order, after it is written.
        threads: number of frames rendered at a time, one per core if None; the files do not depend
            on it.
        force: replace the recording that is there; its frames are removed first.

    Raises:
        InputError: the folder holds a recording already, or cannot be written to.
    """
    folder = Path(folder)
    check_free(folder, force)
    recording = SimulatedRecording(scene)
    truths = []
    try:
        for old in list(_recording_files(folder)):
            old.unlink()
        for name in IMAGES:
            (folder / name).mkdir(parents=True, exist_ok=True)
        (folder / CAMERA_FILE).write_bytes(
            msgspec.json.format(msgspec.json.encode(_camera_json(scene)), indent=1)
        )
        for index, truth in enumerate(_written_frames(recording, folder, threads)):
            truths.append(truth)
            if on_frame is not None:
                on_frame(index)
        truth = stack_truth(scene, truths)
        np.savez_compressed(folder / GROUNDTRUTH_FILE, **truth.arrays())
    except OSError as error:
        raise InputError(
            f"{error.filename or folder}: {error.strerror or error}; "
            "the folder must be one that can be written to"
        ) from error
    return truth


def check_free(folder: Path, force: bool) -> None:
    """Raises InputError if the folder holds a recording that is not to be replaced, or images that
    no simulation wrote."""
    for name in IMAGES:
        for path in sorted((folder / name).glob("*")):
            if not _is_frame(path):
                raise InputError(f"{path}: is no simulated frame; give --out another folder")
    found = min(_recording_files(folder), default=None)
    if found is not None and not force:
        raise InputError(f"{found}: is there already; --force replaces the recording")


def _recording_files(folder: Path) -> Iterator[Path]:
    """What a recording consists of."""
    for name in IMAGES:
        yield from filter(_is_frame, (folder / name).glob("*"))
    yield from (
        path for name in (CAMERA_FILE, GROUNDTRUTH_FILE) if (path := folder / name).exists()
    )


def _is_frame(path: Path) -> bool:
    return path.is_file() and re.fullmatch(r"[0-9]{6,}\.png", path.name) is not None


def _written_frames(
    recording: SimulatedRecording, folder: Path, threads: int | None
) -> Iterator[FrameTruth]:
    """Simulate and write frames, several at a time; gives their truth in order."""
    threads = threads or os.cpu_count() or 1
    pending: deque[Future[FrameTruth]] = deque()
    with ThreadPoolExecutor(threads) as pool:
        for index in range(recording.frame_count):
            if len(pending) >= 2 * threads:  # no further ahead than that, for memory's sake
                yield pending.popleft().result()
            pending.append(pool.submit(_write_frame, recording, folder, index))
        while pending:
            yield pending.popleft().result()


def _write_frame(recording: SimulatedRecording, folder: Path, index: int) -> FrameTruth:
    frame = recording.simulate(index)
    file = f"{index:06d}.png"
    _write_png(folder / "depth" / file, frame.depth_mm)
    _write_png(folder / "rgb" / file, frame.color[..., ::-1])
    _write_png(folder / "mask" / file, frame.mask)
    _write_png(folder / "part" / file, frame.part)
    return frame.truth


def _camera_json(scene: Scene) -> dict[str, Any]:
    camera = scene.camera
    return {
        "fx": camera.fx,
        "fy": camera.fy,
        "cx": camera.cx,
        "cy": camera.cy,
        "width": camera.width,
        "height": camera.height,
        "depth_scale": 0.001,
        "fps": scene.fps,
    }


def _write_png(path: Path, image: NDArray[Any]) -> None:
    _, encoded = cv2.imencode(".png", np.ascontiguousarray(image))
    path.write_bytes(encoded.tobytes())
