"""`.glb` and `.gltf`: everybody as an animated skeleton with a plain body, for Blender and viewers.

Khronos Group, "glTF 2.0 Specification": metres, y up, forwards is +z. The origin lies on the floor
below the camera, which looks along -z.
"""

from __future__ import annotations

from os import PathLike
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from topview.geometry.rotations import are_rotations, unit
from topview.io.writers.extras import needed
from topview.io.writers.levelled import BodyMotion, check_times_grow
from topview.io.writers.output import write_made
from topview.records import InputError
from topview.skeletons import Skeletons, SkeletonSequence, in_memory

Array = NDArray[np.float64]

FLOAT32: Final = 5126  # numbers of the specification
UINT16: Final = 5123
BONE_WAIST: Final = 0.15  # ours: share of a bone's length at which it is thickest
BONE_RADIUS: Final = 0.1  # ours: so thick, as a share of its length
_TYPES: Final = {(): "SCALAR", (3,): "VEC3", (4,): "VEC4", (4, 4): "MAT4"}


def write_skeletons_gltf(skeletons: Skeletons, path: str | PathLike[str]) -> None:
    """All people with a pelvis, at the times of the frames; somebody who is not there is shrunk to
    nothing. Bones have one length each, the median over the frames.

    Args:
        skeletons: what to write.
        path: of the file; `.gltf` is text with all inside, any other ending the binary form.

    Raises:
        InputError: pygltflib is not installed, nobody is there, times do not grow, or it cannot be
            written; the old file, if any, is then unharmed.
    """
    lib = needed("pygltflib", "glTF", "gltf")
    sequence = in_memory(skeletons)
    is_text = Path(path).suffix.lower() == ".gltf"
    write_made(Path(path), lambda: _file(sequence, lib, is_text))


def _file(sequence: SkeletonSequence, lib: Any, is_text: bool) -> bytes:
    if not len(sequence.people_ids):
        raise InputError("has no person; glTF needs a body")
    check_times_grow(sequence.timestamps_s)
    scene = _Scene(lib, sequence.timestamps_s - sequence.timestamps_s[0])
    for person_id in sequence.people_ids.tolist():
        scene.add_person(sequence.of_person(person_id), person_id)
    return scene.data(as_text=is_text)


