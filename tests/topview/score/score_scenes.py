"""Random scenes, and one hand-made, that the score is counted in."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from topview.camera.pyramid import DepthView
from topview.geometry.quadrics import closed_cylinder_depths
from topview.geometry.rotations import transform
from topview.score.definition import Counts, Cylinder, count
from topview.score.utvr import Observed, UtvrTerms, placed_parts, score_hypotheses

FOCAL = 142.5
SHAPE = (120, 160)
TOLERANCE_M = 0.05
DISTANCE_M = 2.0


def view_of(depth_m: np.ndarray) -> DepthView:
    return DepthView(np.ascontiguousarray(depth_m, np.float32), FOCAL, FOCAL, 79.5, 59.5)


def rays() -> np.ndarray:
    """[H, W, 3], of `view_of`."""
    v, u = np.indices(SHAPE, np.float64)
    return np.stack([(u - 79.5) / FOCAL, (v - 59.5) / FOCAL, np.ones(SHAPE)], axis=-1)


def rendered(*cylinders: Cylinder) -> np.ndarray:
    """[H, W] depth, 0 where there is nothing."""
    depth = np.min(
        [
            closed_cylinder_depths(rays(), c.T_camera_part, c.length_m, *c.radii_m)
            for c in cylinders
        ],
        axis=0,
    )
    return np.where(np.isfinite(depth), depth, 0.0).astype(np.float32)


@dataclass(frozen=True)
class Scene:
    """M hypotheses of one size among points, a depth image and placed parts."""

    hypotheses: list[Cylinder]
    is_own: np.ndarray  # [H, W] whose pixels with a reading are the user's points
    view: DepthView
    placed: list[Cylinder]

    def defined(self) -> np.ndarray:
        """[M, 7] counts by the definition."""
        return np.array([self.defined_count(h) for h in self.hypotheses])

    def defined_count(self, hypothesis: Cylinder) -> Counts:
        origins = np.array([h.T_camera_part[:3, 3] for h in self.hypotheses])
        cell_m = self.view.cell_m(float(origins[:, 2].mean()))
        return count(hypothesis, self.points, self.view, self.placed, cell_m, TOLERANCE_M)

    @property
    def points(self) -> np.ndarray:
        """[N, 3] the user's."""
        return self.view.points(*np.nonzero(self.is_own & (self.view.depth_m > 0)))

    @property
    def observed(self) -> Observed:
        return Observed.of(self.view, self.is_own)

    def scored(self, threads: int = 1) -> UtvrTerms:
        """The same by the kernel."""
        Ts = np.array([h.T_camera_part for h in self.hypotheses])
        return score_hypotheses(
            Ts[:, :3, :3],
            Ts[:, :3, 3],
            self.hypotheses[0].length_m,
            np.array(self.hypotheses[0].radii_m),
            self.observed,
            placed_rows(self.placed),
            TOLERANCE_M,
            threads,
        )


def placed_rows(parts: list[Cylinder]) -> np.ndarray:
    Ts = np.array([p.T_camera_part for p in parts]).reshape(-1, 4, 4)
    return placed_parts(
        Ts[:, :3, :3],
        Ts[:, :3, 3],
        np.array([p.length_m for p in parts]),
        np.array([p.radii_m for p in parts]).reshape(-1, 2),
    )


def random_pose(rng: np.random.Generator, spread_m: float) -> np.ndarray:
    """[4, 4] rounded to float32, about two metres ahead."""
    origin = np.array([0.0, 0.0, DISTANCE_M]) + rng.uniform(-spread_m, spread_m, 3)
    T = transform(Rotation.from_quat(rng.normal(size=4)).as_matrix(), origin)
    return T.astype(np.float32).astype(np.float64)


def random_scene(seed: int, hypotheses: int = 12) -> Scene:
    """A part, something in front of it, a wall behind with holes, and placed parts that overlap."""
    rng = np.random.default_rng(seed)
    length = float(np.float32(rng.uniform(0.2, 0.5)))
    radii = (float(np.float32(rng.uniform(0.04, 0.18))), float(np.float32(rng.uniform(0.04, 0.18))))
    truth = Cylinder(random_pose(rng, 0.1), length, radii)
    depth = rendered(truth)
    is_own = depth > 0
    depth[depth == 0] = np.float32(2.6)
    depth[:, rng.integers(60, 100) :][:, :8] = np.float32(1.4)
    depth += rng.normal(0.0, 0.02, SHAPE).astype(np.float32)
    depth[rng.random(SHAPE) < 0.1] = 0.0
    tried = [Cylinder(random_pose(rng, 0.15), length, radii) for _ in range(hypotheses - 1)]
    placed = [Cylinder(random_pose(rng, 0.1), 0.25, (0.1, 0.08)) for _ in range(3)]
    return Scene([truth, *tried], is_own, view_of(depth), placed)
