"""Motion capture as BVH."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from topview.records import InputError
from topview_lab.datasets.bvh import END_SITE, read_bvh

TINY = """HIERARCHY
ROOT hips
{
  OFFSET 1 0 0
  CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
  JOINT knee
  {
    OFFSET 0 -40 0
    CHANNELS 3 Zrotation Xrotation Yrotation
    End Site
    {
      OFFSET 0 -30 0
    }
  }
}
MOTION
Frames: 3
Frame Time: 0.5
0 100 0  0 0 0   0 0 0
0 100 0  90 0 0  0 0 0
0 100 0  0 90 0  0 0 90
"""


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "tiny.bvh"
    path.write_text(TINY)
    return path


def test_positions(file: Path) -> None:
    motion = read_bvh(file)
    assert len(motion) == 3
    assert motion.frame_time_s == 0.5
    at = motion.positions(np.arange(3))
    assert list(at) == ["hips", "knee", "knee" + END_SITE]
    np.testing.assert_allclose(at["hips"], [(1, 100, 0)] * 3)
    # About z by 90 degrees, down goes to the right; about x by 90 degrees, to the back.
    np.testing.assert_allclose(at["knee"], [(1, 60, 0), (41, 100, 0), (1, 100, -40)], atol=1e-9)
    end = at["knee" + END_SITE]
    np.testing.assert_allclose(end, [(1, 30, 0), (71, 100, 0), (1, 100, -70)], atol=1e-9)


def test_rotations_are_multiplied_in_the_order_of_the_channels(file: Path) -> None:
    file.write_text(TINY.replace("0 100 0  90 0 0 ", "0 100 0  90 90 0 "))
    at = read_bvh(file).positions(np.array([1]))
    # Z X y-offset: X first takes down to the back, where Z leaves it.
    np.testing.assert_allclose(at["knee"], [(1, 100, -40)], atol=1e-9)


def test_bones_keep_their_lengths(file: Path) -> None:
    rng = np.random.default_rng(1)
    rows = "\n".join(" ".join(map(str, row)) for row in rng.uniform(-180, 180, (20, 9)))
    file.write_text(TINY.split("Frames:")[0] + f"Frames: 20\nFrame Time: 0.1\n{rows}\n")
    at = read_bvh(file).positions(np.arange(20))
    np.testing.assert_allclose(np.linalg.norm(at["knee"] - at["hips"], axis=-1), 40.0)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("HIERARCHY", "ANARCHY", "does not begin with HIERARCHY"),
        ("Frames: 3", "Frames: 4", "has 27 numbers for 4 frames of 9 channels"),
        ("MOTION", "", "does not end|where ROOT|has no MOTION"),
        ("OFFSET 0 -40 0", "OFFSET 0 x 0", "damaged .*could not convert"),
        ("Xrotation Yrotation\n  JOINT", "Wrotation Yrotation\n  JOINT", "channel Wrotation"),
        ("0 100 0  0 0 0 ", "0 nan 0  0 0 0 ", "finite"),
        ("JOINT", "JOIN", "has 'JOIN' where"),
    ],
)
def test_what_is_broken_is_named(file: Path, old: str, new: str, message: str) -> None:
    file.write_text(TINY.replace(old, new))
    with pytest.raises(InputError, match=message) as error:
        read_bvh(file)
    assert str(file) in str(error.value)
    assert "\n" not in str(error.value)


def test_cut_off_anywhere(file: Path) -> None:
    for size in range(0, len(TINY) - 4, 17):
        file.write_text(TINY[:size])
        with pytest.raises(InputError):
            read_bvh(file)


def test_missing_or_not_text(file: Path) -> None:
    file.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(InputError, match="is not text"):
        read_bvh(file)
    file.unlink()
    with pytest.raises(InputError, match="No such file"):
        read_bvh(file)
