"""Skeletons into Blender, as animated armatures with plain bodies.

    topview convert results moves.glb                       # pip install 'topview[gltf]'
    blender --python docs/recipes/into_blender.py -- moves.glb

Sets the frame rate and the length of the scene by the recording. A .bvh can be imported by hand
instead (File > Import > Motion Capture), one person at a time.
"""

import sys


def main(path: str, rate_hz: float = 30.0) -> None:
    import bpy  # Blender's own Python has it

    bpy.ops.import_scene.gltf(filepath=path)
    scene = bpy.context.scene
    scene.render.fps = round(rate_hz)
    ends = [action.frame_range[1] for action in bpy.data.actions]
    scene.frame_start, scene.frame_end = 0, round(max(ends, default=0))


if __name__ == "__main__":
    main(*sys.argv[sys.argv.index("--") + 1 :])