class _Scene:
    """A glTF that grows person by person."""

    def __init__(self, lib: Any, times_s: Array) -> None:
        self._lib = lib
        self._times_s = times_s
        self._bytes = bytearray()
        self._gltf = lib.GLTF2(
            asset=lib.Asset(generator="topview"),
            scene=0,
            scenes=[lib.Scene(nodes=[])],
            animations=[lib.Animation(name="topview", samplers=[], channels=[])],
        )

    def add_person(self, sequence: SkeletonSequence, person_id: int) -> None:
        lib, gltf = self._lib, self._gltf
        motion = BodyMotion.of(sequence, "a body of glTF")
        first = len(gltf.nodes)
        joints = [first + n for n in range(len(motion.names))]
        for n, name in enumerate(motion.names):
            children = [first + c for c, parent in enumerate(motion.parents) if parent == n]
            gltf.nodes.append(
                lib.Node(name=name, translation=motion.offsets_m[n].tolist(), children=children)
            )
        gltf.nodes[first].translation = motion.root_m[0].tolist()
        holder = lib.Node(name=f"person {person_id}", children=[first])
        body = lib.Node(name=f"body {person_id}", mesh=len(gltf.meshes), skin=len(gltf.skins))
        gltf.scenes[0].nodes += [len(gltf.nodes), len(gltf.nodes) + 1]
        gltf.nodes += [holder, body]

        rest_m = _rest_places(motion)
        to_joints = np.tile(np.eye(4), (len(joints), 1, 1))
        to_joints[:, 3, :3] = -rest_m  # column by column
        matrices = self._accessor(to_joints)
        gltf.skins.append(lib.Skin(joints=joints, skeleton=first, inverseBindMatrices=matrices))
        gltf.meshes.append(self._mesh(motion, rest_m))
        self._animate(motion, first, sequence.present[:, 0])

    def data(self, *, as_text: bool) -> bytes:
        """The file."""
        self._gltf.buffers = [self._lib.Buffer(byteLength=len(self._bytes))]
        self._gltf.set_binary_blob(bytes(self._bytes))
        if not as_text:
            return b"".join(self._gltf.save_to_bytes())
        self._gltf.convert_buffers(self._lib.BufferFormat.DATAURI)
        return self._gltf.gltf_to_json().encode()

    def _animate(self, motion: BodyMotion, first: int, present: NDArray[np.bool_]) -> None:
        times = self._accessor(self._times_s[motion.rows])
        self._channel(first, "translation", times, motion.root_m)
        if not are_rotations(motion.Rs_parent_node).all():
            raise InputError("has parts whose turns are no rotations; glTF can tell no others")
        for n in range(len(motion.names)):
            turns = Rotation.from_matrix(motion.Rs_parent_node[:, n]).as_quat()
            self._channel(first + n, "rotation", times, turns)
        is_here = np.zeros(len(present), bool)
        is_here[motion.rows] = present[motion.rows]
        changes = np.concatenate([[0], 1 + np.nonzero(np.diff(is_here))[0]])
        if not is_here.all():
            scales = np.repeat(is_here[changes, None].astype(np.float64), 3, axis=1)
            at = self._accessor(self._times_s[changes])
            self._channel(first, "scale", at, scales, "STEP")

    def _channel(
        self, node: int, what: str, times: int, values: Array, interpolation: str = "LINEAR"
    ) -> None:
        lib, animation = self._lib, self._gltf.animations[0]
        target = lib.AnimationChannelTarget(node=node, path=what)
        animation.channels.append(
            lib.AnimationChannel(sampler=len(animation.samplers), target=target)
        )
        output = self._accessor(values)
        animation.samplers.append(
            lib.AnimationSampler(input=times, output=output, interpolation=interpolation)
        )

    def _mesh(self, motion: BodyMotion, rest_m: Array) -> Any:
        """A spindle for each bone, which the bone's upper end carries."""
        bones = [(p, c) for c, p in enumerate(motion.parents) if p >= 0]
        corners = np.concatenate([_spindle(rest_m[p], rest_m[c]) for p, c in bones])
        owners = np.zeros((len(corners), 4), np.uint16)
        owners[:, 0] = np.repeat([p for p, _ in bones], len(corners) // len(bones))
        weights = np.tile([1.0, 0.0, 0.0, 0.0], (len(corners), 1))
        triangles = corners.reshape(-1, 3, 3)
        normals = unit(
            np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
        )
        normals[(normals == 0.0).all(-1)] = 0.0, 1.0, 0.0  # of a bone without length
        lib = self._lib
        attributes = lib.Attributes(
            POSITION=self._accessor(corners),
            NORMAL=self._accessor(np.repeat(normals, 3, axis=0)),
            JOINTS_0=self._accessor(owners),
            WEIGHTS_0=self._accessor(weights),
        )
        return lib.Mesh(primitives=[lib.Primitive(attributes=attributes)])

    def _accessor(self, values: NDArray[Any]) -> int:
        """Put values where the file finds them; their number."""
        lib, gltf = self._lib, self._gltf
        stored = values if values.dtype == np.uint16 else values.astype(np.float32)
        view = lib.BufferView(buffer=0, byteOffset=len(self._bytes), byteLength=stored.nbytes)
        self._bytes += stored.tobytes()
        self._bytes += bytes(-len(self._bytes) % 4)
        flat = stored.reshape(len(stored), -1)
        accessor = lib.Accessor(
            bufferView=len(gltf.bufferViews),
            componentType=UINT16 if stored.dtype == np.uint16 else FLOAT32,
            count=len(stored),
            type=_TYPES[stored.shape[1:]],
            min=flat.min(0).tolist(),
            max=flat.max(0).tolist(),
        )
        gltf.bufferViews.append(view)
        gltf.accessors.append(accessor)
        return len(gltf.accessors) - 1


def _rest_places(motion: BodyMotion) -> Array:
    """[K, 3] of the nodes with nothing turned and the root at the origin."""
    places = np.zeros_like(motion.offsets_m)
    for n, parent in enumerate(motion.parents):
        if parent >= 0:
            places[n] = places[parent] + motion.offsets_m[n]
    return places


def _spindle(start: Array, end: Array) -> Array:
    """[24, 3] the corners of eight triangles between two places, thickest near the first."""
    way = end - start
    length = float(np.linalg.norm(way))
    along: Array = way / length if length else np.array([0.0, 1.0, 0.0])
    helper: Array = np.eye(3)[int(np.argmin(np.abs(along)))]
    one = unit(np.cross(along, helper))
    other = np.cross(along, one)
    ring = [
        start + BONE_WAIST * way + BONE_RADIUS * length * direction
        for direction in (one, other, -one, -other)
    ]
    sides = [(ring[k], ring[(k + 1) % 4]) for k in range(4)]
    return np.array([p for a, b in sides for p in (start, b, a, a, b, end)], np.float64)
