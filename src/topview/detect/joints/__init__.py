"""Joint proposals: where somebody's joints may be, from one depth image and whose each pixel is.

A `windows.Windows` is cut out round each person, a `proposals.JointProposer` looks at it, and what
comes back is places in the camera's frame. Proposals are detections: they know one frame, no body
and no past.
"""

from topview.detect.joints.proposals import (
    PROPOSED_JOINTS,
    JointProposals,
    JointProposer,
    proposed_of_joints,
)
from topview.detect.joints.windows import Windows, cut_windows

__all__ = [
    "PROPOSED_JOINTS",
    "JointProposals",
    "JointProposer",
    "Windows",
    "cut_windows",
    "proposed_of_joints",
]
