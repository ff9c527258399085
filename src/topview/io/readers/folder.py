"""A folder of images: `depth/000000.png`, optionally `rgb/000000.png` or `.jpg`, `camera.json`."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.files import naming, read_bytes
from topview.io.readers.camera_json import CameraFile, read_camera_json
from topview.io.readers.depth import depth_image
from topview.io.readers.float_images import FLOAT_SUFFIXES, decode_depth
from topview.io.readers.frame_names import gaps_between, pauses_between
from topview.io.readers.image_lists import ImageList, list_images
from topview.io.readers.images import decode_color
from topview.io.readers.notes import Notes
from topview.io.readers.pairing import nearest_in_time
from topview.io.readers.rig import Rig
from topview.records import Frame, InputError

DEPTH_SUFFIXES: Final = (".png", *FLOAT_SUFFIXES)
COLOR_SUFFIXES: Final = (".png", ".jpg", ".jpeg")


def recognises(path: Path) -> bool:
    return path.is_dir()


class FolderRecording:
    """The recording in a folder, or in the folder above if its `depth` folder is given.

    The last number in an image's name is the frame's index; its time is index / fps. Where images
    are named by times, or `depth.txt` and `rgb.txt` tell them, frames are in their order, and
    colour belongs to the depth nearest in time. Depth is uint16 in the unit of camera.json's
    depth_scale, or floating point, metres unless that says otherwise; 0 = no reading. Colour is
    registered to the depth image, in the same size, or camera.json says by "color" what camera took
    it, and it is registered here; frames without (readable) colour come without. Frames are
    undistorted, and named after their depth image.

    Args:
        path: of the folder.
        camera_file: what camera.json would say; it is read if None.

    Attributes:
        name: the folder's name.
        camera: what took the depth images, with its lens.
        color_camera: what took the colour images; None where they are registered to the depth.
        fps: frames per second.
        problems: relative to the folder.

    Raises:
        InputError: no depth images, or camera.json is missing or wrong.
    """

    def __init__(self, path: Path, camera_file: CameraFile | None = None) -> None:
        self._root = _root_of(path)
        self.name = self._root.resolve().name
        self._notes = Notes()
        self.problems = self._notes.lines
        depths = list_images(self._root, "depth", DEPTH_SUFFIXES)
        self._depth_paths = depths.paths
        self.problems += depths.problems
        if not self._depth_paths:
            raise InputError(
                f"{path}: has no depth images; it must hold depth/000000.png, depth/000001.png, "
                "... and camera.json"
            )
        colors = self._listed_color()
        is_float = all(p.suffix.lower() in FLOAT_SUFFIXES for p in self._depth_paths.values())
        camera_json = self._root / "camera.json"
        camera_file = camera_file or read_camera_json(camera_json, is_float)
        self.camera = camera_file.camera
        self.color_camera = None if camera_file.color is None else camera_file.color.camera
        with naming(camera_json):
            self._rig = Rig(self.camera, camera_file.color)
        self._metres_per_unit = camera_file.metres_per_unit
        self.fps = camera_file.fps
        self._times_s = _times_of(depths, self.fps)
        self._color_paths = self._color_of(depths, colors)
        self._was_read = False
        self._note_gaps(is_timed=depths.times_s is not None)
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
            self._notes.add_alike("images of depth/ cannot be read", str(error))
            return None
        color = self._read_color(self._color_paths.get(index), depth_m)
        camera = self._rig.pinhole
        try:
            with naming(path.relative_to(self._root)):
                frame = Frame(index, self._times_s[index], depth_m, camera, color, path.name)
        except InputError as error:
            if not self._was_read:
                scale = f"depth_scale is {self._metres_per_unit:g} m per unit"
                raise InputError(f"{self._root / 'camera.json'}: {scale}; {error}") from None
            self._notes.add_alike("images of depth/ cannot be read", str(error))
            return None
        self._was_read = True
        return frame

    def _read_depth(self, path: Path) -> NDArray[np.float32]:
        with naming(path.relative_to(self._root)):
            stored = decode_depth(read_bytes(path), self.camera.width, self.camera.height)
            if stored.dtype == np.uint16 and self._metres_per_unit == 1.0:
                raise InputError(
                    "is 16-bit depth; camera.json must have depth_scale: 0.001 for millimetres"
                )
            return self._rig.depth(depth_image(stored, self._metres_per_unit))

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
            line = f"{error}; the frame comes without colour"
            self._notes.add_alike("frames come without colour", line)
            return None
        height, width = color.shape[:2]
        if (width, height) != self._rig.color_size:
            self._notes.add(
                f"rgb/: images are {width} x {height} pixels; {self._rig.right_color}; "
                "going on without colour"
            )
            return None
        return self._rig.color(color, depth_m)

    def _listed_color(self) -> ImageList:
        try:
            colors = list_images(self._root, "rgb", COLOR_SUFFIXES)
        except InputError as error:
            self._notes.add(f"{error}; going on without colour")
            return ImageList()
        self.problems += colors.problems
        return colors

    def _color_of(self, depths: ImageList, colors: ImageList) -> dict[int, Path]:
        """The colour image of each depth image: with its number, or the nearest in time."""
        if depths.times_s is not None and colors.times_s is not None:
            pairs = nearest_in_time(colors.times_s, depths.times_s)
            return {index: colors.paths[color] for index, color in pairs.items()}
        if colors.paths and (depths.times_s is None) != (colors.times_s is None):
            told = ("numbers", "times") if depths.times_s is None else ("times", "numbers")
            self._notes.add(
                f"rgb/: images have {told[1]}, those of depth/ {told[0]}; both must have the same; "
                "going on without colour"
            )
            return {}
        return colors.paths

    def _note_gaps(self, is_timed: bool) -> None:
        names = {index: path.name for index, path in self._depth_paths.items()}
        lines = (
            pauses_between(list(names.values()), list(self._times_s.values()))
            if is_timed
            else gaps_between(names, self.fps)
        )
        self.problems += [f"depth/: {line}" for line in lines]

    def _note_missing_color(self) -> None:
        missing = [index for index in self._depth_paths if index not in self._color_paths]
        if self._color_paths and missing:
            self._notes.add(
                f"rgb/: has no image for {len(missing)} of {self.frame_count} frames, the first of "
                f"them frame {missing[0]}; they come without colour"
            )


def _times_of(depths: ImageList, fps: float) -> dict[int, float]:
    """Seconds since the first frame, or since frame 0 where only numbers are known."""
    if depths.times_s is None:
        return {index: index / fps for index in depths.paths}
    start_s = depths.times_s[0]
    return {index: time_s - start_s for index, time_s in depths.times_s.items()}


def _root_of(path: Path) -> Path:
    is_depth_folder = path.resolve().name == "depth" and not (path / "depth").is_dir()
    return path.resolve().parent if is_depth_folder else path
