"""`.parquet`: the table of `skeletons.csv` in columns, for data frames."""

from __future__ import annotations

import json
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from topview.io.camera_values import camera_values
from topview.io.writers.extras import needed
from topview.io.writers.output import written_atomically
from topview.records import JOINT_STATE_NAMES
from topview.skeletons import Skeletons, SkeletonSequence


def write_skeletons_parquet(skeletons: Skeletons, path: str | PathLike[str]) -> None:
    """One row for each frame, person who is there, and joint, in the columns of `skeletons.csv`.
    Metres, camera frame; null where a joint is not known. `settings`, `camera` and
    `topview_version` are in the file's metadata, as JSON.

    Raises:
        InputError: pyarrow is not installed, or it cannot be written; the old file, if any, is then
            unharmed.
    """
    pa = needed("pyarrow", "Parquet", "parquet")
    pq = needed("pyarrow.parquet", "Parquet", "parquet")
    with written_atomically(Path(path)) as file:
        writer = None
        for block in skeletons.blocks():
            table = pa.table(_columns(block, pa)).replace_schema_metadata(_about(block))
            if writer is None:
                writer = pq.ParquetWriter(file, table.schema)
            writer.write_table(table)
        if writer is not None:
            writer.close()


def _columns(block: SkeletonSequence, pa: Any) -> dict[str, Any]:
    rows, slots = np.nonzero(block.present)
    J = len(block.joint_names)
    joints = np.tile(np.arange(J, dtype=np.int32), len(rows))
    places = block.joints_camera[rows, slots].reshape(-1, 3)
    states = block.joint_state[rows, slots].ravel()

    def named(indices: Any, names: tuple[str, ...]) -> Any:
        return pa.DictionaryArray.from_arrays(
            indices.astype(np.int32), pa.array(names, pa.string())
        )

    return {
        "frame_index": np.repeat(block.frame_index[rows], J),
        "timestamp_s": np.repeat(block.timestamps_s[rows], J),
        "person_id": np.repeat(block.person_ids[rows, slots], J),
        "joint": named(joints, block.joint_names),
        **{
            f"{axis}_m": pa.array(places[:, k], mask=~np.isfinite(places[:, k]))
            for k, axis in enumerate("xyz")
        },
        "state": named(states, JOINT_STATE_NAMES),
        "confidence": block.joint_confidence[rows, slots].ravel(),
    }


def _about(block: SkeletonSequence) -> dict[str, str]:
    camera = None if block.camera is None else camera_values(block.camera)
    return {
        "settings": json.dumps(block.settings, sort_keys=True),
        "camera": json.dumps(camera, sort_keys=True),
        "topview_version": block.topview_version,
    }
