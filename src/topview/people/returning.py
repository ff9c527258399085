"""Who comes back: whoever left or was hidden is known again by clothes and stature (ours; the
thesis's people stay)."""

from __future__ import annotations

from collections.abc import Sequence, Set
from dataclasses import dataclass, field
from math import log
from typing import Final

import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray

from topview.filter.assignment import assign
from topview.people.appearance import Colors, clothes_under, unlikeness
from topview.people.association import CLOTHES_WEIGHT, SAME_CLOTHES
from topview.people.bodies import own_mask
from topview.people.existence import TOLD, Existence
from topview.people.height import HeightEstimate, measured_height
from topview.people.track import Track
from topview.room.scene import Scene

# All ours. Of whom nothing has been seen for so long, has left, or is hidden.
GONE_S: Final = 1.0
# Somebody new is looked at for so long before being told; if the clothes are not seen, no longer
# than the second.
LOOKED_S, WAITED_S = 0.3, 1.0
# Log-likelihood ratio of being one who left, against somebody new and all others who left.
CLEARLY_BACK: Final = 2.0
# Standard deviations between two measurements of one stature, and between the statures of two
# people; a stature speaks against somebody no more than the third, as people stoop.
SAME_STATURE_M, OTHER_STATURE_M, LEAST_BY_STATURE = 0.04, 0.14, -4.0
# So many are remembered, those who left last.
MOST_GONE: Final = 100


@dataclass(slots=True)
class Portrait:
    """What somebody looks like who has come.

    Attributes:
        since_s: when that was.
        clothes: mean of the colours so far, None while unknown.
        looks: how many there were, and since when.
        height: the stature.
    """

    since_s: float
    clothes: Colors | None = None
    looks: int = 0
    looked_since_s: float = np.inf
    height: HeightEstimate = field(default_factory=HeightEstimate)

    def add(self, clothes: Colors | None, height_m: float | None, time_s: float) -> None:
        """What one frame shows."""
        self.height.add(height_m, time_s)
        if clothes is None:
            return
        self.looked_since_s = min(self.looked_since_s, time_s)
        self.looks += 1
        before = clothes if self.clothes is None else self.clothes
        self.clothes = np.asarray(before + (clothes - before) / self.looks, np.float32)

    def is_done(self, time_s: float) -> bool:
        """Whether it has been looked at for long enough."""
        return time_s - self.looked_since_s >= LOOKED_S or time_s - self.since_s >= WAITED_S

    def log_ratio(self, gone: Track) -> float:
        """Of being somebody who has left, against somebody new."""
        if self.clothes is None or gone.clothes is None:
            return -np.inf
        ratio = CLOTHES_WEIGHT * (SAME_CLOTHES - unlikeness(self.clothes, gone.clothes))
        if self.height.is_measured and gone.height.is_measured:
            ratio += by_stature(self.height.height_m - gone.height.height_m)
        return ratio


