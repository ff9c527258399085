"""Recordings looked at both ways in time: what a joint did while it was hidden is told by what was
seen before and after (ours).

Whoever was tracked forward and backward (`topview.track.backwards`) is where both tell, each as far
as it is sure. Over that a Kalman filter goes forward and a smoother back: H. Rauch, F. Tung,
C. Striebel, "Maximum likelihood estimates of linear dynamic systems" (AIAA Journal 1965). Of a body
it takes where the neck is, how both parts of the trunk are turned, and the way along each bone of a
limb, each as sure as `joint_covariance_m2` says; arms in the frame of the upper torso, which
carries them, legs in the camera's, as they stand on the floor and a hidden pelvis tells little of
them. Velocities change at random and fade. The body is then put together again, so that bones keep
their lengths and joints stay on their parts.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from topview.body.parts import (
    HEAD,
    JOINT_NAMES,
    LEFT_FOREARM,
    LEFT_LOWER_LEG,
    LEFT_UPPER_ARM,
    LEFT_UPPER_LEG,
    LOWER_TORSO,
    RIGHT_FOREARM,
    RIGHT_LOWER_LEG,
    RIGHT_UPPER_ARM,
    RIGHT_UPPER_LEG,
    UPPER_TORSO,
)
from topview.detect.joints.proposers import NOTHING, OF_NO_BODY
from topview.geometry.rotations import nearest_rotations, shortest_turns, unit
from topview.skeletons import TrackedFrame
from topview.track.backwards import Partners, partners
from topview.track.offline_errors import mean_information, told_both_ways
from topview.track.smoothing import LEAP_M, Shape, joints_moved_with

Array = NDArray[np.float64]

LAG_S: Final = 5.0  # ours; how far it looks ahead and back, beside what it works on at a time
CHUNK_S: Final = 20.0  # ours; what it works on at a time
AWAY_S: Final = 1.0  # ours; whoever was away for longer, or has leapt, starts anew
DOUBTS: Final = 2.0  # ours; standard deviations at both ends of a leap that may be a mistake
# Fitted on rendered people (seeds 20 to 24, as tracked): what large errors of proposed joints are,
# they are for long, so a variance counts as more by as many times as the standard deviation is
# above this.
LASTING_M: Final = 0.015
# Fitted on rendered people (seeds 0 to 6), as tracked both ways.
FADING_HZ: Final = 8.0  # of velocities
# The same of even seeds from 100 to 194, with velocities that fade half as fast.
PLACE_UNREST_M2_S3: Final = 1.0  # how fast the variance of the neck's velocity grows
TURN_UNREST_RAD2_S3: Final = 13.0  # of the trunk's turning
LIMB_UNREST_M2_S3: Final = 5.0  # of the far end of a bone against its near end
UNKNOWN_M2: Final = 1e6  # ours; the variance of what is not known
LEAST_NOISE_M2: Final = 1e-8  # ours; a variance that is added, so that no noise is flat
START_M2: Final = 1.0  # ours; variance of a place and of a velocity, in m2/s2, at first


@dataclass(frozen=True, slots=True)
class _Bone:
    """A part of a limb: the part in whose frame its way is smoothed, None for the camera's, and its
    ends."""

    part: int
    frame: int | None
    near: int
    far: int
    is_first: bool


def _bones() -> tuple[_Bone, ...]:
    arms = (UPPER_TORSO, ("shoulder", "elbow", "hand"))
    legs = (None, ("hip", "knee", "ankle"))
    bones = []
    for side, (frame, names), parts in (
        ("left", arms, (LEFT_UPPER_ARM, LEFT_FOREARM)),
        ("right", arms, (RIGHT_UPPER_ARM, RIGHT_FOREARM)),
        ("left", legs, (LEFT_UPPER_LEG, LEFT_LOWER_LEG)),
        ("right", legs, (RIGHT_UPPER_LEG, RIGHT_LOWER_LEG)),
    ):
        joints = [JOINT_NAMES.index(f"{side}_{name}") for name in names]
        for k, part in enumerate(parts):
            bones.append(_Bone(part, frame, joints[k], joints[k + 1], k == 0))
    return tuple(bones)


_BONES: Final = _bones()
_NECK: Final = JOINT_NAMES.index("neck")
# Joints that tell how each part of the trunk is turned.
_TRUNK: Final = {
    UPPER_TORSO: [JOINT_NAMES.index(n) for n in ("left_shoulder", "right_shoulder", "torso")],
    LOWER_TORSO: [JOINT_NAMES.index(n) for n in ("left_hip", "right_hip", "torso")],
}
_FORWARD: Final = 1 + 2  # of what is smoothed: where the upper torso faces
LEVER_M: Final = 0.3  # ours; about how far these are from what they turn about


def looked_at_both_ways(
    frames: Iterable[TrackedFrame],
    settings: Mapping[str, Any],
    backward: Iterable[TrackedFrame] = (),
) -> Iterator[TrackedFrame]:
    """The frames of a recording with its people smoothed; joints are in the states that they were
    tracked in.

    Some `CHUNK_S` and twice `LAG_S` of frames are held at a time. The settings are of `About`:
    errors of joints that nothing has proposed do not count as lasting. `backward` are the frames as
    `topview.track.backwards` tracked them; whoever was missed forward, and not so backward, is
    told of, too.
    """
    is_proposed = settings.get("proposals", NOTHING) not in OF_NO_BODY
    held: list[_BothWays] = []
    done = 0  # of the held ones
    for own in _side_by_side(frames, backward):
        held.append(own)
        start_s = held[done].forward.timestamp_s
        if own.forward.timestamp_s - start_s < CHUNK_S + LAG_S:
            continue
        times_s = np.array([each.forward.timestamp_s for each in held])
        end = int(np.searchsorted(times_s, start_s + CHUNK_S))
        yield from _smoothed(held, is_proposed)[done:end]
        first = int(np.searchsorted(times_s, times_s[end] - LAG_S))
        held, done = held[first:], end - first
    yield from _smoothed(held, is_proposed)[done:]


class _BothWays(NamedTuple):
    """A frame, and its people as they were tracked backwards."""

    forward: TrackedFrame
    backward: NDArray[np.void]


def _side_by_side(
    frames: Iterable[TrackedFrame], backward: Iterable[TrackedFrame]
) -> Iterator[_BothWays]:
    """Each frame, with nobody tracked backwards where that was not done."""
    others = iter(backward)
    other = next(others, None)
    for frame in frames:
        while other is not None and other.index < frame.index:
            other = next(others, None)
        if other is not None and other.index == frame.index:
            yield _BothWays(frame, other.people)
        else:
            yield _BothWays(frame, frame.people[:0])


def _smoothed(held: Sequence[_BothWays], is_proposed: bool) -> list[TrackedFrame]:
    """All of these, looked at from all of them."""
    frames = [own.forward for own in held]
    backward = partners(frames, [own.backward for own in held])
    people = [_with_missed(*own) for own in zip(frames, backward, strict=True)]
    rows: dict[int, list[tuple[int, int]]] = {}
    for f, of_frame in enumerate(people):
        for row, person_id in enumerate(of_frame["id"].tolist()):
            rows.setdefault(person_id, []).append((f, row))
    for person_id, where in rows.items():
        packed = np.stack([people[f][row] for f, row in where])
        others = packed.copy()
        for k, (f, _) in enumerate(where):
            others[k] = backward[f].get(person_id, packed[k])
        times_s = np.array([frames[f].timestamp_s for f, _ in where])
        for part in _stretches(packed, times_s):
            packed[part] = _smoothed_person(packed[part], others[part], times_s[part], is_proposed)
        for (f, row), person in zip(where, packed, strict=True):
            people[f][row] = person
    return [replace(frame, people=own) for frame, own in zip(frames, people, strict=True)]


def _with_missed(frame: TrackedFrame, backward: Partners) -> NDArray[np.void]:
    """The people of a frame, and after them whoever is told of backwards alone."""
    present = set(frame.people["id"].tolist())
    missed = {person_id: own for person_id, own in backward.items() if person_id not in present}
    people = np.concatenate([frame.people, np.array([*missed.values()], frame.people.dtype)])
    people["id"][len(frame.people) :] = [*missed]
    return people


def _stretches(people: NDArray[np.void], times_s: Array) -> list[slice]:
    """What goes on without a pause, or a leap between places that are known."""
    necks = people["Ts_camera_part"][:, UPPER_TORSO, :3, 3]
    doubt_m = np.sqrt(np.trace(people["joint_covariance_m2"][:, _NECK], axis1=-2, axis2=-1))
    allowed_m = LEAP_M + DOUBTS * (doubt_m[1:] + doubt_m[:-1])
    step_m = np.linalg.norm(np.diff(necks, axis=0), axis=-1)
    begins = (np.diff(times_s) > AWAY_S) | ~(step_m < allowed_m)
    edges = [0, *(np.flatnonzero(begins) + 1).tolist(), len(times_s)]
    return [slice(a, b) for a, b in zip(edges[:-1], edges[1:], strict=True)]


def _smoothed_person(
    people: NDArray[np.void], others: NDArray[np.void], times_s: Array, is_proposed: bool
) -> NDArray[np.void]:
    """One person in T frames that go on, with proposed joints or without; the same as tracked
    backwards, or once more the same."""
    Ts, joints = people["Ts_camera_part"], people["joints_camera"]
    lasting_m = LASTING_M if is_proposed else np.inf
    measured, noise, unrest = _measured(people, lasting_m)
    of_others, others_noise, _ = _measured(others, lasting_m)
    both, both_noise = _weighted(measured, noise, of_others, others_noise)
    ways = _both_ways(times_s, both, both_noise, unrest)
    out = people.copy()
    out["joint_covariance_m2"], out["joint_confidence"] = told_both_ways(
        people, others, is_proposed
    )
    for k in range(len(people)):
        moved = _body(Ts[k], measured[k], ways[k])
        known = np.isfinite(moved) & np.isfinite(Ts[k])
        out["Ts_camera_part"][k] = np.where(known, moved, Ts[k])
        out["joints_camera"][k] = joints_moved_with(out["Ts_camera_part"][k], Ts[k], joints[k])
    return out


def _weighted(
    one: Array, one_noise: Array, other: Array, other_noise: Array
) -> tuple[Array, Array]:
    """[T, K, 3] between two that have seen the same images, each as far as it is sure; where they
    face apart, what the surer of them says. [T, K, 3, 3] how noisy it is: the mean information, as
    their errors are much alike."""
    variances, others_variances = (
        np.trace(own, axis1=-2, axis2=-1) for own in (one_noise, other_noise)
    )
    share = others_variances / (variances + others_variances)
    is_surer = variances.sum(-1) <= others_variances.sum(-1)
    apart = (one[:, _FORWARD] * other[:, _FORWARD]).sum(-1) < 0.0
    share = np.where(apart[:, None], is_surer[:, None], share)
    mean = share[..., None] * one + (1.0 - share)[..., None] * other
    return mean, mean_information(share, one_noise, other_noise)


def _lasting(covariances: Array, lasting_m: float) -> Array:
    """Covariances as measurements that come again and again count."""
    variances = np.trace(covariances, axis1=-2, axis2=-1)[..., None, None] / 3.0
    return covariances * np.maximum(1.0, np.sqrt(variances) / lasting_m)


def _measured(people: NDArray[np.void], lasting_m: float) -> tuple[Array, Array, Array]:
    """[T, K, 3] what is smoothed: the neck's place, the axes of the trunk's parts, the way along
    each bone in its frame; [T, K, 3, 3] how noisy it is; [K] its unrest."""
    Ts, joints = people["Ts_camera_part"], people["joints_camera"]
    covariances = _lasting(people["joint_covariance_m2"].astype(np.float64), lasting_m)
    values, noise = [Ts[:, UPPER_TORSO, :3, 3]], [covariances[:, _NECK]]
    unrest = [PLACE_UNREST_M2_S3]
    for part, told_by in _TRUNK.items():
        variances = np.trace(covariances[:, told_by], axis1=-2, axis2=-1).mean(-1) / 3.0
        for axis in range(3):
            values.append(Ts[:, part, :3, axis])
            noise.append((variances / LEVER_M**2)[:, None, None] * np.eye(3))
            unrest.append(TURN_UNREST_RAD2_S3)
    for bone in _BONES:
        R = _frame_of(bone, Ts)
        of_ends = covariances[:, bone.far]
        if not bone.is_first:
            of_ends = of_ends + covariances[:, bone.near]
        values.append(np.einsum("tba,tb->ta", R, joints[:, bone.far] - joints[:, bone.near]))
        noise.append(np.einsum("tba,tbc,tcd->tad", R, of_ends, R))
        unrest.append(LIMB_UNREST_M2_S3)
    measured, of_all = np.stack(values, 1), np.stack(noise, 1) + LEAST_NOISE_M2 * np.eye(3)
    is_unknown = np.isnan(measured).any(-1) | np.isnan(of_all).any((-2, -1))
    measured[is_unknown] = 0.0
    of_all[is_unknown] = UNKNOWN_M2 * np.eye(3)
    return measured, of_all, np.array(unrest)


def _frame_of(bone: _Bone, Ts: Array) -> Array:
    """[..., 3, 3] `R_camera_frame` of what a bone's way is smoothed in, of [..., B, 4, 4]."""
    if bone.frame is None:
        return np.broadcast_to(np.eye(3), (*Ts.shape[:-3], 3, 3))
    return Ts[..., bone.frame, :3, :3]


