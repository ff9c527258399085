"""A simulated frame and cylinders in it, for the figures that show what the score counts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final, Literal

import numpy as np
from numpy.typing import NDArray

from topview.body.model import BodyModel
from topview.body.parts import PART_NAMES, UPPER_TORSO
from topview.body.proportions import THESIS
from topview.camera.pyramid import DepthView
from topview.geometry.rotations import transform
from topview.score.definition import Cylinder
from topview.score.utvr import Observed
from topview.track.methods.utvr import UtvrSettings
from topview_lab.reproduce.plots import OUTLINE_COLOR
from topview_lab.sim import GroundTruth, SimulatedRecording

Array = NDArray[np.float64]

AROUND: Final = np.linspace(0.0, 2 * np.pi, 73)
VIEWS: Final = {
    "front": (np.array([1.0, 0.0, 0.0]), "to the image's right, m"),
    "side": (np.array([0.0, 0.0, 1.0]), "away from the camera, m"),
    "oblique": (np.array([np.cos(0.7), 0.0, np.sin(0.7)]), "to the right and away, m"),
}
"""Where the horizontal axis of a picture points in the camera's frame, and its label. The vertical
one points up. Both start at the user's neck."""
ViewName = Literal["front", "side", "oblique"]
Layer = tuple[Array, str]
"""Points [N, 3] and their colour."""


@dataclass(frozen=True, slots=True, eq=False)
class Observation:
    """A simulated frame around its first person.

    Attributes:
        observed: the whole scene, and the first person in it.
        color: [H, W, 3].
        own_camera, other_camera: [N, 3] and [M, 3] points of the first person and of all others.
        T_camera_torso: [4, 4] the true upper torso, from the neck.
        stature_m: true.
    """

    observed: Observed
    color: NDArray[np.uint8]
    own_camera: Array
    other_camera: Array
    T_camera_torso: Array
    stature_m: float

    @classmethod
    def of(cls, recording: SimulatedRecording, truth: GroundTruth, frame: int) -> Observation:
        simulated = recording.simulate(frame)
        camera = recording.camera
        depth_m = simulated.depth_mm.astype(np.float32) / np.float32(1000.0)
        view = DepthView(depth_m, camera.fx, camera.fy, camera.cx, camera.cy)
        is_person = (simulated.mask > 0) & (depth_m > 0)
        is_own, is_other = is_person & (simulated.mask == 1), is_person & (simulated.mask > 1)
        own, other = (view.points(*np.nonzero(where)) for where in (is_own, is_other))
        torso = list(truth.part_names).index(PART_NAMES[UPPER_TORSO])
        T_camera_torso = truth.Ts_camera_part[frame, 0, torso].astype(np.float64)
        return cls(
            Observed.of(view, is_own),
            simulated.color,
            own,
            other,
            T_camera_torso,
            float(truth.stature[0]),
        )

    def torso(self, R_torso_turned: Array, length_share: float) -> Cylinder:
        """A torso that is turned from the true one about the neck.

        It has the girth of the upper torso's cylinder and, as `--method utvr` has it, some width
        for clothes, and lies ahead of the spine.

        Args:
            R_torso_turned: [3, 3].
            length_share: of the stature.
        """
        settings = UtvrSettings()
        R = self.T_camera_torso[:3, :3] @ R_torso_turned
        ahead_m = settings.torso_ahead * self.stature_m
        radii_m = BodyModel.of(self.stature_m, THESIS).radii_m[UPPER_TORSO] + settings.clothing_m
        return Cylinder(
            transform(R, self.T_camera_torso[:3, 3] + ahead_m * R[:, 2]),
            length_share * self.stature_m,
            (float(radii_m[0]), float(radii_m[1])),
        )

    def flat(self, points_camera: Array, view: ViewName) -> Array:
        """[..., 3] points to [..., 2] metres from the neck in a parallel view."""
        from_neck = points_camera - self.T_camera_torso[:3, 3]
        return np.stack([from_neck @ VIEWS[view][0], -from_neck[..., 1]], axis=-1)

    def draw(
        self, ax: Any, view: ViewName, layers: Sequence[Layer], cylinder: Cylinder, size: float
    ) -> None:
        """Points in their colours, the last in front, and the lines of a cylinder."""
        for points, color in layers:
            ax.plot(*self.flat(points, view).T, ".", color=color, markersize=size)
        for line in outline(cylinder):
            ax.plot(*self.flat(line, view).T, color=OUTLINE_COLOR, linewidth=1.2)
        ax.set(xlabel=VIEWS[view][1], aspect="equal")


def outline(cylinder: Cylinder) -> list[Array]:
    """Lines [K, 3] in the camera's frame that show a cylinder: its rims and four along it."""
    rx, rz = cylinder.radii_m

    def at(angles: Array, y: float) -> Array:
        local = np.stack(
            [rx * np.sin(angles), np.full_like(angles, y), rz * np.cos(angles)], axis=-1
        )
        return local @ cylinder.T_camera_part[:3, :3].T + cylinder.T_camera_part[:3, 3]

    ends = [at(AROUND, y) for y in (0.0, cylinder.length_m)]
    return [*ends, *(np.stack([end[k] for end in ends]) for k in range(0, len(AROUND) - 1, 18))]
