"""`.jsonl`: one line of JSON for each frame, for programs that read line by line."""

from __future__ import annotations

from os import PathLike
from pathlib import Path
from typing import Any

import msgspec

from topview.io.writers.output import written_atomically
from topview.records import JOINT_STATE_NAMES
from topview.skeletons import Skeletons, SkeletonSequence


def write_skeletons_jsonl(skeletons: Skeletons, path: str | PathLike[str]) -> None:
    """A line for each frame, also where nobody is: its number, time and name, and its people with
    their joints by name. Metres, camera frame; `null` where a number is not known.

    Raises:
        InputError: it cannot be written; the old file, if any, is then unharmed.
    """
    encoder = msgspec.json.Encoder()  # NaN becomes null
    with written_atomically(Path(path)) as file:
        for block in skeletons.blocks():
            for f in range(len(block.frame_index)):
                file.write(encoder.encode(frame_as_json(block, f)) + b"\n")


def frame_as_json(block: SkeletonSequence, f: int) -> dict[str, Any]:
    """What a line says of the frame in row `f`."""
    heights_m = dict(zip(block.people_ids.tolist(), block.heights_m.tolist(), strict=True))
    people = [
        {
            "id": (person_id := int(block.person_ids[f, s])),
            "height_m": heights_m.get(person_id),
            "joints": _joints(block, f, s),
        }
        for s in block.present[f].nonzero()[0].tolist()
    ]
    return {
        "frame_index": int(block.frame_index[f]),
        "timestamp_s": float(block.timestamps_s[f]),
        "frame_name": block.frame_names[f].encode("utf-8", "replace").decode(),
        "people": people,
    }


def _joints(block: SkeletonSequence, f: int, s: int) -> dict[str, Any]:
    return {
        name: {
            "camera_m": block.joints_camera[f, s, j].tolist(),
            "state": JOINT_STATE_NAMES[block.joint_state[f, s, j]],
            "confidence": float(block.joint_confidence[f, s, j]),
        }
        for j, name in enumerate(block.joint_names)
    }
