"""Labels and truth that cannot be: nothing is learnt from them, and one line says why."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from topview.records import InputError
from topview_lab.cli.train_forest import train_forest
from topview_lab.cli.train_hands import train_hands
from topview_lab.cli.train_skin import train_skin
from topview_lab.sim import scene_by_name, write_scene


@pytest.mark.parametrize(
    "rectangle",
    [(0, -100, 5, 50), (-3, 0, 5, 5), (78, 0, 5, 5), (0, 0, 5, 61), (0, 0, 0, 5), (3, 3, 5, -2),
     (10**18, 0, 10**18, 5)],
)  # fmt: skip
@pytest.mark.parametrize("option", ["skin", "not_skin"])
def test_a_rectangle_outside_labels_nothing(
    tmp_path: Path, rectangle: tuple[int, int, int, int], option: str
) -> None:
    image, out = tmp_path / "image.png", tmp_path / "skin.npz"
    cv2.imwrite(str(image), np.full((60, 80, 3), 90, np.uint8))
    rectangles: dict[str, Any] = {option: [rectangle]}
    with pytest.raises(InputError, match=r"image\.png: rectangle .* in the image, 80 x 60 pixels"):
        train_skin([image], out=out, **rectangles)
    assert not out.exists()


def test_masks_that_label_nothing_teach_nothing(tmp_path: Path) -> None:
    image, mask, out = (tmp_path / name for name in ("image.png", "mask.png", "skin.npz"))
    cv2.imwrite(str(image), np.full((60, 80, 3), 90, np.uint8))
    cv2.imwrite(str(mask), np.full((60, 80), 7, np.uint8))
    with pytest.raises(InputError, match=r"mask\.png: labels no pixel"):
        train_skin([image], masks=[mask], out=out)
    assert not out.exists()


@pytest.fixture(scope="module")
def simulated(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("labelled") / "wave"
    write_scene(scene_by_name("wave", frames=4), folder)
    return folder


@pytest.fixture
def labelled(simulated: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(simulated, tmp_path / "wave"))


def rewritten(folder: Path, change: Callable[[dict[str, Any]], object]) -> None:
    path = folder / "groundtruth.npz"
    arrays = dict(np.load(path))
    change(arrays)
    np.savez(path, **arrays)


def test_good_truth_teaches(labelled: Path, tmp_path: Path) -> None:
    train_hands([labelled], out=tmp_path / "hands.npz")
    assert (tmp_path / "hands.npz").exists()


def to_nan(arrays: dict[str, Any]) -> None:
    arrays["joints"] = np.full_like(arrays["joints"], np.nan)


def shorter(arrays: dict[str, Any]) -> None:
    for key, value in arrays.items():
        if value.shape[:1] == (4,):
            arrays[key] = value[:2]


def nobody(arrays: dict[str, Any]) -> None:
    arrays["present"][:] = False


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (to_nan, "must be finite metres"),
        (shorter, "the recording has 4 frames, its reference 2"),
        (nobody, "on no spot of skin in them is a face, left hand, right hand"),
        (lambda arrays: arrays.pop("present"), "lacks present"),
        (lambda arrays: arrays.update(joints=arrays["joints"][0]), "joints"),
    ],
)
def test_truth_that_cannot_be_teaches_nothing(
    labelled: Path, tmp_path: Path, change: Callable[[dict[str, Any]], object], said: str
) -> None:
    rewritten(labelled, change)
    out = tmp_path / "hands.npz"
    with pytest.raises(InputError, match=said):
        train_hands([labelled], out=out)
    assert not out.exists()


def test_a_recording_without_colour_teaches_nothing(labelled: Path, tmp_path: Path) -> None:
    shutil.rmtree(labelled / "rgb")
    out = tmp_path / "hands.npz"
    with pytest.raises(InputError, match="has no colour images"):
        train_hands([labelled], out=out)
    assert not out.exists()


def test_an_unreadable_frame_is_named_and_shifts_no_truth(
    labelled: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (labelled / "depth" / "000001.png").write_bytes(b"no image")
    train_hands([labelled], out=tmp_path / "hands.npz")
    assert "000001.png" in capsys.readouterr().err


@pytest.mark.parametrize("threads", [-1, -(10**9)])
def test_threads_below_0_grow_no_forest(tmp_path: Path, threads: int) -> None:
    with pytest.raises(InputError, match=f"--threads is {threads}; it must be 0"):
        train_forest(out=tmp_path / "forest.npz", images=1, threads=threads)
