"""Windows that the tracker asks the joint network about, and whether they show a person."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final
from zlib import crc32

import numpy as np
from numpy.typing import NDArray

from topview.camera.pyramid import Pyramid
from topview.detect.joints import JointProposals, Windows
from topview.detect.joints.network import JointNetwork
from topview.records import InputError
from topview.track.settings import TrackerSettings
from topview.track.tracker import Tracker
from topview_lab.datasets.simulated import MadeScene
from topview_lab.sim.scenes.postures import held_postures
from topview_lab.training.joints.recordings import LabelledRecording, gathered, read_labelled
from topview_lab.training.joints.simulated import posture_recording, posture_scenes
from topview_lab.training.joints.windows import Variation, labelled_window, put_into_room
from topview_lab.training.people import KnownPeople, TrueExistence, TruePeople
from topview_lab.training.person_head import seen_under

Floats = NDArray[np.float32]

# Ours: so many windows of a recording are varied, too, as no recording has them: without a
# background, with wrong masks. Of them so many show no person, and more than one; and in so many
# somebody is cut by the border, as whoever enters is. And so many of those that the tracker asked
# about are put into another recording's room.
VARIED_WINDOWS: Final = 80
# And of a person in postures so many are held, each for so many frames.
HELD_EVERY, HELD_FRAMES = 2, 6
# What is asked about nearer than this to the head of somebody who may lie can be legs.
LEGS_REACH_M: Final = 2.0
VARIED: Final = replace(Variation(), nobody_share=0.25, several_share=0.1, border_share=0.3)


@dataclass(frozen=True, slots=True, eq=False)
class WindowRows:
    """N windows.

    Attributes:
        seen: [N, C] what the network's head that tells people sees.
        is_person: [N].
        is_varied: [N] whether a window was varied, and none that the tracker asked about.
    """

    seen: Floats
    is_person: NDArray[np.bool_]
    is_varied: NDArray[np.bool_]

    @classmethod
    def joined(cls, parts: Sequence[WindowRows]) -> WindowRows:
        """One after the other."""
        return cls(
            np.concatenate([part.seen for part in parts]),
            np.concatenate([part.is_person for part in parts]),
            np.concatenate([part.is_varied for part in parts]),
        )


@dataclass(frozen=True, slots=True, eq=False)
class CollectedWindows:
    """Of one recording: the windows, or None and why, in one line."""

    name: str
    rows: WindowRows | None
    problem: str = ""


@dataclass(frozen=True, slots=True)
class WindowsJob:
    """One recording to collect windows from, in any process.

    Attributes:
        recording: whose people are known.
        folder: where it lies, if it has joints and masks, for varied windows; None for none.
        room: where another such recording lies, to put people and furniture into; None for none.
        weights: of the network whose head is to be learnt.
    """

    recording: KnownPeople
    folder: Path | None
    room: Path | None
    weights: Path

    def __call__(self) -> CollectedWindows:
        name = self.recording.name
        try:
            asked = _asked_windows(self.recording, self.weights)
            varied = [] if self.folder is None else _varied_windows(read_labelled(self.folder))
            if self.room is not None:
                varied += _windows_elsewhere(asked, read_labelled(self.room))
        except InputError as error:
            return CollectedWindows(name, None, f"{name}: {error}")
        windows = [*asked, *varied]
        if not windows:
            return CollectedWindows(name, None, f"{name}: nothing was followed")
        return CollectedWindows(name, _rows_of(windows, len(varied), self.weights))


@dataclass(frozen=True, slots=True)
class PosturesJob:
    """Windows of somebody simulated who lies, kneels, bends, in any process: what the tracker asks
    about where some of the postures are held from the first frame on, and varied ones.

    Attributes:
        number: of the person, the seed.
        weights: of the network whose head is to be learnt.
    """

    number: int
    weights: Path

    def __call__(self) -> CollectedWindows:
        recording = posture_recording(self.number)
        asked = [
            window
            for scene in posture_scenes(self.number)
            for own in held_postures(scene, HELD_EVERY, HELD_FRAMES)
            for window in _asked_windows(MadeScene(own), self.weights, LEGS_REACH_M)
        ]
        varied = _varied_windows(recording)
        rows = _rows_of([*asked, *varied], len(varied), self.weights)
        return CollectedWindows(recording.name, rows)


class _WatchedNetwork:
    """A `JointProposer` that keeps what it was asked about."""

    def __init__(self, weights: Path) -> None:
        self.windows: Windows | None = None
        self._network = JointNetwork(weights)

    def propose(self, windows: Windows) -> JointProposals:
        self.windows = windows
        return self._network.propose(windows)


def _asked_windows(
    known: KnownPeople, weights: Path, body_m: float = 0.0
) -> list[tuple[Floats, bool]]:
    """What the tracker asks about people, and about whoever is in doubt, frame by frame; of what is
    no head and within `body_m` of one nothing."""
    truth, existence, network = known.true_heads(), TrueExistence(), _WatchedNetwork(weights)
    finder = TruePeople(existence)
    settings = TrackerSettings(method="joints", threads=1)
    tracker = Tracker(settings, finder=finder, proposer=network)
    seen: list[tuple[Floats, bool]] = []
    for frame in known.open():
        existence.look_at(truth, frame.index)
        network.windows = None
        tracker.update(frame)
        if finder.found is None or network.windows is None:
            continue
        by_id = {track.told_as: track for track in finder.found.tracks}
        asked = [*finder.found.users, *finder.doubtful[:1]]
        for user, image, is_used in zip(
            asked, network.windows.looked_at, network.windows.is_used, strict=True
        ):
            track = by_id.get(user.id)
            label = None
            if is_used and track is None:
                view = Pyramid(finder.found.scene.cloud.frame).full
                points_camera = view.points(*np.unravel_index(user.pixels, view.depth_m.shape))
                label = existence.label_of_cluster(points_camera)
            elif is_used and track is not None and track.is_seen:
                label = existence.label_of(track, finder.found.tracks)
            if label or (label is False and existence.away_m(user.head_camera) > body_m):
                seen.append((image, label))
    return seen


def _rows_of(windows: Sequence[tuple[Floats, bool]], varied: int, weights: Path) -> WindowRows:
    """What the head sees of windows, of which so many, the last ones, are varied."""
    images, is_person = zip(*windows, strict=True)
    seen = seen_under(weights.read_bytes())(np.array(images))
    is_varied = np.arange(len(windows)) >= len(windows) - varied
    return WindowRows(seen, np.array(is_person), is_varied)


def _windows_elsewhere(
    windows: Sequence[tuple[Floats, bool]], room: LabelledRecording
) -> list[tuple[Floats, bool]]:
    """Some of the windows, in the room of another recording."""
    donors = _varied_windows(room)
    if not windows or not donors:
        return []
    rng = np.random.default_rng(crc32(room.name.encode()))
    elsewhere = []
    for (donor, _), number in zip(donors, rng.integers(0, len(windows), len(donors)), strict=True):
        image, is_person = windows[number]
        elsewhere.append((image.copy(), is_person))
        put_into_room(elsewhere[-1][0], donor)
    return elsewhere


def _varied_windows(recording: LabelledRecording) -> list[tuple[Floats, bool]]:
    samples = gathered([recording])
    if not len(samples):
        return []
    rng = np.random.default_rng(crc32(recording.name.encode()))
    numbers = rng.integers(0, len(samples), VARIED_WINDOWS)
    windows = [labelled_window(samples, int(number), rng, VARIED) for number in numbers]
    return [(window.image, window.is_person) for window in windows]
