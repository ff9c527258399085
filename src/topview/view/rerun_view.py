"""What rerun shows: cloud, bodies, skeletons, images with areas, confidences, over time.

Entities, in the camera frame (x right, y down, z forward; metres):

    world/cloud                     the points of the depth image
    world/camera                    the camera; world/camera/image what it saw; world/camera/areas
                                    whose each pixel is
    world/skeletons/3/{middle,left,right}   bones of person 3; the right side is darker
    world/skeletons/3/joints        labelled with their states; larger where confidence is high
    world/bodies/3                  the parts as capsules
    confidence/3                    the mean over the joints
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from topview.body import OUTPUT_JOINT_NAMES, OUTPUT_JOINTS
from topview.body.model import BodyModel
from topview.body.proportions import ANATOMICAL
from topview.camera import unproject_depth
from topview.records import JOINT_STATE_NAMES, Camera, Frame, JointState, Person
from topview.view.drawing import SEEN
from topview.view.frame_picture import frame_picture
from topview.view.palette import GROUND, MUTED, PEOPLE, Color, mix, person_color
from topview.view.rerun_server import serve

# The look: all ours.
MOST_POINTS: Final = 40_000  # of a cloud
BONE_M, JOINT_M = 0.012, (0.012, 0.03)  # radii: of a bone; of joints of confidence 0 and 1
RIGHT_SHADE: Final = 0.45  # how much darker the right side is
BODY_ALPHA, AREA_OPACITY = 90, 0.5
IMAGE_PLANE_M: Final = 0.4
CAPSULE_IN_PART: Final = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])  # z to y
BONE_GROUPS: Final = ("middle", "left", "right")

Labels = Callable[[Frame], NDArray[np.integer] | None]


class RerunView:
    """A viewer that tells rerun.

    Args:
        name: of the recording.
        labels: gives [H, W] ids of whose each pixel of a frame is, 0 for nobody; or None.

    Attributes:
        stream: rerun's recording stream; it goes nowhere before `serve`, or its own `save`.
    """

    def __init__(self, name: str, labels: Labels = lambda frame: None) -> None:
        import rerun

        self._rr: Any = rerun
        self._labels = labels
        self._people: set[int] = set()  # of the last frame
        self._told: set[int] = set()  # of all frames
        self._camera: Camera | None = None
        self.stream: Any = rerun.RecordingStream("topview")
        self.stream.send_recording_name(name)

    def serve(self, *, open_browser: bool = True) -> str:
        """Serve the data and rerun's web viewer to this machine; the address to open.

        Raises:
            InputError: the viewer does not start.
        """
        address = serve(self.stream, open_browser=open_browser)
        self.stream.send_blueprint(self._layout())
        return address

    def show(self, frame: Frame, people: Sequence[Person]) -> None:
        """As `topview.view.Viewer`; the frame is undistorted."""
        self._at(frame.index, frame.timestamp_s)
        self._show_image(frame)
        self.show_people(people)

    def show_skeletons(self, index: int, timestamp_s: float, people: Sequence[Person]) -> None:
        """The people of a frame whose image is not at hand."""
        self._at(index, timestamp_s)
        self.show_people(people)

    def _at(self, index: int, timestamp_s: float) -> None:
        self.stream.set_time("time", duration=timestamp_s)
        self.stream.set_time("frame", sequence=index)

    def _show_image(self, frame: Frame) -> None:
        rr, log = self._rr, self.stream.log
        if self._camera is not frame.camera:
            self._camera = frame.camera
            self._log_camera(frame.camera)
        points, colors = cloud_of(frame)
        log("world/cloud", rr.Points3D(points, colors=colors, radii=0.006))
        log("world/camera/image", rr.Image(frame_picture(frame)).compress(jpeg_quality=85))
        labels = self._labels(frame)
        if labels is not None:
            areas = np.where(labels > 0, (labels - 1) % len(PEOPLE) + 1, 0).astype(np.uint8)
            log("world/camera/areas", rr.SegmentationImage(areas, opacity=AREA_OPACITY))

    def _log_camera(self, camera: Camera) -> None:
        rr, log = self._rr, self.stream.log
        log("world", rr.ViewCoordinates.RDF, static=True)
        colors = [(0, (0, 0, 0, 0)), *((n, color) for n, color in enumerate(PEOPLE, 1))]
        infos = [rr.AnnotationInfo(id=n, color=color) for n, color in colors]
        log("world/camera", rr.AnnotationContext(infos), static=True)
        log(
            "world/camera",
            rr.Pinhole(
                focal_length=(camera.fx, camera.fy),
                principal_point=(camera.cx + 0.5, camera.cy + 0.5),  # its pixels begin at 0
                width=camera.width,
                height=camera.height,
                camera_xyz=rr.ViewCoordinates.RDF,
                image_plane_distance=IMAGE_PLANE_M,
            ),
            static=True,
        )

    def show_people(self, people: Sequence[Person]) -> None:
        """Skeletons and bodies at the time that was set last; who is gone is removed."""
        here = {person.id for person in people}
        for gone in self._people - here:
            for place in (f"world/skeletons/{gone}", f"world/bodies/{gone}"):
                self.stream.log(place, self._rr.Clear(recursive=True))
        for new in here - self._told:
            lines = self._rr.SeriesLines(colors=[person_color(new)], names=[f"person {new}"])
            self.stream.log(f"confidence/{new}", lines, static=True)
        self._people = here
        self._told |= here
        for person in people:
            self._show_person(person)

    def _show_person(self, person: Person) -> None:
        rr, log, place = self._rr, self.stream.log, f"world/skeletons/{person.id}"
        color = person_color(person.id)
        for side in BONE_GROUPS:
            own = mix(color, GROUND, RIGHT_SHADE) if side == "right" else color
            strips = bones_of(person, side)
            log(f"{place}/{side}", rr.LineStrips3D(strips, colors=[own], radii=BONE_M))
        known = np.nonzero(np.isfinite(person.joints_camera).all(-1))[0]
        low_m, high_m = JOINT_M
        log(
            f"{place}/joints",
            rr.Points3D(
                person.joints_camera[known],
                colors=[_joint_color(color, int(person.joint_state[j])) for j in known],
                radii=low_m + (high_m - low_m) * person.joint_confidence[known],
                labels=[
                    f"{OUTPUT_JOINT_NAMES[j]}: {JOINT_STATE_NAMES[person.joint_state[j]]}, "
                    f"{person.joint_confidence[j]:.2f}"
                    for j in known
                ],
                show_labels=False,
            ),
        )
        self._show_body(person, color)
        log(f"confidence/{person.id}", rr.Scalars(float(person.joint_confidence.mean())))

    def _show_body(self, person: Person, color: Color) -> None:
        rr = self._rr
        known = np.isfinite(person.Ts_camera_part).all((1, 2))
        model, Ts = BodyModel.of(person.height_m, ANATOMICAL), person.Ts_camera_part[known]
        turns = Rotation.from_matrix(Ts[:, :3, :3] @ CAPSULE_IN_PART)
        self.stream.log(
            f"world/bodies/{person.id}",
            rr.Capsules3D(
                lengths=model.lengths_m[known],
                radii=model.radii_m[known].mean(1),
                translations=Ts[:, :3, 3],
                quaternions=turns.as_quat(),
                colors=[(*color, BODY_ALPHA)],
            ),
        )

    def _layout(self) -> Any:
        from rerun import blueprint as rrb

        of_image = ["+ $origin/**", "+ /world/skeletons/**"]
        return rrb.Blueprint(
            rrb.Horizontal(
                rrb.Spatial3DView(origin="/world", name="room"),
                rrb.Vertical(
                    rrb.Spatial2DView(origin="/world/camera", contents=of_image, name="camera"),
                    rrb.TimeSeriesView(origin="/confidence", name="confidence"),
                    row_shares=[2, 1],
                ),
                column_shares=[3, 2],
            ),
            collapse_panels=True,
        )


def cloud_of(frame: Frame) -> tuple[NDArray[np.float32], NDArray[np.uint8]]:
    """[N, 3] points in the camera frame and [N, 3] colours; at most `MOST_POINTS`."""
    step = max(1, int(np.ceil(np.sqrt(frame.depth_m.size / MOST_POINTS))))
    points = unproject_depth(frame.depth_m, frame.camera)[::step, ::step]
    seen = points[..., 2] > 0.0
    if frame.color is None:
        return points[seen], np.full((np.count_nonzero(seen), 3), MUTED, np.uint8)
    return points[seen], frame.color[::step, ::step][seen]


def bones_of(person: Person, side: str) -> list[NDArray[np.float64]]:
    """[2, 3] ends of each bone of a side of the body that is known."""
    bones = []
    for joint, end in zip(OUTPUT_JOINTS, person.joints_camera, strict=True):
        own = joint.name.partition("_")[0] if "_" in joint.name else "middle"
        if joint.bone_to >= 0 and own == side:
            bone = np.stack([person.joints_camera[joint.bone_to], end])
            if np.isfinite(bone).all():
                bones.append(bone)
    return bones


def _joint_color(color: Color, state: int) -> Color:
    return color if JointState(state) in SEEN else mix(color, MUTED, 0.7)
