"""A method that asks the joint network and fits nothing, for tests of who is found with it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from topview.timing import StageClock
from topview.track.body_tracker import Needs, Subject
from topview.track.evidence import Evidence
from topview.track.methods.utvr import UtvrSettings
from topview.track.pose import Pose
from topview.track.stances import STANDING, stand


@dataclass(frozen=True, slots=True)
class Standing:
    """Lets everybody stand."""

    needs: ClassVar[Needs] = Needs(joints=True)

    @property
    def name(self) -> str:
        return "standing"

    def tracker(self, subject: Subject) -> StandingTracker:
        return StandingTracker()


class StandingTracker:
    def __init__(self) -> None:
        self.model = UtvrSettings().tracker(Subject(1, 0, 1, StageClock())).model

    def update(self, evidence: Evidence) -> Pose:
        return stand(self.model, evidence.head_camera, STANDING, 0.0, evidence.up_camera)
