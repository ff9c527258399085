"""The forest in the place of the network: the joints for which it votes, as one whole-body mode."""

from __future__ import annotations

from typing import Final

import numpy as np

from topview.body.parts import JOINT_NAMES
from topview.camera.pyramid import DepthView
from topview.detect.joints.proposals import JointProposals
from topview.detect.joints.windows import DEPTH, OWN, WINDOW_PIXELS, Windows
from topview_lab.rivals.forest.model import default_forest
from topview_lab.rivals.forest.proposals import best_of_each, propose_joints

SURE_SCALE_M: Final = 0.05
"""Laplace scale, along each axis, of a joint of confidence 1; it grows as the confidence falls
(ours)."""


class ForestProposer:
    """A `JointProposer`. It cannot tell a person from furniture, so that `p_person` is 1 wherever
    there is something to look at; a joint for which nothing votes is in the middle of the box, with
    the box's own size as its scale."""

    def __init__(self) -> None:
        self._forest = default_forest()

    def propose(self, windows: Windows) -> JointProposals:
        """Proposals for each window, in their order."""
        P, J = len(windows.is_used), len(JOINT_NAMES)
        positions = windows.to_camera(np.zeros((P, 1, J, 3)))
        scales_m = np.tile(windows.halves_m[:, None, None, None], (1, 1, J, 3))
        weights = np.zeros((P, 1))
        for index in np.flatnonzero(windows.is_used).tolist():
            view = view_of_window(windows, index)
            is_own = windows.images[index, OWN] > 0.0
            found = propose_joints(view.depth_m, is_own, view, self._forest)
            places, confidence = best_of_each(found, least_confidence=0.0)
            known = confidence > 0.0
            positions[index, 0, known] = places[known]
            sure_m = SURE_SCALE_M / confidence[known]
            scales_m[index, 0, known] = np.minimum(sure_m, windows.halves_m[index])[:, None]
            weights[index] = known.any()
        is_somebody = windows.is_used.astype(np.float64)
        return JointProposals(positions, scales_m, weights, is_somebody, JOINT_NAMES)


def view_of_window(windows: Windows, index: int) -> DepthView:
    """What a window shows, as a depth image of its own: 0 without a reading, and beyond the box."""
    column, row, middle_m = windows.middles[index]
    half_m = windows.halves_m[index]
    offset = windows.images[index, DEPTH]
    depth_m = np.where(np.abs(offset) < 1.0, middle_m + offset * half_m, 0.0)
    half = WINDOW_PIXELS / 2.0
    focal_px = half * middle_m / half_m  # a box is as many pixels wide, whatever the camera
    cx = half * (1.0 + (windows.cx - column) * middle_m / (half_m * windows.fx)) - 0.5
    cy = half * (1.0 + (windows.cy - row) * middle_m / (half_m * windows.fy)) - 0.5
    return DepthView(depth_m.astype(np.float32), focal_px, focal_px, cx, cy)
