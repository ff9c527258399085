"""Frames on disk: what was appended is there, wherever the process or the disk ended."""

from __future__ import annotations

import os
import subprocess
import sys
from contextlib import suppress
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lenses import LENSES, camera_with
from made_frames import ABOUT, frames_with
from topview import JOINT_NAMES
from topview.io import FramesFile, NothingStoredError, StoredFrames
from topview.io.writers import SkeletonFile, frames_file, npz, write_skeletons_npz
from topview.records import InputError
from topview.skeletons import About, SkeletonSequence, TrackedFrame

WHO = [[1], [1, 2], [], [2], [2, 1], [3, 2]]


def store(path: Path, frames: list[TrackedFrame], about: About = ABOUT) -> Path:
    path.unlink(missing_ok=True)
    with FramesFile(path, about) as file:
        for frame in frames:
            file.append(frame)
    return path


def assert_same(a: SkeletonSequence, b: SkeletonSequence) -> None:
    for field in fields(SkeletonSequence):
        np.testing.assert_equal(getattr(a, field.name), getattr(b, field.name))


@pytest.fixture(scope="module")
def scratch(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("frames")


@given(
    st.lists(st.lists(st.integers(1, 5), unique=True, max_size=3), min_size=1, max_size=9),
    st.integers(1, 10),
)
def test_blocks_of_any_length_hold_what_is_in_memory(scratch, who, block_frames):
    """From the file of frames, and from the result that is made of it in blocks."""
    frames = frames_with(who)
    whole = SkeletonSequence.from_frames(frames, ABOUT)
    stored = StoredFrames(store(scratch / "a.frames", frames))
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(frames_file, "BLOCK_FRAMES", block_frames)
        patched.setattr(npz, "BLOCK_FRAMES", block_frames)
        write_skeletons_npz(stored, scratch / "blocks.npz")
        blocks = list(stored.blocks()), list(SkeletonFile(scratch / "blocks.npz").blocks())
    write_skeletons_npz(whole, scratch / "whole.npz")
    assert (scratch / "blocks.npz").read_bytes() == (scratch / "whole.npz").read_bytes()
    for read in blocks:
        assert [len(block.frame_index) for block in read[:-1]] == [block_frames] * (len(read) - 1)
        for name in ("frame_index", "person_ids", "joints_camera", "Ts_camera_part"):
            joined = np.concatenate([getattr(block, name) for block in read])
            np.testing.assert_array_equal(joined, getattr(whole, name))
        assert read[0].people_ids.tolist() == whole.people_ids.tolist()


def test_what_belongs_to_no_frame_comes_back(tmp_path):
    camera = camera_with(LENSES["rational"], sensor="stereo")
    about = replace(ABOUT, settings={"a": [1, {"b": None}]}, camera=camera, topview_version="9")
    frames = [replace(frame, name="odd \udcff \u00e9") for frame in frames_with(WHO)]
    stored = StoredFrames(store(tmp_path / "a.frames", frames, about))
    assert stored.about == about
    (block,) = stored.blocks()
    assert_same(block, SkeletonSequence.from_frames(frames, about))
    assert block.floor_camera.tolist() == [0.0, -1.0, 0.0, 5.0]


def test_frames_of_16_joints_get_the_ends_that_follow_from_the_parts(tmp_path):
    about = replace(ABOUT, joint_names=JOINT_NAMES[:16])
    frames = frames_with(WHO, about)
    (block,) = StoredFrames(store(tmp_path / "a.frames", frames, about)).blocks()
    whole = SkeletonSequence.from_frames(frames, about)
    assert block.joint_names == JOINT_NAMES
    np.testing.assert_array_equal(block.joints_camera[:, :, :16], whole.joints_camera)
    np.testing.assert_array_equal(np.isfinite(block.joints_camera).all((2, 3)), whole.present)


def test_a_file_cut_anywhere_holds_the_frames_before_the_cut(tmp_path):
    frames = frames_with(WHO)
    whole = store(tmp_path / "whole.frames", frames).read_bytes()
    ends = [
        len(store(tmp_path / "some.frames", frames[:n]).read_bytes())
        for n in range(1, len(frames) + 1)
    ]
    cut = tmp_path / "cut.frames"
    for length in [*range(0, len(whole), 61), *ends]:
        cut.write_bytes(whole[:length])
        count = sum(end <= length for end in ends)
        if not count:
            with pytest.raises(NothingStoredError, match=r"cut\.frames: holds no frame"):
                StoredFrames(cut)
            continue
        stored = StoredFrames(cut)
        assert (stored.frame_count, stored.lost_bytes) == (count, length - ends[count - 1])
        (block,) = stored.blocks()
        assert_same(block, SkeletonSequence.from_frames(frames[:count], ABOUT))


def test_a_damaged_frame_costs_itself_alone(tmp_path):
    frames = frames_with([[1, 2]] * 4)
    ends = [len(store(tmp_path / "a", frames[:n]).read_bytes()) for n in range(1, 5)]
    path = store(tmp_path / "a.frames", frames)
    damaged = bytearray(path.read_bytes())
    damaged[(ends[0] + ends[1]) // 2] ^= 4
    path.write_bytes(damaged)
    stored = StoredFrames(path)
    assert (stored.frame_count, stored.lost_bytes) == (3, ends[1] - ends[0])
    (block,) = stored.blocks()
    assert block.frame_index.tolist() == [0, 2, 3]


def test_one_run_alone_writes_a_file(tmp_path):
    first, second = (FramesFile(tmp_path / "a.frames", ABOUT) for _ in range(2))
    frames = frames_with(WHO)
    with first, second:
        first.append(frames[0])
        with pytest.raises(InputError, match=r"a\.frames: is there already; another run"):
            second.append(frames[0])
        with pytest.raises(InputError, match=r"a\.frames: a run still writes it"):
            StoredFrames(tmp_path / "a.frames")
        first.append(frames[1])
    assert StoredFrames(tmp_path / "a.frames").frame_count == 2


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"PK\x03\x04 an archive", "is no file of frames"),
        (b"topview frames 9\n", "is no file of frames that this version"),
        (b"", "holds no frame"),
    ],
)
def test_another_file_is_refused_in_one_line(tmp_path, content, message):
    (tmp_path / "a.frames").write_bytes(content)
    with pytest.raises(InputError, match=rf"a\.frames: {message}") as error:
        StoredFrames(tmp_path / "a.frames")
    assert "\n" not in str(error.value)


