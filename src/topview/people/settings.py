"""How people are found: one frozen record."""

from __future__ import annotations

from dataclasses import dataclass, field

from topview.detect.detectors import DetectorName
from topview.people.pieces import PieceSettings
from topview.people.segmentation import SegmentationSettings
from topview.room.areas import Areas
from topview.room.floor import FloorSettings
from topview.room.scene import SceneSettings


@dataclass(frozen=True, slots=True)
class PeopleSettings:
    """How people are found.

    Attributes:
        detector: of heads: "auto" takes depth and, where the recording allows, the colour of skin;
            "depth", "skin" (Sec. 4.1) and "cascade" (frontal faces) that alone.
        people: at most so many at the same time; None for any number.
        reidentify: whether somebody who left the picture and comes back is known again by clothes
            and stature, as is whoever was hidden in it.
        areas: where people are looked for.
        floor: which planes may be a floor.
        scene: what is floor and what is furniture.
        segmentation: which points are whose.
        pieces: which loose pieces may be limbs.
    """

    detector: DetectorName = "auto"
    people: int | None = None
    reidentify: bool = False
    areas: Areas = field(default_factory=Areas)
    floor: FloorSettings = field(default_factory=FloorSettings)
    scene: SceneSettings = field(default_factory=SceneSettings)
    segmentation: SegmentationSettings = field(default_factory=SegmentationSettings)
    pieces: PieceSettings = field(default_factory=PieceSettings)
