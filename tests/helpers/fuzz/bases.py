"""Whole recordings, truth and predictions, tiny, each with the command that reads it."""

from __future__ import annotations

import json
import struct
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.io import savemat

from made_frames import ABOUT, frames_with
from skeleton_sequences import people_standing, predicted_of, write_rendered
from tiny_berkeley_mhad import write_calibration, write_sequence
from topview.camera import unproject_depth
from topview.io import FramesFile, write_skeletons_csv, write_skeletons_npz
from topview.records import Camera
from topview_lab.sim import SimulatedRecording, scene_by_name

CAMERA: Final = Camera(fx=143.0, fy=143.0, cx=79.5, cy=59.5, width=160, height=120)
FRAMES: Final = 2
DEPTHS_M: Final = [2.5, 2.6, 2.7]  # of truth


@dataclass(frozen=True, slots=True)
class Base:
    """Input that is whole.

    Attributes:
        write: makes it in a folder.
        arguments: of the command that reads it there; OUT is a folder for results.
        files: those of it that are spoiled, by a short name.
    """

    write: Callable[[Path], None]
    arguments: tuple[str, ...]
    files: dict[str, str]


def _depth_mm() -> list[NDArray[np.uint16]]:
    """Two people in a room."""
    scene = replace(scene_by_name("two_users", seed=1, frames=FRAMES), camera=CAMERA)
    return [np.rint(1e3 * frame.depth_m).astype(np.uint16) for frame in SimulatedRecording(scene)]


