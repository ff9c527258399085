"""Find the palm in a blob of skin; a bare arm and its hand are one blob."""

from __future__ import annotations

from math import cos, dist, sin
from typing import Final

from topview.detect.blobs import Blob
from topview.detect.color_view import ColorView, Place
from topview.kernels.skin import look_at_ends

# All ours. A blob with a longer semi-axis is an arm with its hand.
HAND_M: Final = 0.12
# The palm is the middle of this length at the arm's end.
END_M: Final = 0.16
# The hand is the end further from the chest, a point this far below the head: elbows are near it,
# and a hand that is raised to the head is not. That is right for 94 % of simulated arms; the end
# further from the head itself would be for 85 %.
CHEST_BELOW_HEAD_M: Final = 0.4


def palm_of(view: ColorView, blob: Blob, head: Place | None) -> Place | None:
    """[3] metres, a point on the skin, the hand's end if a blob of known depth is an arm; None if
    the palm is its middle: it is no longer than a hand, or no head is near it."""
    ellipse = blob.ellipse
    px_per_m = view.camera.fx / blob.depth_m
    if head is None or ellipse.major <= HAND_M * px_per_m:
        return None
    chest = head[0], head[1] + CHEST_BELOW_HEAD_M, head[2]
    along = cos(ellipse.angle), sin(ellipse.angle)
    seen = look_at_ends(blob.pixels, view.depth_m, *along, END_M * px_per_m)
    ends = [view.point_camera(x, y, depth_m or blob.depth_m) for x, y, depth_m in seen]
    return max(ends, key=lambda end: dist(end, chest))
