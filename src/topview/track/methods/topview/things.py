"""Things that are taken for a part of a person, and that the body leaves open (ours).

What stands under a head or hangs together with a body is the person's until the body is known: so
are the chair of who sits, and a bag. Points of theirs that a limb explains make a pose cheaper, and
an arm is laid on the back of the chair. The body tells: where most of what is seen around a place
is left open by the body for a while, and stays where it is, that is a thing.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from topview.filter.over_time import FRAME_S, share_after
from topview.kernels.things import forget_changed, mean_around
from topview.room.background import TOLERANCE_M, TOLERANCE_NOISES
from topview.track.evidence import Evidence
from topview.track.methods.topview.refinement import Explained

# All ours. Of what is seen so near a place, such a share is left open round a thing, averaged over
# such a time: chosen on rendered people who sit, seeds 0 to 27.
AROUND_M: Final = 0.16
LEFT_OPEN: Final = 0.45
LEFT_OPEN_S: Final = 0.3
MOST_PLACES: Final = 1000  # at which that is asked; pixels between them are as the nearest


class Things:
    """What one person's pixels show besides the person."""

    def __init__(self) -> None:
        # Of each pixel of the working image: the last depth, and how much is left open there.
        self._depth_m = np.zeros((0, 0), np.float32)
        self._open = np.zeros((0, 0), np.float32)

    def left_out(self, evidence: Evidence) -> Evidence:
        """The evidence of a frame without the things; all of it where these would be most of it.
        Each frame begins with this, and forgets what has changed; then `update`."""
        depth_m = evidence.view.depth_m
        if depth_m.shape != self._depth_m.shape:
            self._depth_m = np.zeros(depth_m.shape, np.float32)
            self._open = np.zeros_like(self._depth_m)
        stays = evidence.noise.times(TOLERANCE_NOISES, TOLERANCE_M)
        forget_changed(depth_m, stays, self._depth_m, self._open)
        own = evidence.pixels[self._open.ravel()[evidence.pixels] > LEFT_OPEN]
        if not 0 < len(own) < 0.5 * len(evidence.pixels):
            return evidence
        is_things = np.zeros(depth_m.shape, np.bool_)
        is_things.ravel()[own] = True
        return evidence.without(is_things)

    def update(self, evidence: Evidence, explained: Explained, elapsed_s: float) -> None:
        """Take over a frame; `evidence` is all of it, of which a body explains so much."""
        open_now = 1.0 - explained.shares
        if open_now.mean() > LEFT_OPEN:
            return  # Such a body tells nothing.
        own, every = evidence.pixels, -(-len(evidence.pixels) // MOST_PLACES)
        places_camera = evidence.all_points_camera[::every]
        around = np.empty(len(places_camera))
        mean_around(places_camera, evidence.points_camera, open_now, AROUND_M, around)
        nearest = (np.arange(len(own)) + every // 2) // every
        around = around[np.minimum(nearest, len(around) - 1)]
        share = share_after(max(elapsed_s, FRAME_S), LEFT_OPEN_S)
        before = self._open.ravel()[own]
        self._open *= 1.0 - share
        self._open.ravel()[own] = before + share * (around - before)
