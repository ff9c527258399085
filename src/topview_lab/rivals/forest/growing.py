"""Grow trees level by level: each node gets the best of many random depth differences.

J. Shotton et al., CVPR 2011, Sec. 3.3: of random offsets and thresholds the pair with the largest
information gain splits a node's pixels.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.records import Camera
from topview_lab.kernels import forest as kernel
from topview_lab.rivals.forest.classes import CLASSES
from topview_lab.rivals.forest.model import Floats, Trees

CANDIDATE_BLOCK: Final = 64
"""Candidates that one task of the kernel tries (ours)."""
PROBE_REACH_M: Final = 1.0
"""How far from its pixel a probe may look (ours)."""
SINGLE_SHARE: Final = 0.5
"""Of the candidates that compare a probe with the pixel itself (Shotton et al., Fig. 4)."""
LEAST_SIDE_PIXELS: Final = 6
"""That each side of a split must keep (ours)."""
MOST_NODE_PIXELS: Final = 2000
"""Of a node, by which splits are judged (ours)."""


@dataclass(frozen=True, slots=True)
class GrowingSettings:
    """The budget of `topview train-forest` (ours); Shotton et al. have 3 trees of depth 20, 2000
    offsets, and 2000 pixels of each of 300 000 images.

    Attributes:
        trees: 1 or more.
        depth: levels of splits, 1 or more.
        candidates: offsets tried at each node, a multiple of `CANDIDATE_BLOCK`; the nodes of a
            level try the same ones.
        pixels: of each image and tree, 1 or more; about as many of each class.
    """

    trees: int = 3
    depth: int = 19
    candidates: int = 192
    pixels: int = 100


@dataclass(frozen=True, slots=True, eq=False)
class LabelledBody:
    """One person alone, cut out.

    Attributes:
        depth_m: [h, w] of `person_depth`.
        label: [h, w] uint8 index into `CLASSES`, `NO_CLASS` off the person.
    """

    depth_m: Floats
    label: NDArray[np.uint8]


NO_CLASS = 255


@dataclass(frozen=True, slots=True, eq=False)
class _Samples:
    """[S] pixels: which image, column, row, and class."""

    image: NDArray[np.int32]
    u: NDArray[np.int32]
    v: NDArray[np.int32]
    label: NDArray[np.uint8]

    def __getitem__(self, chosen: NDArray[np.intp]) -> _Samples:
        return _Samples(self.image[chosen], self.u[chosen], self.v[chosen], self.label[chosen])


def grow_forest(
    bodies: Sequence[LabelledBody],
    camera: Camera,
    settings: GrowingSettings,
    seed: int,
    on_level: Callable[[], None] = lambda: None,
) -> Trees:
    """Grow trees from labelled people, all seen by one camera; `on_level` is called after each
    level."""
    depths = np.concatenate([body.depth_m.ravel() for body in bodies])
    shapes = np.array([body.depth_m.shape for body in bodies], np.int64)
    firsts = np.cumsum(np.append(0, shapes.prod(1)))[:-1]
    crops = np.stack([firsts, shapes[:, 1], shapes[:, 0]], axis=1)
    trees = []
    for t in range(settings.trees):
        rng = np.random.default_rng((seed, t))
        samples = _sample_pixels(bodies, settings.pixels, rng)
        trees.append(_grow_tree(depths, crops, samples, camera, settings, rng, on_level))
    return Trees.joined(trees)


def _sample_pixels(
    bodies: Sequence[LabelledBody], count: int, rng: np.random.Generator
) -> _Samples:
    """Sample pixels of every image, about equally many of each class, fewer of small ones."""
    drawn = []
    for i, body in enumerate(bodies):
        v, u = np.nonzero(body.label != NO_CLASS)
        label = body.label[v, u]
        sizes = np.bincount(label, minlength=len(CLASSES))
        weight = 1.0 / np.maximum(sizes, count / len(CLASSES))[label]
        chosen = rng.choice(len(v), min(count, len(v)), replace=False, p=weight / weight.sum())
        chosen.sort()
        image = np.full(len(chosen), i)
        drawn.append(np.stack([image, u[chosen], v[chosen], label[chosen]]).astype(np.int32))
    image, u, v, label = np.concatenate(drawn, axis=1)
    return _Samples(image, u, v, label.astype(np.uint8))


def draw_offsets(settings: GrowingSettings, rng: np.random.Generator) -> Floats:
    """[C, 4] offsets of two probes in whole millimetres, more of them near the pixel."""
    C = settings.candidates
    radius, angle = PROBE_REACH_M * rng.random((2, C)), 2.0 * np.pi * rng.random((2, C))
    offsets = np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=-1)
    offsets[1, rng.random(C) < SINGLE_SHARE] = 0.0
    return np.round(offsets.transpose(1, 0, 2).reshape(C, 4), 3).astype(np.float32)


def _grow_tree(
    depths: Floats,
    crops: NDArray[np.int64],
    samples: _Samples,
    camera: Camera,
    settings: GrowingSettings,
    rng: np.random.Generator,
    on_level: Callable[[], None],
) -> Trees:
    """One tree, level by level; the samples of the nodes of a level lie one after the other."""
    fx, fy = np.float32(camera.fx), np.float32(camera.fy)
    n = np.arange(MOST_NODE_PIXELS + 1, dtype=np.float64)
    n_log_n = n * np.log(np.maximum(n, 1.0))
    offsets: list[Floats] = []
    thresholds: list[Floats] = []
    children: list[NDArray[np.int32]] = []
    leaves: list[NDArray[np.uint8]] = []
    n_leaves, n_nodes = 0, 1
    nodes = np.array([0, len(samples.image)], np.int64)
    for level in range(settings.depth + 1):
        N = len(nodes) - 1
        candidates = draw_offsets(settings, rng)
        shape = N, len(candidates) // CANDIDATE_BLOCK
        gain, choice = np.full(shape, -np.inf), np.zeros(shape, np.int32)
        if level < settings.depth and N:
            kernel.best_splits(
                depths, crops, samples.image, samples.u, samples.v, samples.label, nodes,
                candidates, fx, fy, CANDIDATE_BLOCK, LEAST_SIDE_PIXELS,
                MOST_NODE_PIXELS, n_log_n, gain,
                choice,
            )  # fmt: skip
        best = gain.argmax(1)
        chosen = choice[np.arange(N), best]
        is_split = gain[np.arange(N), best] > 1e-6
        owner = np.repeat(np.arange(N), np.diff(nodes))

        at = np.where(is_split[:, None], candidates[chosen // kernel.THRESHOLD_BINS], 0.0).astype(
            np.float32
        )
        edge = np.where(is_split, kernel.threshold_m(chosen % kernel.THRESHOLD_BINS), 0.0).astype(
            np.float32
        )
        left = n_nodes + 2 * (np.cumsum(is_split) - 1)
        leaf = -1 - (n_leaves + np.cumsum(~is_split) - 1)
        offsets.append(at)
        thresholds.append(edge)
        children.append(np.where(is_split, left, leaf).astype(np.int32))
        leaves.append(_posteriors(samples.label, owner, N)[~is_split])
        n_leaves += int((~is_split).sum())
        n_nodes += 2 * int(is_split.sum())

        goes_on = np.flatnonzero(is_split[owner])
        samples, owner = samples[goes_on], owner[goes_on]
        value = np.empty(len(owner), np.float32)
        place = (chosen // kernel.THRESHOLD_BINS).astype(np.int32)[owner]
        kernel.differences(
            depths, crops, samples.image, samples.u, samples.v, place, candidates, fx, fy, value
        )
        rank = np.cumsum(is_split) - 1
        child = 2 * rank[owner] + (value > edge[owner])
        order = np.argsort(child, kind="stable")
        samples = samples[order]
        sizes = np.bincount(child, minlength=2 * int(is_split.sum()))
        nodes = np.append(0, np.cumsum(sizes)).astype(np.int64)
        on_level()
    return Trees(
        np.concatenate(offsets),
        np.concatenate(thresholds),
        np.concatenate(children),
        np.zeros(1, np.int32),
        np.concatenate(leaves),
    )


def _posteriors(label: NDArray[np.uint8], owner: NDArray[np.intp], nodes: int) -> NDArray[np.uint8]:
    """[N, K] shares of the classes among the samples of each node, in 1/255."""
    K = len(CLASSES)
    counts = np.bincount(owner * K + label, minlength=nodes * K).reshape(nodes, K)
    shares = counts / np.maximum(counts.sum(1, keepdims=True), 1)
    return np.rint(255.0 * shares).astype(np.uint8)
