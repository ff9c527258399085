# /// script
# requires-python = ">=3.9,<3.13"
# dependencies = ["mediapipe==0.10.21", "numpy<2"]
# ///
"""MediaPipe Pose, lifted by the depth image, as a file for `topview evaluate --predictions`.

It runs in an environment of its own, as MediaPipe wants an older NumPy than topview does; 0.10.21
is the last version that has its model with it and so works off-line:

    python3 -m venv mediapipe-env
    mediapipe-env/bin/pip install mediapipe==0.10.21 'numpy<2'
    mediapipe-env/bin/python scripts/mediapipe_bridge.py RECORDING... --out predictions
    topview evaluate folder RECORDING... --predictions predictions

A recording is a folder with `depth/000000.png`, `rgb/000000.png` (or .jpg) and `camera.json`.
MediaPipe Pose finds one person, in colour. Each landmark is lifted to 3D by the median of the
depths around it and pushed along the ray by half the body's thickness there, from the skin to the
joint. Landmarks outside the image, without depth, or so far from the person's other landmarks that
something else must be in front are NaN; so are all in frames without colour or without a person.
`joint_confidence` is what MediaPipe calls visibility.
"""

from __future__ import annotations

import argparse
import json
import re
import sys
import time
from pathlib import Path

import cv2
import numpy as np

LANDMARKS = (
    "nose", "left_eye_inner", "left_eye", "left_eye_outer", "right_eye_inner", "right_eye",
    "right_eye_outer", "left_ear", "right_ear", "mouth_left", "mouth_right", "left_shoulder",
    "right_shoulder", "left_elbow", "right_elbow", "left_wrist", "right_wrist", "left_pinky",
    "right_pinky", "left_index", "right_index", "left_thumb", "right_thumb", "left_hip",
    "right_hip", "left_knee", "right_knee", "left_ankle", "right_ankle", "left_heel",
    "right_heel", "left_foot_index", "right_foot_index",
)  # fmt: skip
HALF_THICKNESS_M = {
    "ear": 0.07, "shoulder": 0.05, "elbow": 0.04, "wrist": 0.03, "hip": 0.10, "knee": 0.06,
    "ankle": 0.04,
}  # fmt: skip
"""From the skin to the joint: radii of the ANSUR survey (Gordon et al. 1989, NATICK/TR-89/044) for
a stature of 1.7 m; an ear's ray meets the cheek in front of it (ours). 0 for what lies on the skin.
"""
WINDOW_M = 0.05  # side of the square whose depths are looked at; ours
FARTHEST_M = 1.0  # a landmark this far before or behind the median of all is not the person's; ours
PUSH_M = np.array([HALF_THICKNESS_M.get(name.split("_")[-1], 0.0) for name in LANDMARKS])


def lift(pixels, depth_m, camera):
    """[K, 3] metres in the camera frame (x right, y down, z forward), NaN where not known.

    Args:
        pixels: [K, 2] column and row of each landmark, pixel centres at integers.
        depth_m: [H, W] metres along the optical axis, 0 where there is no reading.
        camera: fx, fy, cx and cy in pixels.
    """
    z = np.array([_depth_at(u, v, depth_m, camera["fx"]) for u, v in pixels])
    if np.isfinite(z).any():
        z[np.abs(z - np.nanmedian(z)) > FARTHEST_M] = np.nan
    u, v = np.asarray(pixels, float).T
    rays = np.stack(
        [(u - camera["cx"]) / camera["fx"], (v - camera["cy"]) / camera["fy"], np.ones_like(u)], 1
    )
    push = PUSH_M[:, None] / np.linalg.norm(rays, axis=1, keepdims=True)
    return rays * (z[:, None] + push)


