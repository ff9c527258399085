"""`.jsonl`: one line of JSON for each frame, for programs that read line by line."""

from __future__ import annotations

from os import PathLike
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from scipy.spatial.transform import Rotation

from topview.body.hierarchy import NODES, ROOT, nodes_of
from topview.geometry.rotations import are_rotations
from topview.io.writers.joint_frames import are_ours
from topview.io.writers.levelled import joints_and_parts
from topview.io.writers.output import written_atomically
from topview.records import JOINT_STATE_NAMES
from topview.skeletons import Skeletons, SkeletonSequence

Bones = dict[tuple[int, int], dict[str, Any]]


def write_skeletons_jsonl(skeletons: Skeletons, path: str | PathLike[str]) -> None:
    """A line for each frame, also where nobody is: its number, time and name, and its people with
    their joints and bones by name. Metres, camera frame; `null` where a number is not known.

    Raises:
        InputError: it cannot be written; the old file, if any, is then unharmed.
    """
    encoder = msgspec.json.Encoder()  # NaN becomes null
    with written_atomically(Path(path)) as file:
        for block in skeletons.blocks():
            bones = _bones(block)
            for f in range(len(block.frame_index)):
                file.write(encoder.encode(frame_as_json(block, f, bones)) + b"\n")


def frame_as_json(block: SkeletonSequence, f: int, bones: Bones | None = None) -> dict[str, Any]:
    """What a line says of the frame in row `f`; without bones where they are not given."""
    heights_m = dict(zip(block.people_ids.tolist(), block.heights_m.tolist(), strict=True))
    people = [
        {
            "id": (person_id := int(block.person_ids[f, s])),
            "height_m": heights_m.get(person_id),
            "joints": _joints(block, f, s),
        }
        | ({} if bones is None else {"bones": bones.get((f, s))})
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


def _bones(block: SkeletonSequence) -> Bones:
    """By frame and slot: each known node of `topview.body.hierarchy`, with its parent, its place
    and its turn in the parent's frame. None of other systems' joints."""
    if not are_ours(block):
        return {}
    rows, slots = block.present.nonzero()
    offsets_m, Rs = nodes_of(*joints_and_parts(block, rows, slots))
    is_known = np.isfinite(offsets_m).all(-1) & are_rotations(Rs)
    turns = np.zeros((*Rs.shape[:2], 4))
    turns[is_known] = Rotation.from_matrix(Rs[is_known]).as_quat(canonical=True)
    return {
        (row, slot): {
            node.name: {
                "parent": NODES[node.parent].name if n != ROOT else "camera",
                "offset_m": offsets_m[k, n].tolist(),
                "turn_xyzw": turns[k, n].tolist(),
            }
            for n, node in enumerate(NODES)
            if is_known[k, n]
        }
        for k, (row, slot) in enumerate(zip(rows.tolist(), slots.tolist(), strict=True))
    }
