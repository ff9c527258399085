"""Windows to learn from: as the tracker cuts them, and varied in what a user's scene may differ in.

A variation changes what is seen and the truth together: another scale, a turned camera, a mirrored
scene. Or it changes what is seen alone: other people and things in front, a missing background, a
wrong segmentation, noise and holes. Or it shows no single person, and says so.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from topview.camera.pyramid import DepthView
from topview.detect.joints import PROPOSED_JOINTS
from topview.detect.joints.network import VISIBLE_PIXELS
from topview.detect.joints.proposals import OTHER_SIDES
from topview.detect.joints.windows import (
    DEPTH,
    HALF_BOX_M,
    LEAST_WINDOW_PIXELS,
    NO_READING,
    OTHER,
    OWN,
    WINDOW_PIXELS,
    Windows,
    box_of,
    encode,
    picked_pixels,
    window_pixels,
)
from topview.geometry.rotations import rotations_from_vectors
from topview_lab.training.joints.recordings import DEPTH_UNITS, Samples

Array = NDArray[np.float64]
Image = NDArray[np.float32]
Generator = np.random.Generator
Region = tuple[slice, slice]
"""Rows and columns of an image."""

EVERYTHING: Final[Region] = np.s_[:, :]

SHOULDERS_AND_HIPS: Final = np.array(
    [
        [PROPOSED_JOINTS.index(f"{side}_{joint}") for joint in ("shoulder", "hip")]
        for side in ("left", "right")
    ]
)
"""[2, 2] shoulder and hip of the left, and of the right: the line across tells who faces where."""
_HEAD_TOP: Final = PROPOSED_JOINTS.index("head_top")


@dataclass(frozen=True, slots=True)
class Variation:
    """How windows are varied; shares are of all windows. All ours.

    Attributes:
        scales: a person and all around is this many times as large.
        stretch: by up to such a share of it wider or narrower, taller or shorter, thicker or
            thinner: other proportions than those of the people learnt from.
        boxes: the box is this many times as large as what is seen of the person needs, as not all
            pixels that are somebody's are known.
        turn_rad: the camera turned about each of its axes: about right, down, forward.
        shift_m: of the box's middle.
        far_shift_share, far_shift_m: as if much more of the person were out of sight.
        company_share: another person is put beside, before or behind.
        relief_share, relief_m: clothes stand off elsewhere; bumps of up to.
        fat_share, thin_share: the outline is a pixel wider, or narrower.
        lost_head_share, lost_feet_share, lost_feet_m: hair, that is not read; feet, that went with
            the floor, up to that height.
        thing_share: a thing is put in front.
        edge_share: the image ends within the window.
        border_share, border_hidden: it ends within the person, at a side or below, and so much of
            the person at the most lies outside.
        other_room_share: people stand in the room of another recording.
        no_background_share, far_background_share: nothing but people is seen; nothing farther away.
        ragged_share: of those without a background: something of it is left round the person.
        wrong_mask_share: the segmentation is wrong in one way or another.
        no_mask_share: nobody knows which pixels are the person's.
        noise_share, noise_m: more noise than the recording has, up to.
        holes_share: readings are missing.
        nobody_share, several_share: what is to be looked at is no person; is more than one.
    """

    scales: tuple[float, float] = (0.75, 1.25)
    stretch: tuple[float, float, float] = (0.12, 0.08, 0.15)
    boxes: tuple[float, float] = (0.9, 1.2)
    turn_rad: tuple[float, float, float] = (0.2, 0.2, 0.15)
    shift_m: float = 0.06
    far_shift_share: float = 0.15
    far_shift_m: float = 0.25
    company_share: float = 0.2
    thing_share: float = 0.1
    edge_share: float = 0.08
    border_share: float = 0.12
    border_hidden: float = 0.7
    relief_share: float = 0.5
    relief_m: float = 0.02
    fat_share: float = 0.25
    thin_share: float = 0.2
    lost_head_share: float = 0.12
    lost_feet_share: float = 0.25
    lost_feet_m: float = 0.15
    other_room_share: float = 0.3
    no_background_share: float = 0.3
    far_background_share: float = 0.15
    ragged_share: float = 0.6
    wrong_mask_share: float = 0.5
    no_mask_share: float = 0.15
    noise_share: float = 0.4
    noise_m: float = 0.012
    holes_share: float = 0.4
    nobody_share: float = 0.06
    several_share: float = 0.03


AS_THEY_ARE: Final = Variation(
    scales=(1.0, 1.0),
    stretch=(0.0, 0.0, 0.0),
    boxes=(1.0, 1.0),
    turn_rad=(0.0, 0.0, 0.0),
    border_hidden=0.0,
    **{field.name: 0.0 for field in fields(Variation) if field.name.endswith(("_share", "_m"))},
)
"""No variation: to measure with."""
WITHOUT_PERSON: Final = replace(AS_THEY_ARE, nobody_share=1.0)
"""A piece of the background, where there is one."""


@dataclass(frozen=True, slots=True, eq=False)
class LabelledWindow:
    """One window and what is to be learnt from it.

    Attributes:
        image: [3, 128, 128] as in `topview.detect.joints.Windows`.
        half_m: from the box's middle to its sides.
        places: [21, 3] in the box, 0 where unknown.
        is_known: [21] whether a joint's place is known, and inside of the image.
        hidden: [21] share of each joint that was hidden by others before the window was varied, NaN
            where unknown.
        visible: [32, 32] share of pixels that are truly the person's.
        is_person: whether the window shows one person.
    """

    image: Image
    half_m: float
    places: NDArray[np.float32]
    is_known: NDArray[np.bool_]
    hidden: NDArray[np.float32]
    visible: Image
    is_person: bool


def labelled_window(
    samples: Samples, number: int, rng: Generator, how: Variation
) -> LabelledWindow:
    """The window of one sample, varied."""
    cut = _cut(samples, number, rng, how)
    image, own = cut.image, cut.image[OWN] > 0.0
    is_person = True
    drawn = rng.random()
    if drawn < how.nobody_share and _look_at_something_else(image, rng):
        is_person, own = False, np.zeros_like(own)
    elif drawn < how.nobody_share + how.several_share and _merge_with_others(image, own):
        is_person = False
    if rng.random() < how.company_share:
        donor = _cut(samples, int(rng.integers(len(samples))), rng, how, 0.6)
        own &= ~_put_in_front(image, donor.image, float(rng.uniform(-0.8, 0.5)) / HALF_BOX_M)
    if rng.random() < how.thing_share:
        own &= ~_put_thing_in_front(image, own, rng)
    edges = _cut_by_the_edge(image, own, rng, how)
    _change_outline(image, rng, how)
    _lose_ends(image, cut, rng, how)
    if rng.random() < how.other_room_share:
        put_into_room(image, _cut(samples, int(rng.integers(len(samples))), rng, how).image)
    _change_background(image, rng, how)
    if is_person and rng.random() < how.wrong_mask_share:
        _spoil_mask(image, rng)
    _spoil_depth(image, rng, how)
    if is_person and rng.random() < how.no_mask_share:
        image[OWN] = 0.0
    known = cut.is_known & is_person
    known &= (cut.places[:, :2] > edges[:2]).all(axis=1) & (cut.places[:, :2] < edges[2:]).all(1)
    step = WINDOW_PIXELS // VISIBLE_PIXELS
    visible = own.reshape(VISIBLE_PIXELS, step, VISIBLE_PIXELS, step).mean(axis=(1, 3))
    window = LabelledWindow(
        image,
        cut.half_m,
        np.where(known[:, None], cut.places, 0.0).astype(np.float32),
        known,
        cut.hidden,
        visible.astype(np.float32),
        is_person,
    )
    return _mirrored(window) if any(how.turn_rad) and rng.random() < 0.5 else window


@dataclass(frozen=True, slots=True, eq=False)
class _Cut:
    image: Image
    half_m: float
    places: Array
    is_known: NDArray[np.bool_]
    hidden: NDArray[np.float32]


def _cut(
    samples: Samples, number: int, rng: Generator, how: Variation, shift_m: float | None = None
) -> _Cut:
    """A window round somebody, of a turned camera and a scene stretched along its axes, off its
    middle."""
    which, frame, person = samples.index[number]
    recording = samples.recordings[which]
    scales = rng.uniform(*how.scales) * (1.0 + rng.uniform(-1.0, 1.0, 3) * how.stretch)
    depth_m = recording.depth_mm[frame].astype(np.float32) / DEPTH_UNITS
    labels = recording.masks[frame]
    view = DepthView(depth_m, *recording.intrinsics)
    own = int(recording.ids[person])
    in_image = _borders((labels == own) & (depth_m > 0.0), rng, how)
    if in_image != EVERYTHING:
        whole_m, all_labels = depth_m, labels
        depth_m, labels = np.zeros_like(depth_m), np.zeros_like(labels)
        depth_m[in_image], labels[in_image] = whole_m[in_image], all_labels[in_image]
        view = DepthView(depth_m, *recording.intrinsics)
    box = box_of(view, labels, own)
    if box is None:
        raise ValueError(f"sample {number} shows fewer than {LEAST_WINDOW_PIXELS} pixels")
    R_turned_camera = rotations_from_vectors(rng.uniform(-1.0, 1.0, 3) * how.turn_rad)
    far = rng.random() < how.far_shift_share
    sigma_m = shift_m or (how.far_shift_m if far else how.shift_m)
    shift = rng.normal(0.0, sigma_m, 3) if sigma_m else np.zeros(3)
    half_m = box.half_m(float(scales[:2].max()) * rng.uniform(*how.boxes))
    A_turned_camera = scales[:, None] * R_turned_camera
    turned = _turned_middle(view, box.middle, A_turned_camera)
    turned += shift * [view.fx / turned[2], view.fy / turned[2], 1.0]
    turned[2] = max(turned[2], 0.4)
    rows, columns = window_pixels(view, turned, half_m)
    deeper: Array | float = 1.0
    if not np.array_equal(A_turned_camera, np.eye(3)):
        rows, columns, deeper = _sources(view, rows, columns, A_turned_camera)
    seen_m, owners = picked_pixels(depth_m, labels, rows, columns)
    image = np.empty((3, WINDOW_PIXELS, WINDOW_PIXELS), np.float32)
    encode((seen_m * deeper).astype(np.float32), owners, own, turned[2], half_m, image)
    joints = recording.joints_camera[frame, person].astype(np.float64)
    is_known = np.isfinite(joints).all(axis=1) & _in_image(joints, view, in_image)
    joints = np.where(is_known[:, None], joints, [0.0, 0.0, 1.0]) @ A_turned_camera.T
    halves_m, is_used = np.array([half_m]), np.ones(1, bool)
    window = Windows(
        image[None],
        turned[None],
        halves_m,
        is_used,
        *recording.intrinsics,
        is_mirrored=np.zeros(1, np.bool_),
    )
    places = window.from_camera(joints[None])[0]
    return _Cut(image, half_m, places, is_known, np.asarray(recording.hidden[frame, person]))


def _turned_middle(view: DepthView, middle: Array, A_turned_camera: Array) -> Array:
    """The box's middle as a camera sees it that is turned in its place, the scene stretched."""
    ray = np.array([(middle[0] - view.cx) / view.fx, (middle[1] - view.cy) / view.fy, 1.0])
    point = A_turned_camera @ (ray * middle[2])
    column, row = point[:2] / point[2] * [view.fx, view.fy] + [view.cx, view.cy]
    return np.array([column, row, point[2]])


