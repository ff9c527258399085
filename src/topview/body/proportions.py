"""Sizes of the body's parts as shares of the stature H."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final


@dataclass(frozen=True, slots=True)
class Proportions:
    """Lengths, joint places and radii, all in shares of the stature.

    Attributes:
        head: crown to neck joint.
        torso: neck joint to the height of the hips.
        waist: neck joint to the articulation between upper and lower torso.
        shoulder_drop: neck joint down to the height of the shoulder joints.
        shoulder_half_breadth: spine to each shoulder joint.
        hip_half_breadth: spine to each hip joint.
        upper_arm, forearm, upper_leg, lower_leg: lengths of the limbs' parts; a forearm ends at
            the palm, a lower leg at the sole.
        ankle_height: sole to ankle joint.
        head_radii, upper_torso_radii, lower_torso_radii: (x, z) semi-axes across these parts.
        upper_arm_radius, forearm_radius, upper_leg_radius, lower_leg_radius: limbs are round.
    """

    head: float
    torso: float
    waist: float
    shoulder_drop: float
    shoulder_half_breadth: float
    hip_half_breadth: float
    upper_arm: float
    forearm: float
    upper_leg: float
    lower_leg: float
    ankle_height: float
    head_radii: tuple[float, float]
    upper_torso_radii: tuple[float, float]
    lower_torso_radii: tuple[float, float]
    upper_arm_radius: float
    forearm_radius: float
    upper_leg_radius: float
    lower_leg_radius: float


# Lengths: Table 3.1, "employed"; its shoulder breadth of 26 % is over the arms' outer sides, so a
# joint lies half of that less an arm's radius from the spine. Ankle: Drillis and Contini (1966),
# 3.9 %; shoulder joints at 81.8 % and hip breadth 19.1 % over the outer sides, same source.
# Radii: means of the ANSUR survey, men and women together (Gordon et al. 1989, NATICK/TR-89/044):
# head breadth 14.8 and length 19.2 cm; chest breadth 30.1 and depth 24.1; waist to hip breadth 33
# and waist depth 21; circumferences of the arm (flexed biceps, elbow) 28.9, of the forearm (at its
# fullest, wrist) 23, of the leg (thigh, knee) 47.4 and of the lower leg (calf, ankle) 29.2 cm, each
# the mean of the part's two ends, over the mean stature of 169.5 cm.
THESIS: Final = Proportions(
    head=0.13,
    torso=0.38,
    waist=0.19,
    shoulder_drop=0.052,
    shoulder_half_breadth=0.103,
    hip_half_breadth=0.051,
    upper_arm=0.18,
    forearm=0.19,
    upper_leg=0.25,
    lower_leg=0.24,
    ankle_height=0.039,
    head_radii=(0.0437, 0.0566),
    upper_torso_radii=(0.0888, 0.0711),
    lower_torso_radii=(0.0973, 0.0640),
    upper_arm_radius=0.0271,
    forearm_radius=0.0216,
    upper_leg_radius=0.0445,
    lower_leg_radius=0.0274,
)

# Joints where anatomy has them: Drillis and Contini (1966) as in Winter, "Biomechanics and Motor
# Control of Human Movement" (2009), Fig. 4.1: hip 53 %, knee 28.5 %, ankle 3.9 %, shoulder 81.8 %,
# upper arm 18.6 % measured from the acromion, forearm 14.6 % and 2.5 % on to the palm. The upper
# arm is told from the joint's centre (humerus, 15.9 %: Trotter and Gleser 1952). Breadths, ankles
# and radii are those of `THESIS`.
ANATOMICAL: Final = replace(
    THESIS,
    head=0.14,
    torso=0.33,
    shoulder_drop=0.042,
    upper_arm=0.159,
    forearm=0.171,
    upper_leg=0.245,
    lower_leg=0.285,
)
