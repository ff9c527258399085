"""Recordings with truth for tests of what learns joints: discs at the joints of people."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from topview.detect.joints import PROPOSED_JOINTS
from topview_lab.training.joints.recordings import LabelledRecording

INTRINSICS = (285.0, 285.0, 160.0, 120.0)
SIZE = 240, 320
DISC_PIXELS = 5


def discs(frames: int = 3, people: int = 2, seed: int = 0) -> LabelledRecording:
    """Each joint is a disc that faces the camera, alone in its part of the image."""
    rng = np.random.default_rng(seed)
    fx, fy, cx, cy = INTRINSICS
    depth_mm = np.zeros((frames, *SIZE), np.uint16)
    masks = np.zeros((frames, *SIZE), np.uint8)
    joints = np.zeros((frames, people, len(PROPOSED_JOINTS), 3), np.float32)
    for frame in range(frames):
        for person in range(people):
            left = 30 + 160 * person
            cells = rng.permutation(24)[: len(PROPOSED_JOINTS)]
            columns = left + 30 * (cells % 4) + rng.uniform(-4, 4, len(cells))
            rows = 40 + 30 * (cells // 4) + rng.uniform(-4, 4, len(cells))
            z = 3.0 + 0.3 * person + rng.uniform(-0.3, 0.3, len(cells))
            joints[frame, person] = np.stack([(columns - cx) * z / fx, (rows - cy) * z / fy, z], 1)
            for column, row, z_m in zip(columns, rows, z, strict=True):
                place = round(column), round(row)
                disc = np.zeros(SIZE, np.uint8)
                cv2.circle(disc, place, DISC_PIXELS, 1, -1)
                depth_mm[frame][disc > 0] = round(1000 * z_m)
                masks[frame][disc > 0] = person + 1
    return LabelledRecording(
        "discs",
        depth_mm,
        masks,
        joints,
        np.full(joints.shape[:3], np.nan, np.float32),
        np.ones((frames, people), bool),
        np.arange(1, people + 1),
        INTRINSICS,
    )


def write_recording(folder: Path, recording: LabelledRecording, **truth: NDArray) -> Path:
    """The recording as a folder; `truth` replaces or adds keys of groundtruth.npz."""
    for name, images in (("depth", recording.depth_mm), ("mask", recording.masks)):
        (folder / name).mkdir(parents=True)
        for index, image in enumerate(images):
            cv2.imwrite(str(folder / name / f"{index:06d}.png"), image)
    fx, fy, cx, cy = recording.intrinsics
    camera = {"fx": fx, "fy": fy, "cx": cx, "cy": cy, "width": SIZE[1], "height": SIZE[0]}
    (folder / "camera.json").write_text(json.dumps({**camera, "depth_scale": 1000, "fps": 30}))
    keys = {
        "names": np.array(PROPOSED_JOINTS),
        "joints": recording.joints_camera,
        "present": recording.is_present,
        "ids": recording.ids,
    }
    np.savez(folder / "groundtruth.npz", **{**keys, **truth})
    return folder
