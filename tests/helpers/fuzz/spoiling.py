"""Ways of breaking a file: of any kind, and by what it is."""

from __future__ import annotations

import csv
import io
import json
import os
import re
import socket
import struct
import warnings
import zipfile
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

import cv2
import numpy as np
from numpy.random import Generator

Spoil = Callable[[Path, Generator], None]

NUMBERS: Final = (
    "-1", "0", "1e300", "-1e300", "1e-300", "5e-324", "nan", "inf", "-inf", "1e400", "1e38", "1.5",
    "2147483648", "9223372036854775808", "9" * 400, "9" * 5000, "0x10", "1_000", "٣", "", "x", "1e",
)  # fmt: skip
WORDS: Final = ("", " ", "x", "[/x]", "[bold]", "a\nb", "é", "\x00", "\ud800", "%s{0}", "x" * 10**5)
WORD_VALUES: Final = (np.iinfo(np.int32).max, np.iinfo(np.int32).min, -1, 0, 0x7F800000, 0x7FC00000)
LARGE: Final = 10**15


def _bytes(change: Callable[[bytes, Generator], bytes]) -> Spoil:
    def spoil(path: Path, rng: Generator) -> None:
        path.write_bytes(change(path.read_bytes(), rng))

    return spoil


def _flipped(data: bytes, rng: Generator, count: int) -> bytes:
    changed = bytearray(data)
    for _ in range(count):
        changed[rng.integers(len(changed))] ^= int(rng.integers(1, 256))
    return bytes(changed)


def _word_changed(data: bytes, rng: Generator) -> bytes:
    changed = bytearray(data)
    at = int(rng.integers(max(min(len(changed) - 8, 400), 1)))  # headers come first
    changed[at : at + 4] = struct.pack("<i", int(rng.choice(WORD_VALUES)))
    return bytes(changed)


def _number_changed(data: bytes, rng: Generator) -> bytes:
    """One of the numbers that are written out, of the first few or of all."""
    found = list(re.finditer(rb"-?[0-9][0-9.eE+-]*", data[: int(rng.choice([400, 10**6]))]))
    if not found:
        return data
    number = found[rng.integers(len(found))]
    new = NUMBERS[rng.integers(len(NUMBERS))].encode()
    return data[: number.start()] + new + data[number.end() :]


def _cut_out(data: bytes, rng: Generator) -> bytes:
    start, end = sorted(rng.integers(0, len(data), 2).tolist())
    return data[:start] + data[end:]


def _put_in(data: bytes, rng: Generator) -> bytes:
    at = int(rng.integers(len(data)))
    return data[:at] + rng.bytes(int(rng.integers(1, 2000))) + data[at:]


def _sparse(path: Path, rng: Generator) -> None:
    os.truncate(path, int(rng.choice([2**33, 2**40, 2**43])))


def _another_kind(data: bytes, rng: Generator) -> bytes:
    """The beginning of something else."""
    archive = io.BytesIO()
    with zipfile.ZipFile(archive, "w") as file:
        file.writestr("x", b"x")
    kinds = (
        b"\x89PNG\r\n\x1a\n", b"\xff\xd8\xff\xe0", b"GIF89a", b"P5\n8 8\n255\n",
        b"\x93NUMPY\x01\x00", b"\x89HDF\r\n\x1a\n", b"\x80\x04\x95",
        b"MATLAB 7.3 MAT-file".ljust(124) + b"\x00\x02IM",
        b"{}", b"[]", b"#!/bin/sh\n", b"<html>", archive.getvalue(), b"\x1f\x8b\x08\x00",
        b"%PDF-1.7", "{".encode("utf-16"), b"VERSION 0.7\nFIELDS x y z\n",
    )  # fmt: skip
    return kinds[rng.integers(len(kinds))] + data[: int(rng.integers(0, 2000))]


ANY: Final[dict[str, Spoil]] = {
    "empty": _bytes(lambda data, rng: b""),
    "truncated": _bytes(lambda data, rng: data[: rng.integers(len(data))]),
    "cut at the end": _bytes(lambda data, rng: data[: -int(rng.integers(1, min(len(data), 20)))]),
    "a bit flipped": _bytes(lambda data, rng: _flipped(data, rng, 1)),
    "bytes changed": _bytes(lambda data, rng: _flipped(data, rng, 12)),
    "a word changed": _bytes(_word_changed),
    "a number changed": _bytes(_number_changed),
    "cut out": _bytes(_cut_out),
    "put in": _bytes(_put_in),
    "twice": _bytes(lambda data, rng: data + data),
    "noise": _bytes(lambda data, rng: rng.bytes(int(rng.integers(1, 5000)))),
    "another kind": _bytes(_another_kind),
    "a million gigabytes": _sparse,
}


