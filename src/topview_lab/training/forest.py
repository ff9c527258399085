"""Train the forest of body parts on simulated people, and score it on others."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.body.parts import JOINT_NAMES
from topview_lab.rivals.forest.classes import CLASSES
from topview_lab.rivals.forest.growing import NO_CLASS, GrowingSettings, grow_forest
from topview_lab.rivals.forest.model import Forest, Trees
from topview_lab.rivals.forest.proposals import (
    propose_joints,
    surface_modes,
    votes_and_points,
)
from topview_lab.sim.scenes import KINECT_V1_HALF
from topview_lab.training.body_parts import RenderedBody

Array = NDArray[np.float64]

# Ours: a mode further from the joint belongs to another joint and is left out.
OWN_M: Final = 0.25
# Ours: share of the median area of votes at which the confidence is one half.
HALF_TRUSTED: Final = 1.0 / 3.0
WITHIN_M: Final = 0.10
"""What counts as found (Shotton et al., Sec. 4)."""


def learn_forest(
    bodies: Sequence[RenderedBody],
    others: Sequence[RenderedBody],
    growing: GrowingSettings,
    seed: int,
    trained_on: str,
    on_level: Callable[[], None] = lambda: None,
) -> Forest:
    """Grow trees from `bodies`, seen by `KINECT_V1_HALF`; calibrate the joints' depths behind the
    surface on `others`, which the trees were not grown from."""
    trees = grow_forest([known.body for known in bodies], KINECT_V1_HALF, growing, seed, on_level)
    depths_m, areas_m2 = _behind_the_surface(trees, others)
    return Forest(trees, depths_m, areas_m2, trained_on)


def _behind_the_surface(
    trees: Trees, bodies: Iterable[RenderedBody]
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """[J] medians of how far each joint lies behind the best mode of its votes, along the ray, and
    the share `HALF_TRUSTED` of the votes there."""
    behind_m: list[list[float]] = [[] for _ in JOINT_NAMES]
    areas_m2: list[list[float]] = [[] for _ in JOINT_NAMES]
    for known in bodies:
        is_body = known.body.label != NO_CLASS
        seen = votes_and_points(trees, known.body.depth_m, is_body, known.view)
        for j, modes in enumerate(surface_modes(seen)):
            if not len(modes) or not known.is_shown[j]:
                continue
            place = modes[0, :3].astype(np.float64)
            gap = known.joints_camera[j] - place
            if np.linalg.norm(gap) < OWN_M:
                behind_m[j].append(float(gap @ place / np.linalg.norm(place)))
                areas_m2[j].append(float(modes[0, 3]))
    return (
        np.array([np.median(values or 0.0) for values in behind_m], np.float32),
        np.array([HALF_TRUSTED * np.median(values or 1.0) for values in areas_m2], np.float32),
    )


@dataclass(frozen=True, slots=True, eq=False)
class ForestScore:
    """Scores on people that the forest was not trained on.

    Attributes:
        accuracy: [K] share of each class's pixels that are classified correctly, NaN for none.
        within: [J] share of the joints that are seen whose best candidate lies within `WITHIN_M`.
        median_m: [J] how far the best candidate is off, of those that there are.
    """

    accuracy: Array
    within: Array
    median_m: Array


def score_forest(forest: Forest, bodies: Iterable[RenderedBody]) -> ForestScore:
    """Score the classified pixels and proposed joints of labelled people."""
    right, known_pixels = np.zeros((2, len(CLASSES)))
    errors_m: list[list[float]] = [[] for _ in JOINT_NAMES]
    for known in bodies:
        is_body = known.body.label != NO_CLASS
        pixels = np.stack(np.nonzero(is_body)[::-1]).astype(np.int32)
        focal_px = known.view.fx, known.view.fy
        told = forest.trees.classify(known.body.depth_m, pixels, focal_px).argmax(1)
        label = known.body.label[is_body]
        right += np.bincount(label[told == label], minlength=len(CLASSES))
        known_pixels += np.bincount(label, minlength=len(CLASSES))
        best: dict[str, Array] = {}
        for candidate in propose_joints(known.body.depth_m, is_body, known.view, forest):
            best.setdefault(candidate.joint, candidate.place_camera)
        for j in np.flatnonzero(known.is_shown):
            place = best.get(JOINT_NAMES[j])
            gap = np.inf if place is None else np.linalg.norm(place - known.joints_camera[j])
            errors_m[j].append(float(gap))
    with np.errstate(invalid="ignore"):
        accuracy = right / known_pixels
    errors = [np.array(values or [np.nan]) for values in errors_m]
    return ForestScore(
        accuracy,
        np.array([(of_joint <= WITHIN_M).mean() for of_joint in errors]),
        np.array([np.median(of_joint) for of_joint in errors]),
    )
