"""A scene as a recording: frames as the simulated sensor sees them, without a disk."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from topview.records import Camera, Frame
from topview_lab.sim.bodies import SIM_JOINT_NAMES
from topview_lab.sim.colour import ColorCamera
from topview_lab.sim.images import FURNITURE, NO_PART, ROOM
from topview_lab.sim.noise import noise_generator
from topview_lab.sim.render import Renderer
from topview_lab.sim.scene import Scene
from topview_lab.sim.sensor import KINECT_V1, DepthCamera, Sensor
from topview_lab.sim.truth import FrameTruth, frame_truth

_ANKLES = [SIM_JOINT_NAMES.index(name) for name in ("ankle_l", "ankle_r")]
_BALLS = [SIM_JOINT_NAMES.index(name) for name in ("foot_l", "foot_r")]


@dataclass(frozen=True, slots=True, eq=False)
class SimulatedFrame:
    """What the sensor gives for a frame, and the truth.

    Attributes:
        index: number of the frame.
        depth_mm: [H, W] uint16, 0 = no reading.
        color: [H, W, 3] uint8 RGB.
        mask: [H, W] uint8, person k, 0 elsewhere; without noise.
        part: [H, W] uint8, 1 + index into `bodies.SIM_PART_NAMES`, 0 elsewhere; without noise.
        truth: joints and what hides them.
    """

    index: int
    depth_mm: NDArray[np.uint16]
    color: NDArray[np.uint8]
    mask: NDArray[np.uint8]
    part: NDArray[np.uint8]
    truth: FrameTruth


class SimulatedRecording:
    """A `topview.records.Recording` that is rendered while it is read."""

    def __init__(self, scene: Scene, sensor: Sensor = KINECT_V1) -> None:
        self.name: str = scene.name
        self.camera: Camera = scene.camera
        self.problems: list[str] = []
        self.scene = scene
        self.sensor = sensor
        self._renderer = Renderer(scene)
        self._depth_camera = DepthCamera(scene.camera, scene.seed, sensor)
        self._color_camera = ColorCamera(
            self._renderer.background,
            scene.camera,
            scene.mount.T_camera_room()[:3, :3],
            scene.seed,
            sensor.color_baseline_m,
        )

    @property
    def frame_count(self) -> int:
        return self.scene.frames

    def __iter__(self) -> Iterator[Frame]:
        for index in range(self.frame_count):
            frame = self.simulate(index)
            yield Frame(
                index=index,
                timestamp_s=index / self.scene.fps,
                depth_m=frame.depth_mm.astype(np.float32) / np.float32(1000.0),
                camera=self.camera,
                color=frame.color,
            )

    def simulate(self, index: int) -> SimulatedFrame:
        """One frame, the same whichever were simulated before."""
        scene, rng = self.scene, noise_generator(self.scene.seed, index)
        drawing = self._renderer.draw(index)
        rendering = drawing.rendering
        bodies = [actor.body for actor in scene.actors]
        truth = frame_truth(bodies, drawing.Ts_camera_segment, rendering, scene.camera)
        feet = 0.5 * (truth.joints[:, _ANKLES] + truth.joints[:, _BALLS]).reshape(-1, 3)
        levels = scene.light.levels(scene.time_s(index))
        return SimulatedFrame(
            index=index,
            depth_mm=self._depth_camera.sense(rendering, rng),
            color=self._color_camera.picture(rendering, feet, levels, rng),
            mask=np.where(rendering.instance == FURNITURE, ROOM, rendering.instance),
            part=np.where(rendering.part == NO_PART, 0, rendering.part + 1).astype(np.uint8),
            truth=truth,
        )