class ReturningPeople(Existence):
    """Confirms tracks and ends them, and gives whoever comes back the identity of before.

    Args:
        most: as of `Existence`.
        from_outside: whether whoever left the picture is known again, too, and not only whoever
            was hidden in it.
    """

    def __init__(self, most: int | None = None, from_outside: bool = True) -> None:
        super().__init__(most)
        self._from_outside = from_outside
        self._people: dict[int, Track] = {}  # of the last frame, by id
        self._ended: dict[int, Track] = {}
        self._gone: dict[int, Track] = {}  # the ended and the absent
        self._portraits: dict[int, Portrait] = {}  # by keys of tracks

    def confirmed(
        self, tracks: Sequence[Track], scene: Scene, free: Set[int], has_network: bool
    ) -> list[Track]:
        """As of `Existence`; while somebody is gone, only whoever has been looked at."""
        self._remember(tracks, scene)
        if self._gone:
            self._look_at(tracks, scene)
            free = {key for key in free if self._portraits[key].is_done(scene.time_s)}
        after = super().confirmed(tracks, scene, free, has_network)
        new = {track.key for track in tracks if not track.id}
        back = {
            track.id: track.key for track in after if track.key in new and track.id in self._gone
        }
        after = [
            track if track.id not in back else track.as_person(self._gone[track.id])
            for track in after
            if track.key == back.get(track.id, track.key)
        ]
        self._ended = {own: track for own, track in self._ended.items() if own not in back}
        self._people = {track.id: track for track in after if track.id}
        return after

    def has_ended(self, track: Track, scene: Scene) -> bool:
        """As of `Existence`; and where somebody has left the picture, so that whoever comes in
        there is looked at."""
        has_left = _is_outside(track) and self._is_gone(track, scene)
        return has_left or super().has_ended(track, scene)

    def _remember(self, tracks: Sequence[Track], scene: Scene) -> None:
        if self._from_outside:
            here = {track.id for track in tracks}
            left = [track for own, track in self._people.items() if own not in here]
            ended = self._ended | {track.id: _kept(track) for track in left if _is_known(track)}
            self._ended = dict(list(ended.items())[-MOST_GONE:])
        gone = [track for track in tracks if self._is_gone(track, scene)]
        self._gone = self._ended | {track.id: track for track in gone}

    def _is_gone(self, track: Track, scene: Scene) -> bool:
        """Whether somebody who is to be known again has not been seen for long, nor is their place
        known."""
        return (
            track.id > 0
            and _is_known(track)
            and track.unseen_s(scene.time_s) > GONE_S
            and (self._from_outside or not _is_outside(track))
            and not self.is_put_out(track, scene)
        )

    def _look_at(self, tracks: Sequence[Track], scene: Scene) -> None:
        seen = [track for track in tracks if track.is_seen]
        portraits = {}
        for track in tracks:
            if track.id:
                continue
            portrait = self._portraits.get(track.key) or Portrait(scene.time_s)
            if track.is_seen:
                others = [other.place_camera for other in seen if other.key != track.key]
                clothes = clothes_under(scene, track.place_camera, others)
                is_own = own_mask(scene, track)
                height_m = measured_height(scene, track.place_camera, is_own)
                portrait.add(clothes, height_m, scene.time_s)
            portraits[track.key] = portrait
        self._portraits = portraits

    def _identities(self, ready: Sequence[Track]) -> dict[int, int]:
        """By key: of whoever comes back that of before, new ones of all others."""
        back: dict[int, int] = {}
        if self._gone:
            ids = list(self._gone)
            gone = self._gone.values()
            ratios = [[self._portraits[t.key].log_ratio(other) for other in gone] for t in ready]
            chosen = assign(clear_ones(np.reshape(ratios, (len(ready), len(ids)))))
            back = {ready[row].key: ids[column] for row, column in chosen.items()}
            self._are_there(set(back.values()))
        return back | super()._identities([track for track in ready if track.key not in back])


def by_stature(off_m: float) -> float:
    """Log-likelihood ratio of two statures so far apart being one person's."""
    same, other = SAME_STATURE_M, OTHER_STATURE_M
    ratio = log(other / same) - 0.5 * off_m**2 * (same**-2 - other**-2)
    return max(ratio, LEAST_BY_STATURE)


def clear_ones(ratios: NDArray[np.float64]) -> NDArray[np.float64]:
    """[N, G] log-likelihood ratios of N being one of G against somebody new; -inf where it is not
    clear which one, or whether any."""
    clear = np.full(ratios.shape, -np.inf)
    for (row, column), ratio in np.ndenumerate(ratios):
        others = np.append(np.delete(ratios[row], column), 0.0)
        if ratio - np.logaddexp.reduce(others) > CLEARLY_BACK:
            clear[row, column] = ratio
    return clear


def _is_known(track: Track) -> bool:
    """Whether somebody can be known again."""
    return track.clothes is not None


def _is_outside(track: Track) -> bool:
    """Whether somebody is most probably out of the picture."""
    return track.places is not None and track.places.outside > TOLD


def _kept(track: Track) -> Track:
    """Without images."""
    return replace(track, body_m=None)
