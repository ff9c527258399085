"""Tiny recordings that the tests write themselves, and the real ones where they are."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

HEIGHT, WIDTH = 6, 8
CAMERA = {
    "fx": 9.0,
    "fy": 9.5,
    "cx": 3.5,
    "cy": 2.5,
    "width": WIDTH,
    "height": HEIGHT,
    "depth_scale": 0.001,
}

WriteFolder = Callable[..., Path]


@pytest.fixture
def tmp_path(tmp_path: Path) -> Path:
    """All that these tests read and write lies at a path with a space and beyond ASCII."""
    folder = tmp_path / "é 名"
    folder.mkdir()
    return folder


@pytest.fixture
def depths() -> dict[int, NDArray[np.uint16]]:
    """Frames 0 to 3, up to 20 m, with the least and the greatest value that 16 bits can hold."""
    rng = np.random.default_rng(0)
    images = {i: rng.integers(0, 20000, (HEIGHT, WIDTH), np.uint16) for i in range(4)}
    images[0][0, :3] = 0, 1, 65535
    return images


@pytest.fixture
def write_folder(tmp_path: Path, depths: dict[int, NDArray[np.uint16]]) -> WriteFolder:
    """Writes a folder recording; depth images may be arrays or a file's raw bytes."""

    def write(
        depth: dict[int, Any] | None = None,
        color: dict[str, Any] | None = None,
        **camera: Any,
    ) -> Path:
        root = tmp_path / "walk"
        (root / "depth").mkdir(parents=True)
        for index, image in (depths if depth is None else depth).items():
            write_image(root / "depth" / f"{index:06d}.png", image)
        for name, image in (color or {}).items():
            (root / "rgb").mkdir(exist_ok=True)
            write_image(root / "rgb" / name, image)
        (root / "camera.json").write_text(json.dumps({**CAMERA, **camera}))
        return root

    return write


def write_image(path: Path, image: NDArray[Any] | bytes) -> None:
    path.write_bytes(image if isinstance(image, bytes) else encode_image(image, path.suffix))


def encode_image(image: NDArray[Any], suffix: str = ".png") -> bytes:
    """An image file, RGB order for colour."""
    stored = image[..., ::-1] if image.ndim == 3 else image
    return cv2.imencode(suffix, stored)[1].tobytes()


@pytest.fixture
def encode() -> Callable[..., bytes]:
    return encode_image


@pytest.fixture
def recordings(shared: Path) -> Path:
    return shared / "recordings"


@pytest.fixture
def bench(shared: Path) -> Path:
    return shared / "bench"
