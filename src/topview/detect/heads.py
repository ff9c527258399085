"""Head candidates, which every detector gives, and the detector that needs depth alone.

A head is a top of head size with free space above it and at its sides, over shoulders that are
wider than a neck or an arm. That holds from every side, standing or seated; below a raised fist
there is only an arm.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import sqrt
from typing import Final

import msgspec
import numpy as np
from numpy.typing import NDArray

from topview.detect.cloud import Cloud
from topview.kernels.heads import (
    confidences,
    find_heads,
    median_about,
    unread_shares,
)
from topview.records import check_range

Vector = NDArray[np.float64]

# Half an adult head's mean breadth and length: 15 cm x 19 cm (NASA-STD-3000, vol. I, sec. 3).
HEAD_RADIUS_M: Final = 0.085
# Half its height, chin to crown: 22 cm (same source).
HEAD_HALF_HEIGHT_M: Final = 0.11
# A visible half sphere lies 2/3 of its radius in front of its centre, on average over the image.
CENTER_BEHIND_SURFACE_M: Final = 2 / 3 * HEAD_RADIUS_M


class HeadCandidate(msgspec.Struct, frozen=True, eq=False):
    """A detected head.

    Attributes:
        center_camera: [3] metres, the centre of the head.
        confidence: 0..1.
        torso_is_unread: there is no reading at all where its torso would be. The confidence then
            leaves the torso out; legs below must confirm the head.
        by_face: how much of the confidence comes from a face. Wood, too, may have the colour of
            skin.
    """

    center_camera: Vector
    confidence: float
    torso_is_unread: bool = False
    by_face: float = 0.0

    @property
    def place(self) -> list[float]:
        """The centre, as `math.dist` takes it at once."""
        return self.center_camera.tolist()

    @property
    def by_shape(self) -> float:
        """The confidence by its shape alone."""
        return self.confidence - self.by_face


@dataclass(frozen=True, slots=True, eq=False)
class Hints:
    """What is known before heads are detected.

    Attributes:
        heads_camera: [3] metres each, predicted centres of known people's heads.
        is_candidate: [h, w] pixels of the cloud that may be a person's; all if None.
    """

    heads_camera: Sequence[Vector] = ()
    is_candidate: NDArray[np.bool_] | None = None


NO_HINTS: Final = Hints()


# Ours: the depths of a head lie between these before and behind its centre's, besides two standard
# deviations of the noise; a chest may lie further back, as people lean forward.
BEFORE_M: Final = 0.20
BEHIND_M: Final = 0.12
CHEST_BEHIND_M: Final = 0.30


def _grid(*rows: tuple[float, tuple[float, ...]]) -> NDArray[np.float64]:
    return np.array([(right, up) for up, rights in rows for right in rights])


# Where the template looks, in metres right of and above the head's centre; all ours, from the
# sizes of a grown head and from shoulder breadths of 0.26 of statures from 1.1 m to 2 m; across
# the shoulders also for a person seen from the side, whose chest is 20 cm to 25 cm deep.
INSIDE: Final = _grid(
    (0.08, (-0.035, 0.0, 0.035)),
    (0.04, (-0.055, 0.0, 0.055)),
    (0.0, (-0.06, 0.0, 0.06)),
    (-0.05, (-0.045, 0.0, 0.045)),
)
FREE: Final = _grid(
    (0.20, (-0.08, 0.0, 0.08)),
    (0.15, (-0.15, 0.15)),
    (0.08, (-0.18, 0.18)),
    (0.0, (-0.18, 0.18)),
    (-0.06, (-0.18, 0.18)),
)
SHOULDERS: Final = _grid(
    (-0.24, (-0.10, -0.05, 0.0, 0.05, 0.10)),
    (-0.32, (-0.13, -0.065, 0.0, 0.065, 0.13)),
    (-0.42, (-0.13, -0.065, 0.0, 0.065, 0.13)),
)


def right_of(up_camera: Vector) -> Vector:
    """[3] the image's right, across `up_camera` [3]."""
    x, y, _ = up_camera.tolist()
    length = float(np.hypot(x, y))
    return np.array([-y / length, x / length, 0.0])


# Ours: the share of shoulders that is taken to be there where they are occluded.
OCCLUDED_SHOULDERS: Final = 0.75


def tilted_ups(up_camera: Vector, angles_rad: NDArray[np.float64]) -> Vector:
    """[T, 3] the directions at each of [T] angles to the image's right of up."""
    across = np.sin(angles_rad)[:, None] * right_of(up_camera)
    return np.cos(angles_rad)[:, None] * up_camera + across


def head_confidences(
    cloud: Cloud, centers_camera: Vector, ups_camera: Vector, upright: NDArray[np.float64]
) -> NDArray[np.float64]:
    """[N] how well the depth image around each of [N, 3] centres fits the template of a head that
    stands along the best of `ups_camera`, [T, 3], which count for `upright`, [T]; 0..1."""
    camera = cloud.camera
    return confidences(
        cloud.depth_m,
        (camera.fx, camera.fy),
        (camera.cx, camera.cy),
        centers_camera,
        ups_camera,
        upright,
        (INSIDE, FREE, SHOULDERS),
        (BEFORE_M, BEHIND_M, CHEST_BEHIND_M),
        camera.noise.times(2.0),
        OCCLUDED_SHOULDERS,
    )


def upright_confidence(cloud: Cloud, center_camera: Vector, up_camera: Vector) -> float:
    """Of one head, [3], that stands along [3]."""
    centers, ups = np.array(center_camera, ndmin=2), np.array(up_camera, ndmin=2)
    return float(head_confidences(cloud, centers, ups, np.ones(1))[0])