def _sources(
    view: DepthView, rows: NDArray[np.intp], columns: NDArray[np.intp], A_turned_camera: Array
) -> tuple[NDArray[np.intp], NDArray[np.intp], Array]:
    """Which pixels of the camera the turned one sees at these places, and by what their depth is
    multiplied; a camera turned in its place, before a scene stretched along its axes, sees the
    same surfaces."""
    x, y = (columns - view.cx) / view.fx, (rows - view.cy) / view.fy
    A = np.linalg.inv(A_turned_camera)
    across, down, forward = (A[axis, 0] * x + A[axis, 1] * y + A[axis, 2] for axis in range(3))
    forward = np.maximum(forward, 0.1)
    return (
        np.rint(down / forward * view.fy + view.cy).astype(np.intp),
        np.rint(across / forward * view.fx + view.cx).astype(np.intp),
        1.0 / forward,
    )


def _in_image(points_camera: Array, view: DepthView, in_image: Region) -> NDArray[np.bool_]:
    """[N] whether [N, 3] points, NaN for unknown ones, lie inside of that part of the image."""
    rows, columns, is_inside = view.nearest_pixels(np.nan_to_num(points_camera, nan=-1e6), 0.1)
    is_in = np.zeros(view.depth_m.shape, np.bool_)
    is_in[in_image] = True
    return is_inside & is_in[rows, columns]


