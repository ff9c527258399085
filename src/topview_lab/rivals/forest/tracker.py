"""Bodies from the joints that a decision forest proposes, frame by frame, to compare with.

After J. Shotton et al., CVPR 2011, whose system ends with the proposals
(`topview_lab.rivals.forest`). Here (ours) a body of the
person's size is fitted to the best proposal of each joint: the trunk as one rigid piece, then head
and limbs. Left and right cannot be in the same place: the more confident proposal has it. Parts
without proposals keep their pose relative to the trunk; nothing else is remembered.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Final

import numpy as np
from numpy.typing import NDArray

from topview.body.kinematics import joints_from_parts
from topview.body.model import BodyModel
from topview.body.parts import (
    HEAD,
    JOINT_NAMES,
    JOINTS,
    LEFT_UPPER_ARM,
    LEFT_UPPER_LEG,
    LOWER_TORSO,
    RIGHT_UPPER_ARM,
    RIGHT_UPPER_LEG,
    UPPER_TORSO,
)
from topview.body.proportions import ANATOMICAL
from topview.geometry.rotations import transform, unit
from topview.people.height import PRIOR_HEIGHT_M
from topview.records import InputError
from topview.track.body_tracker import Needs, Subject
from topview.track.elbows import limb_rotations
from topview.track.evidence import Evidence
from topview.track.pose import Pose
from topview.track.stances import STANDING, stand
from topview_lab.rivals.forest import best_of_each, default_forest, propose_joints

Array = NDArray[np.float64]

_TRUNK = [
    JOINT_NAMES.index(name)
    for name in (
        "neck", "torso", "pelvis", "left_shoulder", "right_shoulder", "left_hip", "right_hip",
    )
]  # fmt: skip
_HEAD = JOINT_NAMES.index("head")
# The upper part of each limb, and the joints at the ends of both of its parts.
_LIMBS = tuple(
    (upper, [j for j, joint in enumerate(JOINTS) if joint.part in (upper, upper + 1)][1:])
    for upper in (LEFT_UPPER_ARM, RIGHT_UPPER_ARM, LEFT_UPPER_LEG, RIGHT_UPPER_LEG)
)


LEAST_BODY_PIXELS: Final = 100
"""A person with fewer pixels stays as last seen (ours)."""
MEMORY_WEIGHT: Final = 0.03
"""Weight of where a joint of the trunk was, against a proposal's confidence (ours)."""


@dataclass(frozen=True, slots=True)
class ForestSettings:
    """Which proposals count.

    Attributes:
        least_confidence: of a proposal that moves the body, 0 to 1; a higher one leaves more joints
            where they were (ours).
    """

    least_confidence: float = 0.5

    needs: ClassVar[Needs] = Needs()

    def __post_init__(self) -> None:
        if not 0.0 <= self.least_confidence <= 1.0:
            raise InputError(f"least_confidence is {self.least_confidence}; it must be 0 to 1")

    @property
    def name(self) -> str:
        return "forest"

    def tracker(self, subject: Subject) -> ForestTracker:
        return ForestTracker(subject, self)


class ForestTracker:
    """One person's pose, from each frame's proposals anew."""

    def __init__(self, subject: Subject, settings: ForestSettings) -> None:
        self.subject = subject
        self.settings = settings
        self.model = BodyModel.of(PRIOR_HEIGHT_M, ANATOMICAL)
        self._forest = default_forest()
        self._pose: Pose | None = None

    def update(self, evidence: Evidence) -> Pose:
        """The pose in the next frame."""
        if evidence.stature_m is not None:
            self.model = BodyModel.of(evidence.stature_m, ANATOMICAL)
        last = self._pose or stand(
            self.model, evidence.head_camera, STANDING, 0.0, evidence.up_camera
        )
        if np.count_nonzero(evidence.user_mask) < LEAST_BODY_PIXELS:
            return last
        with self.subject.clock.stage("proposals"):
            view = evidence.view
            found = propose_joints(view.depth_m, evidence.user_mask, view, self._forest)
            places, confidence = best_of_each(found, self.settings.least_confidence)
        with self.subject.clock.stage("body"):
            self._pose = self._fit(last, places, confidence)
        return self._pose

    def _fit(self, last: Pose, places: Array, confidence: Array) -> Pose:
        model = self.model
        before = joints_from_parts(model, last.transforms(model))
        is_new = confidence > 0.0
        targets = np.where(is_new[:, None], places, before)
        weights = np.where(is_new, confidence, 0.0) + MEMORY_WEIGHT
        resting = joints_from_parts(model, _at_rest(model))
        R, neck = rigid_fit(resting[_TRUNK], targets[_TRUNK], weights[_TRUNK])
        turn = R @ last.Rs[UPPER_TORSO].T
        Rs = turn @ last.Rs
        Rs[[UPPER_TORSO, LOWER_TORSO]] = R
        if is_new[_HEAD]:
            Rs[HEAD] = _pointing(unit(neck - places[_HEAD]), R[:, 0])
        origins = Pose(neck, Rs).origins(model)
        for upper, ends in _LIMBS:
            axes = Rs[[upper, upper + 1], :, 1]
            joint = origins[upper]
            middle, end = ends
            if is_new[middle]:
                axes[0] = unit(places[middle] - joint)
            if is_new[end]:
                elbow = (
                    places[middle] if is_new[middle] else joint + model.lengths_m[upper] * axes[0]
                )
                axes[1] = unit(places[end] - elbow)
            Rs[[upper, upper + 1]] = limb_rotations(axes, R, upper)
        return Pose(neck, Rs)


def _at_rest(model: BodyModel) -> Array:
    """[11, 4, 4] parts of a body that stands upright at the origin, its neck there."""
    Rs = np.repeat(np.eye(3)[None], len(model.lengths_m), axis=0)
    return transform(Rs, Pose(np.zeros(3), Rs).origins(model))


def _pointing(y: Array, x_hint: Array) -> Array:
    """[3, 3] rotation with that y axis, and x as near the hint as can be."""
    x = unit(x_hint - y * (x_hint @ y))
    return np.stack([x, y, np.cross(x, y)], axis=1)


def rigid_fit(points_b: Array, points_a: Array, weights: Array) -> tuple[Array, Array]:
    """[3, 3] R_a_b and [3] the origin of b in a that bring points [N, 3] in frame b nearest to
    points in frame a, in weighted squares (W. Kabsch, Acta Cryst. A32, 1976)."""
    share = weights / weights.sum()
    middle_a, middle_b = share @ points_a, share @ points_b
    U, _, Vt = np.linalg.svd(((points_a - middle_a) * share[:, None]).T @ (points_b - middle_b))
    R = U @ np.diag([1.0, 1.0, np.sign(np.linalg.det(U @ Vt))]) @ Vt
    return R, middle_a - R @ middle_b