def _replaced(make: Callable[[Path], object]) -> Spoil:
    def spoil(path: Path, rng: Generator) -> None:
        path.unlink()
        make(path)

    return spoil


def _socket(path: Path) -> None:
    before = os.getcwd()
    os.chdir(path.parent)  # a socket's path has at most a hundred characters
    try:
        with socket.socket(socket.AF_UNIX) as made:
            made.bind(path.name)
    finally:
        os.chdir(before)


def _unreadable(path: Path, rng: Generator) -> None:
    path.chmod(0)


NO_FILE: Final[dict[str, Spoil]] = {
    "a pipe": _replaced(os.mkfifo),
    "a device": _replaced(lambda path: path.symlink_to("/dev/zero")),
    "a socket": _replaced(_socket),
    "a folder": _replaced(Path.mkdir),
    "missing": _replaced(lambda path: None),
    "a loop of links": _replaced(lambda path: path.symlink_to(path.name)),
    **({"not permitted": _unreadable} if os.geteuid() else {}),  # root reads all
}


def _json_value(rng: Generator) -> str:
    depth = int(rng.choice([3, 400, 990, 5000, 100_000]))
    values = (
        *NUMBERS, "null", "true", "[]", "{}", "[1, 2]", '{"a": {}}', "NaN", "Infinity", "-Infinity",
        "[" * depth + "]" * depth, '{"a":' * depth + "1" + "}" * depth,
        *(json.dumps(word) for word in WORDS),
    )  # fmt: skip
    return values[rng.integers(len(values))]


def _json_changed(data: bytes, rng: Generator) -> bytes:
    """The value of a key, of the object or of one inside, is another, or the key another's."""
    text = data.decode()
    keys = re.findall(r'"\w+"(?=:)', text)
    key = keys[rng.integers(len(keys))]
    if rng.random() < 0.15:
        return text.replace(key, json.dumps(WORDS[rng.integers(len(WORDS))]), 1).encode()
    start = text.index(f"{key}:") + len(key) + 1
    _, length = json.JSONDecoder().raw_decode(text[start:].lstrip())
    end = start + length + 1
    return (text[:start] + _json_value(rng) + text[end:]).encode("utf-8", "surrogatepass")


def _arrays(path: Path) -> dict[str, Any]:
    with np.load(path) as arrays:
        return dict(arrays)


def _archive(change: Callable[[dict[str, Any], str, Generator], None]) -> Spoil:
    """A change of one of the arrays."""

    def spoil(path: Path, rng: Generator) -> None:
        arrays = _arrays(path)
        change(arrays, str(rng.choice(sorted(arrays))), rng)
        np.savez_compressed(path, **arrays)

    return spoil


def _kind_changed(arrays: dict[str, Any], key: str, rng: Generator) -> None:
    kind = rng.choice(["U", "S", "c16", "?", "O", "M8[s]", "f2", "i1", "u8", "f4", ">f8", "V3"])
    array = arrays[key]
    try:
        arrays[key] = array.astype(str(kind))
    except (ValueError, TypeError):
        arrays[key] = np.zeros(array.shape, str(kind))


def _shape_changed(arrays: dict[str, Any], key: str, rng: Generator) -> None:
    array = arrays[key]
    shapes = [array[None], array[..., None], array.T, array.ravel(), np.array(3), array]
    if array.ndim:
        shapes += [array[0], array[:0], array[:1], np.concatenate([array, array])]
        shapes += [np.concatenate([array, array], axis=array.ndim - 1), array[..., :-1]]
    arrays[key] = shapes[rng.integers(len(shapes))]


def _values_changed(arrays: dict[str, Any], key: str, rng: Generator) -> None:
    array = np.array(arrays[key])
    if array.dtype.kind == "U":
        values = np.array([WORDS[n].replace("\ud800", "?") for n in rng.permutation(len(WORDS))])
        array = np.resize(values, array.shape)
    elif array.dtype.kind == "f":
        places = rng.random(array.shape) < rng.choice([0.02, 0.5, 1.1])
        with np.errstate(over="ignore"):
            array[places] = rng.choice([np.nan, np.inf, -np.inf, 1e300, -1e300, 1e30, 0.0, 1e-300])
    else:
        limits = np.iinfo(array.dtype) if array.dtype.kind in "iu" else None
        few = [0, 1, *((limits.max, limits.min) if limits else ())]
        places = rng.random(array.shape) < rng.choice([0.02, 0.5, 1.1])
        array[places] = np.array(few, array.dtype)[rng.integers(len(few))]
    arrays[key] = array


