"""Who may be somebody though no upright head is seen: clusters of what nobody explains.

What stands out from the floor and the room, is no track's and has a person's size hangs together in
a cluster. The joint network is asked about one of them a frame, in turn. Where it takes the window
for a person's, it tells where the head is.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import exp, log
from typing import Final

import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray

from topview.kernels.pieces import clusters_of
from topview.people.association import NEW_PER_M3
from topview.people.bodies import LARGEST_M2, SHOWN_M2, body_of, is_short, nearest_body
from topview.people.existence import REFUSED, Existence
from topview.people.height import PRIOR_HEIGHT_M
from topview.people.likelihood import EVIDENCE_MEMORY_S, FLICKER
from topview.people.segmentation import LIMB_STEP_M, full_pixels
from topview.people.spawning import is_free
from topview.people.step import Step
from topview.people.told import Told
from topview.people.track import Track
from topview.people.users import User
from topview.room.scene import Scene

Mask = NDArray[np.bool_]

# The id under which the network is asked about a cluster; no track has it.
CLUSTER_ID: Final = -(2**31) + 1
# All ours. What is seen of most people, which is asked about first.
USUAL_M2: Final = 0.35
# For so long the network looks at a cluster, at 30 frames a second once as it is and once mirrored,
# until that is forgotten or the cluster moves; it is not learnt as the room's before.
LOOKED_AT_S: Final = 0.06


@dataclass(frozen=True, slots=True, eq=False)
class Cluster:
    """What hangs together, has a person's size and is nobody's.

    Attributes:
        is_own: [h, w] its pixels.
        area_m2: of what is seen of it.
        asked_s: for how long the network has looked at it of late.
    """

    is_own: Mask
    area_m2: float
    asked_s: float

    @property
    def turn(self) -> tuple[float, float]:
        """The cluster whose turn is the least is asked about."""
        return self.asked_s, abs(float(np.log(self.area_m2 / USUAL_M2)))

    def as_user(self, scene: Scene) -> User:
        """As the network is asked about it; its middle stands for the head."""
        middle = np.median(scene.cloud.points_camera[self.is_own], axis=0).astype(np.float64)
        pixels = full_pixels(scene, self.is_own)
        return User(CLUSTER_ID, middle, False, PRIOR_HEIGHT_M, False, pixels)


class Clusters:
    """Which clusters wait for the network, and where it has looked.

    Attributes:
        next: the one whose turn it is; None if none waits.
        asked: the one that the network was asked about with the last frame, if it was.
    """

    def __init__(self) -> None:
        self.next: Cluster | None = None
        self.asked: Cluster | None = None
        self._asked_s = np.zeros((0, 0), np.float32)

    def update(self, scene: Scene, is_somebodys: Mask, elapsed_s: float) -> Mask:
        """Find those of a frame.

        Args:
            scene: of the frame.
            is_somebodys: [h, w] what tracks explain.
            elapsed_s: since the last frame.

        Returns:
            [h, w] those that wait, which are not to be learnt as the room's.
        """
        self._remember(scene.cloud.depth_m, elapsed_s)
        waiting = []
        is_waiting = np.zeros(is_somebodys.shape, np.bool_)
        for is_own, area_m2 in clusters_in(scene, is_somebodys):
            asked_s = float(np.median(self._asked_s[is_own]))
            if asked_s < LOOKED_AT_S:
                waiting.append(Cluster(is_own, area_m2, asked_s))
                is_waiting |= is_own
        self.next = min(waiting, key=lambda cluster: cluster.turn, default=None)
        return is_waiting

    def tell(self, doubtful: Sequence[User]) -> None:
        """The network is asked about the first of these with this frame."""
        is_asked = bool(doubtful) and doubtful[0].id == CLUSTER_ID
        self.asked = self.next if is_asked else None

    def _remember(self, depth_m: NDArray[np.float32], elapsed_s: float) -> None:
        """Where the network has looked, and forget it by and by."""
        if self._asked_s.shape != depth_m.shape:
            self._asked_s, self.asked = np.zeros_like(depth_m), None
        self._asked_s *= np.float32(exp(-elapsed_s / EVIDENCE_MEMORY_S))
        if self.asked is not None:
            self._asked_s[self.asked.is_own] += np.float32(elapsed_s)


def track_of_cluster(
    step: Step, asked: Cluster | None, tracks: Sequence[Track], key: int, existence: Existence
) -> Track | None:
    """A new track, of the cluster that the network was asked about, at the head that it tells; None
    if that is no person's, or may be another's. The cluster is its body, wherever the head is: it
    may be hidden behind that.

    Args:
        step: the frame after.
        asked: the cluster; None if the network was asked about none.
        tracks: in that frame.
        key: of the new track.
        existence: says what is worth following.
    """
    scene, told = step.scene, step.told.heads.get(CLUSTER_ID)
    if asked is None or step.last is None or told is None or not told.is_sure:
        return None
    head = step.head_at(told.head_camera)
    if not step.settings.areas.hold(scene, head.center_camera):
        return None
    if is_free(scene, head, tracks, step.told) is not None:
        return None
    features = step.features_under(head, nearest_body(scene, tracks))
    born = Track.born(key, scene.cloud, head, features).found_by_body(scene.time_s)
    evidence = born.evidence.with_network(told.log_odds, step.elapsed_s, step.told_s)
    track = replace(born, evidence=evidence)
    if track.existence(existence.likelihood) <= REFUSED:
        return None
    body_m = np.where(asked.is_own, step.last.away_m(head.center_camera), np.inf)
    track = replace(track, body_m=body_m.astype(np.float32))
    return replace(track, body_m=body_of(scene, track, step.segmentation, step.last))


def give_what_emerges(
    scene: Scene, tracks: Sequence[Track], bodies_m: NDArray[np.float32], told: Told
) -> None:
    """Give, of the bodies [N, h, w], to people of whom nothing is seen what comes into view that is
    nobody's: where one of them is likelier than somebody new, and the network has not just taken it
    for no person's."""
    hidden = [
        row
        for row, track in enumerate(tracks)
        if _is_out_of_sight(track) and not told.is_nobodys(track)
    ]
    if not hidden:
        return
    people = [track for track in tracks if track.id]
    is_somebodys = bodies_m.min(axis=0) < np.inf
    for is_own, _ in clusters_in(scene, is_somebodys):
        middle_m = np.median(scene.overview_m[is_own], axis=0).astype(np.float64)
        ratios = [_log_ratio_at(scene, tracks[row], middle_m) for row in hidden]
        row = hidden[int(np.argmax(ratios))]
        if max(ratios) <= 0.0 or told.share_on_body(scene, is_own, people) > 0.5:
            continue
        if scene.changed_share(is_own, tracks[row].motion_s) > FLICKER:
            bodies_m[row][is_own] = scene.away_m(tracks[row].place_camera)[is_own]


