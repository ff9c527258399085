"""Draw what `topview demo` tracks as a picture that moves: docs/pictures/demo.webp.

python scripts/draw_demo.py
"""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

import cv2
import numpy as np

from topview.io import open_recording
from topview.track import Tracker
from topview.view.contact_sheet import Moment, paint_tile, stage_of
from topview_lab.bench.tracking import TWO_USERS_SCENE
from topview_lab.sim import scene_by_name, write_scene

PICTURE = Path(__file__).resolve().parents[1] / "docs" / "pictures" / "demo.webp"
FRAMES = 120  # as `topview demo`
EVERY = 3  # frames; ten pictures a second
PANEL_PX = 320, 240
QUALITY = 55


def main() -> None:
    with TemporaryDirectory() as folder:
        room = Path(folder) / TWO_USERS_SCENE
        write_scene(scene_by_name(TWO_USERS_SCENE, seed=0, frames=FRAMES), room)
        recording, tracker = open_recording(room), Tracker()
        moments = [Moment(frame, tuple(tracker.update(frame)), frame.index) for frame in recording][
            ::EVERY
        ]
    stage = stage_of(moments)
    tiles = [paint_tile(moment, stage, PANEL_PX) for moment in moments]
    moving = cv2.Animation()
    moving.frames = [cv2.cvtColor(tile, cv2.COLOR_RGB2BGR) for tile in tiles]
    moving.durations = np.full(len(tiles), round(1000 * EVERY / 30), np.int32)
    cv2.imwriteanimation(str(PICTURE), moving, [cv2.IMWRITE_WEBP_QUALITY, QUALITY])
    print(f"{PICTURE}: {len(tiles)} pictures, {PICTURE.stat().st_size / 1e3:.0f} kB")


if __name__ == "__main__":
    main()
