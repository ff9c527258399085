"""An annotation in progress: two recordings, the markers found in them, and the user's edits."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final, Self

import cv2
import msgspec
import numpy as np
from numpy.typing import NDArray

from topview.files import naming
from topview.io import open_recording, prepare_output_folder
from topview.io.readers.folder import FolderRecording
from topview.records import Frame, InputError
from topview_lab.annotate.automatic import (
    FindOptions,
    FoundMarkers,
    OnProgress,
    find_markers,
    follow_again,
)
from topview_lab.annotate.blobs import (
    BULGE,
    Blobs,
    MarkerAppearance,
    depth_near,
    find_blobs,
    pick_marker,
    ray,
)
from topview_lab.annotate.found_file import FOUND_FILE, load_found, save_found
from topview_lab.annotate.joints import (
    Interpolation,
    Joints,
    joints_from_markers,
    marker_points,
)
from topview_lab.annotate.project import (
    PROJECT_FILE,
    VIEW_NAMES,
    Change,
    Look,
    Project,
    change_of,
    check_change,
    load_project,
    save_project,
)
from topview_lab.annotate.sole_use import SoleUse
from topview_lab.annotate.tracks import NO_SPOT, UNDECIDED, View, transform_points
from topview_lab.annotate.truth import TRUTH_FILE, check_own, truth_arrays, write_truth

SNAP_PX: Final = 6.0
"""A marker placed this near to a spot is that spot (ours)."""


@dataclass
class Job:
    """The background job, or its outcome."""

    running: bool = False
    doing: str = ""
    done: int = 0
    total: int = 1
    error: str = ""


class Session:
    """An annotation. Its methods are thread-safe; every edit is on disk when they return. No other
    process can have its folder until it is closed."""

    def __init__(self, front: Path, rear: Path, out: Path | None, wishes: FindOptions) -> None:
        self.recordings = _open(front), _open(rear)
        if _same(front, rear):
            raise InputError(f"{rear}: is the front recording too; it must be the rear camera's")
        self.wishes = wishes
        self.folder = prepare_output_folder(front if out is None else out)
        self._sole_use = SoleUse(self.folder)
        try:
            self._begin(front, rear)
        except BaseException:
            self.close()
            raise

    def _begin(self, front: Path, rear: Path) -> None:
        check_own(self.folder / TRUTH_FILE)
        self.frames = self.recordings[0].indices[-1] + 1
        self.job = Job()
        self._lock = threading.RLock()
        self.project = self._project(front, rear)
        self.found: FoundMarkers | None = None
        self._points: NDArray[np.float64] | None = None
        self._pixels: NDArray[np.float64] | None = None
        self.joints: Joints | None = None
        if self.project.looks:
            self.found = load_found(self.folder / FOUND_FILE, self._looks(), self.frames)
        self._rebuild()

    def close(self) -> None:
        """Leave the folder to others."""
        self._sole_use.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _project(self, front: Path, rear: Path) -> Project:
        path = self.folder / PROJECT_FILE
        fresh = Project(str(front.resolve()), str(rear.resolve()), self.wishes.people)
        if not path.exists():
            return fresh
        kept = load_project(path)
        if (kept.front, kept.rear) != (fresh.front, fresh.rear):
            raise InputError(
                f"{path}: belongs to {kept.front} and {kept.rear}; give --out another folder"
            )
        if kept.people != self.wishes.people:
            raise InputError(
                f"{path}: was begun with {kept.people} people, not {self.wishes.people}; "
                f"give --people {kept.people}, or --out another folder"
            )
        with naming(path):
            for change in kept.changes:
                check_change(change, kept.people, self.frames)
        return kept

    def _looks(self) -> list[MarkerAppearance]:
        return [MarkerAppearance(k.red, k.green, k.blue, k.radius_m) for k in self.project.looks]

    def _save(self, project: Project) -> None:
        save_project(project, self.folder / PROJECT_FILE)
        self.project = project

    # What the user does

    def pick(self, view: int, frame: int, u: float, v: float, add: bool) -> int:
        """Take the colour at a pixel; how many spots of it there are in that image."""
        image = self.frame(view, frame)
        if image is None:
            raise InputError(f"{VIEW_NAMES[view]}: has no frame {frame}")
        look = pick_marker(image, u, v)
        with self._lock:
            self._idle()
            kept = self.project.looks if add else ()
            looks = (*kept, Look(*look.rgb, look.radius_m))
            self._save(msgspec.structs.replace(self.project, looks=looks, accepted=False))
            self.found = None
            self._rebuild()
            return len(find_blobs(image, self._looks()))

    def find(self) -> None:
        """Start the automatic part in the background; the user's edits stay."""
        self._start(self._find)

    def follow_again(self) -> None:
        """Follow the markers again in the background, respecting the user's edits."""
        self._start(self._again)

    def change(self, value: Any) -> Change:
        """Place, delete or interpolate."""
        with self._lock:
            self._idle()
            self._result()
            change = change_of(value, self.project.people, self.frames)
            changes = (*self.project.changes, change)
            if change.kind == "place":
                self._placed(change)  # refuse before it is saved
            self._save(msgspec.structs.replace(self.project, changes=changes, accepted=False))
            self._rebuild()
            return change

    def undo(self) -> Change | None:
        """Undo the last edit."""
        with self._lock:
            self._idle()
            if not self.project.changes:
                return None
            *kept, last = self.project.changes
            self._save(msgspec.structs.replace(self.project, changes=tuple(kept), accepted=False))
            self._rebuild()
            return last

    def accept(self) -> Path:
        """Write `groundtruth.npz`; its path."""
        with self._lock:
            self._idle()
            found, joints = self._result()
            fps = self.recordings[0].fps
            arrays = truth_arrays(
                joints, found.statures_m, found.extrinsics.T_front_rear, found.offset_frames / fps
            )
            if not arrays["present"].any():
                raise InputError(
                    "in no frame all joints are known; interpolate or place the missing ones"
                )
            path = self.folder / TRUTH_FILE
            write_truth(path, arrays)
            self._save(msgspec.structs.replace(self.project, accepted=True))
            return path

    def run(self, report: OnProgress) -> None:
        """The automatic part, in the foreground."""
        self._find(report)

    # What the page shows

    def frame(self, view: int, frame: int) -> Frame | None:
        """A view's image of a frame of the front recording."""
        if not 0 <= frame < self.frames:
            return None
        found = self.found
        if view == 1:
            frame = int(found.rear_frames[frame]) if found is not None else self._rear(frame)
        return self.recordings[view].frame(frame)

    def _rear(self, frame: int) -> int:
        front, rear = self.recordings
        offset_s = self.wishes.offset_s or 0.0
        return round((frame / front.fps + offset_s) * rear.fps)

    def jpeg(self, view: int, frame: int) -> bytes | None:
        image = self.frame(view, frame)
        if image is None or image.color is None:
            return None
        bgr = np.ascontiguousarray(image.color[..., ::-1])
        return cv2.imencode(".jpg", bgr, [cv2.IMWRITE_JPEG_QUALITY, 88])[1].tobytes()

    def spots(self, view: int, frame: int) -> list[list[float]]:
        """[u, v, radius in pixels] of the spots of the picked colours."""
        image = self.frame(view, frame)
        if image is None:
            return []
        blobs = find_blobs(image, self._looks())
        radii = blobs.radii_m * image.camera.fx / blobs.points_camera[:, 2]
        table = np.column_stack([blobs.pixels, radii])
        return np.round(table, 1).tolist()

    def snapshot(self) -> tuple[FoundMarkers, Joints, NDArray[np.float64]] | None:
        """What the page shows: the result, the joints, and [V, F, P, J, 2, 2] pixels of the
        markers."""
        with self._lock:
            if self.found is None or self.joints is None or self._pixels is None:
                return None
            return self.found, self.joints, self._pixels

    # How it works

    def _start(self, work: Any) -> None:
        with self._lock:
            self._idle()
            if not self.project.looks:
                raise InputError("no colour yet; click a marker in one of the videos")
            self.job = Job(running=True)
        threading.Thread(target=self._in_background, args=(work,), daemon=True).start()

    def _in_background(self, work: Any) -> None:
        def report(doing: str, done: int, total: int) -> None:
            self.job.doing, self.job.done, self.job.total = doing, done, total

        try:
            work(report)
        except Exception as error:
            self.job.error = " ".join(str(error).split()) or type(error).__name__
            if not isinstance(error, InputError):
                self.job.running = False
                raise
        finally:
            self.job.running = False

    def _find(self, report: OnProgress) -> None:
        found = find_markers(*self.recordings, self._looks(), self.wishes, report)
        self._keep(found)

    def _again(self, report: OnProgress) -> None:
        found, _ = self._result()
        report("following the markers again", 0, 1)
        found, views = self._with_decisions(found)
        self._keep(follow_again(found, self.recordings[0].fps, views))

    def _keep(self, found: FoundMarkers) -> None:
        with self._lock:
            self.found = found
            save_found(found, self._looks(), self.folder / FOUND_FILE)
            self._save(msgspec.structs.replace(self.project, accepted=False))
            self._rebuild()

    def _idle(self) -> None:
        if self.job.running:
            raise InputError(f"busy {self.job.doing}; wait until it is done")

    def _result(self) -> tuple[FoundMarkers, Joints]:
        if self.found is None or self.joints is None:
            raise InputError("the markers have not been found yet; click a marker, then find all")
        return self.found, self.joints

    def _rebuild(self) -> None:
        """Recompute the joints from the result and the edits since."""
        found = self.found
        if found is None:
            self._points = self._pixels = self.joints = None
            return
        points = marker_points(found.views(), found.tracks.spots)
        pixels = _marker_pixels(found)
        wishes = []
        for change in self.project.changes:
            person, joint, side = change.marker
            if change.kind == "interpolate":
                wishes.append(Interpolation(person, joint, change.frame, change.last))
                continue
            at = (VIEW_NAMES.index(change.view), change.frame, person, joint, side)
            if change.kind == "delete":
                points[at], pixels[at] = np.nan, np.nan
            else:
                pixels[at], points[at] = self._placed(change)
                wishes = [wish for wish in wishes if not _covers(wish, change)]
        self._points, self._pixels = points, pixels
        fps = self.recordings[0].fps
        self.joints = joints_from_markers(points, found.eyes_front, found.tracks, fps, wishes)

    def _placed(self, change: Change) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """[2] pixel and [3] place in the front camera's frame of a marker that was placed.

        Raises:
            InputError: there is no depth.
        """
        found, view = self.found, VIEW_NAMES.index(change.view)
        if found is None or change.pixel is None:
            raise InputError("the markers have not been found yet; click a marker, then find all")
        T_front_view = found.views()[view].T_front_view
        blobs = found.blobs[view][change.frame]
        spot = _nearest(blobs, change.pixel)
        if spot != NO_SPOT:
            return blobs.pixels[spot], transform_points(T_front_view, blobs.points_camera[spot])
        u, v = change.pixel
        image = self.frame(view, change.frame)
        radius_m = self.project.looks[0].radius_m
        z = 0.0
        if image is not None and 0 <= u < image.camera.width and 0 <= v < image.camera.height:
            z = depth_near(image, u, v, 2.0)
        if image is None or z <= 0.0:
            raise InputError(
                f"{change.view}: the pixel at ({u:.0f}, {v:.0f}) of frame {change.frame} has no "
                "depth; place the marker where the camera measured one, or delete it"
            )
        point = ray(image.camera, u, v) * (z + BULGE * radius_m)
        return np.array(change.pixel), transform_points(T_front_view, point)

    def _with_decisions(self, found: FoundMarkers) -> tuple[FoundMarkers, Sequence[View]]:
        """The result with placed markers as spots of their own, and views in which those are fixed
        and deleted ones rejected."""
        views = found.views()
        spots = [[*blobs] for blobs in found.blobs]
        fixed = [np.full(found.tracks.spots.shape[1:], UNDECIDED, np.intp) for _ in views]
        rejected: list[dict[int, frozenset[int]]] = [{}, {}]
        for change in self.project.changes:
            if change.kind == "interpolate":
                continue
            view, f = VIEW_NAMES.index(change.view), change.frame
            blobs = spots[view][f]
            spot = _nearest(blobs, change.pixel) if change.pixel is not None else NO_SPOT
            if change.kind == "delete":
                fixed[view][(f, *change.marker)] = NO_SPOT
                if spot != NO_SPOT:
                    rejected[view][f] = rejected[view].get(f, frozenset()) | {spot}
                continue
            if spot == NO_SPOT:
                pixel, place = self._placed(change)
                point = transform_points(
                    np.asarray(np.linalg.inv(views[view].T_front_view), np.float64), place
                )
                spots[view][f] = _with(blobs, pixel, point, self.project.looks[0].radius_m)
                spot = len(blobs)
            own = fixed[view][f]
            own[own == spot] = NO_SPOT
            own[change.marker] = spot
            rejected[view][f] = rejected[view].get(f, frozenset()) - {spot}
        said = [
            replace(view, blobs=spots[v], fixed=fixed[v], rejected=rejected[v])
            for v, view in enumerate(views)
        ]
        return replace(found, blobs=(spots[0], spots[1])), said