def _depth_at(u, v, depth_m, fx):
    """The median depth in a square as wide as `WINDOW_M` where the landmark is."""
    height, width = depth_m.shape
    if not (-0.5 <= u < width - 0.5 and -0.5 <= v < height - 0.5):
        return np.nan
    column, row = round(u), round(v)
    half = 2
    for _ in range(2):  # how wide the square is in pixels depends on the depth in it
        around = depth_m[
            max(row - half, 0) : row + half + 1, max(column - half, 0) : column + half + 1
        ]
        valid = around[around > 0.0]
        if not len(valid):
            return np.nan
        half = max(1, round(0.5 * WINDOW_M * fx / float(np.median(valid))))
    return float(np.median(valid))


def _numbered(folder, suffixes):
    """Frame number to image, in order."""
    paths = sorted(p for p in folder.glob("*") if p.suffix.lower() in suffixes)
    numbered = {int(n[-1]): p for p in paths if (n := re.findall(r"[0-9]+", p.stem))}
    return dict(sorted(numbered.items()))


def run(recording, pose):
    """The arrays of one recording, and the seconds that MediaPipe took."""
    camera = json.loads((recording / "camera.json").read_text())
    scale = float(camera["depth_scale"])  # metres per unit, or units per metre
    metres_per_unit = 1.0 / scale if scale >= 1.0 else scale
    depths = _numbered(recording / "depth", (".png",))
    colors = _numbered(recording / "rgb", (".png", ".jpg", ".jpeg"))
    joints = np.full((len(depths), 1, len(LANDMARKS), 3), np.nan)
    confidence = np.zeros((len(depths), 1, len(LANDMARKS)), np.float32)
    seconds = 0.0
    for f, (index, path) in enumerate(depths.items()):
        depth = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
        color = cv2.imread(str(colors[index])) if index in colors else None
        if depth is None or color is None:
            continue
        start = time.perf_counter()
        found = pose.process(cv2.cvtColor(color, cv2.COLOR_BGR2RGB)).pose_landmarks
        seconds += time.perf_counter() - start
        if found is None:
            continue
        height, width = depth.shape
        pixels = np.array([(p.x * width - 0.5, p.y * height - 0.5) for p in found.landmark])
        joints[f, 0] = lift(pixels, depth * metres_per_unit, camera)
        is_told = np.isfinite(joints[f, 0]).all(-1)
        confidence[f, 0] = np.where(is_told, [p.visibility for p in found.landmark], 0.0)
    frames = np.array(list(depths), np.int64)
    arrays = {
        "joint_names": np.array(LANDMARKS),
        "joints_camera": joints,
        "joint_confidence": np.clip(confidence, 0.0, 1.0),
        "frame_index": frames,
        "timestamps_s": frames / float(camera.get("fps", 30.0)),
        "person_ids": np.array([1]),
    }
    return arrays, seconds


def main():
    parser = argparse.ArgumentParser(description="MediaPipe Pose, lifted by the depth image.")
    parser.add_argument("recordings", nargs="+", type=Path, metavar="RECORDING")
    parser.add_argument("--out", type=Path, required=True, help="folder for NAME.npz of each")
    options = parser.parse_args()
    try:
        from mediapipe.python.solutions.pose import Pose
    except ImportError:
        sys.exit("mediapipe is not installed; pip install mediapipe==0.10.21 'numpy<2'")
    options.out.mkdir(parents=True, exist_ok=True)
    for recording in options.recordings:
        needed = [recording / name for name in ("camera.json", "depth", "rgb")]
        if missing := [str(path) for path in needed if not path.exists()]:
            sys.exit(f"{recording} has no {', '.join(missing)}; it must be a recording's folder")
        with Pose(model_complexity=1) as pose:
            arrays, seconds = run(recording, pose)
        path = options.out / f"{recording.resolve().name}.npz"
        np.savez_compressed(path, **arrays)
        found = int(np.isfinite(arrays["joints_camera"]).all(-1).any((1, 2)).sum())
        frames = len(arrays["frame_index"])
        each = 1000.0 * seconds / max(frames, 1)
        print(f"{path}: a person in {found} of {frames} frames, {each:.0f} ms a frame")


if __name__ == "__main__":
    main()
