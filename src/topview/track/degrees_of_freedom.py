"""The 28 degrees of freedom that fits move together, as tables for the kernels.

6 of the root, which is the upper torso, 3 each of neck and waist, and 2 for the direction of each
limb's part: the turn of an upper limb about its own axis follows from where its elbow or knee bends
to (`topview.kernels.body.align_hinges`).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from topview.body.parts import HEAD, LOWER_TORSO, PARTS, UPPER_TORSO
from topview.track.pose import HINGE_BENDS, HINGE_PAIRS, TREE_PARENT


def _padded(lists: list[list[int]]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    width = max(map(len, lists))
    return (
        np.array([items + [0] * (width - len(items)) for items in lists]),
        np.array([len(items) for items in lists]),
    )


def _chain(part: int) -> list[int]:
    return [] if part < 0 else [part, *_chain(TREE_PARENT[part])]


_LIMB_PARTS = [part for part in range(len(PARTS)) if part not in (HEAD, UPPER_TORSO, LOWER_TORSO)]
DOF_PART = np.array(
    [UPPER_TORSO] * 6 + [HEAD] * 3 + [LOWER_TORSO] * 3 + [p for p in _LIMB_PARTS for _ in range(2)]
)
DOF_AXIS = np.array([0, 1, 2] * 4 + [0, 2] * len(_LIMB_PARTS))
N_DOFS, N_ROOT_DOFS = len(DOF_PART), 6
DOF_OF, N_DOF_OF = _padded(
    [[d for d in range(3, N_DOFS) if DOF_PART[d] == part] for part in range(len(PARTS))]
)
CHAIN, N_CHAIN = _padded(
    [[d for d in range(N_DOFS) if DOF_PART[d] in _chain(part)] for part in range(len(PARTS))]
)
PARENT_OF = np.array([part.parent for part in PARTS])
TREE = np.array(TREE_PARENT)
HINGES = np.array(HINGE_PAIRS)
BENDS = np.array([HINGE_BENDS[upper] for upper, _ in HINGE_PAIRS])
