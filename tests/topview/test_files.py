"""Whatever is wrong with an archive is one line that names it."""

from __future__ import annotations

import os
import zipfile
from contextlib import suppress
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from topview.files import naming, read_archive
from topview.records import InputError

LARGE = 10**15


def archive(**arrays) -> bytes:
    file = BytesIO()
    np.savez_compressed(file, **arrays)
    return file.getvalue()


def member(data: bytes, **options) -> bytes:
    """An archive with one member of these bytes."""
    file = BytesIO()
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as zipped:
        zipped.writestr("joints.npy", data, **options)
    return file.getvalue()


def header(shape: tuple[int, ...], dtype: str = "<f8") -> bytes:
    file = BytesIO()
    np.lib.format.write_array_header_1_0(
        file, {"shape": shape, "fortran_order": False, "descr": dtype}
    )
    return file.getvalue()


def bare_array() -> bytes:
    file = BytesIO()
    np.save(file, np.ones(3))
    return file.getvalue()


def pickled() -> bytes:
    file = BytesIO()
    np.savez(file, joints=np.array([{}], object), allow_pickle=True)
    return file.getvalue()


WHOLE = archive(joints=np.arange(600.0).reshape(20, 30), names=np.array(["a", "b"]))
ENCRYPTED = bytearray(WHOLE)
for start in (WHOLE.index(b"PK\x03\x04") + 6, WHOLE.index(b"PK\x01\x02") + 8):
    ENCRYPTED[start] |= 1
UNKNOWN = bytearray(WHOLE)
for start in (WHOLE.index(b"PK\x03\x04") + 8, WHOLE.index(b"PK\x01\x02") + 10):
    UNKNOWN[start] = 77

BROKEN = {
    "empty": b"",
    "text": b"not an archive",
    "a bare array": bare_array(),
    "truncated": WHOLE[: len(WHOLE) // 2],
    "encrypted": bytes(ENCRYPTED),
    "an unknown compression": bytes(UNKNOWN),
    "more numbers than there are": member(header((LARGE,))),
    "more dimensions than there are": member(header((LARGE, LARGE, LARGE))),
    "too few numbers": member(header((3,)) + b"\0" * 8),
    "no array inside": member(b"text"),
    "a pickle": pickled(),
}


def read(path: Path):
    with naming(path):
        return read_archive(path)


@pytest.mark.parametrize("what", BROKEN)
def test_a_broken_archive_is_one_line(tmp_path, what):
    path = tmp_path / "truth.npz"
    path.write_bytes(BROKEN[what])
    with pytest.raises(InputError, match=r"truth\.npz: is truncated or damaged") as raised:
        read(path)
    assert "\n" not in str(raised.value)


def test_what_is_no_file_is_not_waited_for(tmp_path):
    os.mkfifo(tmp_path / "pipe.npz")
    for path in (tmp_path / "pipe.npz", tmp_path, Path("/dev/zero")):
        with pytest.raises(InputError, match="is no regular file"):
            read(path)
    with pytest.raises(InputError, match="cannot be read: No such file"):
        read(tmp_path / "nowhere.npz")


def test_what_unpacks_to_too_much_is_refused_before_it_is_unpacked(tmp_path, monkeypatch):
    monkeypatch.setattr("topview.files.MOST_UNPACKED_BYTES", 10_000)
    path = tmp_path / "bomb.npz"
    path.write_bytes(archive(joints=np.zeros(100_000)))
    assert path.stat().st_size < 10_000
    with pytest.raises(InputError, match="it unpacks to 800128 bytes, more than 10000"):
        read(path)


def test_a_whole_archive_is_read(tmp_path):
    path = tmp_path / "truth.npz"
    path.write_bytes(WHOLE)
    arrays = read(path)
    np.testing.assert_array_equal(arrays["joints"], np.arange(600.0).reshape(20, 30))
    assert arrays["names"].tolist() == ["a", "b"]


@given(st.integers(0, len(WHOLE) - 1), st.integers(1, 255))
def test_a_changed_byte_is_read_or_refused(tmp_path_factory, where, change):
    data = bytearray(WHOLE)
    data[where] ^= change
    path = tmp_path_factory.getbasetemp() / "changed.npz"
    path.write_bytes(data)
    with suppress(InputError):
        read(path)
