"""A file of images that tell whose each pixel is, and which part of the body."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Sequence
from pathlib import Path
from tempfile import TemporaryFile
from typing import Any, BinaryIO, Final
from zipfile import ZIP_STORED, ZipFile, ZipInfo

import cv2
import numpy as np
from numpy.typing import NDArray

from topview.files import naming
from topview.records import Frame, InputError, PartMap, Person

PEOPLE_FOLDER, PARTS_FOLDER = "mask", "part"
"""In the file: as the simulator's recordings have them."""
MOST_ID: Final = int(np.iinfo(np.uint16).max)
MAPS_NEED_ROOM: Final = "the part maps wait there until they are whole, and need room"


class PartMaps:
    """A viewer that keeps two PNGs of each frame in a zip: `mask/000000.png`, 16 bits, the id of
    the person; `part/000000.png`, 8 bits, 1 + the index of the part. 0 is nobody, and no part.

    Args:
        folder: where the file waits until it is written; nothing is left there, whatever happens.
        part_map: gives the map of the frame that is shown; None where nothing was tracked.
    """

    def __init__(self, folder: Path, part_map: Callable[[], PartMap | None]) -> None:
        self._folder = folder
        self._part_map = part_map
        self._file = TemporaryFile(dir=folder)  # noqa: SIM115, closed when it is written
        self._zip = ZipFile(self._file, "w", ZIP_STORED)  # PNGs are small already

    @property
    def is_blank(self) -> bool:
        """True while no frame was shown."""
        return not self._zip.filelist

    def show(self, frame: Frame, people: Sequence[Person]) -> None:
        """Keep the next frame's images. Raises InputError where the disk is full."""
        part_map = self._part_map()
        if part_map is None:
            return
        if (last := int(part_map.person_ids.max(initial=0))) > MOST_ID:
            raise InputError(
                f"frame {frame.index} has person {last}; part maps hold up to {MOST_ID}"
            )
        with naming(self._folder, "written to", MAPS_NEED_ROOM):
            for folder, image in (
                (PEOPLE_FOLDER, part_map.person_ids.astype(np.uint16)),
                (PARTS_FOLDER, part_map.parts),
            ):
                # Without a time the bytes depend on the recording alone.
                self._zip.writestr(ZipInfo(f"{folder}/{frame.index:06d}.png"), _png(image))

    def write(self, file: BinaryIO) -> None:
        """End the zip, and copy it to a file."""
        self._zip.close()
        self._file.seek(0)
        shutil.copyfileobj(self._file, file)
        self._file.close()


def _png(image: NDArray[Any]) -> bytes:
    return cv2.imencode(".png", image)[1].tobytes()