def _both_ways(times_s: Array, measured: Array, noise: Array, unrest: Array) -> Array:
    """[T, K, 3] of [T, K, 3] measurements."""
    count, K = measured.shape[:2]
    now, now_P = np.empty((count, K, 6)), np.empty((count, K, 6, 6))
    before, before_P = np.empty_like(now), np.empty_like(now_P)
    moves = np.empty((count, 6, 6))
    for i in range(count):
        if i == 0:
            before[0] = np.concatenate([measured[0], np.zeros((K, 3))], axis=-1)
            before_P[0] = START_M2 * np.eye(6)
        else:
            moves[i], grows = _motion(times_s[i] - times_s[i - 1])
            before[i] = now[i - 1] @ moves[i].T
            before_P[i] = moves[i] @ now_P[i - 1] @ moves[i].T + unrest[:, None, None] * grows
        of_place = before_P[i, :, :3]
        gain = np.swapaxes(np.linalg.solve(of_place[..., :3] + noise[i], of_place), -1, -2)
        off = measured[i] - before[i, :, :3]
        now[i] = before[i] + np.einsum("kab,kb->ka", gain, off)
        now_P[i] = before_P[i] - gain @ of_place
    both = now.copy()
    for i in range(count - 2, -1, -1):
        ahead = moves[i + 1] @ now_P[i]
        gain = np.swapaxes(np.linalg.solve(before_P[i + 1], ahead), -1, -2)
        both[i] += np.einsum("kab,kb->ka", gain, both[i + 1] - before[i + 1])
    return both[..., :3]


