"""Splits of the errors: by hidden share, by its cause, by action and by body."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview_lab.metrics.errors import Errors, Pool, total_share
from topview_lab.metrics.samples import CAUSES, OUT_OF_VIEW

ALL: Final = "all"
UNHIDDEN: Final = "unhidden"
UNHIDDEN_BELOW: Final = 0.05  # ours: the rim of a joint's neighbourhood always loses a little
HIDDEN_SHARES: Final = (0.3, 0.6)  # the occlusions of Table 6.3
ACTION_PREFIX: Final = "action: "
BODY_PREFIX: Final = "body: "


def hidden_split(share: float, cause: str = "") -> str:
    """The name of the split of which `share` 0..1 or more is hidden, by anything or by a cause."""
    what = {"": "hidden", OUT_OF_VIEW: OUT_OF_VIEW}.get(cause, f"hidden by {cause}")
    return f"{what} ≥ {share:.0%}"


def splits(pool: Pool, errors: Errors) -> dict[str, NDArray[np.bool_]]:
    """[N, C] masks of the errors in each split; an error may be in several."""
    return {
        ALL: np.ones(errors.raw.shape, bool),
        **occlusion_splits(errors.hidden),
        **{
            name: np.broadcast_to(where[:, None], errors.raw.shape)
            for name, where in label_splits(pool).items()
        },
    }


def occlusion_splits(hidden: NDArray[np.float64]) -> dict[str, NDArray[np.bool_]]:
    """[...] masks of the [..., 4] shares: by how much is hidden, by anything and by each cause."""
    total = total_share(hidden)
    return {
        UNHIDDEN: total < UNHIDDEN_BELOW,
        **{hidden_split(share): total >= share for share in HIDDEN_SHARES},
        **{
            hidden_split(share, cause): hidden[..., i] >= share
            for i, cause in enumerate(CAUSES)
            for share in HIDDEN_SHARES
        },
    }


def label_splits(pool: Pool) -> dict[str, NDArray[np.bool_]]:
    """[N] masks of the person-frames of each action and of each body that the reference names."""
    return {
        prefix + label: labels == label
        for prefix, labels in (
            (ACTION_PREFIX, pool.samples.action),
            (BODY_PREFIX, pool.samples.body),
        )
        for label in np.unique(labels).tolist()
        if label
    }
