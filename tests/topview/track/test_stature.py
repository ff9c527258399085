"""Which stature is believed, by what bodies of it leave unexplained."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar

from topview.track import Tracker, TrackerSettings
from topview.track.body_tracker import Needs, Subject
from topview.track.methods.topview import TopviewSettings, TopviewTracker
from topview.track.stature import StatureBelief, adults_cost
from topview_lab.sim import SimulatedRecording, scene_by_name


@dataclass(frozen=True)
class Watched:
    """The default method, which keeps whom it tracks."""

    needs: ClassVar[Needs] = TopviewSettings.needs
    name: str = "watched"
    subjects: list[Subject] = field(default_factory=list)

    def tracker(self, subject: Subject) -> TopviewTracker:
        self.subjects.append(subject)
        return TopviewSettings().tracker(subject)


def test_a_stature_that_explains_more_for_long_is_believed() -> None:
    belief = StatureBelief()
    belief.tell(1.1)
    for _ in range(60):
        tried_m = belief.next_m()
        cost, tried_cost = (0.4 - 0.3 * (m == 1.55) for m in (belief.stature_m, tried_m))
        belief.judge(cost, tried_cost)
    assert belief.stature_m == 1.55
    belief.tell(1.12)
    assert belief.stature_m == 1.55


def test_a_measured_stature_is_kept_where_others_explain_as_much() -> None:
    belief = StatureBelief()
    belief.tell(1.6)
    for _ in range(60):
        belief.next_m()
        belief.judge(0.4, 0.4)
    belief.tell(1.61)
    assert belief.stature_m == 1.61


def test_the_stature_of_the_first_poses_is_believed_until_one_is_measured() -> None:
    belief = StatureBelief()
    belief.begin(1.4)
    assert belief.stature_m == 1.4
    assert belief.is_doubted(is_lost=False)
    belief.tell(1.5)
    assert belief.stature_m == 1.5
    assert not belief.is_doubted(is_lost=False)
    assert belief.is_doubted(is_lost=True)


def test_while_none_is_measured_adults_are_likelier_wherever_it_began() -> None:
    """The first poses tell which stature to begin with, not which one is usual."""
    belief = StatureBelief()
    belief.begin(1.25)
    assert belief.stature_m == 1.25
    assert belief.prior == StatureBelief().prior
    assert adults_cost(1.25) > adults_cost(1.4) > adults_cost(1.9) > adults_cost(1.72) == 0.0


def test_what_the_body_has_told_of_its_stature_is_not_measured_away() -> None:
    belief = StatureBelief()
    belief.learn(1.6)
    belief.tell(1.1)
    assert belief.stature_m == 1.6
    assert belief.is_measured


def test_the_measured_one_is_believed_again_where_a_body_of_the_learnt_one_is_lost() -> None:
    belief = StatureBelief()
    belief.tell(1.5)
    belief.learn(1.5)
    belief.tell(1.87)
    assert belief.stature_m == 1.5
    assert belief.unlearn()
    assert belief.stature_m == 1.87
    belief.tell(1.86)
    assert belief.stature_m == 1.86
    assert not belief.unlearn()


def test_what_was_learnt_is_kept_where_nobody_could_measure_another() -> None:
    belief = StatureBelief()
    belief.learn(1.5)
    assert not belief.unlearn()
    assert belief.stature_m == 1.5


def test_a_stature_that_was_given_is_not_doubted() -> None:
    belief = StatureBelief(is_given=True)
    belief.tell(1.6)
    assert not belief.is_doubted(is_lost=True)


def test_who_has_a_given_stature_is_tracked_with_it() -> None:
    frame = next(iter(SimulatedRecording(scene_by_name("sitting", frames=1))))
    for stature_m in (None, 1.9):
        method = Watched()
        tracker = Tracker(TrackerSettings(threads=1, stature=stature_m), body=method)
        tracker.update(frame)
        assert [subject.stature_is_given for subject in method.subjects] == [stature_m is not None]
