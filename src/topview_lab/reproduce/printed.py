"""The numbers that the thesis prints, Ch. 5 and 6."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal


@dataclass(frozen=True, slots=True)
class Printed:
    """Mean and standard deviation in cm or degrees, share within 10 of them; None: not printed."""

    mean: float
    std: float
    within_10: float | None = None


TABLE_6_1: Final[dict[str, Printed]] = {
    "NiTE": Printed(5.29, 4.95, 0.873),
    "bPSO": Printed(6.22, 6.95, 0.823),
    "pPSO": Printed(4.18, 3.31, 0.944),
    "HYBRID": Printed(4.55, 4.41, 0.925),
    "uTVR": Printed(4.43, 2.97, 0.905),
}
"""12 subjects of Berkeley MHAD, boxing; cm. bPSO, pPSO and HYBRID used two Kinects."""

TABLE_6_2: Final[dict[str, Printed]] = {
    "NiTE": Printed(5.45, 4.62, 0.863),
    "bPSO": Printed(5.06, 4.88, 0.895),
    "pPSO": Printed(3.93, 2.73, 0.963),
    "HYBRID": Printed(4.45, 3.54, 0.942),
    "uTVR": Printed(4.27, 3.05, 0.948),
}
"""Subject 09 of Berkeley MHAD, 11 actions; cm."""

Occlusion = Literal["0 %", "30 %", "60 %"]
OCCLUSIONS: Final[tuple[Occlusion, ...]] = ("0 %", "30 %", "60 %")

TABLE_6_3: Final[dict[str, dict[Occlusion, Printed]]] = {
    "reproj × align": {
        "0 %": Printed(11.3, 10.1, 0.80),
        "30 %": Printed(13.8, 13.0, 0.74),
        "60 %": Printed(15.7, 14.4, 0.70),
    },
    "align × discr": {
        "0 %": Printed(15.9, 15.4, 0.71),
        "30 %": Printed(17.6, 16.3, 0.65),
        "60 %": Printed(18.8, 17.1, 0.57),
    },
    "reproj × discr": {
        "0 %": Printed(10.8, 6.7, 0.89),
        "30 %": Printed(12.3, 9.1, 0.84),
        "60 %": Printed(15.2, 12.8, 0.79),
    },
    "all (f_uTVR)": {
        "0 %": Printed(9.5, 4.5, 0.96),
        "30 %": Printed(11.5, 6.7, 0.91),
        "60 %": Printed(14.2, 7.8, 0.84),
    },
}
"""The torso, with a factor of f_uTVR left out, by how much of it is occluded; degrees."""

Group = Literal["torso", "arms", "legs"]
GROUPS: Final[tuple[Group, ...]] = ("torso", "arms", "legs")
Part = Literal["overall", "occluded"]
FRAME_SETS: Final[tuple[Part, ...]] = ("overall", "occluded")
"""All frames, and those in which another person occludes the user."""

TABLE_6_4: Final[dict[Group, dict[str, dict[Part, Printed]]]] = {
    "torso": {
        "uTVR": {"overall": Printed(9.50, 4.56, 0.96), "occluded": Printed(13.36, 6.22, 0.87)},
        "Kinect SDK": {
            "overall": Printed(12.95, 5.70, 0.92),
            "occluded": Printed(18.89, 7.43, 0.82),
        },
    },
    "arms": {
        "uTVR": {"overall": Printed(7.39, 4.50, 0.92), "occluded": Printed(17.10, 6.30, 0.82)},
        "Kinect SDK": {
            "overall": Printed(7.38, 4.30, 0.89),
            "occluded": Printed(20.22, 9.07, 0.75),
        },
    },
    "legs": {
        "uTVR": {"overall": Printed(8.67, 5.74, 0.93), "occluded": Printed(13.03, 7.40, 0.82)},
        "Kinect SDK": {
            "overall": Printed(8.47, 5.59, 0.91),
            "occluded": Printed(14.80, 9.50, 0.79),
        },
    },
}
"""Relative angles by group of joints; degrees."""

TABLE_5_2: Final[dict[str, dict[Part, Printed]]] = {
    "bTVR": {"overall": Printed(7.40, 3.70), "occluded": Printed(11.39, 6.48)},
    "NiTE": {"overall": Printed(8.03, 4.20), "occluded": Printed(14.14, 7.57)},
}
"""The torso by bTVR; degrees."""
