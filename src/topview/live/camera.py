"""What a live camera is: a few lines over the maker's library."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from topview.io.readers.registration import ColorCamera
from topview.records import Camera


@dataclass(frozen=True, slots=True, eq=False)
class RawFrame:
    """What a camera gives.

    Attributes:
        timestamp_s: by the camera's own clock, from whatever beginning.
        depth: [H, W] uint16 in the camera's unit, 0 where there is no reading.
        color: [H, W, 3] uint8 RGB of the colour camera, or None.
    """

    timestamp_s: float
    depth: NDArray[np.uint16]
    color: NDArray[np.uint8] | None = None


class DepthCamera(Protocol):
    """A camera that runs. It may have `problems`, too: lines about what it leaves aside."""

    @property
    def name(self) -> str:
        """Of it, for people."""
        ...

    @property
    def camera(self) -> Camera:
        """Of the depth images, with its lens and kind of noise."""
        ...

    @property
    def color(self) -> ColorCamera | None:
        """The camera of the colour images; None where they are registered to the depth, or there
        are none."""
        ...

    @property
    def metres_per_unit(self) -> float:
        """Of the depth."""
        ...

    @property
    def fps(self) -> float:
        """Frames per second that it should give."""
        ...

    def read(self) -> RawFrame | None:
        """Wait for the next frame; its arrays are no longer the library's. None once the camera
        gives no more.

        Raises:
            InputError: the camera is gone.
        """
        ...

    def close(self) -> Any:
        """Stop it; `read` in another thread then ends soon."""
        ...
