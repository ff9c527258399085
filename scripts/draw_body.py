"""Draw every joint, part and frame of the outputs: docs/pictures/body.svg.

python scripts/draw_body.py
"""

from __future__ import annotations

from collections.abc import Sequence
from math import cos, radians, sin
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from topview.body import OUTPUT_JOINTS, PARTS
from topview.body.ends import output_joints
from topview.body.kinematics import (
    R_CAMERA_FACING,
    forward_kinematics,
    rotations_in_camera,
)
from topview.body.model import BodyModel
from topview.body.proportions import ANATOMICAL

PICTURE = Path(__file__).resolve().parents[1] / "docs" / "pictures" / "body.svg"
Array = NDArray[np.float64]
STATURE_M, CAMERA_HEIGHT_M = 1.75, 1.5
CROWN = np.array([0.0, CAMERA_HEIGHT_M - STATURE_M, 0.0])
SPREAD_DEG = {"arm": 20.0, "leg": 6.0}  # limbs to their sides, so that they can be told apart
AXES = (("x", "#d03030"), ("y", "#209040"), ("z", "#3050d0"))
INK, PALE, LEFT, RIGHT = "#222", "#999", "#1c7ed6", "#e8590c"
PX_PER_M = 250.0
# Axes of a frame, columns in the camera's: x right, y down, z forward.
FRAMES = {
    "camera": np.eye(3),
    "y up": np.diag([1.0, -1.0, -1.0]),
    "z up": np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]]),
    "world, if none is given": np.array([[0.0, -1, 0], [0, 0, -1], [1, 0, 0]]),
}
MEANINGS = {
    "camera": "x right, y down, z forward; origin in the lens",
    "y up": "x right, y up, z to the camera; origin on the floor",
    "z up": "x right, y away, z up; origin on the floor",
    "world, if none is given": "x forward, y left, z up; origin on the floor",
}


def turn(yaw_deg: float, pitch_deg: float) -> Array:
    """Of the one who looks: round to the side, then up."""
    y, p = radians(yaw_deg), radians(pitch_deg)
    about_y = np.array([[cos(y), 0, -sin(y)], [0, 1, 0], [sin(y), 0, cos(y)]])
    about_x = np.array([[1, 0, 0], [0, cos(p), -sin(p)], [0, sin(p), cos(p)]])
    return about_x @ about_y


class Sketch:
    """Lines and words, seen from afar."""

    def __init__(self) -> None:
        self.parts: list[str] = []

    def line(self, a: Array, b: Array, color: str, width: float, dash: str = "") -> None:
        dashes = f' stroke-dasharray="{dash}"' if dash else ""
        self.parts.append(
            f'<line x1="{a[0]:.1f}" y1="{a[1]:.1f}" x2="{b[0]:.1f}" y2="{b[1]:.1f}" '
            f'stroke="{color}" stroke-width="{width}" stroke-linecap="round"{dashes}/>'
        )

    def dot(self, at: Array, color: str) -> None:
        self.parts.append(f'<circle cx="{at[0]:.1f}" cy="{at[1]:.1f}" r="5" fill="{color}"/>')

    def words(
        self, text: str, at: Array, size: int = 14, anchor: str = "start", color: str = INK
    ) -> None:
        self.parts.append(
            f'<text x="{at[0]:.1f}" y="{at[1] + size / 3:.1f}" font-size="{size}" '
            f'text-anchor="{anchor}" fill="{color}">{text}</text>'
        )

    def axes(self, origin: Array, R: Array, view: Array, length_px: float, named: bool) -> None:
        """The axes of a frame; `R` has them as columns."""
        for (name, color), axis in zip(AXES, R.T, strict=True):
            end = origin + length_px * (view @ axis)[:2]
            self.line(origin, end, color, 2.5)
            if named:
                self.words(name, end + 10 * (view @ axis)[:2], 13, "middle", color)

    def named(self, points: Sequence[tuple[str, Array]], x: float, anchor: str) -> None:
        """Names in a column at `x`, each with a thin line to its place."""
        y = -np.inf
        for name, at in sorted(points, key=lambda point: point[1][1]):
            y = max(y + 20.0, float(at[1]))
            label = np.array([x, y])
            self.line(label + (6 if anchor == "end" else -6) * np.array([1, 0]), at, PALE, 0.8)
            self.words(name, label, 13, anchor)


def side_color(name: str) -> str:
    return {"left": LEFT, "right": RIGHT}.get(name.partition("_")[0], INK)


def standing() -> tuple[BodyModel, Array, Array]:
    """The body, [11, 4, 4] poses of its parts and [20, 3] joints of who faces the camera."""
    body = BodyModel.of(STATURE_M, ANATOMICAL)
    Rs = np.repeat(np.eye(3)[None], len(PARTS), axis=0)
    Rs[0] = R_CAMERA_FACING
    for index, part in enumerate(PARTS):
        side, _, limb = part.name.partition("_upper_")
        if limb:
            angle = radians(SPREAD_DEG.get(limb, 0.0)) * {"left": 1, "right": -1}.get(side, 0)
            Rs[index, :2, :2] = [[cos(angle), -sin(angle)], [sin(angle), cos(angle)]]
            # A positive turn about z swings a part's far end, at +y, to the person's left, at -x.
    Ts = forward_kinematics(body, CROWN, rotations_in_camera(Rs))
    return body, Ts, output_joints(body, Ts)