def _key_dropped(arrays: dict[str, Any], key: str, rng: Generator) -> None:
    array = arrays.pop(key)
    if rng.random() < 0.5:
        arrays[WORDS[rng.integers(1, 6)].replace("/", "_") + key] = array


def _claims(path: Path, rng: Generator) -> None:
    """An array's header tells of more numbers than there are."""
    arrays = _arrays(path)
    key = str(rng.choice(sorted(arrays)))
    shape = [(LARGE,), (LARGE,) * 3, (2**31, 4), (-1, 3), (10**9,)][rng.integers(5)]
    member = io.BytesIO()
    np.lib.format.write_array_header_1_0(
        member, {"shape": shape, "fortran_order": False, "descr": arrays.pop(key).dtype.str}
    )
    np.savez_compressed(path, **arrays)
    with zipfile.ZipFile(path, "a", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr(f"{key}.npy", member.getvalue() + bytes(int(rng.integers(0, 2**20))))


def _members(path: Path, rng: Generator) -> None:
    """Members of odd names, no arrays, or the same twice."""
    name = ("../x.npy", "x", "joints.npy", "names.npy", "/etc/x.npy", "[/x].npy")[rng.integers(6)]
    with warnings.catch_warnings(action="ignore"), zipfile.ZipFile(path, "a") as archive:
        archive.writestr(name, rng.bytes(int(rng.integers(0, 200))))


def _pickled(path: Path, rng: Generator) -> None:
    arrays = _arrays(path)
    arrays[str(rng.choice(sorted(arrays)))] = np.array([{}, print], object)
    np.savez(path, allow_pickle=True, **arrays)


ARCHIVE: Final[dict[str, Spoil]] = {
    "a key's type": _archive(_kind_changed),
    "a key's shape": _archive(_shape_changed),
    "a key's values": _archive(_values_changed),
    "values, again": _archive(_values_changed),
    "no such key": _archive(_key_dropped),
    "huge claims": _claims,
    "members": _members,
    "pickled": _pickled,
}


def _csv(change: Callable[[list[list[str]], Generator], None]) -> Spoil:
    def spoil(path: Path, rng: Generator) -> None:
        rows = list(csv.reader(io.StringIO(path.read_text())))
        change(rows, rng)
        text = io.StringIO(newline="")
        csv.writer(text).writerows(rows)
        path.write_bytes(text.getvalue().encode("utf-8", "surrogatepass"))

    return spoil


def _cell_changed(rows: list[list[str]], rng: Generator) -> None:
    row = int(rng.integers(len(rows)) if rng.random() < 0.8 else 0)
    values = (*NUMBERS, *WORDS, "x" * 200_000)
    rows[row][rng.integers(len(rows[row]))] = values[rng.integers(len(values))]


def _column_changed(rows: list[list[str]], rng: Generator) -> None:
    column, value = rng.integers(len(rows[0])), str(rng.choice(NUMBERS[:14]))
    for row in rows[1:]:
        row[column] = value


def _rows_changed(rows: list[list[str]], rng: Generator) -> None:
    match rng.integers(4):
        case 0:
            rows.append(rows[-1])
        case 1:
            del rows[rng.integers(len(rows))][-1]
        case 2:
            rows[:] = rows[:1]
        case _:
            rows[0].append(rows[0][0])


def _scattered(rows: list[list[str]], rng: Generator) -> None:
    """Every line is of another frame, person and joint: together they ask for very much."""
    header = rows[0]
    template = rows[1]
    del rows[1:]
    for n in range(2500):
        row = list(template)
        row[header.index("frame_index")] = str(n)
        row[header.index("person_id")] = str(n)
        row[header.index("joint")] = f"joint{n}"
        rows.append(row)


CSV: Final[dict[str, Spoil]] = {
    "a cell": _csv(_cell_changed),
    "a cell, again": _csv(_cell_changed),
    "a column": _csv(_column_changed),
    "rows": _csv(_rows_changed),
    "scattered": _csv(_scattered),
}


def _chunk(kind: bytes, content: bytes) -> bytes:
    checksum = zlib.crc32(kind + content)
    return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", checksum)


def png(width: int, height: int, bits: int, color_type: int, content: bytes) -> bytes:
    """A PNG file whose checksums are right, whatever it holds."""
    header = struct.pack(">IIBBBBB", width, height, bits, color_type, 0, 0, 0)
    parts = _chunk(b"IHDR", header), _chunk(b"IDAT", content), _chunk(b"IEND", b"")
    return b"\x89PNG\r\n\x1a\n" + b"".join(parts)


def _png_claims(path: Path, rng: Generator) -> None:
    """Another size, depth or colour than it has, or too little in it."""
    sides = (0, 1, 120, 160, 4000, 30_000, 100_000, 2**31 - 1, 2**32 - 1)
    width, height = (int(rng.choice(sides)) for _ in range(2))
    if rng.random() < 0.5:
        width, height = 160, 120
    bits, color_type = int(rng.choice([1, 8, 16, 3, 255])), int(rng.choice([0, 2, 3, 4, 6, 9]))
    content = zlib.compress(bytes(int(rng.choice([0, 100, 10**5, 10**6]))))
    path.write_bytes(png(width, height, bits, color_type, content[: rng.integers(1, 2000)]))


def _image_of_another_kind(path: Path, rng: Generator) -> None:
    shapes = (120, 160), (120, 160, 3), (120, 160, 4), (60, 80), (1, 1), (160, 120)
    shape = shapes[rng.integers(len(shapes))]
    kind = (np.uint8, np.uint16)[rng.integers(2)]
    image = rng.integers(0, np.iinfo(kind).max, shape, dtype=kind, endpoint=True)
    suffix = str(rng.choice([".png", ".jpg", ".bmp", ".tiff", ".pgm"]))
    if suffix in (".jpg", ".bmp", ".pgm"):
        image = image.astype(np.uint8)[..., :3] if image.ndim == 3 else image.astype(np.uint8)
    if suffix == ".pgm" and image.ndim == 3:
        image = image[..., 0]
    path.write_bytes(cv2.imencode(suffix, image)[1].tobytes())


def _values_of_image(path: Path, rng: Generator) -> None:
    values = (0, 1, 65535, 30_000)[rng.integers(4)]
    image = np.full((120, 160), values, np.uint16)
    image[rng.random(image.shape) < 0.3] = rng.integers(65536)
    path.write_bytes(cv2.imencode(".png", image)[1].tobytes())


def _jpg_claims(path: Path, rng: Generator) -> None:
    data = bytearray(path.read_bytes())
    at = data.find(b"\xff\xc0") + 5  # start of frame: length and precision, then height and width
    sides = [int(rng.choice([0, 1, 120, 5000, 30_000, 65_535])) for _ in range(2)]
    data[at : at + 4] = struct.pack(">HH", *sides)
    path.write_bytes(data)


PNG: Final[dict[str, Spoil]] = {
    "claims": _png_claims,
    "claims, again": _png_claims,
    "another image": _image_of_another_kind,
    "other values": _values_of_image,
}
JPG: Final[dict[str, Spoil]] = {"claims": _jpg_claims, "another image": _image_of_another_kind}
JSON: Final[dict[str, Spoil]] = {
    f"a value, {n}": _bytes(_json_changed) for n in ("once", "again", "a third time", "a fourth")
}


def _record_changed(data: bytes, rng: Generator) -> bytes:
    """A record of `skeletons.frames` is another, and its checksum right."""
    start = data.index(b"\n") + 1
    records = []
    while start < len(data):
        length, _ = struct.unpack_from("<II", data, start)
        records.append(data[start + 8 : start + 8 + length])
        start += 8 + length
    number = int(rng.integers(len(records)) if rng.random() < 0.5 else 0)
    changes = _flipped(records[number], rng, 1), _cut_out(records[number], rng), rng.bytes(40)
    records[number] = changes[rng.integers(len(changes))]
    framed = (struct.pack("<II", len(r), zlib.crc32(r)) + r for r in records)
    return data[: data.index(b"\n") + 1] + b"".join(framed)


FRAMES: Final[dict[str, Spoil]] = {
    f"a record, {n}": _bytes(_record_changed) for n in ("once", "again", "a third time")
}
BY_SUFFIX: Final = {
    ".frames": FRAMES,
    ".json": JSON,
    ".npz": ARCHIVE,
    ".csv": CSV,
    ".png": PNG,
    ".jpg": JPG,
}
