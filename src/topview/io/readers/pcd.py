"""An organized point cloud, `.pcd` (Point Cloud Library, format 0.7): one frame.

https://pointclouds.org/documentation/tutorials/pcd_file_format.html. Points must be in the camera
frame x right, y down, z forward; the intrinsics are recovered from the cloud itself.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import accumulate
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from topview.files import MOST_BYTES, naming, read_bytes
from topview.io.readers.depth import depth_image
from topview.io.readers.lzf import lzf_decompress
from topview.records import (
    FARTHEST_READING_M,
    MAX_IMAGE_SIDE_PX,
    Camera,
    Frame,
    InputError,
    shown,
)

TYPE_KINDS: Final = {"F": "f", "U": "u", "I": "i"}
MAX_RESIDUAL_PX: Final = 0.5  # ours: half a pixel, no worse than the sampling of the image itself
MIN_POINTS: Final = 100  # ours: fewer do not say where the camera is
MAX_SLOPE: Final = 20.0  # ours; |x / z| and |y / z| of 87 degrees aside, as far as no camera sees


def recognises(path: Path) -> bool:
    return path.suffix.lower() == ".pcd"


class PcdRecording:
    """One frame from an organized cloud with fields x y z and optionally rgb or rgba.

    Raises:
        InputError: unreadable, truncated, unorganized, or not the image of a pinhole camera.
    """

    def __init__(self, path: Path) -> None:
        self.name = path.stem
        self.problems: list[str] = []
        with naming(path):
            header, body = parse_header(read_bytes(path))
            columns = read_columns(header, body)
            image_shape = (header.height, header.width)
            with np.errstate(invalid="ignore"):  # of NaN that signals
                x, y, z = (columns[axis].reshape(image_shape).astype(np.float64) for axis in "xyz")
            is_seen = points_seen(x, y, z)
            self.camera = fit_camera(x, y, z, is_seen)
            z = np.where(is_seen, z, 0.0)
        packed = columns.get("rgb", columns.get("rgba"))
        color = None if packed is None else unpack_color(packed).reshape(*image_shape, 3)
        self._frame = Frame(0, 0.0, depth_image(z, 1.0), self.camera, color, path.name)

    @property
    def frame_count(self) -> int:
        return 1

    def __iter__(self) -> Iterator[Frame]:
        yield self._frame


@dataclass(frozen=True, slots=True)
class Field:
    """`count` values of one type per point; `offset` bytes into the point."""

    dtype: np.dtype[Any]
    count: int
    offset: int
    column: int


@dataclass(frozen=True, slots=True)
class PcdHeader:
    """The cloud's layout; `encoding` is ascii, binary or binary_compressed."""

    fields: dict[str, Field]
    width: int
    height: int
    encoding: str

    @property
    def points(self) -> int:
        return self.width * self.height

    @property
    def point_size(self) -> int:
        return sum(field.dtype.itemsize * field.count for field in self.fields.values())

    @property
    def point_columns(self) -> int:
        return sum(field.count for field in self.fields.values())