def _folder(root: Path) -> None:
    numbers = ("fx", "fy", "cx", "cy", "width", "height")
    color = {name: getattr(CAMERA, name) for name in numbers} | {
        "T_color_depth": np.eye(4).tolist(),
        "distortion": {"model": "rational", "coefficients": [0.01] * 8},
    }
    camera: dict[str, Any] = {name: getattr(CAMERA, name) for name in numbers} | {
        "depth_scale": 0.001,
        "fps": 30,
        "sensor": "kinect1",
        "distortion": {"model": "brown_conrady", "coefficients": [-0.05, 0.01, 0.0, 0.0, 0.0]},
        "T_world_camera": np.eye(4).tolist(),
        "color": color,
    }
    (root / "depth").mkdir()
    (root / "rgb").mkdir()
    (root / "camera.json").write_text(json.dumps(camera))
    for index, depth_mm in enumerate(_depth_mm()):
        shades = (depth_mm // 16).astype(np.uint8)
        image = np.stack([shades, shades // 2, 255 - shades], axis=-1)
        cv2.imwrite(str(root / "depth" / f"{index:06d}.png"), depth_mm)
        cv2.imwrite(str(root / "rgb" / f"{index:06d}.{'png' if index else 'jpg'}"), image)


def _pcd(encoding: str) -> Callable[[Path], None]:
    def write(root: Path) -> None:
        depth_m = (1e-3 * _depth_mm()[0]).astype(np.float32)
        points = unproject_depth(depth_m, CAMERA).reshape(-1, 3).astype("<f4")
        points = points[: 160 * 120]
        match encoding:
            case "ascii":
                body = "".join(" ".join(map(repr, row)) + "\n" for row in points.tolist()).encode()
            case "binary":
                body = points.tobytes()
            case _:
                plain = points.T.tobytes()
                blocks = [plain[start : start + 32] for start in range(0, len(plain), 32)]
                packed = b"".join(bytes([len(block) - 1]) + block for block in blocks)
                body = struct.pack("<II", len(packed), len(plain)) + packed
        header = (
            "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\n"
            "WIDTH 160\nHEIGHT 120\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 19200\n"
            f"DATA {encoding}\n"
        )
        (root / "cloud.pcd").write_bytes(header.encode() + body)

    return write


def _mat(packed: bool) -> Callable[[Path], None]:
    def write(root: Path) -> None:
        wall = np.full((240, 320, FRAMES), 3000, np.uint16)
        savemat(root / "a1_s1_t1_depth.mat", {"d_depth": wall}, do_compression=packed)

    return write


def _utd(root: Path) -> None:
    for name in ("Depth", "Skeleton", "predictions"):
        (root / name).mkdir()
    _mat(packed=True)(root / "Depth")
    skeleton = np.tile(np.linspace(1.0, 2.0, 60).reshape(20, 3, 1), (1, 1, 6))
    savemat(root / "Skeleton" / "a1_s1_t1_skeleton.mat", {"d_skel": skeleton}, do_compression=True)
    _predictions(root / "predictions" / "a1_s1_t1.npz")


def _msr(root: Path) -> None:
    units = np.full((FRAMES, 120, 160), 3000, "<i4")
    header = np.array([FRAMES, 160, 120], "<i4")
    (root / "a01_s01_e01_sdepth.bin").write_bytes(header.tobytes() + units.tobytes())
    rows = np.tile([[80.0, 60.0, 3000.0, 1.0]], (20 * FRAMES, 1))
    text = "\n".join(" ".join(map(str, row)) for row in rows.tolist())
    (root / "a01_s01_e01_skeleton.txt").write_text(text)
    _predictions(root / "a01_s01_e01.npz")


def _mhad(root: Path) -> None:
    write_sequence(root, "s01_a01_r01", list(range(FRAMES)))
    write_calibration(root)
    _predictions(root / "s01_a01_r01.npz")


def _predictions(path: Path) -> None:
    sequence = predicted_of(people_standing(len(DEPTHS_M), 0.0, 1.0))
    write = write_skeletons_csv if path.suffix == ".csv" else write_skeletons_npz
    write(sequence, path)


def _truth(predictions: str) -> Callable[[Path], None]:
    def write(root: Path) -> None:
        part_names = np.array(["head", "torso"])
        write_rendered(
            root / "recording",
            DEPTHS_M,
            ids=np.array([1]),
            actions=np.full((len(DEPTHS_M), 1), "standing"),
            bodies=np.array(["body"]),
            part_names=part_names,
            Ts_camera_part=np.tile(np.eye(4), (len(DEPTHS_M), 1, 2, 1, 1)),
        )
        _predictions(root / predictions)

    return write


def _composite(root: Path) -> None:
    _truth("predictions.npz")(root)
    with np.load(root / "recording" / "groundtruth.npz") as rendered:
        names, joints = rendered["names"], rendered["joints"]
    both = np.tile(np.swapaxes(joints, 0, 1), (2, 1, 1, 1))
    np.savez_compressed(
        root / "recording" / "groundtruth.npz",
        joint_names=names,
        joints=both,
        joint_not_behind_other=np.ones(both.shape[:3], bool),
    )


def _stored(root: Path) -> None:
    """The output folder of a run that was killed."""
    (root / "killed").mkdir()
    with FramesFile(root / "killed" / "skeletons.frames", ABOUT) as file:
        for frame in frames_with([(1,), (1, 2), (), (2,)]):
            file.append(frame)


_EVALUATE: Final = ("evaluate", "folder", "recording", "--per-sequence", "--detail")
_TRACK: Final = ("--out", "OUT")

BASES: Final[dict[str, Base]] = {
    "folder": Base(
        _folder,
        ("track", ".", *_TRACK),
        {
            "camera.json": "camera.json",
            "depth image": "depth/000001.png",
            "colour image.png": "rgb/000001.png",
            "colour image.jpg": "rgb/000000.jpg",
        },
    ),
    **{
        f"pcd {encoding}": Base(
            _pcd(encoding), ("track", "cloud.pcd", *_TRACK), {f"{encoding}.pcd": "cloud.pcd"}
        )
        for encoding in ("ascii", "binary", "binary_compressed")
    },
    **{
        f"mat {'packed' if packed else 'plain'}": Base(
            _mat(packed),
            ("track", "a1_s1_t1_depth.mat", *_TRACK),
            {f"{'packed' if packed else 'plain'}.mat": "a1_s1_t1_depth.mat"},
        )
        for packed in (False, True)
    },
    "utd": Base(
        _utd,
        ("evaluate", "utd-mhad", ".", "--predictions", "predictions"),
        {"skeleton.mat": "Skeleton/a1_s1_t1_skeleton.mat"},
    ),
    "msr": Base(
        _msr,
        ("track", "a01_s01_e01_sdepth.bin", *_TRACK),
        {"sdepth.bin": "a01_s01_e01_sdepth.bin"},
    ),
    "msr truth": Base(
        _msr,
        ("evaluate", "msr-action3d", ".", "--predictions", "."),
        {"skeleton.txt": "a01_s01_e01_skeleton.txt"},
    ),
    "mhad": Base(
        _mhad,
        ("track", "Kinect/Kin01/S01/A01/R01", *_TRACK),
        {
            "image.pgm": "Kinect/Kin01/S01/A01/R01/kin_k01_s01_a01_r01_depth_00001.pgm",
            "image.ppm": "Kinect/Kin01/S01/A01/R01/kin_k01_s01_a01_r01_color_00001.ppm",
            "camcfg.yml": "Calibration/camcfg_k01.yml",
        },
    ),
    "mhad truth": Base(
        _mhad,
        ("evaluate", "mhad", ".", "--predictions", "."),
        {
            "skeleton.bvh": "Mocap/SkeletalData/skl_s01_a01_r01.bvh",
            "correspondences.txt": "Kinect/Correspondences/corr_moc_kin01_s01_a01_r01.txt",
            "RwTw.txt": "Calibration/RwTw_k01.txt",
        },
    ),
    "stored": Base(_stored, ("recover", "killed"), {"skeletons.frames": "killed/skeletons.frames"}),
    "truth": Base(
        _truth("predictions.npz"),
        (*_EVALUATE, "--predictions", "predictions.npz"),
        {"truth.npz": "recording/groundtruth.npz", "skeletons.npz": "predictions.npz"},
    ),
    "composite": Base(
        _composite,
        (*_EVALUATE, "--predictions", "predictions.npz"),
        {"composite truth.npz": "recording/groundtruth.npz"},
    ),
    "csv": Base(
        _truth("predictions.csv"),
        (*_EVALUATE, "--predictions", "predictions.csv"),
        {"predictions.csv": "predictions.csv"},
    ),
}
"""Each `files` entry is a target of its own."""
