"""Draw whose each pixel is, and which part of the body: docs/pictures/part_map.png.

python scripts/draw_part_map.py
"""

from __future__ import annotations

from itertools import islice
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from topview.body import PART_NAMES
from topview.records import PartMap
from topview.track import Tracker
from topview.view.palette import GROUND, TEXT, mix, person_color
from topview_lab.bench.tracking import TWO_USERS_SCENE
from topview_lab.sim import SimulatedRecording, scene_by_name

PICTURE = Path(__file__).resolve().parents[1] / "docs" / "pictures" / "part_map.png"
FRAMES = 46  # of the demo's scene; in the last one somebody passes before somebody else
SHADES = 0.0, 0.35, 0.65  # parts that touch have different ones


def main() -> None:
    recording = SimulatedRecording(scene_by_name(TWO_USERS_SCENE, seed=0, frames=FRAMES))
    tracker, color = Tracker(), None
    for frame in islice(recording, FRAMES):
        tracker.update(frame)
        color = frame.color
    part_map = tracker.part_map()
    assert color is not None
    assert part_map is not None
    both = np.hstack([color, painted(part_map)])
    enlarged = cv2.resize(both, None, fx=2, fy=2, interpolation=cv2.INTER_NEAREST)
    cv2.imwrite(str(PICTURE), cv2.cvtColor(enlarged, cv2.COLOR_RGB2BGR))
    print(f"{PICTURE}: {PICTURE.stat().st_size / 1e3:.0f} kB")


def painted(part_map: PartMap) -> NDArray[np.uint8]:
    """[H, W, 3] a colour for each person, a shade for each part; of no part is white."""
    picture = np.full((*part_map.parts.shape, 3), GROUND, np.uint8)
    for person in np.unique(part_map.person_ids[part_map.person_ids > 0]).tolist():
        shades = [mix(person_color(person), GROUND, share) for share in SHADES]
        colors = np.array(
            [TEXT, *(shades[part % len(SHADES)] for part in range(len(PART_NAMES)))], np.uint8
        )
        is_own = part_map.person_ids == person
        picture[is_own] = colors[part_map.parts[is_own]]
    return picture


if __name__ == "__main__":
    main()