def parse_header(data: bytes) -> tuple[PcdHeader, bytes]:
    """The header, and the bytes after it.

    Raises:
        InputError: incomplete, or not an organized cloud with x, y and z.
    """
    entries: dict[str, list[str]] = {}
    start = 0
    while "DATA" not in entries:
        end = data.find(b"\n", start)
        if end < 0:
            raise InputError("has no DATA line (truncated?); it must be a PCD file")
        words = data[start:end].decode("ascii", "replace").split()
        if words and not words[0].startswith("#"):
            entries[words[0].upper()] = words[1:]
        start = end + 1
    missing = [key for key in ("FIELDS", "SIZE", "TYPE", "WIDTH", "HEIGHT") if key not in entries]
    if missing:
        raise InputError(f"has no {', '.join(missing)} in its header; it must be a PCD file")
    try:
        width, height = (int(entries[key][0]) for key in ("WIDTH", "HEIGHT"))
        fields = _fields(entries)
        encoding = entries["DATA"][0].lower()
    except (ValueError, IndexError, TypeError, KeyError) as error:
        raise InputError(f"has a damaged header ({error}); it must be a PCD file") from None
    if not (width <= MAX_IMAGE_SIDE_PX and height <= MAX_IMAGE_SIDE_PX):
        raise InputError(
            f"is a cloud of {shown(width)} x {shown(height)} points; "
            f"it must be at most {MAX_IMAGE_SIDE_PX} x {MAX_IMAGE_SIDE_PX}"
        )
    if height <= 1 or width <= 1:
        raise InputError(
            f"is an unorganized cloud, {width} x {height} points; "
            "it must be organized, as an image of points"
        )
    absent = [axis for axis in "xyz" if axis not in fields or fields[axis].dtype.kind != "f"]
    if absent:
        raise InputError(
            f"has no fields {', '.join(absent)} of type F (it has {' '.join(fields)}); "
            "it must have x, y and z"
        )
    header = PcdHeader(fields, width, height, encoding)
    if header.points * header.point_size > MOST_BYTES:
        raise InputError(
            f"has {header.points * header.point_size} bytes of points, by its header; "
            f"it must have at most {MOST_BYTES}"
        )
    return header, data[start:]


def _fields(entries: dict[str, list[str]]) -> dict[str, Field]:
    names, sizes, types = entries["FIELDS"], entries["SIZE"], entries["TYPE"]
    counts = [int(count) for count in entries.get("COUNT", ["1"] * len(names))]
    dtypes = [
        np.dtype(f"<{TYPE_KINDS[kind]}{int(size)}") for kind, size in zip(types, sizes, strict=True)
    ]
    if min(counts) < 1:
        raise ValueError(f"COUNT {min(counts)}")
    lengths = [dtype.itemsize * count for dtype, count in zip(dtypes, counts, strict=True)]
    offsets = accumulate(lengths, initial=0)
    columns = accumulate(counts, initial=0)
    # Padding fields share the name "_"; numbered, each keeps its place.
    unique = [name if name != "_" else f"_{i}" for i, name in enumerate(names)]
    return {
        name: Field(dtype, count, offset, column)
        for name, dtype, count, offset, column in zip(
            unique, dtypes, counts, offsets, columns, strict=False
        )
    }


def read_columns(header: PcdHeader, body: bytes) -> dict[str, NDArray[Any]]:
    """Each field's first value of every point, [points]; colour fields of other than 4 bytes are
    left out."""
    wanted = {
        name: field
        for name, field in header.fields.items()
        if name in ("x", "y", "z") or (name in ("rgb", "rgba") and field.dtype.itemsize == 4)
    }
    match header.encoding:
        case "ascii":
            table = _ascii_table(header, body)
            with np.errstate(over="ignore", invalid="ignore"):  # beyond 32 bits is infinite
                return {name: table[:, f.column].astype(f.dtype) for name, f in wanted.items()}
        case "binary":
            _check_length(len(body), header)
            return {
                name: np.ndarray(
                    header.points, f.dtype, body, offset=f.offset, strides=(header.point_size,)
                )
                for name, f in wanted.items()
            }
        case "binary_compressed":
            body = _decompressed(header, body)
            return {  # all values of one field, then all of the next
                name: np.ndarray(
                    header.points,
                    f.dtype,
                    body,
                    offset=f.offset * header.points,
                    strides=(f.dtype.itemsize * f.count,),
                )
                for name, f in wanted.items()
            }
        case other:
            raise InputError(f"has DATA {other}; it must be ascii, binary or binary_compressed")


def _ascii_table(header: PcdHeader, body: bytes) -> NDArray[np.float64]:
    expected = header.points * header.point_columns
    words = body.split(None, expected)  # no more of them than are wanted
    if len(words) != expected:
        count = f"more than {expected}" if len(words) > expected else len(words)
        raise InputError(
            f"is truncated or damaged: it holds {count} numbers; "
            f"{header.width} x {header.height} points must have {expected}"
        )
    try:
        values = np.array(words, dtype=np.float64)
    except ValueError as error:
        raise InputError(f"has a point that is no number ({error})") from None
    return values.reshape(header.points, header.point_columns)


