"""Places of joints in a body, as shares of its stature.

Lengths are those of R. Drillis and R. Contini, Body Segment Parameters (1966), as printed in D.
Winter, Biomechanics and Motor Control of Human Movement (2009), Fig. 4.1; hip centres those of A.
Bell et al., Human Movement Science 8 (1989).
"""

from __future__ import annotations

from typing import Final

from topview_lab.sim.appearance import MEAN_STATURE_M, Appearance

Vector = tuple[float, float, float]

ADULT_HEAD_SHARE: Final = 0.130  # chin to head top, Winter (2009)
SOLE_SHARE: Final = 0.039  # the ankle above the sole
HIP_SHARE, KNEE_SHARE = 0.530, 0.285
TORSO_SHARE: Final = 0.100  # the mid spine above the hips
UPPER_ARM_SHARE, FOREARM_SHARE = 0.186, 0.146
CHIN_DROP_SHARE: Final = 0.032  # the chin below the joint of head and neck (ours)
C7_DROP_SHARE: Final = 0.020  # the base of the neck below the chin, Gordon et al. (1989)


def head_share(appearance: Appearance) -> float:
    """Chin to head top as a share of stature: heads of children grow less than their bodies."""
    return (
        ADULT_HEAD_SHARE
        * (MEAN_STATURE_M / appearance.stature_m) ** 0.6
        * appearance.proportions.head
    )


def hip_share(appearance: Appearance) -> float:
    """Height of the hips of the standing person."""
    return HIP_SHARE * appearance.proportions.legs


def knee_share(appearance: Appearance) -> float:
    """Height of the knees of the standing person."""
    return KNEE_SHARE * appearance.proportions.legs * appearance.proportions.shins


def shoulder_share(appearance: Appearance) -> float:
    """Height of the shoulder centres above the mid spine; they lie below and inside of the
    acromion (0.818 high, 0.129 to the side)."""
    neck_base = 1.0 - head_share(appearance) - C7_DROP_SHARE
    return (
        neck_base
        - 0.034
        - appearance.proportions.shoulder_slope
        - hip_share(appearance)
        - TORSO_SHARE
    )


def arm_shares(appearance: Appearance) -> tuple[float, float]:
    """Lengths of the right upper arm and forearm."""
    whole = appearance.proportions.arms
    return UPPER_ARM_SHARE * whole, FOREARM_SHARE * whole * appearance.proportions.forearms


def segment_offsets(appearance: Appearance) -> dict[str, Vector]:
    """Origins of the segments in their parents' frames, shares of stature.

    The spine lies in the back third of the trunk: C7 0.022 behind the middle of the hips (ours).
    """
    more, is_man = appearance.proportions, appearance.sex == "man"
    shoulder = shoulder_share(appearance)
    upper_arm, forearm = arm_shares(appearance)
    thigh, calf = (
        hip_share(appearance) - knee_share(appearance),
        knee_share(appearance) - SOLE_SHARE,
    )
    hip = (0.050 if is_man else 0.052) * more.hips
    reach = (0.106 if is_man else 0.098) * more.shoulders
    offsets: dict[str, Vector] = {
        "pelvis": (0.0, hip_share(appearance), 0.0),
        "abdomen": (0.0, 0.045, -0.008),
        "chest": (0.0, TORSO_SHARE - 0.045, -0.002),
        "neck": (0.0, shoulder + more.shoulder_slope + 0.034, -0.012),
        "head": (0.0, C7_DROP_SHARE + CHIN_DROP_SHARE, 0.018 + more.neck_forward),
    }
    for side, out, longer in (("l", 1.0, more.left_arm), ("r", -1.0, 1.0)):
        offsets |= {
            f"clavicle_{side}": (out * 0.015, shoulder + 0.004, 0.014),
            f"upper_arm_{side}": (out * (reach - 0.015), -0.004, -0.018),
            f"forearm_{side}": (0.0, -upper_arm * longer, 0.0),
            f"hand_{side}": (0.0, -forearm * longer, 0.0),
            f"thigh_{side}": (out * hip, 0.0, 0.0),
            f"calf_{side}": (0.0, -thigh, 0.0),
            f"foot_{side}": (0.0, -calf, 0.0),
        }
    return offsets


def joint_places(appearance: Appearance) -> dict[str, tuple[str, Vector, float]]:
    """Segment, place in it and half breadth of the flesh there, shares of stature."""
    g = appearance.girth
    head = head_share(appearance)
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