def _borders(is_own: NDArray[np.bool_], rng: Generator, how: Variation) -> Region:
    """Where the image is; some of somebody's [H, W] pixels may lie beyond one of its sides or
    below, if enough are left to look at."""
    if rng.random() >= how.border_share:
        return EVERYTHING
    rows, columns = np.nonzero(is_own)
    gone = int(rng.uniform(0.0, how.border_hidden) * len(columns))
    if len(columns) - gone < LEAST_WINDOW_PIXELS:
        return EVERYTHING
    left, right = np.partition(columns, (gone, len(columns) - 1 - gone))[[gone, -1 - gone]]
    below = np.partition(rows, len(rows) - 1 - gone)[-1 - gone]
    return (
        np.s_[:, int(left) :],
        np.s_[:, : int(right) + 1],
        np.s_[: int(below) + 1, :],
    )[int(rng.integers(3))]


def _look_at_something_else(image: Image, rng: Generator) -> bool:
    """Take a piece of the background for the person, who is made somebody else; False where there
    is no background."""
    is_nobodys = (image[DEPTH] < NO_READING) & (image[OWN] + image[OTHER] == 0.0)
    places = np.argwhere(is_nobodys)
    if len(places) < 10 * LEAST_WINDOW_PIXELS:
        return False
    row, column = places[rng.integers(len(places))]
    depth = image[DEPTH] - image[DEPTH, row, column]
    reach = rng.uniform(0.1, 0.6, 2) * WINDOW_PIXELS
    rows, columns = np.ogrid[:WINDOW_PIXELS, :WINDOW_PIXELS]
    near = ((rows - row) / reach[0]) ** 2 + ((columns - column) / reach[1]) ** 2 < 1.0
    piece = is_nobodys & near & (np.abs(depth) < rng.uniform(0.1, 0.4))
    if np.count_nonzero(piece) < LEAST_WINDOW_PIXELS:
        return False
    middle = np.median(image[DEPTH][piece])
    rows, columns = np.nonzero(piece)
    to_middle = np.eye(2, 3)
    to_middle[:, 2] = WINDOW_PIXELS / 2 - np.array([np.median(columns), np.median(rows)])
    image[OTHER] += image[OWN]
    image[OWN] = piece
    image[DEPTH] = np.where(
        image[DEPTH] < NO_READING, np.clip(image[DEPTH] - middle, -1.0, 1.0), NO_READING
    )
    for channel, outside in ((DEPTH, NO_READING), (OWN, 0.0), (OTHER, 0.0)):
        image[channel] = cv2.warpAffine(
            image[channel],
            to_middle,
            (WINDOW_PIXELS, WINDOW_PIXELS),
            flags=cv2.INTER_NEAREST,
            borderValue=outside,
        )
    return True


