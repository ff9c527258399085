"""What the experiments track: simulated counterparts of the thesis's sequences, in variants."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import NamedTuple

from rich.console import Console

from topview.detect.joints.proposers import FINDER, NETWORK, NOTHING, ProposalsName
from topview.records import Recording
from topview.track import Tracker, TrackerSettings, TrackingResult, track_recording
from topview.track.body_tracker import BodyMethod
from topview.track.methods.joints import JointsSettings
from topview.track.methods.topview import TopviewSettings
from topview.track.methods.utvr import UtvrSettings
from topview_lab.datasets import EvaluatedRecording, FolderRecording
from topview_lab.evaluate.run import Job, Outcome, run_all
from topview_lab.metrics import Evaluation, ReferenceSequence, SequenceErrors
from topview_lab.reproduce.finding import Finding, Search
from topview_lab.sim import Scene, scene_by_name, write_scene
from topview_lab.sim.appearance import Appearance


@dataclass(frozen=True, slots=True)
class Variant:
    """A way to track: a method with its settings, and what proposes joints to it."""

    body: BodyMethod
    proposals: ProposalsName = NETWORK

    @property
    def settings(self) -> TrackerSettings:
        return TrackerSettings(method=self.body.name, threads=1, proposals=self.proposals)

    def __call__(self, recording: Recording, settings: TrackerSettings) -> TrackingResult:
        return track_recording(recording, tracker=Tracker(settings, body=self.body))


DEFAULT_VARIANT = Variant(TopviewSettings())
WITHOUT_NETWORK = Variant(TopviewSettings(), NOTHING)
NETWORK_ALONE = Variant(JointsSettings())
THESIS_RECIPE = Variant(UtvrSettings())
RECIPE_AND_NETWORK = Variant(UtvrSettings(), FINDER)


@dataclass(frozen=True, slots=True)
class Counterpart:
    """A simulated recording in place of one of the thesis's.

    Attributes:
        root: folder of all of them.
        scene, seed, frames: as `topview simulate` has them.
        start_s: where in the scene it begins.
        body: what to call the body that the first person has; "" for a drawn one.
        look: of that body.
    """

    root: Path
    scene: str
    seed: int
    frames: int
    start_s: float = 0.0
    body: str = ""
    appearance: Appearance | None = None

    @property
    def name(self) -> str:
        start = f"from{self.start_s:g}s" if self.start_s else ""
        return "_".join(filter(None, (self.scene, self.body, f"seed{self.seed}", start)))

    @property
    def folder(self) -> FolderRecording:
        return FolderRecording(self.root / self.name)

    def open(self) -> Recording:
        return self.folder.open()

    def reference(self) -> ReferenceSequence:
        return self.folder.reference()

    def make(self) -> Scene:
        appearances = None if self.appearance is None else (self.appearance,)
        scene = scene_by_name(
            self.scene, seed=self.seed, frames=self.frames, appearances=appearances
        )
        return replace(scene, start_s=self.start_s)

    def simulate(self) -> None:
        """Write it to its folder."""
        write_scene(self.make(), self.root / self.name, threads=1, force=True)


class Run(NamedTuple):
    """A recording that is tracked in some variant."""

    variant: Variant
    recording: EvaluatedRecording


@dataclass(frozen=True, slots=True, eq=False)
class Measured:
    """What was measured of runs, and found by searches."""

    outcomes: dict[Run, Outcome]
    findings: dict[Search, Finding] = field(default_factory=dict)

    def of(self, runs: Iterable[Run]) -> Evaluation:
        """The errors of those runs that could be measured."""
        outcomes = (self.outcomes.get(run) for run in runs)
        errors: list[SequenceErrors] = [o.errors for o in outcomes if o and o.errors is not None]
        return Evaluation(tuple(errors))


@dataclass(frozen=True, slots=True, eq=False)
class Tracked:
    """What became of all runs: errors, what went wrong, and whether Ctrl-C ended it early."""

    measured: Measured
    problems: tuple[str, ...]
    interrupted: bool


def track_runs(runs: Sequence[Run], workers: int, console: Console | None = None) -> Tracked:
    """Simulate what is to be simulated, then track and measure every run once."""
    runs = list(dict.fromkeys(runs))
    counterparts = dict.fromkeys(r.recording for r in runs if isinstance(r.recording, Counterpart))
    simulated = run_all([c.simulate for c in counterparts], workers, console, "simulating")
    if simulated.interrupted or simulated.problems:
        return Tracked(Measured({}), simulated.problems, simulated.interrupted)
    jobs = [Job(run.recording, run.variant.settings, run.variant) for run in runs]
    done = run_all(jobs, workers, console)
    outcomes = {run: o for run, o in zip(runs, done.results, strict=True) if o is not None}
    unread = dict.fromkeys(problem for outcome in outcomes.values() for problem in outcome.problems)
    return Tracked(Measured(outcomes), (*unread, *done.problems), done.interrupted)


def with_findings(
    tracked: Tracked, searches: Sequence[Search], workers: int, console: Console | None = None
) -> Tracked:
    """The same, and what the searches found."""
    if not searches:
        return tracked
    done = run_all(searches, workers, console, "finding people")
    findings = {s: found for s, found in zip(searches, done.results, strict=True) if found}
    return Tracked(
        replace(tracked.measured, findings=findings),
        (*tracked.problems, *done.problems),
        tracked.interrupted or done.interrupted,
    )
