"""Body parts in a depth image by a randomised decision forest, and joints from them.

After J. Shotton et al., "Real-time human pose recognition in parts from single depth images", CVPR
2011. `propose_joints` is the plain function from a depth image to candidates for the joints.
"""

from topview_lab.rivals.forest.model import Forest, default_forest
from topview_lab.rivals.forest.proposals import JointCandidate, best_of_each, propose_joints

__all__ = ["Forest", "JointCandidate", "best_of_each", "default_forest", "propose_joints"]