def _merge_with_others(image: Image, own: NDArray[np.bool_]) -> bool:
    """Take others for the person, too; False where there are not enough of them."""
    if np.count_nonzero(image[OTHER]) < 0.5 * np.count_nonzero(own):
        return False
    image[OWN] += image[OTHER]
    image[OTHER] = 0.0
    return True


def _put_in_front(image: Image, donor: Image, behind: float) -> NDArray[np.bool_]:
    """Put the person of another window into this one, so much farther away; [128, 128] where that
    hides what was seen."""
    depth = donor[DEPTH] + behind
    is_in_front = (donor[OWN] > 0.0) & (depth < image[DEPTH]) & (np.abs(depth) < 1.0)
    image[DEPTH][is_in_front] = depth[is_in_front]
    image[OWN][is_in_front] = 0.0
    image[OTHER][is_in_front] = 1.0
    return is_in_front


def _put_thing_in_front(image: Image, own: NDArray[np.bool_], rng: Generator) -> NDArray[np.bool_]:
    """Put a slanted board before the person; [128, 128] where that hides what was seen."""
    box = (rng.uniform(0, WINDOW_PIXELS, 2), rng.uniform(0.1, 0.5, 2) * WINDOW_PIXELS)
    corners = cv2.boxPoints((tuple(box[0]), tuple(box[1]), float(rng.uniform(0, 30))))
    board = np.zeros((WINDOW_PIXELS, WINDOW_PIXELS), np.uint8)
    cv2.fillConvexPoly(board, corners.astype(np.int32), 1)
    nearest = np.percentile(image[DEPTH][own], 5) if own.any() else 0.0
    rows, columns = np.ogrid[:WINDOW_PIXELS, :WINDOW_PIXELS]
    slant = rng.normal(0.0, 0.15, 2) * 2.0 / WINDOW_PIXELS
    depth = nearest - rng.uniform(0.03, 0.5)
    depth = depth + slant[0] * (rows - box[0][1]) + slant[1] * (columns - box[0][0])
    is_in_front = (board > 0) & (depth < image[DEPTH]) & (depth > -1.0)
    image[DEPTH][is_in_front] = depth[is_in_front]
    image[OWN][is_in_front] = 0.0
    image[OTHER][is_in_front] = 0.0
    return is_in_front