def _motion(elapsed_s: float) -> tuple[Array, Array]:
    """[6, 6] how place and velocity go on, and the covariance that comes to them for a unit of
    unrest: an integrated Ornstein-Uhlenbeck process."""
    rate = FADING_HZ
    kept = np.exp(-rate * elapsed_s)
    way = (1.0 - kept) / rate
    of_velocity = (1.0 - kept**2) / (2.0 * rate)
    of_place = (elapsed_s - 2.0 * way + of_velocity) / rate**2
    both = 0.5 * way**2
    return _on_axes(1.0, way, 0.0, kept), _on_axes(of_place, both, both, of_velocity)


def _on_axes(a: float, b: float, c: float, d: float) -> Array:
    """[6, 6] blocks a b, c d, each on three axes."""
    return np.array(np.kron(np.array([[a, b], [c, d]]), np.eye(3)), np.float64)


def _body(Ts: Array, measured: Array, ways: Array) -> Array:
    """[B, 4, 4] of one frame, with the neck, trunk and bones as they are smoothed."""
    shape = Shape.of(Ts)
    Rs = shape.Rs_camera_part.copy()
    for first, part in ((1, UPPER_TORSO), (4, LOWER_TORSO)):
        Rs[part] = nearest_rotations(ways[first : first + 3].T)
    turn = Rs[UPPER_TORSO] @ Ts[UPPER_TORSO, :3, :3].T
    Rs[HEAD] = turn @ Rs[HEAD]
    for bone, seen, smooth in zip(_BONES, measured[7:], ways[7:], strict=True):
        R = _frame_of(bone, Ts)
        bend = shortest_turns(unit(R @ seen), unit(R @ smooth))
        carried = np.eye(3) if bone.frame is None else turn
        Rs[bone.part] = carried @ bend @ Rs[bone.part]
    return replace(shape, neck_camera=ways[0], Rs_camera_part=Rs).transforms()
