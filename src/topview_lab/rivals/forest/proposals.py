"""Joint proposals from a depth image: modes of the forest's votes.

Shotton et al. (2011), Sec. 3.4: each pixel votes for the joints with the probability of their
classes times the square of its depth, that is the surface it stands for; mean shift finds the modes
of the votes in 3D, which are then pushed from the surface into the body.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Protocol

import numpy as np
from numpy.typing import NDArray

from topview.body.parts import JOINT_NAMES, other_side
from topview.records import read_only
from topview_lab.kernels.forest import find_modes
from topview_lab.rivals.forest.classes import VOTES
from topview_lab.rivals.forest.model import Floats, Forest, Trees, person_depth

Array = NDArray[np.float64]


class Intrinsics(Protocol):
    """Intrinsics of a camera, in pixels."""

    @property
    def fx(self) -> float: ...
    @property
    def fy(self) -> float: ...
    @property
    def cx(self) -> float: ...
    @property
    def cy(self) -> float: ...


# All ours; Shotton et al. optimise the first two by part on held-out images.
BANDWIDTH_M: Final = 0.065
"""b_c: of the mean shift."""
LEAST_PROBABILITY: Final = 0.08
"""lambda_c: below it a pixel does not vote."""
MOST_VOTES: Final = 800
"""Pixels that vote for a joint, chosen evenly among more."""
MODES: Final = 4
"""Modes that are looked for, from as many starts."""
MEAN_SHIFT_ITERATIONS: Final = 12
"""Of the mean shift."""
OTHER_SIDE_APART_M: Final = 0.1
"""A joint and the one of the other side are further apart than this."""

# For each joint the one of the other side; itself in the middle.
_OTHER_SIDE = [JOINT_NAMES.index(other_side(name)) for name in JOINT_NAMES]


@dataclass(frozen=True, slots=True, eq=False)
class JointCandidate:
    """A proposed position of a joint.

    Attributes:
        joint: its name, one of `topview.body.JOINT_NAMES`.
        place_camera: [3] metres.
        confidence: 0..1, grows with the area of the surface that votes for the joint there.
    """

    joint: str
    place_camera: Array
    confidence: float

    def __post_init__(self) -> None:
        read_only(self.place_camera)


def propose_joints(
    depth_m: Floats,
    is_body: NDArray[np.bool_],
    lens: Intrinsics,
    forest: Forest,
) -> list[JointCandidate]:
    """Propose joints of one person, by joint, the most confident first; none for joints without
    votes.

    Args:
        depth_m: [H, W] float32 metres, 0 where there is no reading.
        is_body: [H, W] the person's pixels.
        lens: intrinsics.
        forest: `default_forest()` for the one that comes with the project.
    """
    seen = votes_and_points(forest.trees, depth_m, is_body, lens)
    found = []
    for j, modes in enumerate(surface_modes(seen)):
        for *place, area_m2 in modes.astype(np.float64):
            inwards = np.array(place) / np.linalg.norm(place)
            found.append(
                JointCandidate(
                    JOINT_NAMES[j],
                    np.array(place) + float(forest.depths_m[j]) * inwards,
                    float(area_m2 / (area_m2 + forest.areas_m2[j])),
                )
            )
    return found


def best_of_each(found: Sequence[JointCandidate], least_confidence: float) -> tuple[Array, Array]:
    """[16, 3] position and [16] confidence of each joint, NaN and 0 for none above
    `least_confidence`: greedily by confidence; a place that the other side's joint has is taken."""
    places, confidence = np.full((len(JOINT_NAMES), 3), np.nan), np.zeros(len(JOINT_NAMES))
    for candidate in sorted(found, key=lambda c: -c.confidence):
        j = JOINT_NAMES.index(candidate.joint)
        other = places[_OTHER_SIDE[j]]
        is_taken = np.linalg.norm(other - candidate.place_camera) < OTHER_SIDE_APART_M
        if candidate.confidence > least_confidence and not confidence[j] and not is_taken:
            places[j], confidence[j] = candidate.place_camera, candidate.confidence
    return places, confidence


@dataclass(frozen=True, slots=True, eq=False)
class SurfaceVotes:
    """Votes of S points of a person's surface.

    Attributes:
        points_camera: [S, 3] float32 metres.
        areas_m2: [S] that each point stands for, seen face on.
        votes: [S, J] float32 probability that each is at the joint.
    """

    points_camera: Floats
    areas_m2: Floats
    votes: Floats


def votes_and_points(
    trees: Trees, depth_m: Floats, is_body: NDArray[np.bool_], lens: Intrinsics
) -> SurfaceVotes:
    """The trees' votes at a person's pixels [H, W]."""
    v, u = np.nonzero(is_body & (depth_m > 0.0))
    pixels = np.stack([u, v]).astype(np.int32)
    shares = trees.classify(person_depth(depth_m, is_body), pixels, (lens.fx, lens.fy))
    z = depth_m[v, u]
    x, y = (u - lens.cx) * z / lens.fx, (v - lens.cy) * z / lens.fy
    return SurfaceVotes(
        np.stack([x, y, z], axis=1).astype(np.float32),
        (z**2 / (lens.fx * lens.fy)).astype(np.float32),
        np.stack([shares[:, classes].sum(1) for classes in map(list, VOTES)], axis=1),
    )


def surface_modes(seen: SurfaceVotes) -> list[Floats]:
    """For each joint [M, 4]: places on the surface, metres, and the votes there, square metres;
    the most first."""
    out = []
    for votes in seen.votes.T:
        voters = np.flatnonzero(votes > LEAST_PROBABILITY)
        step = max(1, -(-len(voters) // MOST_VOTES))
        voters = voters[::step]
        modes = np.empty((MODES, 4), np.float32)
        find_modes(
            seen.points_camera[voters], votes[voters] * seen.areas_m2[voters] * np.float32(step),
            np.float32(BANDWIDTH_M), MEAN_SHIFT_ITERATIONS, modes,
        )  # fmt: skip
        modes = modes[np.argsort(-modes[:, 3], kind="stable")]
        out.append(_distinct(modes[modes[:, 3] > 0.0]))
    return out


def _distinct(modes: Floats) -> Floats:
    """The modes that are further than a bandwidth from every better one."""
    kept: list[int] = []
    for m, mode in enumerate(modes):
        if all(np.linalg.norm(mode[:3] - modes[k, :3]) > BANDWIDTH_M for k in kept):
            kept.append(m)
    return modes[kept]
