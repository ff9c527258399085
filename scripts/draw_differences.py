"""Draw where the joints' network helps most, and where it harms most.

    python scripts/draw_differences.py RECORDING... --out DIR [--count N]

Tracks each recording with the network and without, and draws the frames in which somebody's joints
are nearer to the truth by most with it, and those in which they are by most without it: of each
recording one of either kind, where there is one. Left the truth, then without, then with it; the
mean distance of the person's joints below, constant offsets taken out.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from cyclopts import App
from numpy.typing import NDArray

from topview.body import OUTPUT_JOINT_NAMES, PART_NAMES
from topview.detect.joints.proposers import NETWORK, NOTHING, ProposalsName
from topview.records import Frame, JointState, Person
from topview.skeletons import About, SkeletonSequence, TrackedFrame
from topview.track import Tracker, TrackerSettings
from topview.view.drawing import Image, draw_text, png_of
from topview.view.frame_picture import frame_with_skeletons
from topview.view.palette import TEXT
from topview_lab.datasets import EvaluatedRecording, find_folder_recordings
from topview_lab.metrics import Evaluation, Pool, SequenceErrors, measure_sequence, pool

PANEL_PX = 480, 360
CAPTION_PX = 10


@dataclass(frozen=True, slots=True)
class Tracked:
    """One recording as tracked, with everybody of each frame."""

    errors: SequenceErrors
    people: dict[int, tuple[Person, ...]]


@dataclass(frozen=True, slots=True)
class Difference:
    """A person-frame: the recording's number, the frame, the row among the samples, and the mean
    distances without and with the network."""

    recording: int
    frame: int
    row: int
    without_m: float
    with_m: float

    @property
    def gain_m(self) -> float:
        return self.without_m - self.with_m


def main(*folders: Path, out: Path, count: int = 10) -> None:
    """Track, choose and draw."""
    out.mkdir(parents=True, exist_ok=True)
    recordings = find_folder_recordings(list(folders))
    without = [tracked(recording, NOTHING) for recording in recordings]
    proposed = [tracked(recording, NETWORK) for recording in recordings]
    pools = [pool(Evaluation(tuple(own.errors for own in of))) for of in (without, proposed)]
    found = differences(*pools)
    for kind, sign in (("helps", 1.0), ("harms", -1.0)):
        those = [own for own in found if sign * own.gain_m > 0.0]
        chosen = one_of_each(sorted(those, key=lambda own: -abs(own.gain_m)))[:count]
        for place, own in enumerate(chosen, 1):
            recording = recordings[own.recording]
            panels = drawn(
                recording, own, pools[0], without[own.recording], proposed[own.recording]
            )
            path = out / f"{kind}_{place:02d}_{recording.name}_{own.frame}.png"
            path.write_bytes(png_of(panels))
            print(f"{path.name}: {100 * own.without_m:.1f} cm without, {100 * own.with_m:.1f} with")


def tracked(recording: EvaluatedRecording, proposals: ProposalsName) -> Tracked:
    """Everybody in each frame, and what is wrong with them."""
    tracker = Tracker(TrackerSettings(proposals=proposals, threads=1))
    about = About(OUTPUT_JOINT_NAMES, PART_NAMES)
    frames, people = [], {}
    for frame in recording.open():
        people[frame.index] = tuple(tracker.update(frame))
        packed = about.packed(people[frame.index])
        frames.append(TrackedFrame(frame.index, frame.timestamp_s, frame.name, packed))
    sequence = SkeletonSequence.from_frames(frames, about)
    return Tracked(measure_sequence(sequence, recording.reference(), recording.name), people)


def differences(without: Pool, proposed: Pool) -> list[Difference]:
    """Of all person-frames that were found both times."""
    mean_m = [mean_distances(own) for own in (without, proposed)]
    rows = np.flatnonzero(np.isfinite(mean_m[0]) & np.isfinite(mean_m[1]))
    return [
        Difference(
            int(without.sequence[row]),
            int(without.samples.frame[row]),
            int(row),
            float(mean_m[0][row]),
            float(mean_m[1][row]),
        )
        for row in rows
    ]


def mean_distances(of: Pool) -> NDArray[np.float64]:
    """[N] of each person-frame, offsets out, metres; NaN where nobody was found."""
    apart_m = np.linalg.norm(of.corrected_camera - of.samples.reference_camera, axis=-1)
    known = np.isfinite(apart_m)
    count = np.where(known.any(axis=1), known.sum(axis=1), np.nan)
    return np.where(known, apart_m, 0.0).sum(axis=1) / count


def one_of_each(ranked: Sequence[Difference]) -> list[Difference]:
    """The first of each recording."""
    first = {}
    for own in ranked:
        first.setdefault(own.recording, own)
    return list(first.values())


def drawn(
    recording: EvaluatedRecording, own: Difference, of: Pool, without: Tracked, proposed: Tracked
) -> Image:
    """The three panels."""
    frame = next(frame for frame in recording.open() if frame.index == own.frame)
    people = without.people[own.frame], proposed.people[own.frame]
    joints_camera = np.concatenate(
        [of.samples.reference_camera[own.row], of.samples.reference_ends_camera[own.row]]
    )
    states = np.full(len(joints_camera), JointState.VISIBLE, np.uint8)
    truth = replace(people[0][0], id=1, joints_camera=joints_camera, joint_state=states)
    panels = [
        panel(frame, (truth,), f"{recording.name}, frame {own.frame}: truth"),
        panel(frame, people[0], f"without the network: {100 * own.without_m:.1f} cm"),
        panel(frame, people[1], f"with it: {100 * own.with_m:.1f} cm"),
    ]
    return np.hstack(panels)


def panel(frame: Frame, people: Sequence[Person], caption: str) -> Image:
    """Everybody's skeleton, and a caption."""
    picture = frame_with_skeletons(frame, people, PANEL_PX)
    draw_text(picture, caption, (8, PANEL_PX[1] - 10), CAPTION_PX, TEXT)
    return picture


if __name__ == "__main__":
    app = App()
    app.default(main)
    app()
