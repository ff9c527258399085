"""A video of a whole recording with everybody's skeleton over it: MP4 with H.264, by PyAV."""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from fractions import Fraction
from pathlib import Path
from tempfile import TemporaryFile
from typing import Any, BinaryIO, Final

import numpy as np

from topview.files import naming
from topview.records import Frame, InputError, Person
from topview.view.drawing import Image, draw_bone, draw_text
from topview.view.frame_picture import frame_with_skeletons
from topview.view.palette import MUTED, PANEL, TEXT, person_color

# The look of the video: all ours.
LEAST_WIDTH_PX: Final = 640  # narrower images are enlarged
MOST_SIDE_PX: Final = 1280  # larger ones are reduced
CAPTION_PX: Final = 32
TICKS_HZ: Final = 1000  # of the video's clock
NOMINAL_HZ: Final = 30  # what players are told; each frame has its own time
NEEDS_ROOM: Final = "a video waits there until it is whole, and needs room"
# As good as the eye can tell; one thread, so that the bytes do not depend on the machine's cores.
OPTIONS: Final = {"crf": "20", "preset": "veryfast", "threads": "1"}


class OverlayVideo:
    """A viewer that encodes each frame as it is shown, at its own time.

    Args:
        folder: where the video waits until it is written; nothing is left there, whatever happens.

    Raises:
        InputError: PyAV is not installed.
    """

    def __init__(self, folder: Path) -> None:
        try:
            import av
        except ImportError:
            raise InputError(
                "mp4 needs av; install it with: pip install 'topview[video]'"
            ) from None
        self._av: Any = av
        self._folder = folder
        self._file = TemporaryFile(dir=folder)  # noqa: SIM115, closed when it is written
        self._container: Any = None
        self._stream: Any = None
        self._start_s = 0.0
        self._size_px = 0, 0

    @property
    def is_blank(self) -> bool:
        """True while no frame was shown."""
        return self._container is None

    def show(self, frame: Frame, people: Sequence[Person]) -> None:
        """Encode the next frame. Raises InputError where the disk is full."""
        with naming(self._folder, "written to", NEEDS_ROOM):
            if self.is_blank:
                self._begin(frame)
            picture = self._av.VideoFrame.from_ndarray(self._painted(frame, people), format="rgb24")
            picture.pts = round((frame.timestamp_s - self._start_s) * TICKS_HZ)
            picture.time_base = Fraction(1, TICKS_HZ)
            self._container.mux(self._stream.encode(picture))

    def write(self, file: BinaryIO) -> None:
        """End the video, and copy it to a file."""
        if self._container is not None:
            self._container.mux(self._stream.encode())
            self._container.close()
            self._file.seek(0)
            shutil.copyfileobj(self._file, file)
        self._file.close()

    def _begin(self, frame: Frame) -> None:
        self._size_px = size_px(frame.camera.width, frame.camera.height)
        self._start_s = frame.timestamp_s
        self._container = self._av.open(self._file, "w", format="mp4")
        self._stream = self._container.add_stream("libx264", rate=NOMINAL_HZ, options=dict(OPTIONS))
        self._stream.width, self._stream.height = self._size_px[0], self._size_px[1] + CAPTION_PX
        self._stream.pix_fmt = "yuv420p"
        self._stream.codec_context.time_base = Fraction(1, TICKS_HZ)

    def _painted(self, frame: Frame, people: Sequence[Person]) -> Image:
        width, height = self._size_px
        picture = np.full((height + CAPTION_PX, width, 3), PANEL, np.uint8)
        picture[:height] = frame_with_skeletons(frame, people, self._size_px)
        y = float(height + CAPTION_PX - 11)
        x = 12.0 + draw_text(picture, f"frame {frame.index}", (12, y), 10, TEXT)
        draw_text(picture, f"{frame.timestamp_s:.2f} s", (x + 14, y), 10, MUTED)
        x = float(width - 12)
        for side, is_dashed in (("right", True), ("left", False)):
            x -= draw_text(picture, side, (x, y), 10, MUTED, "right") + 40
            ends = np.array([x, y - 5]), np.array([x + 30, y - 5])
            draw_bone(picture, ends, person_color(1), 3, is_dashed)
            x -= 16
        return picture


def size_px(width: int, height: int) -> tuple[int, int]:
    """Width and height of a video of such images: even, as H.264 wants them."""
    scale = max(1.0, LEAST_WIDTH_PX / width)
    scale = min(scale, MOST_SIDE_PX / max(width, height))
    return max(round(width * scale / 2), 1) * 2, max(round(height * scale / 2), 1) * 2
