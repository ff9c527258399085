"""Where joints lie in a body, as shares of its stature.

Lengths are those of R. Drillis and R. Contini, Body Segment Parameters (1966), as printed in D.
Winter, Biomechanics and Motor Control of Human Movement (2009), Fig. 4.1; hip centres those of A.
Bell et al., Human Movement Science 8 (1989).
"""

from __future__ import annotations

from typing import Final

from topview.sim.looks import MEAN_STATURE_M, Look

Vector = tuple[float, float, float]

ADULT_HEAD_SHARE: Final = 0.130  # chin to head top, Winter (2009)
SOLE_SHARE: Final = 0.039  # the ankle above the sole
HIP_SHARE, KNEE_SHARE = 0.530, 0.285
CHIN_DROP_SHARE: Final = 0.032  # the chin below the joint of head and neck (ours)
C7_DROP_SHARE: Final = 0.020  # the base of the neck below the chin, Gordon et al. (1989)


def head_share(stature_m: float) -> float:
    """Chin to head top as a share of stature: heads of children grow less than their bodies."""
    return ADULT_HEAD_SHARE * (MEAN_STATURE_M / stature_m) ** 0.6


def segment_offsets(look: Look) -> tuple[dict[str, Vector], dict[str, Vector]]:
    """Origins of the middle and of the left segments in their carriers, shares of stature.

    The shoulder centre lies below and inside of the acromion (0.818 high, 0.129 to the side).
    """
    is_man = look.sex == "man"
    neck_base = 1.0 - head_share(look.stature_m) - C7_DROP_SHARE
    shoulder = neck_base - 0.034
    torso = HIP_SHARE + 0.100
    middle: dict[str, Vector] = {
        "pelvis": (0.0, HIP_SHARE, 0.0),
        "abdomen": (0.0, 0.045, -0.006),
        "chest": (0.0, torso - HIP_SHARE - 0.045, 0.0),
        "neck": (0.0, neck_base - torso, -0.012),
        "head": (0.0, C7_DROP_SHARE + CHIN_DROP_SHARE, 0.014),
    }
    reach = 0.106 if is_man else 0.098
    side: dict[str, Vector] = {
        "clavicle": (0.015, shoulder - torso + 0.004, 0.014),
        "upper_arm": (reach - 0.015, -0.004, -0.022),
        "forearm": (0.0, -0.186, 0.0),
        "hand": (0.0, -0.146, 0.0),
        "thigh": (0.050 if is_man else 0.052, 0.0, 0.0),
        "calf": (0.0, -(HIP_SHARE - KNEE_SHARE), 0.0),
        "foot": (0.0, -(KNEE_SHARE - SOLE_SHARE), 0.0),
    }
    return middle, side


def joint_places(look: Look) -> dict[str, tuple[str, Vector, float]]:
    """Segment, place in it and half breadth of the flesh there, shares of stature."""
    g = look.girth
    head = head_share(look.stature_m)
    origin = (0.0, 0.0, 0.0)
    joints = {
        "head_top": ("head", (0.0, head - CHIN_DROP_SHARE, 0.0), 0.35 * head),
        "head": ("head", (0.0, 0.5 * head - CHIN_DROP_SHARE, 0.006), 0.35 * head),
        "neck": ("neck", origin, 0.035 * g),
        "torso": ("chest", origin, 0.070 * g),
        "pelvis": ("pelvis", origin, 0.080 * g),
    }
    for s in ("l", "r"):
        joints |= {
            f"shoulder_{s}": (f"upper_arm_{s}", origin, 0.034 * g),
            f"elbow_{s}": (f"forearm_{s}", origin, 0.024 * g),
            f"wrist_{s}": (f"hand_{s}", origin, 0.017),
            f"hand_{s}": (f"hand_{s}", (0.0, -0.030, 0.004), 0.022),
            f"hip_{s}": (f"thigh_{s}", origin, 0.050 * g),
            f"knee_{s}": (f"calf_{s}", origin, 0.034 * g),
            f"ankle_{s}": (f"foot_{s}", origin, 0.021),
            f"foot_{s}": (f"foot_{s}", (0.0, -0.026, 0.080), 0.024),
        }
    return joints
