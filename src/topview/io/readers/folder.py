"""A folder of images: `depth/000000.png`, optionally `rgb/000000.png` or `.jpg`, `camera.json`."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path, PurePath
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.camera import undistorted_camera, undistortion
from topview.files import naming, read_bytes
from topview.io.readers.camera_json import COLOR_KEYS, read_camera_json
from topview.io.readers.depth import depth_image
from topview.io.readers.frame_names import by_number
from topview.io.readers.images import decode_color, decode_depth_png
from topview.io.readers.registration import register_color
from topview.records import Frame, InputError

DEPTH_SUFFIXES: Final = (".png",)
COLOR_SUFFIXES: Final = (".png", ".jpg", ".jpeg")
MAX_GAP_LINES: Final = 5  # more gaps than this share one line
MAX_COLOR_LINES: Final = 5  # colour files that cannot be read beyond these do so too


def recognises(path: Path) -> bool:
    return path.is_dir()


class FolderRecording:
    """The recording in a folder, or in the folder above if its `depth` folder is given.

    The last number in an image's name is the frame's index; its time is index / fps. Depth is
    uint16 in the unit of camera.json's depth_scale, 0 = no reading. Colour is registered to the
    depth image, in the same size, or camera.json says by "color" what camera took it, and it is
    registered here; frames without (readable) colour come without. Frames are undistorted, and
    named after their depth image.

    Attributes:
        name: the folder's name.
        camera: what took the depth images, with its lens.
        fps: frames per second.
        problems: relative to the folder.

    Raises:
        InputError: no depth images, or camera.json is missing or wrong.
    """

    def __init__(self, path: Path) -> None:
        self._root = _root_of(path)
        self.name = self._root.resolve().name
        self.problems: list[str] = []
        self._bad_color_paths: set[Path] = set()
        self._depth_paths = self._numbered_images("depth", DEPTH_SUFFIXES)
        if not self._depth_paths:
            raise InputError(
                f"{path}: has no depth images; it must hold depth/000000.png, depth/000001.png, "
                "... and camera.json"
            )
        self._color_paths = self._numbered_color()
        camera_file = read_camera_json(self._root / "camera.json")
        self.camera = camera_file.camera
        with naming(self._root / "camera.json"):
            self._look_up = None if self.camera.is_pinhole else undistortion(self.camera)
            self._pinhole = undistorted_camera(self.camera)
        self._metres_per_unit = camera_file.metres_per_unit
        self.fps = camera_file.fps
        self._color_camera = camera_file.color
        self._note_gaps()
        self._note_missing_color()

    @property
    def frame_count(self) -> int:
        """How many depth images there are, the unreadable ones included."""
        return len(self._depth_paths)

    def __iter__(self) -> Iterator[Frame]:
        for index in self._depth_paths:
            if (frame := self.frame(index)) is not None:
                yield frame

    @property
    def indices(self) -> tuple[int, ...]:
        """The frames that there are, in order, the unreadable ones included."""
        return tuple(self._depth_paths)

    def frame(self, index: int) -> Frame | None:
        """One frame by its index; None where there is none or it cannot be read."""
        if index not in self._depth_paths:
            return None
        path = self._depth_paths[index]
        try:
            depth_m = self._read_depth(path)
        except InputError as error:
            self._note(str(error))
            return None
        color = self._read_color(self._color_paths.get(index), depth_m)
        return Frame(index, index / self.fps, depth_m, self._pinhole, color, path.name)

    def _read_depth(self, path: Path) -> NDArray[np.float32]:
        with naming(path.relative_to(self._root)):
            units = decode_depth_png(read_bytes(path), self.camera.width, self.camera.height)
            depth_m = depth_image(units, self._metres_per_unit)
        return depth_m if self._look_up is None else self._look_up.depth(depth_m)

    def _read_color(
        self, path: Path | None, depth_m: NDArray[np.float32]
    ) -> NDArray[np.uint8] | None:
        """[H, W, 3] registered to the undistorted depth image."""
        if path is None:
            return None
        try:
            with naming(path.relative_to(self._root)):
                color = decode_color(read_bytes(path))
        except InputError as error:
            self._note_bad_color(path, f"{error}; the frame comes without colour")
            return None
        height, width = color.shape[:2]
        told = self._color_camera.camera if self._color_camera else self.camera
        if (width, height) != (told.width, told.height):
            self._note(f"rgb/: images are {width} x {height} pixels; {self._right_color_size}")
            return None
        if self._color_camera is not None:
            return register_color(color, self._color_camera, depth_m, self._pinhole)
        return color if self._look_up is None else self._look_up.color(color)

    @property
    def _right_color_size(self) -> str:
        if self._color_camera is not None:
            told = self._color_camera.camera
            return (
                f'they must be {told.width} x {told.height}, as "color" in camera.json says; '
                "going on without colour"
            )
        return (
            f"they must be registered to the depth images, {self.camera.width} x "
            f'{self.camera.height}, or camera.json must have "color": {{{", ".join(COLOR_KEYS)}}}; '
            "going on without colour"
        )

    def _numbered_color(self) -> dict[int, Path]:
        try:
            return self._numbered_images("rgb", COLOR_SUFFIXES)
        except InputError as error:
            self._note(f"{error}; going on without colour")
            return {}

    def _numbered_images(self, folder: str, suffixes: tuple[str, ...]) -> dict[int, Path]:
        """Frame index to image path, in order."""
        directory = self._root / folder
        if not directory.is_dir():
            return {}
        with naming(directory):
            names = [path.name for path in directory.iterdir()]
        images = [
            name
            for name in names
            if PurePath(name).suffix.lower() in suffixes and not name.startswith(".")
        ]
        try:
            numbered, problems = by_number(images)
        except InputError as error:
            raise InputError(f"{directory}/{error}") from None
        for problem in problems:
            self._note(f"{folder}/{problem}")
        return {index: directory / name for index, name in numbered.items()}

    def _note_gaps(self) -> None:
        gaps = [
            (before, after) for before, after in pairwise(self._depth_paths) if after > before + 1
        ]
        if len(gaps) > MAX_GAP_LINES:
            missing = sum(after - before - 1 for before, after in gaps)
            first, last = gaps[0][0], gaps[-1][1]
            self._note(
                f"depth/: {missing} frames are missing in {len(gaps)} gaps between "
                f"{self._depth_paths[first].name} and {self._depth_paths[last].name}"
            )
            return
        for before, after in gaps:
            frames = (
                f"frame {before + 1} is"
                if after == before + 2
                else f"frames {before + 1}-{after - 1} are"
            )
            self._note(
                f"depth/: {frames} missing between "
                f"{self._depth_paths[before].name} and {self._depth_paths[after].name}"
            )

    def _note_missing_color(self) -> None:
        missing = [index for index in self._depth_paths if index not in self._color_paths]
        if self._color_paths and missing:
            self._note(
                f"rgb/: has no image for {len(missing)} of {self.frame_count} frames, the first of "
                f"them frame {missing[0]}; they come without colour"
            )

    def _note_bad_color(self, path: Path, problem: str) -> None:
        if path in self._bad_color_paths:
            return
        self._bad_color_paths.add(path)
        more = len(self._bad_color_paths) - MAX_COLOR_LINES
        if more > 1:
            self.problems.remove(_more_bad_color(more - 1))
        self._note(problem if more < 1 else _more_bad_color(more))

    def _note(self, problem: str) -> None:
        if problem not in self.problems:
            self.problems.append(problem)


def _more_bad_color(count: int) -> str:
    return f"rgb/: {count} more cannot be read; these frames come without colour too"


def _root_of(path: Path) -> Path:
    is_depth_folder = path.resolve().name == "depth" and not (path / "depth").is_dir()
    return path.resolve().parent if is_depth_folder else path
