"""How far joints may be off that were looked at both ways in time (ours).

Each way in time has told a law of the same error. Both are mixed, the surer one for more, and how
far apart they have the joint adds to it. Smoothing leaves less of that, as was measured.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from topview.records import JointState
from topview.track.joint_errors import confidences_of, kinds_of, shipped_joint_errors

Array = NDArray[np.float64]

# What is left of a variance, of joints behind another person and of others: fitted on rendered
# people of even seeds from 100 to 194.
LEFT_BEHIND, LEFT_IN_VIEW = 0.75, 0.9


def are_laws(covariances: Array) -> NDArray[np.bool_]:
    """[...] which of [..., 3, 3] covariances are known, and flat in no direction."""
    is_law = np.asarray(np.isfinite(covariances).all((-2, -1)))
    is_law[is_law] = np.linalg.eigvalsh(covariances[is_law])[:, 0] > 0.0
    return is_law


def mean_information(share: Array, one: Array, other: Array) -> Array:
    """[..., 3, 3] between two [..., 3, 3] covariances of much the same error, of which the first
    counts by a [...] share."""
    information = share[..., None, None] * np.linalg.inv(one)
    information += (1.0 - share)[..., None, None] * np.linalg.inv(other)
    return np.asarray(np.linalg.inv(information), np.float64)


def told_both_ways(
    people: NDArray[np.void], others: NDArray[np.void], is_proposed: bool
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """[T, J, 3, 3] covariances in square metres, and [T, J] confidences, of one person in T frames,
    as tracked forward and backward, with proposed joints or without; what was told forward where
    either tells nothing."""
    forward, backward = (own["joint_covariance_m2"].astype(np.float64) for own in (people, others))
    is_known = are_laws(forward) & are_laws(backward)
    is_behind = (people["joint_state"] == JointState.OCCLUDED_BY_PERSON)[is_known]
    apart = (people["joints_camera"] - others["joints_camera"])[is_known]
    mixed = _mixed(forward[is_known], backward[is_known], apart, is_behind)
    covariances, confidences = forward, people["joint_confidence"].copy()
    covariances[is_known] = mixed
    kinds = kinds_of(np.full(len(mixed), is_proposed), is_behind)
    confidences[is_known] = confidences_of(mixed, kinds, shipped_joint_errors())
    return covariances.astype(np.float32), confidences


def _mixed(forward: Array, backward: Array, apart: Array, is_behind: NDArray[np.bool_]) -> Array:
    """[N, 3, 3] of two [N, 3, 3] covariances and the [N, 3] ways from one place to the other."""
    variances, others = (np.trace(own, axis1=-2, axis2=-1) for own in (forward, backward))
    share = others / (variances + others)
    left = np.where(is_behind, LEFT_BEHIND, LEFT_IN_VIEW)[:, None, None]
    between = apart[:, :, None] * apart[:, None, :] * (share * (1.0 - share))[:, None, None]
    return left * mean_information(share, forward, backward) + between
