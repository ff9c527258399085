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
from topview_lab.sim.render import Drawing, Renderer
from topview_lab.sim.scene import Scene
from topview_lab.sim.sensor import KINECT_V1, DepthCamera, Sensor
from topview_lab.sim.truth import FrameTruth, frame_truth

_JOINTS = len(SIM_JOINT_NAMES)
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
        self._bodies = [actor.body for actor in scene.actors]
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
            yield self._frame(index, *self._sensed(index, self._renderer.draw(index)))

    def _frame(self, index: int, depth_mm: NDArray[np.uint16], color: NDArray[np.uint8]) -> Frame:
        return Frame(
            index=index,
            timestamp_s=index / self.scene.fps,
            depth_m=depth_mm.astype(np.float32) / np.float32(1000.0),
            camera=self.camera,
            color=color,
        )

    def simulate(self, index: int) -> SimulatedFrame:
        """One frame, the same whichever were simulated before."""
        drawing = self._renderer.draw(index)
        depth_mm, color = self._sensed(index, drawing)
        rendering, bodies = drawing.rendering, self._bodies
        return SimulatedFrame(
            index=index,
            depth_mm=depth_mm,
            color=color,
            mask=np.where(rendering.instance == FURNITURE, ROOM, rendering.instance),
            part=np.where(rendering.part == NO_PART, 0, rendering.part + 1).astype(np.uint8),
            truth=frame_truth(bodies, drawing.Ts_camera_segment, rendering, self.camera),
        )

    def _sensed(self, index: int, drawing: Drawing) -> tuple[NDArray[np.uint16], NDArray[np.uint8]]:
        """The depth image in millimetres, and the colours."""
        scene, rng = self.scene, noise_generator(self.scene.seed, index)
        posed = zip(self._bodies, drawing.Ts_camera_segment, strict=True)
        joints = np.array([body.joints(Ts) for body, Ts in posed]).reshape(-1, _JOINTS, 3)
        feet = 0.5 * (joints[:, _ANKLES] + joints[:, _BALLS]).reshape(-1, 3)
        levels = scene.light.levels(scene.time_s(index))
        depth_mm = self._depth_camera.sense(drawing.rendering, rng)
        return depth_mm, self._color_camera.picture(drawing.rendering, feet, levels, rng)
