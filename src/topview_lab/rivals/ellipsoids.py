"""The thesis's first attempt at the upper body (Sec. 2.2, Fig. 2.3), as a baseline.

Shoulders are found where the silhouette's contour is most curved; they separate the points of torso
and arms, to which ellipsoids of the model's size are fitted, by their pseudo-distance. Shoulders
are spheres. The thesis gives only this outline. It does not say how a shoulder is distinguished
from other bends of the contour, how the points are assigned, what the pseudo-distance is, what
happens to a hidden shoulder or arm, or where sizes and the head come from. All numbers and these
decisions are ours: sizes are the model's, the head is the detected one, and a hidden part keeps its
pose in the torso's frame. The person is assumed to face the camera at first.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Final

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d
from scipy.optimize import least_squares

from topview.body.model import HEAD_CENTRE, BodyModel
from topview.body.parts import HEAD, LEFT_UPPER_ARM, RIGHT_UPPER_ARM, UPPER_TORSO
from topview.body.proportions import ANATOMICAL
from topview.geometry.rotations import rotations_from_vectors, unit
from topview.people.height import PRIOR_HEIGHT_M
from topview.records import InputError
from topview.track.body_tracker import Needs, Subject
from topview.track.elbows import elbows_on_circle, spread_points
from topview.track.evidence import Evidence
from topview.track.methods.btvr.arm_angles import arm_angles, beyond_ranges_rad
from topview.track.methods.btvr.arms import Arm
from topview.track.methods.btvr.pixels import UserPixels
from topview.track.methods.btvr.torso import Torso
from topview.track.methods.btvr.tracker import BtvrPose, assemble
from topview.track.stances import facing

Array = NDArray[np.float64]


# All ours, as the thesis prints no numbers.
SMOOTHING_M: Final = 0.03
"""Of the contour, before its curvature is taken."""
LEAST_CURVATURE_PER_M: Final = 3.0
"""Of a shoulder."""
SHOULDER_SIGMA_M: Final = 0.06
"""Standard deviation of a shoulder from its prediction by the last torso."""
TORSO_CENTRE_SIGMA_M, TORSO_TURN_SIGMA_RAD = 0.03, 0.15
"""Standard deviations of the torso from the pose that the shoulders give."""
MOTION_SIGMA_RAD: Final = 0.5
"""Standard deviation of the turn of an arm's part from the start of its search."""
LEAST_SURFACE_POINTS: Final = 20
"""Fewer points show neither an arm nor a torso."""
PALM_CANDIDATES, ELBOWS_ON_CIRCLE = 5, 8
"""Points that are tried as palms, and elbows on each one's circle."""
CAP_M: Final = 0.1
"""The largest distance that counts where arms are compared."""
TURN_COST_M, RANGE_COST_M = 0.003, 0.05
"""Per radian away from the last arm, and per radian beyond Table 5.1."""


@dataclass(frozen=True, slots=True)
class EllipsoidSettings:
    """What depends on the camera and on the machine.

    Attributes:
        noise_m: standard deviation of a point's distance from a surface, above 0 to 0.1 m; points
            that are further off than 4 of them count no more.
        most_points: that an ellipsoid is fitted to, 20 or more; fewer are faster.
    """

    noise_m: float = 0.02
    most_points: int = 300

    needs: ClassVar[Needs] = Needs()

    def __post_init__(self) -> None:
        if not 0.0 < self.noise_m <= 0.1:
            raise InputError(f"noise_m is {self.noise_m}; it must be above 0, up to 0.1")
        if self.most_points < LEAST_SURFACE_POINTS:
            raise InputError(
                f"most_points is {self.most_points}; it must be {LEAST_SURFACE_POINTS} or more"
            )

    @property
    def name(self) -> str:
        return "ellipsoids"

    def tracker(self, subject: Subject) -> EllipsoidTracker:
        return EllipsoidTracker(subject, self)


