"""What one frame says about one user, prepared once for every step of the tracker."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from topview.camera.pyramid import DepthView, Pyramid
from topview.people.floor import FloorPlane
from topview.people.users import HandCandidate, User
from topview.records import Camera
from topview.track.pose import FittedBody

WORKING_SPACING_M = 0.008  # the image is thinned while neighbours stay nearer than this; ours
CAMERA_UP = np.array([0.0, -1.0, 0.0])
HIDES_M = 0.05  # what is nearer by this hides; ours
MAX_REFINEMENT_POINTS = 1000  # ours: more did not make the pose better


Columns = tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.float32]]


@dataclass(frozen=True, slots=True, eq=False)
class Evidence:
    """A user in one frame; images are at the working resolution.

    Attributes:
        frame_index, timestamp_s: of the frame.
        stride: full pixels per pixel of these images.
        view: the scene's depth.
        user_mask: [H, W] bool, pixels of the user.
        nearest: [H, W] int32, flat index of the user's pixel nearest to each pixel; -1 for none.
        coarse_view: the scene's depth at half the resolution.
        all_points_camera: [A, 3] the user's points, metres.
        is_coarse: [A] which of them are in `coarse_view`.
        points_camera: [N, 3] an even choice of them, for refinement.
        point_area_m2: surface that one of `points_camera` stands for, seen face on.
        head_camera, head_is_seen: the head's centre in metres, and whether it was measured.
        stature_m: as measured; None while nobody could measure it.
        floor: [4] upward normal and height of the camera over the floor in metres; zeros for none.
        hidden_share: of the user's image area, by nearer users (Sec. 5.1.3); 0 where nobody asked.
        unowned_mask: [H, W] bool, pixels that belong to no user; None where not asked for.
        nearer_bodies: of people who stand before, fitted already, nearest first.
        hands: where detectors that see colour take the hands to be, whosesoever they are.
        face_share: how much of late the face has been seen to look at the camera, None if unknown.
    """

    frame_index: int
    timestamp_s: float
    stride: int
    view: DepthView
    user_mask: NDArray[np.bool_]
    nearest: NDArray[np.int32]
    coarse_view: DepthView
    all_points_camera: NDArray[np.float64]
    is_coarse: NDArray[np.bool_]
    points_camera: NDArray[np.float64]
    point_area_m2: float
    head_camera: NDArray[np.float64]
    head_is_seen: bool
    stature_m: float | None
    floor: NDArray[np.float64]
    hidden_share: float = 0.0
    unowned_mask: NDArray[np.bool_] | None = None
    hands: tuple[HandCandidate, ...] = ()
    nearer_bodies: tuple[FittedBody, ...] = ()
    face_share: float | None = None

    @property
    def up_camera(self) -> NDArray[np.float64]:
        """[3] unit vector: the floor's normal, or the camera's own up where no floor is known."""
        return self.floor[:3] if self.floor.any() else CAMERA_UP

    def is_on_user(self, point_camera: NDArray[np.float64]) -> bool:
        """Whether a [3] point lies, in the image, on the user."""
        x, y, z = point_camera.tolist()
        if z <= 0.1:
            return False
        u, v = (
            round(self.view.fx * x / z + self.view.cx),
            round(self.view.fy * y / z + self.view.cy),
        )
        height, width = self.user_mask.shape
        return 0 <= u < width and 0 <= v < height and bool(self.user_mask[v, u])

    def out_of_sight(
        self, places_camera: NDArray[np.float64], radius_m: float
    ) -> NDArray[np.bool_]:
        """[N] whether places [N, 3], so far below the skin, lie behind something that is not the
        user, or outside of the image."""
        x, y, z = places_camera.T
        z = np.maximum(z, 0.1)
        u = np.rint(self.view.fx * x / z + self.view.cx).astype(int)
        v = np.rint(self.view.fy * y / z + self.view.cy).astype(int)
        height, width = self.user_mask.shape
        inside = (u >= 0) & (v >= 0) & (u < width) & (v < height)
        u, v = np.where(inside, u, 0), np.where(inside, v, 0)
        seen = self.view.depth_m[v, u]
        is_behind = (seen > 0) & (seen < z - radius_m - HIDES_M) & ~self.user_mask[v, u]
        return ~inside | is_behind


def working_stride(camera: Camera, nearest_m: float) -> int:
    """By how much to thin the image so that neighbouring points lie `WORKING_SPACING_M` apart."""
    return max(1, round(WORKING_SPACING_M * min(camera.fx, camera.fy) / max(nearest_m, 0.3)))


def gather(
    user: User, image: Pyramid, is_users: NDArray[np.bool_], floor: FloorPlane | None
) -> Evidence:
    """The evidence for one user, from the image thinned to what the user's distance needs.

    Args:
        user: who.
        image: the whole frame.
        is_users: [H, W] pixels that are the user's.
        floor: None where none is known.
    """
    frame = image.frame
    stride = working_stride(frame.camera, float(user.head_camera[2]))
    view = image.view(stride)
    user_mask = is_users[::stride, ::stride] & (view.depth_m > 0.0)
    pixels = np.flatnonzero(user_mask)
    z = view.depth_m.ravel()[pixels].astype(np.float64)
    v = pixels // user_mask.shape[1]
    u = pixels - v * user_mask.shape[1]
    points = np.stack([(u - view.cx) * z / view.fx, (v - view.cy) * z / view.fy, z], axis=1)
    step = max(1, -(-len(points) // MAX_REFINEMENT_POINTS))
    distance = float(np.median(z)) if len(z) else 1.0
    return Evidence(
        frame.index,
        frame.timestamp_s,
        stride,
        view,
        user_mask,
        nearest_pixels(user_mask),
        image.view(2 * stride),
        points,
        (v % 2 == 0) & (u % 2 == 0),
        np.ascontiguousarray(points[::step]),
        step * distance**2 / (view.fx * view.fy),
        user.head_camera,
        user.head_is_seen,
        user.height_m if user.height_is_measured else None,
        np.zeros(4) if floor is None else np.append(floor.normal_camera, floor.distance_m),
        face_share=user.face_share,
    )


def nearest_pixels(mask: NDArray[np.bool_]) -> NDArray[np.int32]:
    """[H, W] flat index of the set pixel nearest to each pixel, -1 everywhere if none is set."""
    if not mask.any():
        return np.full(mask.shape, -1, np.int32)
    _, labels = cv2.distanceTransformWithLabels(
        (~mask).view(np.uint8), cv2.DIST_L2, 3, labelType=cv2.DIST_LABEL_PIXEL
    )
    labels = np.asarray(labels, np.int32)
    pixels = np.flatnonzero(mask)
    index_of = np.zeros(labels.max() + 1, np.int32)
    index_of[labels.ravel()[pixels]] = pixels
    return np.take(index_of, labels, mode="clip")  # none is out of range; this is faster


def columns(points_camera: NDArray[np.float64]) -> Columns:
    """[N, 3] to x, y and z, as the kernels want them."""
    x, y, z = np.ascontiguousarray(points_camera.T, np.float32)
    return x, y, z