def _open(path: Path) -> FolderRecording:
    recording = open_recording(path)
    if not isinstance(recording, FolderRecording):
        raise InputError(f"{path}: must be a folder with depth/, rgb/ and camera.json")
    return recording


def _same(a: Path, b: Path) -> bool:
    return a.resolve() == b.resolve()


def _covers(wish: Interpolation, change: Change) -> bool:
    person, joint, _ = change.marker
    return (wish.person, wish.joint) == (person, joint) and wish.first <= change.frame <= wish.last


def _nearest(blobs: Blobs, pixel: tuple[float, float]) -> int:
    """The spot at a pixel, -1 where there is none."""
    if not len(blobs):
        return NO_SPOT
    distances = np.linalg.norm(blobs.pixels - pixel, axis=-1)
    nearest = int(distances.argmin())
    return nearest if distances[nearest] <= SNAP_PX else NO_SPOT


def _with(
    blobs: Blobs, pixel: NDArray[np.float64], point: NDArray[np.float64], radius_m: float
) -> Blobs:
    return Blobs(
        np.vstack([blobs.pixels, pixel]),
        np.vstack([blobs.points_camera, point]),
        np.append(blobs.radii_m, radius_m),
    )


def _marker_pixels(found: FoundMarkers) -> NDArray[np.float64]:
    """[V, F, P, J, 2, 2] pixels of the named spots, NaN where there is none."""
    spots = found.tracks.spots
    pixels = np.full((*spots.shape, 2), np.nan)
    for v, blobs in enumerate(found.blobs):
        for f in range(spots.shape[1]):
            named = spots[v, f] != NO_SPOT
            if named.any():
                pixels[v, f][named] = blobs[f].pixels[spots[v, f][named]]
    return pixels
