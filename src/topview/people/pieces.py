"""Limbs that the depth image cuts off from their body: a hand stretched out at the camera hides
its own forearm, and a trunk the arm behind it but for the hand."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from topview.kernels.pieces import join_pieces, small_pieces
from topview.room.scene import Scene

Distance = NDArray[np.float32]


@dataclass(frozen=True, slots=True)
class PieceSettings:
    """Which loose pieces may be limbs; ours.

    Attributes:
        area_m2: a fist shows 0.008 m^2, and a forearm with its hand 0.06 m^2.
        gap_m: how far it is before or behind the body beside it in the picture; a forearm with its
            hand is 0.45 m long.
        lowest_m: above the floor, of what is behind: what reaches farther down stands on the floor,
            or is a foot. Where no floor is known nothing is taken that is behind.
        reach: from the head's centre, in statures, to the toes of a stretched leg.
    """

    area_m2: tuple[float, float] = (0.002, 0.07)
    gap_m: float = 0.45
    lowest_m: float = 0.3
    reach: float = 1.0


@dataclass(frozen=True, slots=True, eq=False)
class Pieces:
    """Small pieces that stand free, are nobody's body, and may be limbs.

    Attributes:
        scene: what is seen.
        settings: which may be limbs.
        labels: [h, w] number of each pixel's piece, whatever its size, 0 for none.
        count: of numbers, 0 included.
        pixels: flat indices of the small ones' pixels.
    """

    scene: Scene
    settings: PieceSettings
    labels: NDArray[np.int32]
    count: int
    pixels: NDArray[np.int32]

    @classmethod
    def of(cls, scene: Scene, is_somebodys: NDArray[np.bool_], settings: PieceSettings) -> Pieces:
        """`is_somebodys` [h, w]: what is a body already."""
        cloud = scene.cloud
        labels = np.empty(cloud.depth_m.shape, np.int32)
        pixels, count = small_pieces(
            scene.standing_px, is_somebodys, scene.is_bulky, cloud.depth_m, cloud.camera.fx,
            *settings.area_m2, labels,
        )  # fmt: skip
        return cls(scene, settings, labels, count, pixels)

    def join_to(
        self, body: Distance, head_camera: NDArray[np.float64], height_m: float, *, behind: bool
    ) -> None:
        """Add to a body [h, w] the pieces before it, or `behind` it as well, that touch it in the
        picture and are near enough; they are as far from the head as the straight line."""
        if not len(self.pixels):
            return
        scene, settings = self.scene, self.settings
        join_pieces(
            self.pixels,
            self.labels,
            self.count,
            scene.cloud.depth_m,
            scene.cloud.points_camera,
            scene.heights_m,
            head_camera.astype(np.float32),
            settings.reach * height_m,
            settings.gap_m,
            settings.lowest_m if behind and scene.floor is not None else np.inf,
            body,
        )
