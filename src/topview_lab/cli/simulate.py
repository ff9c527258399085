"""`topview simulate`: a scene of the simulator, written as a recording with its truth."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Final, Literal

from cyclopts import Parameter

from topview.cli.progress import progress_bar
from topview.records import Camera
from topview_lab.sim import SCENES, scene_by_name, write_scene
from topview_lab.sim.markers import SCENE_PREFIX, marker_scenes, write_marker_scenes
from topview_lab.sim.scenes import KINECT_V1_FULL, KINECT_V1_HALF

Size = Literal["320x240", "640x480"]
CAMERAS: Final[dict[Size, Camera]] = {"320x240": KINECT_V1_HALF, "640x480": KINECT_V1_FULL}


def simulate(
    scene: str,
    /,
    *,
    out: Path,
    people: int | None = None,
    seed: int = 0,
    frames: int | None = None,
    size: Size | None = None,
    force: Annotated[bool, Parameter(negative="")] = False,
) -> None:
    """Simulate people in a room before a Kinect-like camera.

    Writes a recording in the folder layout that `topview track` reads, and its truth. "markers" or
    "markers:SCENE" is a scene whose first person wears colour markers, as front/ and rear/ see it,
    for `topview annotate`; truth.npz is beside them.

    Args:
        scene: what happens: one of SCENE_NAMES.
        out: folder for depth/, rgb/, mask/, part/, camera.json and groundtruth.npz.
        people: how many; more than the scene asks for stand in the background.
        seed: of bodies, clothes, style of motion and sensor noise.
        frames: how many, at 30 a second; as many as the scene is made for if not given.
        size: of the images, in pixels; 320x240 if not given, 640x480 with markers.
        force: replace the recording that the folder holds.
    """
    is_marked = scene.partition(":")[0] == SCENE_PREFIX
    rear = None
    if is_marked:
        made, rear = marker_scenes(
            scene, seed=seed, frames=frames, people=people, camera=CAMERAS[size or "640x480"]
        )
    else:
        made = scene_by_name(
            scene, seed=seed, frames=frames, people=people, camera=CAMERAS[size or "320x240"]
        )
    with progress_bar() as progress:
        task = progress.add_task(f"simulating {scene}", total=made.frames * (2 if rear else 1))
        if rear is None:
            write_scene(made, out, lambda _: progress.advance(task), force=force)
        else:
            write_marker_scenes(made, rear, out, lambda _: progress.advance(task), force)
    print(f"{made.frames} frames with {len(made.actors)} people, written to {out}")


simulate.__doc__ = (simulate.__doc__ or "").replace("SCENE_NAMES", ", ".join(SCENES))
