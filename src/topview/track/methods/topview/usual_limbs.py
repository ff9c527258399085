"""Limbs looked up by what they explain: all that limbs usually do, one cost (ours).

The table by which whole bodies are looked up (`lookup`) knows how limbs move. Poses of it that
differ are tried, each in place of a limb, with the rest of the body as it is: what the limb
explains of the points that the rest leaves open, less what of it is in free space, is what the
whole body's cost changes by.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, cached_property
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.body.parts import LEFT_UPPER_ARM, LEFT_UPPER_LEG, PARTS
from topview.geometry.rotations import unit
from topview.kernels.limb_scan import ending_near, left_open_without, scan_limb
from topview.kernels.spread import cheapest_apart, farthest_first
from topview.records import read_only
from topview.track.degrees_of_freedom import PARENT_OF
from topview.track.elbows import elbows_on_circle, limb_rotations, spread_points
from topview.track.methods.topview.refinement import RefinementSettings
from topview.track.methods.topview.usual_poses import usual_poses
from topview.track.methods.topview.whole_body import FREE_SPACE_COST, FrameContext
from topview.track.pose import LIMBS, MIRRORED, OTHER_SIDE, Pose

Array = NDArray[np.float64]

# All ours.
LIMB_POSES: Final = 400  # of a limb that are tried
DIFFERENT_LENGTHS: Final = 0.3  # of elbows and hands together, against a part's length
LEAST_OPEN: Final = 0.02  # of a point: a limb that explains so little is not asked about it
# A point of which so much is left open may be a palm or a foot. So many of them, far from each
# other, are looked at; of every so many-th pose so many end nearest to each.
LIKELY_OPEN: Final = 0.5
PALMS: Final = 8
POSE_STRIDE: Final = 6
ENDING_THERE: Final = 6
# A limb's end is tried so far along its line of sight, with the elbow in so many places.
SIGHT_STEPS_M: Final = np.array([-0.16, -0.08, 0.0, 0.08, 0.16])
ELBOWS: Final = 8

_UPPERS: Final = np.array(LIMBS)


@cache
def usual_limbs(upper: int) -> Array:
    """[M, 2, 3, 3] different rotations of a limb's two parts, each in its parent's frame, which is
    the torso's for the upper one."""
    if upper not in (LEFT_UPPER_ARM, LEFT_UPPER_LEG):
        return read_only(MIRRORED @ usual_limbs(OTHER_SIDE[upper]) @ MIRRORED)
    limbs = usual_poses().Rs_relative[:, upper : upper + 2]
    ends, others = _ends(limbs), np.empty(LIMB_POSES - 1, np.int64)
    farthest_first(ends, ends[0], others)
    return read_only(limbs[[0, *others]])


@cache
def many_limbs(upper: int) -> Array:
    """[M, 2, 3, 3] as `usual_limbs`, more of them, alike ones too."""
    return read_only(
        np.ascontiguousarray(usual_poses().Rs_relative[::POSE_STRIDE, upper : upper + 2])
    )


@cache
def _ends_of_many(upper: int) -> Array:
    return read_only(_ends(many_limbs(upper)))


