"""How people are found: one frozen record."""

from __future__ import annotations

from dataclasses import dataclass, field

from topview.detect.detectors import DetectorName
from topview.people.floor import FloorSettings
from topview.people.pieces import PieceSettings
from topview.people.scene import SceneSettings
from topview.people.segmentation import SegmentationSettings
from topview.people.validation import PersonLimits


@dataclass(frozen=True, slots=True)
class PeopleSettings:
    """How people are found.

    Attributes:
        detector: of heads: "auto" takes depth and, where the recording allows, the colour of skin;
            "depth", "skin" (Sec. 4.1) and "cascade" (frontal faces) that alone.
        new_confidence: a head's, from which it makes a user: at once in the very first frame, else
            once it was seen often enough.
        upright_confidence: that a new head stands upright; furniture often seems to lean.
        new_s: for how long a new head must be seen, in every frame.
        least_apart_m: two heads, seen from above; a shoulder is nearer to its own head.
        grace_s: how long a user who is hidden is waited for.
        out_s: the same for one who went out of the picture.
        headless_s: for how long at most the waiting does not begin, as enough of the body is seen.
        border_m: a head this near to the border may have gone out of the picture.
        floor: which planes may be a floor.
        scene: what is floor and what is furniture.
        segmentation: which points are whose.
        pieces: which loose pieces may be limbs.
        limits: what a person measures.
    """

    detector: DetectorName = "auto"
    new_confidence: float = 0.75
    upright_confidence: float = 0.55
    new_s: float = 0.05
    least_apart_m: float = 0.33
    grace_s: float = 5.0
    out_s: float = 0.5
    headless_s: float = 20.0
    border_m: float = 0.15
    floor: FloorSettings = field(default_factory=FloorSettings)
    scene: SceneSettings = field(default_factory=SceneSettings)
    segmentation: SegmentationSettings = field(default_factory=SegmentationSettings)
    pieces: PieceSettings = field(default_factory=PieceSettings)
    limits: PersonLimits = field(default_factory=PersonLimits)