def _check_length(length: int, header: PcdHeader) -> None:
    expected = header.points * header.point_size
    if length < expected:
        raise InputError(
            f"is truncated: it holds {length} bytes of points; "
            f"{header.width} x {header.height} points must have {expected}"
        )


def _decompressed(header: PcdHeader, body: bytes) -> bytes:
    compressed, size = (int.from_bytes(body[i : i + 4], "little") for i in (0, 4))
    if len(body) < 8 + compressed:
        raise InputError(
            f"is truncated: it holds {len(body)} bytes of compressed points; "
            f"it must have {8 + compressed}"
        )
    _check_length(size, header)
    if size > MOST_BYTES:
        raise InputError(f"unpacks to {size} bytes, as it says; it must be at most {MOST_BYTES}")
    return lzf_decompress(body[8 : 8 + compressed], size)


def unpack_color(packed: NDArray[Any]) -> NDArray[np.uint8]:
    """[points, 3] uint8 RGB from 4-byte values 0xAARRGGBB, whatever type they pass for."""
    bits = np.ascontiguousarray(packed).view(np.uint32)
    return np.stack([bits >> 16 & 255, bits >> 8 & 255, bits & 255], axis=-1).astype(np.uint8)


def points_seen(
    x: NDArray[np.float64], y: NDArray[np.float64], z: NDArray[np.float64]
) -> NDArray[np.bool_]:
    """[H, W] where a point is one that a camera can see: ahead of it, and not too far or aside."""
    with np.errstate(invalid="ignore", over="ignore"):
        is_ahead = (z > 0.0) & (z <= FARTHEST_READING_M)
        return is_ahead & (np.abs(x) <= MAX_SLOPE * z) & (np.abs(y) <= MAX_SLOPE * z)


def fit_camera(
    x: NDArray[np.float64],
    y: NDArray[np.float64],
    z: NDArray[np.float64],
    is_seen: NDArray[np.bool_],
) -> Camera:
    """The pinhole camera whose pixel (column, row) sees each point [H, W], by least squares.

    Raises:
        InputError: too few points, or they are no picture taken from the origin along +z.
    """
    height, width = z.shape
    if is_seen.sum() < MIN_POINTS:
        raise InputError(
            f"has {is_seen.sum()} points with z above 0, up to {FARTHEST_READING_M:g} m; it must "
            f"have at least {MIN_POINTS}, in metres, in the camera frame x right, y down, z forward"
        )
    rows, columns = np.nonzero(is_seen)
    fx, cx, residual_u = _fit_line(x[is_seen] / z[is_seen], columns)
    fy, cy, residual_v = _fit_line(y[is_seen] / z[is_seen], rows)
    if not (fx > 0.0 and fy > 0.0):
        raise InputError(
            f"has focal lengths {fx:.1f} and {fy:.1f} px; both must be positive: "
            "points in the camera frame x right, y down, z forward"
        )
    residual_px = max(residual_u, residual_v)
    if residual_px > MAX_RESIDUAL_PX:
        raise InputError(
            f"is no pinhole image: points lie {residual_px:.2f} px from their pixels; "
            f"it must be at most {MAX_RESIDUAL_PX} px"
        )
    return Camera(fx, fy, cx, cy, width, height)


def _fit_line(
    slopes: NDArray[np.float64], pixels: NDArray[np.integer]
) -> tuple[float, float, float]:
    """f and c of pixels = f * slopes + c, and the root mean square residual."""
    design = np.stack([slopes, np.ones_like(slopes)], axis=-1)
    focal, centre = np.linalg.lstsq(design, pixels, rcond=None)[0]
    residuals = design @ (focal, centre) - pixels
    return float(focal), float(centre), float(np.sqrt(np.mean(residuals**2)))