def pseudo_distances(points: Array, semi_axes_m: Array) -> Array:
    """[...] metres from the surface along the line to the ellipsoid's centre, negative inside.

    Args:
        points: [..., 3] in the ellipsoid's own frame.
        semi_axes_m: [3].
    """
    size = np.maximum(np.linalg.norm(points / semi_axes_m, axis=-1), 1e-6)
    return np.linalg.norm(points, axis=-1) * (1.0 - 1.0 / size)


def contour_curvature(mask: NDArray[np.bool_], smoothing_px: float) -> tuple[Array, Array, Array]:
    """The largest outline of a mask: [N, 2] columns and rows, [N, 2] unit vectors inwards, and [N]
    curvatures in 1/pixels, positive where it is convex."""
    found, _ = cv2.findContours(mask.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    if not found:
        return np.empty((0, 2)), np.empty((0, 2)), np.empty(0)
    outline = max(found, key=cv2.contourArea)[:, 0].astype(np.float64)
    if cv2.contourArea(outline.astype(np.float32), oriented=True) < 0.0:
        outline = outline[::-1]
    place, step, bend = (
        gaussian_filter1d(outline, smoothing_px, axis=0, order=order, mode="wrap")
        for order in range(3)
    )
    length = np.maximum(np.linalg.norm(step, axis=1), 1e-6)
    curvature = (step[:, 0] * bend[:, 1] - step[:, 1] * bend[:, 0]) / length**3
    return place, np.stack([-step[:, 1], step[:, 0]], axis=1) / length[:, None], curvature


@dataclass(frozen=True, slots=True, eq=False)
class TorsoSize:
    """Somebody's torso, whose semi-axes end at the shoulder joints and at the chest.

    Attributes:
        length_m: neck joint to hips.
        radii_m: [2] along x and z.
        to_neck_m: from the head's centre to the neck joint.
        shoulder_drop_m: from the neck joint down to the height of the shoulder joints.
    """

    length_m: float
    radii_m: Array
    to_neck_m: float
    shoulder_drop_m: float

    @classmethod
    def of(cls, model: BodyModel) -> TorsoSize:
        left, right = model.joints_parent[LEFT_UPPER_ARM], model.joints_parent[RIGHT_UPPER_ARM]
        return cls(
            float(model.lengths_m[1:3].sum()),
            np.array([(right[0] - left[0]) / 2, model.radii_m[UPPER_TORSO, 1]]),
            float((1.0 - HEAD_CENTRE) * model.lengths_m[HEAD]),
            float(right[1]),
        )


class EllipsoidTracker:
    """One person's upper body, each frame's ellipsoids fitted from where the last frame's were."""

    def __init__(self, subject: Subject, settings: EllipsoidSettings) -> None:
        self.subject = subject
        self.settings = settings
        self.model = BodyModel.of(PRIOR_HEIGHT_M, ANATOMICAL)
        self._torso: Torso | None = None
        self._arms: list[Arm] = []

    def update(self, evidence: Evidence) -> BtvrPose:
        """The pose in the next frame."""
        if evidence.stature_m is not None:
            self.model = BodyModel.of(evidence.stature_m, ANATOMICAL)
        with self.subject.clock.stage("torso"):
            expected = self._predict_torso(evidence)
            shoulders = self._find_shoulders(expected, evidence)
            self._torso = torso = self._fit_torso(expected, shoulders, evidence)
        with self.subject.clock.stage("arms"):
            self._arms = self._fit_arms(torso, shoulders, evidence)
        return assemble(self.model, torso, self._arms, evidence)

    def _predict_torso(self, evidence: Evidence) -> Torso:
        """The last torso's orientation, below the present head."""
        if self._torso is None:
            R = facing(0.0, evidence.up_camera)
        else:
            R = self._torso.R_camera_torso
            if not evidence.head_is_seen:
                return self._torso
        neck = evidence.head_camera + TorsoSize.of(self.model).to_neck_m * R[:, 1]
        return Torso(neck, R)

    def _find_shoulders(self, expected: Torso, evidence: Evidence) -> Array:
        """[2, 3] centres of the left and the right shoulder's sphere, in metres."""
        view = evidence.view
        uppers = [LEFT_UPPER_ARM, RIGHT_UPPER_ARM]
        R, neck = expected.R_camera_torso, expected.neck_camera
        centres = neck + self.model.joints_parent[uppers] @ R.T
        pixel_m = max(neck[2], 0.3) / view.fx
        place, inward, curvature = contour_curvature(evidence.user_mask, SMOOTHING_M / pixel_m)
        radius_m = float(self.model.radii_m[LEFT_UPPER_ARM, 0])
        joints = (place + inward * radius_m / pixel_m - (view.cx, view.cy)) * pixel_m
        for k, centre in enumerate(centres):
            if not len(place):
                break
            off = np.linalg.norm(joints - centre[:2] * neck[2] / centre[2], axis=1)
            score = curvature / pixel_m * np.exp(-0.5 * (off / SHOULDER_SIGMA_M) ** 2)
            best = int(score.argmax())
            if score[best] > LEAST_CURVATURE_PER_M:
                centre[:2] = joints[best] * centre[2] / neck[2]
            centres[k] = self._fit_sphere(centre, radius_m, evidence)
        return centres

    def _fit_sphere(self, seed: Array, radius_m: float, evidence: Evidence) -> Array:
        """[3] the centre of a sphere, fitted to the points around a shoulder."""
        s, points = self.settings, evidence.all_points_camera
        around = self._subsample(points[((points - seed) ** 2).sum(1) < (2.0 * radius_m) ** 2])
        if len(around) < LEAST_SURFACE_POINTS:
            return seed
        radii = np.full(3, radius_m)

        def residuals(centre: Array) -> Array:
            gaps = pseudo_distances(around - centre, radii) / s.noise_m / np.sqrt(len(around))
            return np.append(gaps, (centre - seed) / SHOULDER_SIGMA_M)

        return least_squares(residuals, seed, loss="soft_l1", max_nfev=10).x

    def _fit_torso(self, expected: Torso, shoulders: Array, evidence: Evidence) -> Torso:
        """The torso's ellipsoid, fitted to the points between and below the shoulders."""
        s, size = self.settings, TorsoSize.of(self.model)
        y = expected.R_camera_torso[:, 1]
        across = shoulders[1] - shoulders[0]
        x = unit(across - y * (across @ y))
        R0 = np.stack([x, y, np.cross(x, y)], axis=1)
        rx, rz = self.model.radii_m[UPPER_TORSO]
        half_m = 0.5 * size.length_m
        semi_axes = np.array([rx, half_m, rz])
        to_centre = half_m - size.shoulder_drop_m
        centre0 = shoulders.mean(0) + to_centre * y
        local = (evidence.all_points_camera - centre0) @ R0
        points = self._subsample(local[(np.abs(local) < (rx, half_m, 2.0 * rz)).all(1)])
        if len(points) < LEAST_SURFACE_POINTS:
            return expected

        def residuals(state: Array) -> Array:
            turn = rotations_from_vectors(state[3:])
            gaps = pseudo_distances((points - state[:3]) @ turn, semi_axes)
            gaps = np.clip(gaps, -4 * s.noise_m, 4 * s.noise_m) / s.noise_m
            held = np.concatenate(
                [state[:3] / TORSO_CENTRE_SIGMA_M, state[3:] / TORSO_TURN_SIGMA_RAD]
            )
            return np.append(gaps * np.sqrt(30.0 / len(points)), held)

        state = least_squares(residuals, np.zeros(6), max_nfev=15).x
        R = R0 @ rotations_from_vectors(state[3:])
        centre = centre0 + R0 @ state[:3]
        return Torso(centre - half_m * R[:, 1], R)

    def _fit_arms(self, torso: Torso, shoulders: Array, evidence: Evidence) -> list[Arm]:
        """Fit the left and the right arm, each to the points nearer to its last pose than to the
        other arm's."""
        R = torso.R_camera_torso
        pixels = UserPixels(torso, self.model, evidence)
        points = pixels.points[pixels.weights > 0.5]
        hanging = unit(np.array([[0.0, 1.0, 0.0], [0.0, 1.0, 0.2]]))
        arms = []
        last = [arm.axes_torso for arm in self._arms] or [hanging] * 2
        hung = [
            _ArmEllipsoids(upper, self.model, shoulder, axes @ R.T)
            for upper, shoulder, axes in zip(
                (LEFT_UPPER_ARM, RIGHT_UPPER_ARM), shoulders, last, strict=True
            )
        ]
        away = np.stack([arm.distances(points, arm.last[None])[0] for arm in hung])
        for k, arm in enumerate(hung):
            reach = np.linalg.norm(points - arm.shoulder, axis=1) < arm.reach_m
            own = self._subsample(points[reach & (away[k] <= away[1 - k])])
            axes, cost_m = self._fit_axes(arm, own, R, side=2.0 * k - 1.0)
            offset = (arm.shoulder - torso.neck_camera) @ R
            arms.append(Arm(offset, axes @ R, cost_m / CAP_M))
        return arms

    def _fit_axes(
        self, arm: _ArmEllipsoids, points: Array, R: Array, side: float
    ) -> tuple[Array, float]:
        """[2, 3] directions of an arm's parts in the camera frame, and their mean distance."""
        s = self.settings
        if len(points) < LEAST_SURFACE_POINTS:
            return arm.last, CAP_M
        palms = spread_points(points, arm.shoulder, PALM_CANDIDATES)
        upper_m, fore_m = map(float, arm.lengths_m)
        drawn = elbows_on_circle(arm.shoulder, palms, upper_m, fore_m, ELBOWS_ON_CIRCLE)
        starts = np.concatenate([arm.last[None], drawn])
        costs = np.minimum(np.abs(arm.distances(points, starts)), CAP_M).mean(1)
        turned = np.arccos(np.clip((starts * arm.last).sum(-1), -1.0, 1.0)).sum(1)
        beyond = beyond_ranges_rad(arm_angles(starts @ R, side))
        best = starts[(costs + TURN_COST_M * turned + RANGE_COST_M * beyond).argmin()]

        def residuals(state: Array) -> Array:
            gaps = arm.distances(points, unit(best + state.reshape(2, 3))[None])[0]
            gaps = np.clip(gaps, -4 * s.noise_m, 4 * s.noise_m) / s.noise_m
            return np.append(gaps * np.sqrt(30.0 / len(points)), state / MOTION_SIGMA_RAD)

        state = least_squares(residuals, np.zeros(6), max_nfev=10).x
        axes = unit(best + state.reshape(2, 3))
        return axes, float(np.minimum(np.abs(arm.distances(points, axes[None])), CAP_M).mean())

    def _subsample(self, points: Array) -> Array:
        """At most `most_points` of the points, evenly spaced."""
        return points[:: max(1, -(-len(points) // self.settings.most_points))]


class _ArmEllipsoids:
    """An arm of two ellipsoids from a shoulder on; `last` [2, 3] are its parts' last directions."""

    def __init__(self, upper: int, model: BodyModel, shoulder: Array, last: Array) -> None:
        self.shoulder, self.last = shoulder, last
        self.lengths_m = model.lengths_m[[upper, upper + 1]]
        self.radii_m = model.radii_m[[upper, upper + 1], 0]
        self.reach_m = 1.1 * float(self.lengths_m.sum())

    def distances(self, points: Array, axes: Array) -> Array:
        """[M, N] pseudo-distances of the [N, 3] points from the nearer one of both ellipsoids, for
        arms of [M, 2, 3] directions."""
        start, gaps = self.shoulder + np.zeros((len(axes), 3)), []
        for k, (length_m, radius_m) in enumerate(zip(self.lengths_m, self.radii_m, strict=True)):
            axis = axes[:, k]
            off = points - (start + 0.5 * length_m * axis)[:, None]
            along = np.einsum("mnc,mc->mn", off, axis)
            across = np.sqrt(np.maximum((off**2).sum(-1) - along**2, 0.0))
            own = np.stack([across, along, np.zeros_like(along)], axis=-1)
            gaps.append(pseudo_distances(own, np.array([radius_m, 0.5 * length_m, radius_m])))
            start = start + length_m * axis
        return np.where(np.abs(gaps[0]) < np.abs(gaps[1]), *gaps)
