"""The torso's cylinder: how large it is, and where it hangs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from topview.body.model import HEAD_CENTRE
from topview.body.proportions import THESIS
from topview.records import check_range


@dataclass(frozen=True, slots=True)
class TorsoShape:
    """The cylinder of a torso and how it hangs below the head, in shares of the stature.

    Attributes:
        half_width, half_depth: semi-axes, across and from back to front, 0.01 to 0.5.
        length: from the neck joint down, 0.01 to 1.
        neck_below, neck_behind: the neck joint from the head's centre, along the axis and to the
            back, 0 to 0.2.
        ahead: of the cylinder's axis from the neck joint to the front, 0 to 0.2.

    Raises:
        InputError: a value out of range.
    """

    half_width: float
    half_depth: float
    length: float
    neck_below: float
    neck_behind: float
    ahead: float

    def __post_init__(self) -> None:
        check_range(self, 0.01, 0.5, "half_width", "half_depth")
        check_range(self, 0.01, 1.0, "length")
        check_range(self, 0.0, 0.2, "neck_below", "neck_behind", "ahead")

    @property
    def semi_axes(self) -> tuple[float, float]:
        """Across and from back to front."""
        return self.half_width, self.half_depth


# Ours. Without the shoulders, so that hanging arms stay outside, and before the neck joint, so that
# the chest lies inside. The neck joint: means of the bodies of the simulator, standing or leaning.
NARROW: Final = TorsoShape(0.072, 0.060, 0.33, neck_below=0.09, neck_behind=0.045, ahead=0.06)
# Table 3.1: as broad as the shoulders, as long as the torso, straight below the head. The depth,
# which the thesis does not print, is that of the chest.
SHOULDER_WIDE: Final = TorsoShape(
    0.13,
    THESIS.upper_torso_radii[1],
    THESIS.torso,
    neck_below=(1.0 - HEAD_CENTRE) * THESIS.head,
    neck_behind=0.0,
    ahead=0.0,
)