def _cut_by_the_edge(image: Image, own: NDArray[np.bool_], rng: Generator, how: Variation) -> Array:
    """Let the image end within the window; left, top, right and bottom of what is left."""
    edges = np.array([-np.inf, -np.inf, np.inf, np.inf])
    if rng.random() >= how.edge_share:
        return edges
    side = int(rng.integers(4))
    at = int(rng.uniform(0.15, 0.45) * WINDOW_PIXELS)
    if side >= 2:
        at = WINDOW_PIXELS - at
    gone = np.s_[:at] if side < 2 else np.s_[at:]
    outside = (slice(None), gone) if side % 2 == 0 else (gone, slice(None))
    image[DEPTH][outside], image[OWN][outside], image[OTHER][outside] = NO_READING, 0.0, 0.0
    own[outside] = False
    edges[side] = at * 2.0 / WINDOW_PIXELS - 1.0
    return edges


def _change_outline(image: Image, rng: Generator, how: Variation) -> None:
    """Let the person stand out a pixel wider, as a pattern's window reads him, or narrower."""
    drawn = rng.random()
    own = image[OWN]
    around = np.ones((3, 3), np.uint8)
    if drawn < how.fat_share:
        nearest = cv2.erode(np.where(own > 0.0, image[DEPTH], np.float32(NO_READING)), around)
        is_new = (own == 0.0) & (nearest < image[DEPTH])
        image[DEPTH][is_new] = nearest[is_new]
        own[is_new] = 1.0
        image[OTHER][is_new] = 0.0
    elif drawn < how.fat_share + how.thin_share:
        lost = (own > 0.0) & (cv2.erode(own, around) == 0.0)
        image[DEPTH][lost] = NO_READING
        own[lost] = 0.0


def _lose_ends(image: Image, cut: _Cut, rng: Generator, how: Variation) -> None:
    """Lose what is on the head, as dark hair is not read, or the feet, as whoever takes away the
    floor takes them, too; whichever way the person faces."""
    rows, columns = np.mgrid[:WINDOW_PIXELS, :WINDOW_PIXELS]
    lost = np.zeros(rows.shape, np.bool_)
    if cut.is_known[_HEAD_TOP] and rng.random() < how.lost_head_share:
        column, row = (cut.places[_HEAD_TOP, :2] + 1.0) * WINDOW_PIXELS / 2
        reach = rng.uniform(2.0, 12.0, 2)
        column += rng.normal(0.0, 2.0)
        lost |= ((columns - column) / reach[0]) ** 2 + ((rows - row) / reach[1]) ** 2 < 1.0
        lost &= rng.random(rows.shape, np.float32) < rng.uniform(0.5, 1.5)
    if rng.random() < how.lost_feet_share and (image[OWN] > 0.0).any():
        last = np.flatnonzero((image[OWN] > 0.0).any(axis=1))[-1]
        height = rng.uniform(0.0, how.lost_feet_m) / HALF_BOX_M * WINDOW_PIXELS / 2
        slope = rng.normal(0.0, 0.05)
        lost |= rows > last - height + slope * (columns - WINDOW_PIXELS / 2)
    lost &= image[OWN] > 0.0
    image[DEPTH][lost] = NO_READING
    image[OWN][lost] = 0.0


def put_into_room(image: Image, donor: Image) -> None:
    """Put who is in a window before what is nobody's in another one, where that is seen."""
    is_nobodys = (image[OWN] + image[OTHER] == 0.0) & (donor[OWN] + donor[OTHER] == 0.0)
    image[DEPTH][is_nobodys] = donor[DEPTH][is_nobodys]


def _change_background(image: Image, rng: Generator, how: Variation) -> None:
    """Take away the background, or what is farther away."""
    drawn = rng.random()
    nobodys = image[OWN] + image[OTHER] == 0.0
    if drawn < how.no_background_share:
        if rng.random() < how.ragged_share:
            size = 2 * int(rng.integers(1, 6)) + 1
            near = cv2.boxFilter(image[OWN], -1, (size, size), normalize=False)
            beside = cv2.boxFilter(image[DEPTH] * image[OWN], -1, (size, size), normalize=False)
            step = np.abs(image[DEPTH] - beside / np.maximum(near, 1.0))
            left = nobodys & (near > 0.5) & (step < rng.uniform(0.05, 0.4))
            image[OWN][left] = 1.0
            nobodys &= ~left
        image[DEPTH][nobodys] = NO_READING
    elif drawn < how.no_background_share + how.far_background_share:
        image[DEPTH][nobodys & (image[DEPTH] > rng.uniform(0.1, 0.9))] = NO_READING


