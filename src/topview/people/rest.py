"""What was refused and has stood still ever since: most frames tell nothing new of it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray

from topview.people.existence import REFUSED
from topview.people.likelihood import FLICKER, Likelihood
from topview.people.track import Track
from topview.room.scene import Scene
from topview.room.surfaces import jump_of


def is_at_rest(track: Track, scene: Scene, likelihood: Likelihood) -> bool:
    """Whether a track was refused by the network, and has not changed up to this frame."""
    own = track.evidence
    if track.id or not track.is_seen or track.body_m is None:
        return False
    if own.asked_s == 0.0 or own.still < 1.0 or track.existence(likelihood) >= REFUSED:
        return False
    return scene.changed_share(track.body_m < np.inf, own.looked_s) < FLICKER


def left_as_they_were(tracks: Sequence[Track], scene: Scene, last: Scene | None) -> list[Track]:
    """Tracks in a frame in which they are not looked at: where they were in the last one, but for
    what of their bodies something has come to hide."""
    if not tracks or last is None:
        return []
    z = scene.cloud.depth_m
    a, b, c = jump_of(scene.cloud.camera.noise)
    has_stayed = np.abs(z - last.cloud.depth_m) < a + (b + c * z) * z
    return [_left_as_it_was(track, scene.time_s, has_stayed) for track in tracks]


def _left_as_it_was(track: Track, time_s: float, has_stayed: NDArray[np.bool_]) -> Track:
    assert track.body_m is not None
    body_m = np.where(has_stayed, track.body_m, np.float32(np.inf))
    return replace(track, motion_s=time_s, seen_s=time_s, time_s=time_s, body_m=body_m)
