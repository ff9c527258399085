"""Renders of people with labelled skin, faces and hands: the default tables are learnt from
them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from topview.records import Frame
from topview_lab.sim import SCENES as SCENE_NAMES
from topview_lab.sim import Scene, SimulatedRecording, scene_by_name
from topview_lab.sim.appearance import CLOTHS, DENIMS, Rgb
from topview_lab.sim.bodies import SIM_JOINT_NAMES, build_body
from topview_lab.sim.flesh import SKIN as SKIN_MATERIAL
from topview_lab.sim.render import Renderer
from topview_lab.sim.scene import Actor
from topview_lab.training.hands import KIND_OF_JOINT, LabelledFrame
from topview_lab.training.skin import IS_SKIN, NOT_SKIN, UNKNOWN, LabelledImage
from topview_lab.training.tones import SKIN_TONES, random_tone, relit

# Ours: stride over the room's pixels in the not-skin class, so that people and clothes weigh as
# much as the room.
ROOM_STRIDE: Final = 6
SKIN_SCENES: Final = ("wave", "raise_arms", "reach", "box")
FRAMES: Final = 60
# Ours: of each scene, its first frames at 15 a second, which are enough to show its motion.
HAND_FRAMES: Final = 72
HAND_STEP: Final = 2
# Ours: how much the colours of cloth and walls vary about the simulator's, as a logarithm.
DYE_SPREAD: Final = 0.25


def simulated_skin(
    per_tone: int, seed: int = 0, tones: Sequence[str] = tuple(SKIN_TONES)
) -> Iterator[LabelledImage]:
    """Renders of people of each tone, in random clothes, rooms and light."""
    for t, tone in enumerate(tones):
        for n in range(per_tone):
            yield _render(tone, np.random.default_rng((seed, t, n)))


def simulated_hands(seeds: Iterable[int]) -> Iterator[Iterator[LabelledFrame]]:
    """Every scene of the simulator, with the people of each seed."""
    for seed in seeds:
        for name in SCENE_NAMES:
            yield _with_places(scene_by_name(name, seed=seed, frames=HAND_FRAMES))


def _with_places(scene: Scene) -> Iterator[LabelledFrame]:
    recording = SimulatedRecording(scene)
    for index in range(0, scene.frames, HAND_STEP):
        made = recording.simulate(index)
        depth_m = made.depth_mm.astype(np.float32) / np.float32(1000.0)
        frame = Frame(index, index / scene.fps, depth_m, scene.camera, made.color)
        places = {
            kind: made.truth.joints[:, SIM_JOINT_NAMES.index(name)]
            for name, kind in KIND_OF_JOINT.items()
        }
        yield LabelledFrame(frame, places, made.mask > 0)


def _render(tone: str, rng: np.random.Generator) -> LabelledImage:
    scene = scene_by_name(
        SKIN_SCENES[rng.integers(len(SKIN_SCENES))], seed=int(rng.integers(2**31)), frames=FRAMES
    )
    actors = tuple(_recolored(actor, random_tone(tone, rng), rng) for actor in scene.actors)
    room = replace(scene.room, walls=_dyed(scene.room.walls, rng), floor=_dyed(CLOTHS[3], rng))
    scene = replace(scene, actors=actors, room=room)
    index = int(rng.integers(FRAMES))
    made = SimulatedRecording(scene).simulate(index)
    truth = Renderer(scene).draw(index).rendering
    label = np.full(truth.material.shape, UNKNOWN, np.uint8)
    label[::ROOM_STRIDE, ::ROOM_STRIDE] = NOT_SKIN
    label[made.mask > 0] = NOT_SKIN
    label[truth.material == SKIN_MATERIAL] = IS_SKIN
    rgb = relit(made.color, rng)
    depth_m = made.depth_mm.astype(np.float32) / np.float32(1000.0)
    return LabelledImage(rgb, label, tone, Frame(0, 0.0, depth_m, scene.camera, rgb), made.mask > 0)


def _recolored(actor: Actor, skin: Rgb, rng: np.random.Generator) -> Actor:
    appearance = actor.body.appearance
    cloths = [*CLOTHS, *DENIMS]
    shirt, trousers = (_dyed(cloths[rng.integers(len(cloths))], rng) for _ in range(2))
    clothes = replace(appearance.clothes, shirt=shirt, trousers=trousers)
    return replace(actor, body=build_body(replace(appearance, skin=skin, clothes=clothes)))


def _dyed(color: Rgb, rng: np.random.Generator) -> Rgb:
    red, green, blue = np.clip(color * np.exp(rng.normal(0.0, DYE_SPREAD, 3)), 0.0, 1.0).tolist()
    return red, green, blue
