"""A depth camera, maybe a colour camera beside it: stored images become those of a frame."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from topview.camera import undistorted_camera, undistortion
from topview.io.readers.camera_json import COLOR_KEYS
from topview.io.readers.registration import ColorCamera, register_color
from topview.records import Camera


class Rig:
    """The cameras of a recording.

    Args:
        camera: of the depth images.
        color_camera: of the colour images, if they are not registered to the depth.
        told_by: what describes the colour camera, for errors.

    Attributes:
        camera: of the depth images, with its lens.
        color_camera: of the colour images; None where they are registered to the depth.
        pinhole: what frames carry: the camera of the undistorted depth images.

    Raises:
        InputError: a lens that no image can be undistorted with.
    """

    def __init__(
        self,
        camera: Camera,
        color_camera: ColorCamera | None = None,
        told_by: str = '"color" in camera.json',
    ) -> None:
        self.camera = camera
        self._told_by = told_by
        self.color_camera = color_camera
        self.pinhole = undistorted_camera(camera)
        self._look_up = None if camera.is_pinhole else undistortion(camera)

    def depth(self, depth_m: NDArray[np.float32]) -> NDArray[np.float32]:
        """[H, W] metres, undistorted."""
        return depth_m if self._look_up is None else self._look_up.depth(depth_m)

    @property
    def color_size(self) -> tuple[int, int]:
        """Width and height that colour images must have."""
        told = self.color_camera.camera if self.color_camera else self.camera
        return told.width, told.height

    @property
    def right_color(self) -> str:
        """What colour images must be, for an error about one of another size."""
        width, height = self.color_size
        if self.color_camera is not None:
            return f"they must be {width} x {height}, as {self._told_by} says"
        return (
            f"they must be registered to the depth images, {width} x {height}, or camera.json "
            f'must have "color": {{{", ".join(COLOR_KEYS)}}}'
        )

    def color(self, color: NDArray[np.uint8], depth_m: NDArray[np.float32]) -> NDArray[np.uint8]:
        """[H, W, 3] registered to an undistorted depth image.

        Args:
            color: of `color_size`.
            depth_m: as `depth` gives it.
        """
        if self.color_camera is not None:
            return register_color(color, self.color_camera, depth_m, self.pinhole)
        return color if self._look_up is None else self._look_up.color(color)
