"""A camera as a recording: the newest frame is tracked, older ones are dropped."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Iterator
from time import perf_counter
from typing import Final

import numpy as np

from topview.io.readers.depth import depth_image
from topview.io.readers.rig import Rig
from topview.live.camera import DepthCamera, RawFrame
from topview.live.folder_writer import FolderWriter
from topview.records import Frame, InputError

STOPS_S: Final = 1.0  # ours; so long is waited for the camera's thread
MOST_LATENCIES: Final = 100_000  # ours; an hour at 30 frames a second


class LiveRecording:
    """As `topview.Recording`; it can be iterated once. Frames are numbered as they are tracked, and
    their time is that of the camera since the first of them.

    Args:
        source: the camera, which runs; it is closed at the end.
        writer: where the frames that are given out are recorded, too; those that are tracked, and
            no others.

    Attributes:
        dropped: how many frames came while the one before was tracked, and were left out.
        latencies_s: from the arrival of each of the last frames at this machine until
            `note_written`.
    """

    def __init__(self, source: DepthCamera, writer: FolderWriter | None = None) -> None:
        self.name = source.name
        self.camera = source.camera
        self.problems: list[str] = list(getattr(source, "problems", ()))
        self.dropped = 0
        self.latencies_s: deque[float] = deque(maxlen=MOST_LATENCIES)
        self._source, self._writer = source, writer
        self._rig = Rig(source.camera, source.color, "the camera")
        self._changed = threading.Condition()
        self._newest: tuple[RawFrame, float] | None = None
        self._has_ended = False
        self._failure: Exception | None = None
        self._arrived_s = 0.0

    @property
    def frame_count(self) -> int | None:
        """Nobody knows."""
        return None

    def __iter__(self) -> Iterator[Frame]:
        thread = threading.Thread(target=self._read_all, daemon=True, name="topview-camera")
        thread.start()
        first_s, last_s, index, has_color = None, -np.inf, 0, False
        try:
            while (taken := self._take()) is not None:
                raw, self._arrived_s = taken
                if first_s is None:
                    first_s, has_color = raw.timestamp_s, raw.color is not None
                time_s = raw.timestamp_s - first_s
                if (raw.color is not None) != has_color:  # or colours would be paired otherwise
                    self._note("frames came without colour, or with it all at once; left out")
                    continue
                if time_s <= last_s:
                    self._note("the camera's clock stood still or went back; frames are left out")
                    continue
                frame = self._frame(raw, index, time_s)
                if self._writer is not None:
                    self._writer.append(raw, frame)
                yield frame
                self._confirm()
                last_s, index = time_s, index + 1
        finally:
            self.close()
            thread.join(STOPS_S)
        if self._failure is not None:
            raise self._failure

    def note_written(self) -> None:
        """The skeletons of the frame given out last are written."""
        self.latencies_s.append(perf_counter() - self._arrived_s)
        self._confirm()

    def _confirm(self) -> None:
        if self._writer is not None:
            self._writer.confirm()

    @property
    def told(self) -> str:
        """Latency and dropped frames, a line."""
        if not self.latencies_s:
            return "no frame was tracked"
        median_s, most_s = np.quantile(self.latencies_s, (0.5, 0.95))
        return (
            f"from a frame's arrival to its skeletons on disk: {1e3 * median_s:.0f} ms in the "
            f"median, {1e3 * most_s:.0f} ms at most in 95 %; {self.dropped} frames were dropped"
        )

    def close(self) -> None:
        """Stop the camera."""
        with self._changed:
            self._has_ended = True
            self._changed.notify()
        self._source.close()
        if self._writer is not None:
            self._writer.close()

    def _frame(self, raw: RawFrame, index: int, time_s: float) -> Frame:
        depth_m = self._rig.depth(depth_image(raw.depth, self._source.metres_per_unit))
        color = None
        if raw.color is not None:
            height, width = raw.color.shape[:2]
            if (width, height) != self._rig.color_size:
                right = " x ".join(map(str, self._rig.color_size))
                raise InputError(
                    f"{self.name}: colour has {width} x {height} pixels; it must have {right}"
                )
            color = self._rig.color(raw.color, depth_m)
        return Frame(index, time_s, depth_m, self._rig.pinhole, color, f"{index:06d}.png")

    def _take(self) -> tuple[RawFrame, float] | None:
        """Wait for a frame that is new; None at the end."""
        with self._changed:
            while self._newest is None and not self._has_ended:
                self._changed.wait()
            newest, self._newest = self._newest, None
            return newest

    def _read_all(self) -> None:
        try:
            while not self._has_ended and (raw := self._source.read()) is not None:
                with self._changed:
                    self.dropped += self._newest is not None
                    self._newest = raw, perf_counter()
                    self._changed.notify()
        except Exception as error:
            if not self._has_ended:  # closing it makes some libraries fail here
                self._failure = error if isinstance(error, InputError) else self._gone(error)
        finally:
            with self._changed:
                self._has_ended = True
                self._changed.notify()

    def _gone(self, error: Exception) -> InputError:
        return InputError(f"{self.name}: the camera gives no more frames: {error}")

    def _note(self, problem: str) -> None:
        if problem not in self.problems:
            self.problems.append(problem)
