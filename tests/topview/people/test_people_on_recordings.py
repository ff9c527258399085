"""People found in real and rendered recordings; the numbers are floors, not records."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray
from standing_bodies import Standing

import topview.io as readers
from topview.camera.pyramid import Pyramid
from topview.people.finder import PeopleFinder
from topview.people.users import User
from topview.records import Recording
from topview.track import Tracker, TrackerSettings

pytestmark = pytest.mark.slow


def find_all(recording: Recording) -> list[list[User]]:
    finder = PeopleFinder()
    return [finder.update(Pyramid(frame)) for frame in recording]


def needed(path: Path) -> Path:
    if not path.exists():
        pytest.skip(f"needs {path}, which is not part of the project")
    return path


@pytest.mark.parametrize(
    ("name", "counts"),
    [
        ("five_people", {5}),
        ("turning_man", {1}),
        # The fourth too, who wears black: there is no depth between the face and the trousers.
        ("four_people_kinect2", {4}),
    ],
)
def test_real_rooms_hold_as_many_as_there_are(shared: Path, name: str, counts: set[int]) -> None:
    found = find_all(readers.open_recording(needed(shared / "recordings" / name)))
    assert {len(users) for users in found} == counts


def test_the_falling_man_is_one_and_the_same(shared: Path) -> None:
    """Who is not clearly a person in the first frame is one once he was seen for 0.05 s: at 30
    frames a second from the third frame on."""
    found = find_all(readers.open_recording(needed(shared / "recordings" / "urfall_fall01")))
    assert {tuple(user.id for user in users) for users in found[:2]} <= {(), (1,)}
    assert {tuple(user.id for user in users) for users in found[2:]} == {(1,)}


def test_the_network_does_not_take_him_for_the_curtain_beside_him(shared: Path) -> None:
    recording = readers.open_recording(needed(shared / "recordings" / "urfall_fall01"))
    tracker = Tracker(TrackerSettings(threads=1))
    found = [tuple(person.id for person in tracker.update(frame)) for frame in recording]
    assert set(found[2:]) == {(1,)}


@pytest.mark.parametrize("name", ["a1_s1_t1", "a6_s2_t1", "a19_s3_t1", "a27_s2_t2"])
def test_utd_mhad_has_one_person_with_the_head_on_top(shared: Path, name: str) -> None:
    found = find_all(utd_mhad(shared, name))
    assert {tuple(user.id for user in users) for users in found} == {(1,)}


def test_utd_mhad_has_one_person_where_the_network_must_tell(shared: Path) -> None:
    """By shape and motion alone there is a second one in most of the frames."""
    tracker = Tracker(TrackerSettings(threads=1), body=Standing())
    found = [tracker.update(frame) for frame in utd_mhad(shared, "a21_s4_t1")]
    assert {tuple(person.id for person in people) for people in found} == {(1,)}


def utd_mhad(shared: Path, name: str) -> Recording:
    folder = shared / "recordings" / "utd_mhad" / "Depth"
    return readers.open_recording(needed(folder / f"{name}_depth.mat"))


@pytest.mark.parametrize("name", ["b1_pass_by", "b3_stand60", "c2_two_pairs", "d1_seated_start"])
def test_people_of_the_bench_keep_their_ids_and_points(shared: Path, name: str) -> None:
    folder = needed(shared / "bench" / name)
    found = find_all(readers.open_recording(folder))
    truth = np.load(folder / "groundtruth.npz")
    heads = truth["joints"][:, :, list(truth["names"]).index("head")]
    is_visible = truth["present"] & (np.nan_to_num(truth["person_occ_inter"], nan=1.0) <= 0.6)
    ids: dict[int, set[int]] = {p: set() for p in range(heads.shape[1])}
    hits, shares = 0, []
    for f, users in enumerate(found):
        mask = cv2.imread(str(folder / "mask" / f"{f:06d}.png"), cv2.IMREAD_UNCHANGED)
        assert mask is not None
        for p in np.flatnonzero(is_visible[f]):
            near = [u for u in users if np.linalg.norm(u.head_camera - heads[f, p]) < 0.35]
            if near:
                user = min(near, key=lambda u: float(np.linalg.norm(u.head_camera - heads[f, p])))
                ids[int(p)].add(user.id)
                hits += 1
                shares.append(share_on(user.pixels, mask == p + 1))
    assert hits > 0.95 * is_visible.sum()
    assert np.mean(shares) > 0.84
    assert all(len(own) == 1 for own in ids.values())
    assert len(set.union(*ids.values())) == len(ids)


def share_on(pixels: NDArray[np.int32], is_person: NDArray[np.bool_]) -> float:
    """Share of the pixels that lie on the person."""
    return float(is_person.ravel()[pixels].mean()) if len(pixels) else 0.0
