"""People found in simulated recordings: by the people finder alone, or by the whole tracker."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import radians
from typing import Final, Literal, NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from topview.body import JOINT_NAMES
from topview.camera.pyramid import Pyramid
from topview.detect.detectors import DepthAndSkinHeads, DetectorName, SkinHeads
from topview.detect.skin import BackgroundName, SkinSettings
from topview.people.finder import PeopleFinder
from topview.people.settings import PeopleSettings
from topview.people.users import by_depth
from topview.records import Frame
from topview.timing import StageClock
from topview.track import Tracker, TrackerSettings
from topview_lab.datasets.true_heads import HEAD_NAME
from topview_lab.metrics.heads import PeopleFound, TrueHeads, measure_heads
from topview_lab.sim import Scene, SimulatedRecording, scene_by_name
from topview_lab.sim.appearance import SKINS
from topview_lab.sim.bodies import SIM_JOINT_NAMES
from topview_lab.sim.light import Light
from topview_lab.sim.scene import Mount
from topview_lab.sim.truth import FrameTruth

Image = NDArray[np.uint8]
Colour = Literal["as it is", "none", "grey", "dark", "bright"]
AUTO: Final = "auto"
DETECTOR_NAMES: Final[tuple[DetectorName, ...]] = ("auto", "depth", "skin", "cascade")
BACKGROUNDS: Final[dict[str, tuple[DetectorName, type[SkinHeads], BackgroundName]]] = {
    "auto, mixtures of colour and depth": ("auto", DepthAndSkinHeads, "mixtures"),
    "skin, mixtures of colour alone": ("skin", SkinHeads, "colors"),
    "skin, what keeps still in depth": ("skin", SkinHeads, "still"),
}
"""Detectors that search skin before another background than by default."""
WITH_NETWORK: Final = "auto, with bodies and the joint network"
"""The whole tracker as it is by default."""
TONE_GROUPS: Final = ("light", "middle", "dark")
HEAD_JOINT: Final = SIM_JOINT_NAMES.index(HEAD_NAME)

DARK, BRIGHT = 0.2, 2.5
"""Factors on the grey levels of an under- and an over-exposed picture (ours)."""
LAMP: Final = Light(switches_s=(-5.0, 1.5))
"""Off, until it is switched on."""


@dataclass(frozen=True, slots=True)
class Conditions:
    """Special conditions of a recording.

    Attributes:
        name: "" for the usual conditions.
        mount, light: in place of the scene's.
        colour: change of the colour image.
    """

    name: str = ""
    mount: Mount | None = None
    light: Light | None = None
    colour: Colour = "as it is"


USUAL: Final = Conditions()
SPECIAL: Final = (
    Conditions("nothing special"),
    Conditions("camera 1.2 m high, level", mount=Mount(1.2, 0.0)),
    Conditions("camera 1.8 m high, 15° down", mount=Mount(1.8, radians(15))),
    Conditions("camera 2.5 m high, 30° down", mount=Mount(2.5, radians(30))),
    Conditions("camera 0.6 m high, level", mount=Mount(0.6, 0.0)),
    Conditions("no floor in view", mount=Mount(1.5, radians(-10))),
    Conditions("no colour", colour="none"),
    Conditions("grey", colour="grey"),
    Conditions("under-exposed", colour="dark"),
    Conditions("over-exposed", colour="bright"),
    Conditions("lamp switched on", light=LAMP),
)


@dataclass(frozen=True, slots=True)
class Case:
    """A simulated recording in which people are to be found.

    Attributes:
        scene, seed, frames, people: as `topview_lab.sim.scene_by_name` has them.
        start_s: where in the scene it begins.
        conditions: what is special about it.
    """

    scene: str
    seed: int
    frames: int
    people: int | None = None
    start_s: float = 0.0
    conditions: Conditions = USUAL

    def make(self) -> Scene:
        scene = scene_by_name(self.scene, seed=self.seed, frames=self.frames, people=self.people)
        return replace(
            scene,
            start_s=self.start_s,
            mount=self.conditions.mount or scene.mount,
            light=self.conditions.light or scene.light,
        )


@dataclass(frozen=True, slots=True, eq=False)
class Finding:
    """What was found in one case.

    Attributes:
        tones: of each person's skin.
        found: by detector.
    """

    tones: tuple[str, ...]
    found: dict[str, PeopleFound]


class FoundHead(NamedTuple):
    """Somebody who is found in a frame: the identity, and [3] the head."""

    id: int
    head_camera: NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Search:
    """Find the people of a case with each of some detectors, in any process."""

    case: Case
    detectors: tuple[str, ...] = (*DETECTOR_NAMES, *BACKGROUNDS, WITH_NETWORK)

    def __call__(self) -> Finding:
        scene = self.case.make()
        recording = SimulatedRecording(scene)
        seekers = {name: seeker_by_name(name) for name in self.detectors}
        heads: dict[str, list[list[FoundHead]]] = {name: [] for name in self.detectors}
        truths: list[FrameTruth] = []
        for index in range(scene.frames):
            simulated = recording.simulate(index)
            frame = Frame(
                index,
                index / scene.fps,
                simulated.depth_mm.astype(np.float32) / np.float32(1000.0),
                scene.camera,
                altered_color(simulated.color, self.case.conditions.colour),
            )
            truths.append(simulated.truth)
            for name, seek in seekers.items():
                heads[name].append(seek(frame))
        return Finding(
            tuple(_tone(actor.body.appearance.skin) for actor in scene.actors),
            {name: compared_with_truth(own, truths, scene.fps) for name, own in heads.items()},
        )


def seeker_by_name(name: str) -> Callable[[Frame], list[FoundHead]]:
    """What finds heads in one frame after the other: a finder (`finder_by_name`), or the whole
    tracker."""
    if name == WITH_NETWORK:
        tracker, head = Tracker(TrackerSettings(threads=1)), JOINT_NAMES.index(HEAD_NAME)
        return lambda frame: [
            FoundHead(person.id, person.joints_camera[head]) for person in tracker.update(frame)
        ]
    finder = finder_by_name(name)
    return lambda frame: [
        FoundHead(user.id, user.head_camera) for user in by_depth(finder.update(Pyramid(frame)))
    ]


def finder_by_name(name: str) -> PeopleFinder:
    """A new finder with one of `DETECTOR_NAMES` or `BACKGROUNDS`."""
    if name not in BACKGROUNDS:
        return PeopleFinder(PeopleSettings(detector=cast(DetectorName, name)))
    detector, heads, background = BACKGROUNDS[name]
    skin = SkinSettings(background=background)
    return PeopleFinder(PeopleSettings(detector=detector), heads(StageClock(), skin))


def compared_with_truth(
    heads: Sequence[Sequence[FoundHead]], truths: Sequence[FrameTruth], fps: float
) -> PeopleFound:
    """Heads of F frames against their truths."""
    slots = max(map(len, heads), default=0)
    found_camera = np.full((len(heads), slots, 3), np.nan)
    ids = np.zeros((len(heads), slots), np.int64)
    for f, frame in enumerate(heads):
        for slot, head in enumerate(frame):
            found_camera[f, slot] = head.head_camera
            ids[f, slot] = head.id
    return measure_heads(true_heads(truths), found_camera, ids, np.arange(len(heads)) / fps)


def true_heads(truths: Sequence[FrameTruth]) -> TrueHeads:
    """What F simulated frames say of where heads are and how much of people is to be seen."""
    outside = np.array([truth.part_hidden.mean(truth.part_area).outside for truth in truths])
    return TrueHeads(
        np.array([truth.joints[:, HEAD_JOINT] for truth in truths]),
        np.clip([visible_shares(truth) for truth in truths], 0.0, 1.0),
        np.clip(outside, 0.0, 1.0),
        np.ones(outside.shape, np.bool_),
    )


def visible_shares(truth: FrameTruth) -> NDArray[np.float64]:
    """[P] visible share of each person: in view, and hidden by neither people nor objects."""
    hidden = truth.part_hidden.mean(truth.part_area)
    return 1.0 - hidden.by.sum(-1) - hidden.by_furniture - hidden.outside


def altered_color(color: Image, colour: Colour) -> Image | None:
    """[H, W, 3] the image under changed colour or exposure; None for no colour."""
    if colour == "none":
        return None
    if colour == "grey":
        return np.repeat(color.mean(-1, keepdims=True).astype(np.uint8), 3, axis=-1)
    factor = {"as it is": 1.0, "dark": DARK, "bright": BRIGHT}[colour]
    return np.minimum(factor * color, 255.0).astype(np.uint8)


def _tone(skin: tuple[float, float, float]) -> str:
    return TONE_GROUPS[SKINS.index(skin) * len(TONE_GROUPS) // len(SKINS)]