def _is_out_of_sight(track: Track) -> bool:
    is_bodiless = track.body_m is None or not (track.body_m < np.inf).any()
    return track.is_hidden and is_bodiless


def _log_ratio_at(scene: Scene, track: Track, overview_m: NDArray[np.float64]) -> float:
    """Log-likelihood ratio of a person who is not seen, at a place [2], against somebody
    new."""
    assert track.places is not None
    head_camera = scene.point_at(overview_m, track.places.height_m)
    return track.places.log_density(scene, head_camera) - log(NEW_PER_M3)


def clusters_in(scene: Scene, is_somebodys: Mask) -> Iterator[tuple[Mask, float]]:
    """[h, w] and the area in square metres of each cluster of a person's size, or as large as what
    shows of somebody beside whoever hides the rest; depths within one step by `LIMB_STEP_M` at
    most, so that a limb before the body is in its cluster."""
    cloud = scene.cloud
    labels = np.empty(cloud.depth_m.shape, np.int32)
    areas_m2 = clusters_of(
        scene.standing_px, is_somebodys, cloud.depth_m, cloud.camera.fx, LIMB_STEP_M, labels
    )
    for label, area_m2 in enumerate(areas_m2.tolist()):
        if SHOWN_M2 < area_m2 < LARGEST_M2:
            is_own = labels == label
            if is_short(scene, is_own):
                yield is_own, area_m2
