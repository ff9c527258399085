"""TUM RGB-D: a sequence as it is published, with `depth.txt`, `rgb.txt` and no `camera.json`.

J. Sturm, N. Engelhard, F. Endres, W. Burgard and D. Cremers, "A benchmark for the evaluation of
RGB-D SLAM systems", IROS 2012; https://cvg.cit.tum.de/data/datasets/rgbd-dataset/file_formats says
the unit of depth, that depth is registered to the colour, and the camera to assume, of which the
calibrated ones of single sequences differ by up to 4 %.
"""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from typing import Final

from topview.files import naming, read_bytes
from topview.io.readers.camera_json import DEFAULT_FPS, CameraFile, metres_per_unit
from topview.io.readers.folder import DEPTH_SUFFIXES, FolderRecording
from topview.io.readers.image_lists import list_images
from topview.io.readers.images import check_png
from topview.records import Camera, InputError

TUM_CAMERA: Final = Camera(fx=525.0, fy=525.0, cx=319.5, cy=239.5, width=640, height=480)
TUM_UNITS_PER_M: Final = 5000.0


def recognises(path: Path) -> bool:
    is_listed = (path / "depth.txt").is_file() and (path / "depth").is_dir()
    return is_listed and not (path / "camera.json").exists()


class TumRecording(FolderRecording):
    """A sequence of the benchmark, taken by its default camera.

    Raises:
        InputError: no depth images, or none of the benchmark's size.
    """

    def __init__(self, path: Path) -> None:
        _check_size(path)
        scale = metres_per_unit(TUM_UNITS_PER_M)
        super().__init__(path, CameraFile(TUM_CAMERA, scale, DEFAULT_FPS))
        camera = ", ".join(
            f"{key} {getattr(TUM_CAMERA, key):g}" for key in ("fx", "fy", "cx", "cy")
        )
        self.problems.append(
            f"camera.json is missing; taken for TUM RGB-D's default camera: {camera}, "
            f"depth_scale {TUM_UNITS_PER_M:g}"
        )


def _check_size(path: Path) -> None:
    """Raises InputError where the first depth image is of another size than the benchmark's."""
    for image in list_images(path, "depth", DEPTH_SUFFIXES).paths.values():
        with suppress(InputError), naming(image):
            header = check_png(read_bytes(image))
            break
    else:
        return
    if (header.width, header.height) != (TUM_CAMERA.width, TUM_CAMERA.height):
        raise InputError(
            f"{path}: has no camera.json, and its depth images are {header.width} x "
            f"{header.height}, not TUM RGB-D's {TUM_CAMERA.width} x {TUM_CAMERA.height}; it must "
            "have camera.json"
        )
