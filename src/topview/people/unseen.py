"""Where the head of a user is who is known, but whose head is not seen."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from topview.people.doubts import COVERED, SLID_M
from topview.people.height import sunk_m
from topview.people.identity import BRIEFLY_S, KnownUser, nearest_m
from topview.people.roll import Roll, area_m2
from topview.people.scene import Scene

Vector = NDArray[np.float64]
Distance = NDArray[np.float32]

# Ours, in statures: a head that is higher is upright, and over the trunk, which is between these
# heights; one that is lower is one's who stoops.
UPRIGHT, TRUNK, STOOPED = 0.8, (0.5, 0.85), 0.65
# Ours: of whom less is seen stands right behind somebody; of a trunk more tells where the head is,
# no further aside than this from over what is seen of it.
UNSEEN_M2, TRUNK_M2, OVER_TRUNK_M = 0.02, 0.03, 0.12
# Ours: what is less high, in a column of the image, is an arm.
COLUMN_M = 0.3
# Ours: where the head of one who stoops is not made out, it is the highest of the body so near to
# where it was seen last, from above; of one who is alone, and bends down, so near to where it was
# thought to be.
STOOPING_M, SUNK_ASIDE_M = 0.25, 0.5
# Ours: who has nobody so near is hidden by nobody; a head is sought first near to where it was, and
# is found where so much of what is as broad has its colours: of an arm less has.
ALONE_M, SOUGHT_M, FOUND = 2.0, (0.2, 0.4), 0.42


def miss(roll: Roll, scene: Scene, user: KnownUser) -> Distance:
    """Tell a user that the head was not found, and where it is most likely; gives the body."""
    way_on = _way_on(scene, user, roll.settings.border_m)
    user.miss(scene.time_s, scene.up_camera, way_on)
    body = roll.body_of(scene, user)
    is_lost = way_on is None and scene.time_s - user.seen_s > BRIEFLY_S
    if is_lost and _is_alone(roll, user) and _is_found_in_view(scene, user, body):
        return body
    is_gone = way_on is not None or scene.is_empty_at(user.head_camera)
    stood = is_gone and _stands_at(scene, user, UPRIGHT)
    trunk = _trunk(scene, user, body) if stood else None
    if trunk is not None:
        _place_over(scene, user, trunk)
        if way_on is not None:
            _stand_upright(scene, user)
    elif way_on is not None and area_m2(scene, user, body < np.inf) < UNSEEN_M2:
        _place_behind_cover(scene, user)
    elif is_lost:
        _place_at_top(scene, user, body)
    return body


def _way_on(scene: Scene, user: KnownUser, border_m: float) -> Vector | None:
    """[3] how far on from the place where a head is expected, but was not found, something hides
    it; None where it must be in view."""
    place = user.predicted(scene.time_s)
    if scene.is_hidden_at(place) or scene.is_out(place, border_m):
        return np.zeros(3)
    return scene.way_to_hidden(place, user.velocity) if scene.is_empty_at(place) else None


def _stands_at(scene: Scene, user: KnownUser, statures: float) -> bool:
    """Whether the head is higher than so many statures."""
    return scene.height_of(user.head_camera) > statures * user.height.height_m


def _trunk(scene: Scene, user: KnownUser, body: Distance) -> Vector | None:
    """[2] the middle of what is seen of the trunk, from above; None if that is too little."""
    low_m, high_m = (share * user.height.height_m for share in TRUNK)
    is_trunk = (body < np.inf) & (scene.heights_m > low_m) & (scene.heights_m < high_m)
    heights_m = np.count_nonzero(is_trunk, axis=0) * scene.cloud.pixel_m(user.head_camera)
    is_trunk &= heights_m > COLUMN_M
    if area_m2(scene, user, is_trunk) < TRUNK_M2:
        return None
    return np.median(scene.overview_m[is_trunk], axis=0).astype(np.float64)


def _place_over(scene: Scene, user: KnownUser, trunk: Vector) -> None:
    """Upright people's heads go where their trunks go; but not to where they would be seen."""
    off = trunk - scene.overview_of(user.head_camera)
    way = max(1.0 - OVER_TRUNK_M / max(float(np.hypot(*off)), 1e-9), 0.0) * off
    place = user.head_camera + way @ scene.basis_camera
    if not scene.is_empty_at(place) or scene.is_empty_at(user.head_camera):
        user.head_camera = place


def _place_behind_cover(scene: Scene, user: KnownUser) -> None:
    """Of whom nothing is seen stands, most likely, right behind what hides him."""
    user.head_camera = user.head_camera + scene.way_to_cover(user.head_camera)
    _stand_upright(scene, user)


def _stand_upright(scene: Scene, user: KnownUser) -> None:
    """A head that is about as high as the stature is taken to be just that."""
    below_m = sunk_m(scene, user.head_camera, user.height)
    if below_m is not None and below_m < SLID_M:
        user.head_camera = user.head_camera + below_m * scene.up_camera


def _is_alone(roll: Roll, user: KnownUser) -> bool:
    """Whether nobody is so near that he might hide the head."""
    return nearest_m(user, [other for other, _ in roll.others_of(user)]) > ALONE_M


def _is_found_in_view(scene: Scene, user: KnownUser, body: Distance) -> bool:
    """The head of one who bends may be in view without being made out: it is where the body has
    its colours, near to where it was; or, if there is nothing any more, at the body's top."""
    is_body = body < np.inf
    if user.head_colors is not None:
        for reach_m in SOUGHT_M:
            found = user.head_colors.place_in(scene.cloud, is_body, user.head_camera, reach_m)
            if found is not None and found[1] > FOUND:
                user.head_camera = found[0]
                return True
    if not scene.is_empty_at(user.head_camera):
        return False
    top = scene.top_near(is_body, user.head_camera, SUNK_ASIDE_M)
    user.head_camera = user.head_camera if top is None else top
    return top is not None


def _place_at_top(scene: Scene, user: KnownUser, body: Distance) -> None:
    """The head of one who stoops, where it is not made out, is the body's top near by."""
    is_in_view = scene.covered_share(user.head_camera) < COVERED
    if is_in_view and not _stands_at(scene, user, STOOPED):
        top = scene.top_near(body < np.inf, user.seen_camera, STOOPING_M)
        user.head_camera = user.head_camera if top is None else top