FILLS = """
import resource, sys
from pathlib import Path
from made_frames import ABOUT, frames_with
from topview import JOINT_NAMES
from topview import InputError
from topview.io import FramesFile
path, limit = Path(sys.argv[1]), int(sys.argv[2])
resource.setrlimit(resource.RLIMIT_FSIZE, (limit, resource.RLIM_INFINITY))
with FramesFile(path, ABOUT) as file:
    for n, frame in enumerate(frames_with([[1, 2]] * 50)):
        try:
            file.append(frame)
        except InputError as error:
            print(n, error)
            break
"""


@pytest.mark.parametrize("limit", [100, 50_000])
def test_a_full_disk_costs_the_frame_that_did_not_fit_alone(tmp_path, limit):
    """With a real limit on the size of files, in a process of its own."""
    path = tmp_path / "a.frames"
    helpers = str(Path(__file__).parents[2] / "helpers")
    code = f"import sys; sys.path.insert(0, {helpers!r}){FILLS}"
    done = subprocess.run(
        [sys.executable, "-c", code, str(path), str(limit)],
        capture_output=True,
        text=True,
        check=True,
    )
    kept, _, complaint = done.stdout.partition(" ")
    assert f"{path}: cannot be written: File too large" in complaint
    if kept == "0":
        assert not path.exists()
    else:
        stored = StoredFrames(path)
        assert (stored.frame_count, stored.lost_bytes) == (int(kept), 0)


def test_a_recording_s_name_that_is_no_text_is_kept(tmp_path):
    name = os.fsdecode(b"\xff\xfe")
    about = replace(ABOUT, settings={"recording": name})
    stored = StoredFrames(store(tmp_path / "a.frames", frames_with([[1]]), about))
    assert stored.about.settings == {"recording": name}


def test_what_is_no_regular_file_is_not_waited_for(tmp_path):
    os.mkfifo(tmp_path / "a.frames")
    with pytest.raises(InputError, match="is no regular file; it must be what `topview track`"):
        StoredFrames(tmp_path / "a.frames")


@given(st.integers(0, 2**16), st.integers(1, 255), st.integers(0, 3))
def test_a_record_whose_checksum_is_right_is_frames_or_one_line(scratch, where, change, number):
    path = store(scratch / "a.frames", frames_with([[1], [1, 2], [2]]))
    data, begins = path.read_bytes(), len(frames_file.FIRST_LINE)
    records = []
    while begins < len(data):
        length = int.from_bytes(data[begins : begins + 4], "little")
        records.append(bytearray(data[begins + 8 : begins + 8 + length]))
        begins += 8 + length
    records[number][where % len(records[number])] ^= change
    path.write_bytes(
        frames_file.FIRST_LINE + b"".join(frames_file._framed(bytes(r)) for r in records)
    )
    with suppress(InputError):
        for block in StoredFrames(path).blocks():
            assert len(block.frame_index) <= 3
