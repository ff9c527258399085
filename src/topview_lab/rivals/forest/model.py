"""The forest: its trees as flat arrays, and the file that holds them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from io import BytesIO
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.body.parts import JOINT_NAMES
from topview.files import naming, read_archive
from topview.records import InputError, read_only
from topview_lab.kernels import forest as kernel
from topview_lab.rivals.forest.classes import CLASSES

Floats = NDArray[np.float32]

DEFAULT_FOREST: Final = Path(__file__).parent / "data" / "forest.npz"
VERSION: Final = 1
"""Of the file; to be raised when features, classes or what is learnt of joints change."""


@dataclass(frozen=True, slots=True, eq=False)
class Trees:
    """T trees of N nodes and L leaves in all.

    Attributes:
        offsets: [N, 4] float32 (x, y) of both probes of a node, metres; zeros in leaves.
        thresholds: [N] float32 metres; what is above goes right.
        children: [N] int32 the left child, with the right one after it; -1 - leaf for a leaf.
        roots: [T] int32.
        leaves: [L, K] uint8 probabilities of `CLASSES`, in 1/255.
    """

    offsets: Floats
    thresholds: Floats
    children: NDArray[np.int32]
    roots: NDArray[np.int32]
    leaves: NDArray[np.uint8]

    def __post_init__(self) -> None:
        nodes, leaves = len(self.children), len(self.leaves)
        inner = self.children >= 0
        is_sound = (
            self.offsets.shape == (nodes, 4)
            and self.thresholds.shape == (nodes,)
            and self.leaves.ndim == 2
            and len(self.roots) > 0
            and 0 <= self.roots.min() <= self.roots.max() < nodes
            # children come after their parents, so that every walk ends
            and (self.children[inner] > np.flatnonzero(inner)).all()
            and (self.children < nodes - 1).all()
            and (-1 - self.children[~inner] < leaves).all()
        )
        if not is_sound:
            raise InputError("its trees lead nowhere; it must be a whole file")
        for name in self.__dataclass_fields__:
            read_only(getattr(self, name))

    def classify(
        self, body_depth_m: Floats, pixels: NDArray[np.int32], focal_px: tuple[float, float]
    ) -> Floats:
        """[S, K] probabilities of the classes at pixels [2, S] (columns, rows) of a person's depth
        image (`person_depth`)."""
        out = np.empty((pixels.shape[1], self.leaves.shape[1]), np.float32)
        fx, fy = map(np.float32, focal_px)
        kernel.classify(
            np.ascontiguousarray(body_depth_m), pixels[0], pixels[1], fx, fy, self.offsets,
            self.thresholds, self.children, self.roots, self.leaves, out,
        )  # fmt: skip
        return out

    @classmethod
    def joined(cls, trees: list[Trees]) -> Trees:
        """Many trees as one record."""
        nodes = np.cumsum([0, *(len(tree.children) for tree in trees)])
        leaves = np.cumsum([0, *(len(tree.leaves) for tree in trees)])
        children = [
            np.where(tree.children >= 0, tree.children + nodes[t], tree.children - leaves[t])
            for t, tree in enumerate(trees)
        ]
        return cls(
            np.concatenate([tree.offsets for tree in trees]),
            np.concatenate([tree.thresholds for tree in trees]),
            np.concatenate(children).astype(np.int32),
            np.concatenate([tree.roots + nodes[t] for t, tree in enumerate(trees)]).astype(
                np.int32
            ),
            np.concatenate([tree.leaves for tree in trees]),
        )


@dataclass(frozen=True, slots=True, eq=False)
class Forest:
    """A trained forest.

    Attributes:
        trees: classify pixels.
        depths_m: [J] how far each joint of `topview.body.JOINT_NAMES` lies behind the surface,
            along the ray: zeta of Shotton et al.
        areas_m2: [J] the area of votes for a joint at which the confidence is one half.
        trained_on: the data, in words; written by `topview train-forest`.
    """

    trees: Trees
    depths_m: Floats
    areas_m2: Floats
    trained_on: str

    def __post_init__(self) -> None:
        for name in ("depths_m", "areas_m2"):
            array = read_only(getattr(self, name))
            if array.shape != (len(JOINT_NAMES),):
                raise InputError(
                    f"{name} is {array.shape}; it must be of {len(JOINT_NAMES)} joints"
                )

    @classmethod
    def load(cls, path: Path = DEFAULT_FOREST) -> Forest:
        """Read what `topview train-forest` wrote.

        Raises:
            InputError: no such file, one of another version, or something else.
        """
        right = "it must be written by `topview train-forest`"
        with naming(path, right=right):
            file = read_archive(path, right)
            try:
                version = int(file["version"])
                if version != VERSION:
                    raise InputError(f"is of version {version}, not {VERSION}; {right}, again")
                if tuple(file["classes"]) != CLASSES:
                    raise InputError(f"tells other body parts apart; {right}, again")
                trees = Trees(
                    file["offsets_mm"].astype(np.float32) / np.float32(1000.0),
                    kernel.threshold_m(file["bins"]),
                    file["children"].astype(np.int32),
                    file["roots"].astype(np.int32),
                    file["leaves"].astype(np.uint8),
                )
                depths_m, areas_m2 = file["depths_m"], file["areas_m2"]
                return cls(trees, depths_m, areas_m2, str(file["trained_on"]))
            except InputError:  # which is a ValueError, too
                raise
            except (KeyError, TypeError, ValueError):
                raise InputError(f"holds no forest; {right}") from None

    def npz(self) -> bytes:
        """A compressed .npz file: offsets in whole millimetres, thresholds as their bins."""
        trees = self.trees
        thresholds = kernel.threshold_m(np.arange(kernel.THRESHOLD_BINS))
        bins = np.abs(trees.thresholds[:, None] - thresholds).argmin(1)
        file = BytesIO()
        np.savez_compressed(
            file,
            version=np.array(VERSION),
            classes=np.array(CLASSES),
            offsets_mm=np.rint(1000.0 * trees.offsets).astype(np.int16),
            bins=bins.astype(np.uint8),
            children=trees.children,
            roots=trees.roots,
            leaves=trees.leaves,
            depths_m=self.depths_m,
            areas_m2=self.areas_m2,
            trained_on=np.array(self.trained_on),
        )
        return file.getvalue()


@cache
def default_forest() -> Forest:
    """The forest that comes with the project: `topview train-forest --out` with its defaults."""
    return Forest.load()


def person_depth(depth_m: Floats, is_body: NDArray[np.bool_]) -> Floats:
    """[H, W] depth of one person alone: `BACKGROUND_M` everywhere else."""
    return np.where(is_body & (depth_m > 0.0), depth_m, kernel.BACKGROUND_M).astype(np.float32)
