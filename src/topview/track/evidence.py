"""What one frame shows of one user, prepared once for every step of a body tracker."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.camera.pyramid import DepthView, Pyramid
from topview.detect.joints.proposals import JointProposals
from topview.kernels.normals import surface_normals
from topview.kernels.windows import nearest_in_rows, own_points
from topview.people.users import HandCandidate, User
from topview.records import KINECT1_NOISE, Camera, DepthNoise
from topview.room.floor import CAMERA_UP, FloorPlane
from topview.score.utvr import Observed
from topview.track.pose import FittedBody

# All ours.
WORKING_SPACING_M: Final = 0.008  # between neighbouring points, which the thinned image comes near
NEAREST_USER_M: Final = 0.3  # a user counts as no nearer to the camera when the image is thinned
NEAREST_PLACE_M: Final = 0.1  # a place counts as no nearer to the camera when it is projected
OCCLUDER_MARGIN_M: Final = 0.05  # what is nearer than a surface by more than this occludes it
MAX_REFINEMENT_POINTS: Final = 600  # more did not make the pose better
FIRST_LOOK_POINTS: Final = 330  # enough to tell which of many poses are worth refining


@dataclass(frozen=True, slots=True, eq=False)
class NearestPixels:
    """Which of a user's pixels are nearest, row by row, in a window round all of them;
    `topview.kernels.body.nearest_own` tells from it which is nearest to a place in the image.

    Attributes:
        columns: [h, w] int32, column in the image of the user's pixel nearest to each pixel of the
            window in its row; -1 for none.
        corner: row and column of the window's first pixel.
    """

    columns: NDArray[np.int32]
    corner: tuple[int, int]

    @classmethod
    def of(
        cls, mask: NDArray[np.bool_], top: int, bottom: int, left: int, right: int
    ) -> NearestPixels:
        """Of [H, W] a mask that is set in some of the rows top to bottom and columns left to right,
        ends left out, and nowhere else."""
        if bottom <= top:
            return cls(np.full((1, 1), -1, np.int32), (0, 0))
        columns = np.empty((bottom - top, right - left), np.int32)
        nearest_in_rows(mask, top, left, columns)
        return cls(columns, (top, left))


@dataclass(frozen=True, slots=True, eq=False)
class Evidence:
    """One user in one frame; images are at the working resolution.

    Attributes:
        timestamp_s: of the frame.
        stride: full pixels from one pixel of these images to the next.
        view: the scene's depth.
        user_mask: [H, W] bool, pixels of the user.
        nearest: which of the user's pixels are nearest to where.
        coarse_view: the scene's depth at half the resolution.
        all_points_camera: [A, 3] the user's points, metres.
        pixels: [A] int32, flat indices of them into these images.
        points_camera: [N, 3] every n-th of them, for refinement.
        normals_camera: [N, 3] which way the surface there faces, towards the camera; zeros where
            that is not known, or not asked (`with_normals`).
        point_area_m2: surface that one of `points_camera` stands for, seen face on.
        head_camera, head_is_seen: the head's centre in metres, and whether it was measured.
        head_sigma_m: standard deviation of it along each axis, metres.
        noise: of the depth.
        stature_m: as measured; None while nobody could measure it.
        floor: [4] upward normal and height of the camera over the floor in metres; zeros for none.
        hidden_share: of the user's image area, by nearer users (Sec. 5.1.3); 0 for methods that
            do not need it.
        unowned_mask: [H, W] bool, pixels that belong to no user; None for methods that do not need
            it.
        nearer_bodies: the fitted bodies of nearer people, nearest first.
        hands: candidates from colour, of any person.
        face_share: share of the recent time in which the face was seen to look at the camera, 0 to
            1; None if unknown.
        proposals: of the user's joints, P = 1; None for methods that do not need them, where there
            is nothing that proposes joints, and where it sees too little of the user.
    """

    timestamp_s: float
    stride: int
    view: DepthView
    user_mask: NDArray[np.bool_]
    nearest: NearestPixels
    coarse_view: DepthView
    all_points_camera: NDArray[np.float64]
    pixels: NDArray[np.int32]
    points_camera: NDArray[np.float64]
    normals_camera: NDArray[np.float64]
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
    proposals: JointProposals | None = None
    head_sigma_m: float = 0.0
    noise: DepthNoise = KINECT1_NOISE

    def observed(self, is_coarse: bool) -> Observed:
        """The scene and the user's points, at half the resolution if `is_coarse`."""
        if is_coarse:
            return Observed.of(self.coarse_view, self.user_mask[::2, ::2])
        return Observed.of(self.view, self.user_mask)

    def thinned(self) -> Evidence:
        """With fewer points for refinement, for a first look."""
        step = max(1, -(-len(self.points_camera) // FIRST_LOOK_POINTS))
        return replace(
            self,
            points_camera=np.ascontiguousarray(self.points_camera[::step]),
            normals_camera=np.ascontiguousarray(self.normals_camera[::step]),
            point_area_m2=self.point_area_m2 * step,
        )

    def without(self, is_others: NDArray[np.bool_]) -> Evidence:
        """With [H, W] pixels that are somebody or something else, not the user."""
        mask = self.user_mask & ~is_others
        is_own = mask.ravel()[self.pixels]
        is_kept = is_own[:: _points_step(len(self.pixels))]
        rows, columns = np.flatnonzero(mask.any(1)), np.flatnonzero(mask.any(0))
        top, left = (int(ends[0]) if len(ends) else 0 for ends in (rows, columns))
        bottom, right = (int(ends[-1]) + 1 if len(ends) else 0 for ends in (rows, columns))
        return replace(
            self,
            user_mask=mask,
            nearest=NearestPixels.of(mask, top, bottom, left, right),
            all_points_camera=self.all_points_camera[is_own],
            pixels=self.pixels[is_own],
            points_camera=self.points_camera[is_kept],
            normals_camera=self.normals_camera[is_kept],
        )

    def with_normals(self) -> Evidence:
        """With the normals of `points_camera`."""
        view, normals_camera = self.view, np.empty_like(self.points_camera)
        surface_normals(
            self.points_camera, view.depth_m, self.user_mask,
            view.fx, view.fy, view.cx, view.cy, normals_camera,
        )  # fmt: skip
        return replace(self, normals_camera=normals_camera)

    @property
    def up_camera(self) -> NDArray[np.float64]:
        """[3] unit vector: the floor's normal, or the camera's own up where no floor is known."""
        return self.floor[:3] if self.floor.any() else CAMERA_UP

    @property
    def seen_m2(self) -> float:
        """Surface of the user that is seen, face on."""
        return len(self.points_camera) * self.point_area_m2

    def above_floor_m(self, points_camera: NDArray[np.float64]) -> NDArray[np.float64]:
        """[...] how high above a floor that is known [..., 3] points are, metres."""
        return points_camera @ self.floor[:3] + self.floor[3]

    def is_on_user(self, point_camera: NDArray[np.float64]) -> bool:
        """Whether a [3] point lies, in the image, on the user."""
        if point_camera[2] <= NEAREST_PLACE_M:
            return False
        (row,), (column,), (is_inside,) = self.view.nearest_pixels(
            point_camera[None], NEAREST_PLACE_M
        )
        return bool(is_inside and self.user_mask[row, column])

    def is_in_image(self, places_camera: NDArray[np.float64]) -> NDArray[np.bool_]:
        """[N] whether places [N, 3], metres, lie inside of the image's edges."""
        return self.view.nearest_pixels(places_camera, NEAREST_PLACE_M)[2]

    def out_of_sight(
        self, places_camera: NDArray[np.float64], radius_m: float
    ) -> NDArray[np.bool_]:
        """[N] whether places [N, 3] are outside of the image, or behind something that is not the
        user.

        Args:
            places_camera: metres, inside the body.
            radius_m: from the places to the body's surface.
        """
        rows, columns, is_inside = self.view.nearest_pixels(places_camera, NEAREST_PLACE_M)
        surface_m = np.maximum(places_camera[:, 2], NEAREST_PLACE_M) - radius_m
        seen = self.view.depth_m[rows, columns]
        is_behind = (seen > 0) & (seen < surface_m - OCCLUDER_MARGIN_M)
        return ~is_inside | (is_behind & ~self.user_mask[rows, columns])


def _points_step(count: int) -> int:
    """Every so many-th of all the user's points is one for refinement."""
    return max(1, -(-count // MAX_REFINEMENT_POINTS))


def working_stride(camera: Camera, distance_m: float) -> int:
    """The stride at which neighbouring points at this distance lie about `WORKING_SPACING_M`
    apart."""
    return max(
        1, round(WORKING_SPACING_M * min(camera.fx, camera.fy) / max(distance_m, NEAREST_USER_M))
    )


def gather(
    user: User,
    image: Pyramid,
    labels: NDArray[np.int32],
    floor: FloorPlane | None,
    *,
    with_unowned_mask: bool = False,
    hidden_share: float = 0.0,
    hands: tuple[HandCandidate, ...] = (),
    nearer_bodies: tuple[FittedBody, ...] = (),
    proposals: JointProposals | None = None,
) -> Evidence:
    """The evidence for one user, from the image thinned to what the user's distance needs.

    Args:
        user: whose.
        image: the whole frame.
        labels: [H, W] id of the user that each pixel belongs to, 0 for nobody.
        floor: None where none is known.
        with_unowned_mask: whether that mask is wanted.
        hidden_share, hands, nearer_bodies, proposals: as in `Evidence`.
    """
    frame = image.frame
    stride = working_stride(frame.camera, float(user.head_camera[2]))
    view = image.view(stride)
    user_mask = np.zeros(view.depth_m.shape, np.bool_)
    points = np.empty((len(user.pixels), 3))
    pixels = np.empty(len(user.pixels), np.int32)
    count, distance_m, top, bottom, left, right = own_points(
        user.pixels, labels, user.id, view.depth_m, stride, (view.fx, view.fy, view.cx, view.cy),
        user_mask, points, pixels,
    )  # fmt: skip
    points, pixels = points[:count], pixels[:count]
    step = _points_step(count)
    thinned = np.ascontiguousarray(points[::step])
    return Evidence(
        timestamp_s=frame.timestamp_s,
        stride=stride,
        view=view,
        user_mask=user_mask,
        nearest=NearestPixels.of(user_mask, top, bottom, left, right),
        coarse_view=image.view(2 * stride),
        all_points_camera=points,
        pixels=pixels,
        points_camera=thinned,
        normals_camera=np.zeros_like(thinned),
        point_area_m2=step * distance_m**2 / (view.fx * view.fy),
        head_camera=user.head_camera,
        head_is_seen=user.head_is_seen,
        stature_m=user.height_m if user.height_is_measured else None,
        floor=np.zeros(4) if floor is None else np.append(floor.normal_camera, floor.distance_m),
        hidden_share=hidden_share,
        unowned_mask=labels[::stride, ::stride] == 0 if with_unowned_mask else None,
        nearer_bodies=nearer_bodies,
        hands=hands,
        face_share=user.face_share,
        proposals=proposals,
        head_sigma_m=user.head_sigma_m,
        noise=frame.camera.noise,
    )
