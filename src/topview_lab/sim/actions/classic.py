"""Plain actions with fixed curves: wave, box, raise the arms, reach."""

from __future__ import annotations

import numpy as np

from topview_lab.sim.actions.act import SIDES, Act, Angles, Moment


def wave(moment: Moment) -> Act:
    """One hand beside the head swings from the elbow and the shoulder, about 1.2 times a second."""
    style = moment.style
    beat = np.sin(2.0 * np.pi * (1.2 * style.tempo * moment.time_s))
    return Act(
        {
            "upper_arm_r": (28.0 + 4.0 * beat, 74.0 * style.reach + 6.0 * beat, -72.0),
            "forearm_r": (92.0 - 24.0 * style.reach * beat, 0.0, 10.0),
            "hand_r": (0.0, 4.0 - 14.0 * beat, 0.0),
            "chest": (0.0, 3.0, -4.0),
        }
    )


def box(moment: Moment) -> Act:
    """Guard before the chin, and straight punches that take turns; the right hand leads."""
    beat = moment.time_s * 0.9 * moment.style.tempo
    angles: Angles = {}
    twist = 0.0
    for side, shift, to in (("r", 0.0, 1.0), ("l", 0.5, -1.0)):
        out = np.clip(np.sin(2.0 * np.pi * (beat + shift)), 0.0, None) ** 1.5
        out = min(float(out * moment.style.reach), 1.0)
        angles |= {
            f"upper_arm_{side}": (30.0 + 56.0 * out, 12.0 + 4.0 * out, 8.0 + 10.0 * out),
            f"forearm_{side}": (126.0 - 116.0 * out, 0.0, 20.0 + 40.0 * out),
            f"hand_{side}": (0.0, 0.0, 0.0),
        }
        twist += to * 14.0 * out
    return Act(
        angles
        | {
            "pelvis": (3.0, 0.0, 0.2 * twist),
            "abdomen": (4.0, 0.0, 0.3 * twist),
            "chest": (6.0, 0.0, 0.7 * twist),
            "neck": (8.0, 0.0, -0.7 * twist),
        }
    )


def _there_and_back(moment: Moment) -> float:
    """0 to 1 and back, every three seconds."""
    return 0.5 - 0.5 * float(np.cos(2.0 * np.pi * moment.time_s * moment.style.tempo / 3.0))


def raise_arms(moment: Moment) -> Act:
    """Both arms go up sideways and down again."""
    up = _there_and_back(moment)
    angles: Angles = {}
    for side in SIDES:
        raised = 10.0 + 142.0 * moment.style.reach * up
        angles |= {
            f"upper_arm_{side}": (8.0 * up, raised, 10.0 - 20.0 * up),
            f"forearm_{side}": (16.0 - 8.0 * up, 0.0, 10.0),
        }
    return Act(angles)


def reach(moment: Moment) -> Act:
    """One arm reaches forward and up, the trunk follows; back again."""
    far = _there_and_back(moment) * moment.style.reach
    return Act(
        {
            "abdomen": (9.0 * far, 0.0, 5.0 * far),
            "chest": (8.0 * far, 0.0, 10.0 * far),
            "neck": (-4.0 * far, 0.0, -4.0 * far),
            "upper_arm_r": (6.0 + 92.0 * far, 10.0 + 6.0 * far, 12.0 - 20.0 * far),
            "forearm_r": (18.0 + 42.0 * far * (1.0 - far), 0.0, 15.0),
        }
    )
