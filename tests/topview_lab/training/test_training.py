"""Training: labels from truth, tables that tell kinds apart, and the commands' words."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from detect_scenes import CAMERA, SHIRT_RGB, SKIN_RGB, frame_of
from topview.detect.beliefs import BeliefTables, Kind
from topview.detect.skin import SkinHistograms
from topview.records import InputError
from topview_lab.cli.train_hands import train_hands
from topview_lab.cli.train_skin import train_skin
from topview_lab.training.hands import (
    NO_TABLES,
    LabelledFrame,
    learn_beliefs,
    observe,
    score_beliefs,
)
from topview_lab.training.renders import simulated_skin
from topview_lab.training.skin import IS_SKIN, NOT_SKIN, learn_skin, score_skin
from topview_lab.training.tones import SKIN_TONES, linear_rgb


def waving(frames: int = 20) -> list[LabelledFrame]:
    """A face, and two hands of which the person's left waves, on the image's right."""
    labelled = []
    for index in range(frames):
        wave = 10.0 * np.sin(index)
        pixels = {
            Kind.FACE: (80.0, 30.0),
            Kind.LEFT_HAND: (120.0, 60.0 + wave),
            Kind.RIGHT_HAND: (40.0, 90.0),
        }
        discs = [(80.0, 75.0, 26.0, 2.0, SHIRT_RGB), (80.0, 110.0, 5.0, 1.9, SKIN_RGB)]
        discs += [
            (*at, 12.0 if kind == Kind.FACE else 6.0, 2.0, SKIN_RGB) for kind, at in pixels.items()
        ]
        places = {
            kind: np.array(
                [[(x - CAMERA.cx) / CAMERA.fx * 2.0, (y - CAMERA.cy) / CAMERA.fy * 2.0, 2.05]]
            )
            for kind, (x, y) in pixels.items()
        }
        labelled.append(LabelledFrame(frame_of(discs, index=index), places, None))
    return labelled


def test_blobs_are_labelled_by_what_projects_into_them() -> None:
    seen = list(observe(waving(), SkinHistograms.load(), NO_TABLES))
    assert {observation.kind for observation in seen} == set(Kind)
    lefts = [o.blob.ellipse.x for o in seen if o.kind == Kind.LEFT_HAND]
    assert np.allclose(lefts, 120, atol=1.5)
    others = [o.blob.ellipse.y for o in seen if o.kind == Kind.OTHER]
    assert np.allclose(others, 110, atol=1.5)


def test_tables_learnt_from_a_scene_tell_its_kinds() -> None:
    skin = SkinHistograms.load()
    tables = learn_beliefs([waving()], skin, "waving")
    score = score_beliefs([waving()], skin, tables)
    assert (score.accuracy > 0.95).all()
    blind = score_beliefs([waving()], skin, tables.only(()))
    assert blind.accuracy.sum() < 2.0


def test_tones_are_the_classes_of_the_typology_angle() -> None:
    degrees = [np.degrees(np.arctan2(lab[0] - 50.0, lab[2])) for lab in SKIN_TONES.values()]
    bounds = (90.0, 55.0, 41.0, 28.0, 10.0, -30.0, -90.0)
    for angle, upper, lower in zip(degrees, bounds[:-1], bounds[1:], strict=True):
        assert lower < angle <= upper
    assert linear_rgb((100.0, 0.0, 0.0)) == pytest.approx((1.0, 1.0, 1.0), abs=1e-3)


@pytest.mark.slow
def test_skin_of_every_tone_is_found() -> None:
    scores = score_skin(SkinHistograms.load(), simulated_skin(3, seed=77))
    assert [score.tone for score in scores] == list(SKIN_TONES)
    assert all(score.recall > 0.75 for score in scores)
    assert np.mean([score.recall for score in scores]) > 0.88


def test_histograms_learnt_from_renders_score_on_others() -> None:
    learnt = learn_skin(simulated_skin(2, 0, ("tan",)), "tan people")
    (score,) = score_skin(learnt, simulated_skin(1, 1, ("tan",)))
    assert score.recall > 0.5


@pytest.fixture
def hand_files(tmp_path: Path) -> tuple[Path, Path]:
    """An image of a hand of the shirt's colour, and its mask."""
    frame = frame_of([(80, 60, 20, 2.0, SHIRT_RGB)])
    assert frame.color is not None
    image, mask = tmp_path / "image.png", tmp_path / "mask.png"
    cv2.imwrite(str(image), frame.color[..., ::-1])
    cv2.imwrite(str(mask), np.where(frame.depth_m < 2.5, IS_SKIN, NOT_SKIN).astype(np.uint8))
    return image, mask


def test_train_skin_learns_shows_and_corrects(
    hand_files: tuple[Path, Path], tmp_path: Path
) -> None:
    image, mask = hand_files
    out, picture = tmp_path / "skin.npz", tmp_path / "show.png"
    train_skin([image], masks=[mask], out=out, show=picture)
    assert np.asarray(cv2.imread(str(picture))).shape == (120, 480, 3)
    first = SkinHistograms.load(out)
    assert "1 images" in first.trained_on
    train_skin([image], not_skin=[(70, 50, 20, 20)], start=out, weight=0.8, out=out, force=True)
    second = SkinHistograms.load(out)
    assert second.probability.max() < 0.6 < first.probability.max()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({}, "nothing to learn from"),
        ({"masks": []}, "0 files; it must be one for each of 1"),
        ({"skin": [(500, 0, 5, 5)]}, "lies outside"),
        ({"weight": 2.0}, "--weight is 2.0"),
    ],
)
def test_train_skin_refuses(
    hand_files: tuple[Path, Path], tmp_path: Path, arguments: dict, message: str
) -> None:
    images = [hand_files[0]] if arguments else None
    with pytest.raises(InputError, match=message):
        train_skin(images, out=tmp_path / "skin.npz", **arguments)


def test_labels_without_a_place_to_write_to_are_refused(hand_files: tuple[Path, Path]) -> None:
    with pytest.raises(InputError, match="--out is missing"):
        train_skin([hand_files[0]], masks=[hand_files[1]])
    with pytest.raises(InputError, match="--out is missing"):
        train_hands([hand_files[0]])
    with pytest.raises(InputError, match="groundtruth"):
        train_hands(test=[hand_files[0].parent])


def test_default_tables_say_what_they_were_trained_on() -> None:
    assert "simulat" in SkinHistograms.load().trained_on
    assert "simulat" in BeliefTables.load().trained_on