def _spoil_mask(image: Image, rng: Generator) -> None:
    """Make one of a segmentation's mistakes: the mask grows, shrinks, takes in others or what is
    near, or loses pieces."""
    own, drawn = image[OWN], rng.random()
    is_read = image[DEPTH] < NO_READING
    if drawn < 0.3:
        size = 2 * int(rng.integers(1, 4)) + 1
        kernel = np.ones((size, size), np.uint8)
        changed = (cv2.dilate if rng.random() < 0.6 else cv2.erode)(own, kernel) * is_read
    elif drawn < 0.55:
        size = 2 * int(rng.integers(3, 12)) + 1
        near = cv2.dilate(own, np.ones((size, size), np.uint8)) > 0.0
        reach = rng.uniform(0.05, 0.25)
        inside = np.sort(image[DEPTH][own > 0.0])
        if not len(inside):
            return
        low, high = inside[[len(inside) // 20, -1 - len(inside) // 20]]
        changed = near & is_read & (image[DEPTH] > low - reach) & (image[DEPTH] < high + reach)
        changed &= image[OTHER] == 0.0
    elif drawn < 0.65:
        changed = own + image[OTHER]
    else:
        changed = own.copy()
        for _ in range(int(rng.integers(1, 4))):
            corner = rng.integers(0, WINDOW_PIXELS, 2)
            size = rng.integers(6, 40, 2)
            changed[corner[0] : corner[0] + size[0], corner[1] : corner[1] + size[1]] = 0.0
    image[OWN] = changed
    image[OTHER] *= 1.0 - image[OWN]


def _spoil_depth(image: Image, rng: Generator, how: Variation) -> None:
    """Add noise and lose readings, as other sensors do."""
    depth = image[DEPTH]
    if rng.random() < how.relief_share:
        cells = int(rng.integers(5, 17))
        bumps = rng.standard_normal((cells, cells), np.float32) * rng.uniform(0.0, how.relief_m)
        bumps = cv2.resize(bumps, depth.shape, interpolation=cv2.INTER_LINEAR) / HALF_BOX_M
        depth += bumps * (image[OWN] > 0.0) * (depth < NO_READING)
        np.clip(depth, -1.0, 1.0, out=depth)
    if rng.random() < how.noise_share:
        sigma = rng.uniform(0.0, how.noise_m) / HALF_BOX_M
        noise = rng.standard_normal(depth.shape, np.float32) * np.float32(sigma)
        if rng.random() < 0.3:
            noise = cv2.GaussianBlur(noise, (0, 0), 1.0) * 2.0
        depth[depth < NO_READING] += noise[depth < NO_READING]
        if rng.random() < 0.4:
            step = rng.uniform(0.003, 0.03) / HALF_BOX_M
            depth[:] = np.where(depth < NO_READING, np.round(depth / step) * step, depth)
        np.clip(depth, -1.0, 1.0, out=depth)
    if rng.random() < how.holes_share:
        lost = rng.random(depth.shape, np.float32) < rng.uniform(0.0, 0.06)
        if rng.random() < 0.5:
            edge = cv2.morphologyEx(depth, cv2.MORPH_GRADIENT, np.ones((3, 3), np.uint8)) > 0.1
            lost |= edge & (rng.random(depth.shape, np.float32) < rng.uniform(0.2, 1.0))
        for _ in range(int(rng.integers(0, 4))):
            corner, size = rng.integers(0, WINDOW_PIXELS, 2), rng.integers(3, 20, 2)
            lost[corner[0] : corner[0] + size[0], corner[1] : corner[1] + size[1]] = True
        depth[lost] = NO_READING
        image[OWN][lost] = 0.0
        image[OTHER][lost] = 0.0


def _mirrored(window: LabelledWindow) -> LabelledWindow:
    """The window in a mirror, where left is right."""
    places = window.places[OTHER_SIDES] * np.array([-1.0, 1.0, 1.0], np.float32)
    return LabelledWindow(
        np.ascontiguousarray(window.image[:, :, ::-1]),
        window.half_m,
        places,
        window.is_known[OTHER_SIDES],
        window.hidden[OTHER_SIDES],
        np.ascontiguousarray(window.visible[:, ::-1]),
        window.is_person,
    )
