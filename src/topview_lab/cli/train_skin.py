"""`topview train-skin`: what skin looks like, learnt from images with labelled masks."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np
from cyclopts import Parameter
from numpy.typing import NDArray
from rich.table import Table

from topview.cli.outputs import prepare_output_file
from topview.cli.printing import plain_console
from topview.cli.progress import progress_bar
from topview.detect.skin import DEFAULT_SKIN, SkinHistograms
from topview.files import naming
from topview.io import write_atomically
from topview.io.readers.images import decode_color
from topview.records import InputError
from topview.view.detections import skin_picture
from topview.view.drawing import png_of
from topview_lab.seeds import SKIN_HELD_OUT_SEED, SKIN_LEARNT_SEED
from topview_lab.training.renders import simulated_skin
from topview_lab.training.skin import (
    IS_SKIN,
    NOT_SKIN,
    UNKNOWN,
    LabelledImage,
    as_frame,
    corrected,
    find_skin,
    learn_skin,
    score_skin,
)
from topview_lab.training.tones import SKIN_TONES

SIMULATED_PER_TONE = 24
HELD_OUT_PER_TONE = 8

Rectangle = tuple[int, int, int, int]


def train_skin(
    images: list[Path] | None = None,
    /,
    *,
    masks: Annotated[list[Path] | None, Parameter(consume_multiple=True, negative="")] = None,
    skin: Annotated[list[Rectangle] | None, Parameter(negative="")] = None,
    not_skin: Annotated[list[Rectangle] | None, Parameter(negative="")] = None,
    simulated: Annotated[bool, Parameter(negative="")] = False,
    start: Path | None = None,
    weight: float = 0.3,
    out: Path | None = None,
    show: Path | None = None,
    force: Annotated[bool, Parameter(negative="")] = False,
) -> None:
    """Learn what skin looks like, correct it, and show what is found in an image.

    Masks are PNG images of the same size: 255 is skin, 0 is not, anything else is not known.
    Rectangles correct what was wrongly found or missed in all the images.

    Args:
        images: colour images.
        masks: one for each image, in their order.
        skin: LEFT TOP WIDTH HEIGHT of a rectangle that is skin.
        not_skin: LEFT TOP WIDTH HEIGHT of a rectangle that is not.
        simulated: learn from the simulator's people, as the default was; prints how well skin of
            every tone is found on others of them.
        start: histograms to correct, the default's if there are rectangles; with masks alone,
            they are learnt anew unless this is given.
        weight: of a correction, 0 to 1.
        out: the .npz to write.
        show: a PNG of the first image to write: the image, the probability, what is found.
        force: replace the files that are there.
    """
    corrections = _Corrections(tuple(skin or ()), tuple(not_skin or ()))
    if not images and not simulated:
        raise InputError("there is nothing to learn from; give images, or --simulated")
    if not 0.0 < weight <= 1.0:
        raise InputError(f"--weight is {weight}; it must be above 0, up to 1")
    is_labelled = bool(masks or corrections.are_given)
    if is_labelled and out is None:
        raise InputError("--out is missing; it must name the .npz to write what is learnt to")
    for option, path in (("--out", out), ("--show", show)):
        if path is not None:
            prepare_output_file(option, path, force)
    labelled = _read_labelled(images or [], masks, corrections)

    histograms = _starting_point(start, simulated, is_new=bool(masks) and not corrections.are_given)
    if is_labelled:
        learnt = learn_skin(labelled, f"{len(labelled)} images")
        histograms = learnt if histograms is None else corrected(histograms, learnt, weight)
    assert histograms is not None
    if out is not None:
        write_atomically(out, histograms.npz())
        print(f"trained on {histograms.trained_on}; written to {out}")
    if show is not None and labelled:
        rgb = labelled[0].rgb
        view, probability, is_skin = find_skin(as_frame(rgb), histograms)
        write_atomically(show, png_of(skin_picture(view.rgb, probability, is_skin)))
        print(f"{100 * is_skin.mean():.1f} % of {(images or [])[0]} is skin; look at {show}")


@dataclass(frozen=True, slots=True)
class _Corrections:
    """Rectangles that are skin, and that are not."""

    skin: tuple[Rectangle, ...]
    not_skin: tuple[Rectangle, ...]

    @property
    def are_given(self) -> bool:
        return bool(self.skin or self.not_skin)

    def draw(self, label: NDArray[np.uint8], path: Path) -> None:
        for value, rectangles in ((IS_SKIN, self.skin), (NOT_SKIN, self.not_skin)):
            for left, top, width, height in rectangles:
                is_inside = (
                    0 <= left < left + width <= label.shape[1]
                    and 0 <= top < top + height <= label.shape[0]
                )
                if not is_inside:
                    raise InputError(
                        f"{path}: rectangle {left} {top} {width} {height} lies outside; it must "
                        f"lie in the image, {label.shape[1]} x {label.shape[0]} pixels"
                    )
                label[top : top + height, left : left + width] = value


def _starting_point(start: Path | None, simulated: bool, is_new: bool) -> SkinHistograms | None:
    if simulated:
        return _learn_simulated()
    if start is None and is_new:
        return None
    return SkinHistograms.load(start or DEFAULT_SKIN)


def _learn_simulated() -> SkinHistograms:
    """Learn from the simulator, and print how well skin is found on people it was not learnt of."""
    count = SIMULATED_PER_TONE * len(SKIN_TONES)
    with progress_bar() as progress:
        bar = progress.add_task("simulating", total=count + HELD_OUT_PER_TONE * len(SKIN_TONES))

        def counted(images: Iterator[LabelledImage]) -> Iterator[LabelledImage]:
            for image in images:
                yield image
                progress.advance(bar)

        histograms = learn_skin(
            counted(simulated_skin(SIMULATED_PER_TONE, SKIN_LEARNT_SEED)),
            f"{count} renders of simulated people of {len(SKIN_TONES)} skin tones",
        )
        held_out = counted(simulated_skin(HELD_OUT_PER_TONE, SKIN_HELD_OUT_SEED))
        scores = score_skin(histograms, held_out)
    table = Table("skin tone", title="skin found on other simulated people")
    table.add_column("found", justify="right")
    table.add_column("of what was found, skin", justify="right")
    for score in scores:
        table.add_row(score.tone, f"{100 * score.recall:.1f} %", f"{100 * score.precision:.1f} %")
    plain_console().print(table)
    return histograms


def _read_labelled(
    images: list[Path], masks: list[Path] | None, corrections: _Corrections
) -> list[LabelledImage]:
    if masks is not None and len(masks) != len(images):
        raise InputError(
            f"--masks names {len(masks)} files; it must be one for each of {len(images)} images"
        )
    labelled = []
    for i, path in enumerate(images):
        rgb = _read_image(path)
        label = np.full(rgb.shape[:2], UNKNOWN, np.uint8)
        if masks is not None:
            mask = _read_image(masks[i])
            if mask.shape != rgb.shape:
                raise InputError(
                    f"{masks[i]}: is {mask.shape[1]} x {mask.shape[0]} pixels; "
                    f"it must be {rgb.shape[1]} x {rgb.shape[0]}, as {path} is"
                )
            label = np.where(np.isin(mask[..., 0], (NOT_SKIN, IS_SKIN)), mask[..., 0], UNKNOWN)
        corrections.draw(label, path)
        if (masks is not None or corrections.are_given) and (label == UNKNOWN).all():
            raise InputError(
                f"{masks[i] if masks else path}: labels no pixel; a mask's must be "
                f"{IS_SKIN} (skin) or {NOT_SKIN} (not)"
            )
        labelled.append(LabelledImage(rgb, label))
    return labelled


def _read_image(path: Path) -> NDArray[np.uint8]:
    try:
        data = path.read_bytes()
    except OSError as error:
        raise InputError(f"{path}: {error.strerror}; it must be a PNG or JPEG image") from error
    with naming(path):
        return decode_color(data)