# Ours: a torso in black cloth absorbs the infrared light, but a zip or a hand may have a reading.
# It is unread if this share of it has none.
UNREAD_SHARE: Final = 0.75


def torso_is_unread(cloud: Cloud, centers_camera: Vector, ups_camera: Vector) -> NDArray[np.bool_]:
    """[N] whether there is no reading, neither of a chest nor of anything before or behind it,
    where the shoulders and the chest under [N, 3] heads, upright along [N, 3], would be."""
    camera = cloud.camera
    focal_px, principal_px = (camera.fx, camera.fy), (camera.cx, camera.cy)
    shares = unread_shares(
        cloud.depth_m, focal_px, principal_px, centers_camera, ups_camera, SHOULDERS
    )
    return shares >= UNREAD_SHARE


# Ours: people lean to the side; the template is tilted with them, at this penalty per radian.
TILTS_RAD: Final = np.array([-0.5, 0.0, 0.5])
TILT_PENALTY: Final = 0.15
TILT_SHARES: Final = 1.0 - TILT_PENALTY * np.abs(TILTS_RAD)
# Ours: the centres of two heads are at least two heads' breadths apart.
LEAST_APART_M: Final = 4 * HEAD_RADIUS_M
# Ours: the near shoulder of a person in profile looks like a head. The true head is above it by
# these metres (from, to), aside by at most this, and behind it by at least this.
ABOVE_SHOULDER_M: Final = (0.15, 0.45)
ASIDE_SHOULDER_M: Final = 0.3
BEHIND_SHOULDER_M: Final = 0.04
# Ours: the pixel above a head is further away by more than this.
STEP_M: Final = 0.12
# Ours: a candidate's centre is the centre of a surface if its depth differs by less than this.
SURFACE_M: Final = 0.2
# Ours: a head is the mean of those of its candidates that have more than this share of the best
# one's confidence.
LIKE_SHARE: Final = 0.9


@dataclass(frozen=True, slots=True)
class DepthHeadDetector:
    """Detects heads by their shape in the depth image.

    Attributes:
        min_confidence: candidates below it are not reported; 0 to 1.
        max_depth_m: further away a head is only noise; 0.5 to 100 metres.

    Raises:
        InputError: a value out of range.
    """

    min_confidence: float = 0.6
    max_depth_m: float = 7.0

    def __post_init__(self) -> None:
        check_range(self, 0.0, 1.0, "min_confidence")
        check_range(self, 0.5, 100.0, "max_depth_m")

    @property
    def needs_color(self) -> bool:
        return False

    @property
    def colors(self) -> None:
        """None: it uses depth alone."""

    def detect(
        self, cloud: Cloud, up_camera: Vector, hints: Hints = NO_HINTS
    ) -> list[HeadCandidate]:
        """Heads in the frame, best first; the hints are not used."""
        camera = cloud.camera
        centers, confidence, lone_centers, alone = find_heads(
            cloud.depth_m,
            cloud.points_camera,
            (camera.fx, camera.fy),
            (camera.cx, camera.cy),
            up_camera,
            tilted_ups(up_camera, TILTS_RAD),
            TILT_SHARES,
            (self.max_depth_m, STEP_M, HEAD_HALF_HEIGHT_M, SURFACE_M),
            (INSIDE, FREE, SHOULDERS),
            (BEFORE_M, BEHIND_M, CHEST_BEHIND_M),
            camera.noise.times(2.0),
            OCCLUDED_SHOULDERS,
            self.min_confidence,
            UNREAD_SHARE,
            (ABOVE_SHOULDER_M, ASIDE_SHOULDER_M, BEHIND_SHOULDER_M),
            (LEAST_APART_M, HEAD_RADIUS_M, LIKE_SHARE),
        )
        heads = [HeadCandidate(*head) for head in zip(centers, confidence.tolist(), strict=True)]
        return heads + [
            HeadCandidate(center, share, torso_is_unread=True)
            for center, share in zip(lone_centers, alone.tolist(), strict=True)
            if all(_length(center - head) > LEAST_APART_M for head in centers)
        ]


def refine_center(cloud: Cloud, center_camera: Vector, up_camera: Vector) -> Vector | None:
    """[3] a head centred on the median of the points around it; None where there are none."""
    surface, count = median_near(
        cloud,
        center_camera,
        up_camera,
        1.5 * HEAD_HALF_HEIGHT_M,
        HEAD_HALF_HEIGHT_M,
        1.5 * HEAD_RADIUS_M,
    )
    if not count:
        return None
    return center_behind(surface)


def center_behind(surface_camera: Vector) -> Vector:
    """[3] the centre of a head, from the middle of its visible surface, [3]."""
    return surface_camera * (1.0 + CENTER_BEHIND_SURFACE_M / _length(surface_camera))


def _length(vector: Vector) -> float:
    """Of [3], as `np.linalg.norm` has it, which takes longer to be called."""
    return sqrt(vector.dot(vector))


def median_near(
    cloud: Cloud,
    center_camera: Vector,
    up_camera: Vector,
    radius_m: float,
    half_height_m: float = np.inf,
    across_m: float = np.inf,
) -> tuple[Vector, int]:
    """[3] median of the cloud's points within a ball, and in an upright cylinder about the same
    centre; and how many there are."""
    median = np.zeros(3)
    if center_camera[2] <= 0.0:
        return median, 0
    camera = cloud.camera
    count = median_about(
        cloud.points_camera,
        (camera.fx, camera.fy),
        (camera.cx, camera.cy),
        center_camera,
        up_camera,
        radius_m,
        half_height_m,
        across_m,
        median,
    )
    return median, count