def draw_joints(sketch: Sketch, joints: Array, middle: Array) -> None:
    at = middle + PX_PER_M * (joints - joints.mean(0))[:, :2]
    for joint, end in zip(OUTPUT_JOINTS, at, strict=True):
        if joint.bone_to >= 0:
            color = side_color(joint.name)
            sketch.line(at[joint.bone_to], end, color, 4, "7 7" if color == RIGHT else "")
    for joint, place in zip(OUTPUT_JOINTS, at, strict=True):
        sketch.dot(place, side_color(joint.name))
    named = [(joint.name, place) for joint, place in zip(OUTPUT_JOINTS, at, strict=True)]
    sketch.named([n for n in named if "right" in n[0]], middle[0] - 165, "end")
    sketch.named([n for n in named if "right" not in n[0]], middle[0] + 165, "start")


def draw_parts(sketch: Sketch, body: BodyModel, Ts: Array, middle: Array) -> None:
    view = turn(28.0, 14.0)
    center = Ts[:, :3, 3].mean(0)

    def seen(point: Array) -> Array:
        return middle + PX_PER_M * (view @ (point - center))[:2] - [0, 40]

    named = []
    for part, T, length_m, radii_m in zip(PARTS, Ts, body.lengths_m, body.radii_m, strict=True):
        start, end = seen(T[:3, 3]), seen(T[:3, 3] + length_m * T[:3, 1])
        width = 2 * PX_PER_M * float(np.mean(radii_m))
        sketch.line(start, end, "#e4e7eb", round(width, 1))
        named.append((part.name, (start + 3 * end) / 4))
    for T in Ts:
        sketch.axes(seen(T[:3, 3]), T[:3, :3], view, 26.0, named=False)
    sketch.named([n for n in named if "right" in n[0]], middle[0] - 165, "end")
    sketch.named([n for n in named if "right" not in n[0]], middle[0] + 165, "start")


def draw_frames(sketch: Sketch, top_left: Array) -> None:
    view = turn(-30.0, 22.0)
    for number, (name, R) in enumerate(FRAMES.items()):
        camera = top_left + np.array([70 + 270 * number, 70])
        floor = camera + 110 * (view @ [0, 1.0, 0])[:2]
        for a, b in (
            ((-1, -1), (1, -1)),
            ((1, -1), (1, 1)),
            ((1, 1), (-1, 1)),
            ((-1, 1), (-1, -1)),
        ):
            ends = [floor + 60 * (view @ [x, 0.0, z])[:2] for x, z in (a, b)]
            sketch.line(ends[0], ends[1], "#ccc", 1)
        sketch.line(camera, floor, PALE, 1, "3 4")
        corners = [
            camera + 26 * (view @ [x, y, 1.3])[:2]
            for x, y in ((-1, -0.7), (1, -0.7), (1, 0.7), (-1, 0.7))
        ]
        for corner, other in zip(corners, [*corners[1:], corners[0]], strict=True):
            sketch.line(camera, corner, PALE, 1)
            sketch.line(corner, other, PALE, 1)
        sketch.axes(camera if name == "camera" else floor, R, view, 52.0, named=True)
        first, _, second = MEANINGS[name].partition("; ")
        sketch.words(name, camera + np.array([0, 160]), 15, "middle")
        sketch.words(first, camera + np.array([0, 181]), 12, "middle", "#555")
        sketch.words(second, camera + np.array([0, 198]), 12, "middle", "#555")


def svg() -> str:
    """The picture."""
    sketch = Sketch()
    body, Ts, joints = standing()
    sketch.words("20 joints, as the camera sees them", np.array([280.0, 28.0]), 17, "middle")
    draw_joints(sketch, joints, np.array([280.0, 285.0]))
    sketch.words("11 parts and their frames", np.array([810.0, 28.0]), 17, "middle")
    draw_parts(sketch, body, Ts, np.array([810.0, 330.0]))
    for (name, color), means in zip(
        AXES, ("the person's right", "along the part", "front"), strict=True
    ):
        x = {"x": 670.0, "y": 825.0, "z": 940.0}[name]
        sketch.words(f"{name}: {means}", np.array([x, 600.0]), 14, "middle", color)
    sketch.words("left", np.array([235.0, 600.0]), 14, "middle", LEFT)
    sketch.words("right (dashed)", np.array([320.0, 600.0]), 14, "middle", RIGHT)
    sketch.words("Frames of the outputs", np.array([545.0, 655.0]), 17, "middle")
    draw_frames(sketch, np.array([70.0, 670.0]))
    return (
        '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 1090 945" '
        'font-family="Helvetica, Arial, sans-serif">\n'
        '<rect width="1090" height="945" fill="white"/>\n' + "\n".join(sketch.parts) + "\n</svg>\n"
    )


if __name__ == "__main__":
    PICTURE.write_text(svg())