@dataclass(frozen=True)
class LimbScan:
    """What the whole body costs with another pose of a limb, all else as it is.

    Attributes:
        pose: of the body.
        look: the frame, with normals.
        settings: of refinement, whose cost it is.
    """

    pose: Pose
    look: FrameContext
    settings: RefinementSettings

    @cached_property
    def origins_camera(self) -> Array:
        """[11, 3] where the parts begin."""
        return self.pose.origins(self.look.model)

    def likeliest(self, upper: int, tried: Array, count: int, margin: float = np.inf) -> Array:
        """[count or fewer, 2, 3, 3] different poses of the limb of this upper part with which the
        whole body costs least, the cheapest first, and at most by a margin more than as it is: of
        [M, 2, 3, 3], of those that end at open points, and of the limb as it is with its end
        nearer or farther and its elbow elsewhere."""
        as_it_is = self.pose.relative()[None, upper : upper + 2]
        several = tried, self._reaching(upper), self._swivelled(upper), as_it_is
        tried = np.concatenate(several)
        costs, chosen = self.costs(upper, tried), np.empty(count, np.int64)
        found = cheapest_apart(costs[:-1], _ends(tried[:-1]), DIFFERENT_LENGTHS, chosen)
        chosen = chosen[:found]
        return tried[chosen[costs[chosen] < costs[-1] + margin]]

    def _reaching(self, upper: int) -> Array:
        """[K, 2, 3, 3] usual poses of a limb that end near points that the rest of the body leaves
        open, far from each other: these may be palms and feet."""
        model, evidence = self.look.model, self.look.evidence
        joint_camera = self.origins_camera[upper]
        is_likely = self.left_open[upper] > LIKELY_OPEN
        palms = spread_points(evidence.points_camera[is_likely], joint_camera, PALMS)
        palms = palms + unit(palms) * model.radii_m[upper + 1].min()  # from the skin to the axis
        palms = (palms - joint_camera) @ self.pose.Rs[PARENT_OF[upper]]
        many, is_near = many_limbs(upper), np.empty(len(many_limbs(upper)), np.bool_)
        ending_near(_ends_of_many(upper), model.lengths_m, upper, palms, ENDING_THERE, is_near)
        return many[is_near]

    def _swivelled(self, upper: int) -> Array:
        """[K, 2, 3, 3] the limb with its end where it is seen, nearer or farther, and its elbow all
        round: one that is bent towards the camera looks much like one that is bent away from it, or
        straight, and no step of the refinement leads from one to the other."""
        model, Rs, lower = self.look.model, self.pose.Rs, upper + 1
        start, R_parent = self.origins_camera[upper], Rs[PARENT_OF[upper]]
        end = self.origins_camera[lower] + model.lengths_m[lower] * Rs[lower, :, 1]
        ends = end + SIGHT_STEPS_M[:, None] * unit(end)
        axes = elbows_on_circle(start, ends, model.lengths_m[upper], model.lengths_m[lower], ELBOWS)
        Rs_upper, Rs_lower = np.moveaxis(limb_rotations(axes, R_parent, upper), 1, 0)
        return np.stack([R_parent.T @ Rs_upper, np.swapaxes(Rs_upper, -1, -2) @ Rs_lower], axis=1)

    def costs(self, upper: int, tried: Array) -> Array:
        """[M] what the whole body costs with each of [M, 2, 3, 3] poses of a limb, up to a
        constant."""
        s, model, evidence = self.settings, self.look.model, self.look.evidence
        view, left_open = evidence.view, self.left_open[upper]
        is_open = left_open > LEAST_OPEN
        explained, in_free_space = np.empty(len(tried)), np.empty(len(tried))
        scan_limb(
            tried, self.pose.Rs[PARENT_OF[upper]], self.origins_camera[upper], upper,
            model.lengths_m, model.shapes_m, model.joints_parent, evidence.points_camera[is_open],
            evidence.normals_camera[is_open], left_open[is_open], view.depth_m, evidence.user_mask,
            evidence.nearest.columns, evidence.nearest.corner, view.fx, view.fy, view.cx, view.cy,
            evidence.floor, s.reach_m, s.scale_m, s.free_space_margin_m, s.samples_per_part,
            explained, in_free_space,
        )  # fmt: skip
        share = in_free_space / (len(PARTS) * s.samples_per_part)
        return FREE_SPACE_COST * share - explained / max(len(left_open), 1)

    @cached_property
    def left_open(self) -> dict[int, Array]:
        """By limb, [N] how much of each point the body without it leaves unexplained, 0 to 1; 0
        where the limb does not reach."""
        s, evidence, surface = self.settings, self.look.evidence, self.look.model.surface
        left_open = np.empty((len(LIMBS), len(evidence.points_camera)))
        left_open_without(
            evidence.points_camera, evidence.normals_camera,
            *surface.placed(self.pose.Rs, self.origins_camera), surface.lengths_m, surface.shapes_m,
            surface.owners, _UPPERS, s.reach_m, s.scale_m, left_open,
        )  # fmt: skip
        return dict(zip(LIMBS, left_open, strict=True))


def _ends(Rs_relative: Array) -> Array:
    """[M, 6] where both parts end, each as long as 1, in the frame of the limb's parent."""
    elbows = Rs_relative[:, 0, :, 1]
    hands = elbows + (Rs_relative[:, 0] @ Rs_relative[:, 1])[..., 1]
    return np.concatenate([elbows, hands], axis=1)
