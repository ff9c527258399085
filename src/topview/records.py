"""The records that pass between the rooms of topview: cameras, frames, people, recordings.

All arrays are validated on construction and made read-only, so that a record can be handed
around freely. The camera frame is x right, y down, z forward; units are metres, radians, seconds.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from enum import IntEnum
from math import isfinite
from numbers import Integral, Real
from typing import Any, Final, Literal, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from topview.lines import as_line

MAX_FOCAL_LENGTH_PX = 20_000.0
# Ours; of the image's side from its first to its last pixel, then seen under 169 degrees. An image
# of one pixel's width, as a coarse look at a narrow one may be, has no angle.
MIN_FOCAL_SHARE = 0.05
MIN_FOCAL_LENGTH_PX = 1e-6
MAX_IMAGE_SIDE_PX = 16_384
MAX_IMAGE_PIXELS = 2**25  # ours: several times those of any depth camera, and of most of colour
MAX_PLACE_M = 1e8  # ours; from a world's origin: twice around the Earth
ROTATION_TOLERANCE = 0.01  # ours; of R R', for numbers written with three digits
LEAST_DOWN = 0.5  # ours; the share of gravity along an image's columns: tilted by up to 60 degrees


class InputError(ValueError):
    """Something a user gave cannot be used; the message is one line: what, value, what is right.

    Whatever it tells of, it is printable and short (`as_line`). The command line prints it, and
    exits with status 2.
    """

    def __init__(self, message: str) -> None:
        super().__init__(as_line(message))


MOST_SHOWN: Final = 80  # characters of a value in an error


def shown(value: object) -> str:
    """A value as an error tells it: in one short line, whatever it is."""
    try:
        text = repr(value)
    except (RecursionError, ValueError):  # nested too deeply; a number of too many digits
        text = f"a {type(value).__name__}"
    text = " ".join(text.split())
    return text if len(text) <= MOST_SHOWN else f"{text[:MOST_SHOWN]} ..."


def real_number(value: object, name: str) -> float:
    """A float of a number of whatever type: kernels are compiled for each type anew, and a number
    of 32 bits is less exact.

    Raises:
        InputError: no real number: a truth value, text, None, a complex number.
    """
    if isinstance(value, Real) and not isinstance(value, bool):
        try:
            return float(value)
        except OverflowError:
            pass
    raise InputError(f"{name} is {shown(value)}; it must be a number")


def whole_number(value: object, name: str) -> int:
    """An int of a whole number of whatever type.

    Raises:
        InputError: no whole number.
    """
    if isinstance(value, Integral) and not isinstance(value, bool):
        return int(value)
    if isinstance(value, Real) and not isinstance(value, bool) and float(value).is_integer():
        return int(float(value))
    raise InputError(f"{name} is {shown(value)}; it must be a whole number")


def check_range(settings: object, low: float, high: float, *names: str) -> None:
    """Make fields of a frozen settings class floats, or ints where `low` is one, and check that
    they lie within `low` to `high`, both included.

    Raises:
        InputError: one of them does not, or is no such number.
    """
    as_number = whole_number if isinstance(low, int) else real_number
    for name in names:
        value = as_number(getattr(settings, name), name)
        if not low <= value <= high:
            raise InputError(f"{name} is {shown(value)}; it must be {low:g} to {high:g}")
        object.__setattr__(settings, name, value)


# Ours. No depth camera of a room reads farther than the first; an image of which more lies beyond
# the second than before it is in other units.
FARTHEST_READING_M: Final = 100.0
FARTHEST_ROOM_M: Final = 30.0


def read_only(array: NDArray[Any]) -> NDArray[Any]:
    """The array itself, made read-only."""
    array.setflags(write=False)
    return array


def _frozen(array: NDArray[Any]) -> NDArray[Any]:
    """A contiguous read-only copy; the array itself if it is one that nobody can write to."""
    flags = array.flags
    if flags.owndata and flags.c_contiguous and not flags.writeable:
        return array
    return read_only(np.array(array, order="C"))


def _is_image(array: Any, shape: tuple[int, ...], dtype: type) -> bool:
    return isinstance(array, np.ndarray) and array.shape == shape and array.dtype == dtype


def _told(array: Any) -> str:
    if isinstance(array, np.ndarray):
        return f"{array.dtype} {array.shape}"
    return "None" if array is None else f"a {type(array).__name__}"


def _make_numbers(record: object, as_number: Callable[[object, str], Any], *names: str) -> None:
    """Make fields of a frozen record what `as_number` makes of them; `names` are "camera fx"."""
    for name in names:
        field_name = name.rpartition(" ")[2]
        object.__setattr__(record, field_name, as_number(getattr(record, field_name), name))


def rigid_transform(T: Any, name: str) -> NDArray[np.float64]:
    """[4, 4] float64, read-only, of what should be a rigid transform in metres.

    Raises:
        InputError: it is not 4 x 4 finite numbers, or no rotation and translation.
    """
    try:
        given = np.array(T)
    except (TypeError, ValueError):  # rows of different lengths
        given = np.empty(0)
    is_numbers = given.dtype.kind in "iuf" and given.shape == (4, 4)
    T = given.astype(np.float64) if is_numbers else np.empty(0)
    if not is_numbers:
        raise InputError(f"{name} must be 4 x 4 numbers: a list of four rows of four")
    R = T[:3, :3]
    with np.errstate(over="ignore", invalid="ignore"):
        off = np.abs(R @ R.T - np.eye(3)).max()
    if not off < ROTATION_TOLERANCE or np.linalg.det(R) < 0.0:
        raise InputError(
            f"the upper left 3 x 3 of {name} is no rotation; its rows must be at right angles, "
            "one long and right-handed"
        )
    if T[3].tolist() != [0.0, 0.0, 0.0, 1.0]:
        raise InputError(f"the last row of {name} is {T[3].tolist()}; it must be 0, 0, 0, 1")
    if not (np.abs(T[:3, 3]) <= MAX_PLACE_M).all():
        raise InputError(
            f"the last column of {name} is {T[:3, 3].tolist()}; it must be metres, "
            f"up to {MAX_PLACE_M:g}"
        )
    return read_only(T)


def gravity_direction(gravity: Any, name: str) -> NDArray[np.float64]:
    """[3] float64 unit vector, read-only, of what should point down in the frame of a camera.

    Raises:
        InputError: it is not three finite numbers, or does not point down in the image.
    """
    try:
        given = np.array(gravity)
    except (TypeError, ValueError):
        given = np.empty(0)
    is_numbers = given.dtype.kind in "iuf" and given.shape == (3,) and np.isfinite(given).all()
    down = given.astype(np.float64) if is_numbers else np.zeros(3)
    with np.errstate(over="ignore"):
        length = float(np.linalg.norm(down))
    if not 0.0 < length < np.inf or down[1] / length < LEAST_DOWN:
        raise InputError(
            f"{name} is {shown(gravity)}; it must be three numbers that point down in the frame of "
            "the camera, y the largest; what an accelerometer at rest tells is the opposite"
        )
    return read_only(down if abs(length - 1.0) < 1e-9 else down / length)  # so that it is kept


# Model: how many coefficients it may have.
DISTORTION_MODELS: Final[dict[str, tuple[int, ...]]] = {
    "none": (0, 4, 5, 8),
    "brown_conrady": (4, 5),
    "rational": (8,),
    "inverse_brown_conrady": (4, 5),
}


@dataclass(frozen=True, slots=True)
class Distortion:
    """How a lens bends an image; `topview.camera.lens` has the formulas.

    Attributes:
        model: "brown_conrady" (OpenCV's 4 or 5 coefficients), "rational" (OpenCV's 8; the Azure
            Kinect's), "inverse_brown_conrady" (RealSense's) or "none".
        coefficients: in OpenCV's order, k1 k2 p1 p2 [k3 [k4 k5 k6]]; of "none" all 0, if any.

    Raises:
        InputError: a model that is not known, a wrong number of coefficients, one not finite.
    """

    model: str
    coefficients: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        counts = DISTORTION_MODELS.get(self.model) if isinstance(self.model, str) else None
        if counts is None:
            raise InputError(
                f"distortion model is {shown(self.model)}; it must be one of "
                f"{', '.join(DISTORTION_MODELS)}"
            )
        if isinstance(self.coefficients, str) or not isinstance(self.coefficients, Iterable):
            raise InputError(
                f"distortion coefficients are {shown(self.coefficients)}; they must be numbers"
            )
        coefficients = tuple(
            real_number(coefficient, f"distortion coefficient {n}")
            for n, coefficient in enumerate(self.coefficients, 1)
        )
        object.__setattr__(self, "coefficients", coefficients)
        if len(coefficients) not in counts:
            raise InputError(
                f"distortion {self.model} has {len(coefficients)} coefficients; it must have "
                f"{' or '.join(map(str, counts))}, in the order k1 k2 p1 p2 k3 k4 k5 k6"
            )
        if not all(map(isfinite, coefficients)):
            raise InputError(
                f"distortion coefficients are {shown(coefficients)}; they must be finite"
            )
        if self.model == "none" and any(coefficients):
            raise InputError(
                f"distortion none has the coefficients {shown(coefficients)}; they must be 0, or "
                "left out"
            )

    @property
    def is_none(self) -> bool:
        """Whether it leaves the image as it is."""
        return not any(self.coefficients)


@dataclass(frozen=True, slots=True)
class DepthNoise:
    """The standard deviation of a depth reading at z metres: a + b z + c z^2.

    Attributes:
        constant_m: a, metres.
        per_m: b, metres per metre.
        per_square_m: c, 1/m.
    """

    constant_m: float = 0.0
    per_m: float = 0.0
    per_square_m: float = 0.0

    @property
    def is_quadratic(self) -> bool:
        """Whether it grows with the square of the depth alone, as that of a disparity does."""
        return not self.constant_m and not self.per_m

    def sigma_m(self, depth_m: Any) -> Any:
        """Metres, of readings of any shape."""
        grows_m = self.per_square_m * depth_m * depth_m
        if self.is_quadratic:
            return grows_m
        return self.constant_m + self.per_m * depth_m + grows_m

    def times(self, factor: float, more_m: float = 0.0) -> tuple[float, float, float]:
        """(a, b, c) of so many standard deviations and `more_m`, as the kernels take it."""
        return (
            factor * self.constant_m + more_m,
            factor * self.per_m,
            factor * self.per_square_m,
        )


SensorName = Literal["kinect1", "tof", "stereo"]
SENSOR_NOISE: Final[dict[str, DepthNoise]] = {
    # Structured light, Kinect v1: a disparity errs alike near and far. K. Khoshelham and
    # S. Elberink, "Accuracy and resolution of Kinect depth data" (Sensors 2012): 1.4e-3 z^2.
    "kinect1": DepthNoise(per_square_m=0.0015),
    # Time of flight, Kinect v2 and Azure Kinect: ours, 8 mm at 3.5 m; the Azure Kinect's data
    # sheet allows 17 mm there (confirmed by M. Tölgyessy et al., Sensors 2021).
    "tof": DepthNoise(constant_m=0.001, per_m=0.002),
    # Active stereo: z^2 times the error of a disparity, 0.08 pixels, over focal length and
    # baseline (Intel, "Tuning depth cameras for best performance"); of a RealSense D435 at
    # 848 x 480, whose 424 pixels and 50 mm are those of the noisiest of its family.
    "stereo": DepthNoise(per_square_m=0.0038),
}
KINECT1_NOISE: Final = SENSOR_NOISE["kinect1"]


@dataclass(frozen=True, slots=True, eq=False)
class Camera:
    """A depth camera: intrinsics in pixels (pixel centres at integers), lens, noise and place.

    Attributes:
        fx, fy: focal lengths, pixels.
        cx, cy: principal point, pixels.
        width, height: of the image, pixels.
        distortion: of the lens; None where the image is undistorted already.
        sensor: what kind of depth camera, which says how noisy a reading is (`SENSOR_NOISE`).
        T_world_camera: [4, 4] its pose in a world frame of the user's, metres; None if not known.
        gravity_camera: [3] points down in the camera's frame, of any length, kept as a unit vector;
            None if only the floor tells it.

    Raises:
        InputError: a value is no number, not positive where it must be, or absurd.
    """

    fx: float
    fy: float
    cx: float
    cy: float
    width: int
    height: int
    distortion: Distortion | None = None
    sensor: SensorName = "kinect1"
    T_world_camera: NDArray[np.float64] | None = None
    gravity_camera: NDArray[np.float64] | None = None

    def __post_init__(self) -> None:
        _make_numbers(self, whole_number, "camera width", "camera height")
        _make_numbers(self, real_number, "camera fx", "camera fy", "camera cx", "camera cy")
        for name in ("width", "height"):
            side = getattr(self, name)
            if not 1 <= side <= MAX_IMAGE_SIDE_PX:
                raise InputError(
                    f"camera {name} is {shown(side)}; it must be 1 to {MAX_IMAGE_SIDE_PX} pixels"
                )
        if self.width * self.height > MAX_IMAGE_PIXELS:
            raise InputError(
                f"camera has {self.width} x {self.height} pixels; it must have at most "
                f"{MAX_IMAGE_PIXELS}"
            )
        for name, side in (("fx", self.width), ("fy", self.height)):
            focal = getattr(self, name)
            least = max(MIN_FOCAL_SHARE * (side - 1), MIN_FOCAL_LENGTH_PX)
            if not least <= focal <= MAX_FOCAL_LENGTH_PX:
                raise InputError(
                    f"camera {name} is {focal}; it must be a focal length in pixels, {least:g} "
                    f"to {MAX_FOCAL_LENGTH_PX:g} for an image of {side}"
                )
        for name, side in (("cx", self.width), ("cy", self.height)):
            centre = getattr(self, name)
            if not -side <= centre <= 2 * side:
                raise InputError(
                    f"camera {name} is {centre}; it must be a principal point near the image, "
                    f"0 to {side - 1} pixels"
                )
        if self.sensor not in tuple(SENSOR_NOISE):
            known = ", ".join(SENSOR_NOISE)
            raise InputError(f"camera sensor is {shown(self.sensor)}; it must be one of {known}")
        if not isinstance(self.distortion, Distortion | None):
            raise InputError(
                f"camera distortion is {shown(self.distortion)}; it must be a Distortion or None"
            )
        if self.T_world_camera is not None:
            T = rigid_transform(self.T_world_camera, "T_world_camera")
            object.__setattr__(self, "T_world_camera", T)
        if self.gravity_camera is not None:
            down = gravity_direction(self.gravity_camera, "gravity_camera")
            object.__setattr__(self, "gravity_camera", down)

    @property
    def is_pinhole(self) -> bool:
        """Whether its images are undistorted."""
        return self.distortion is None or self.distortion.is_none

    @property
    def noise(self) -> DepthNoise:
        """Of a depth reading."""
        return SENSOR_NOISE[self.sensor]

    def _values(self) -> tuple[Any, ...]:
        T = self.T_world_camera
        pose = None if T is None else tuple(T.ravel().tolist())
        down = None if self.gravity_camera is None else tuple(self.gravity_camera.tolist())
        intrinsics = (self.fx, self.fy, self.cx, self.cy, self.width, self.height)
        return (*intrinsics, self.distortion, self.sensor, pose, down)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Camera) and self._values() == other._values()

    def __hash__(self) -> int:
        return hash(self._values())


@dataclass(frozen=True, slots=True, eq=False)
class Frame:
    """One registered depth (and colour) image; the arrays given are copied.

    Attributes:
        index: number of the frame in its recording, or how many came before where the source does
            not number them; only a name, time is `timestamp_s`.
        timestamp_s: seconds since the recording's start.
        depth_m: [H, W] float32 metres along the optical axis, 0 where there is no reading. What is
            no number above 0, or beyond `FARTHEST_READING_M`, is no reading and becomes 0.
        camera: what took both images.
        color: [H, W, 3] uint8 RGB registered to the depth image, or None.
        name: what the source itself calls it, the image's file for one; empty if nothing.

    Raises:
        InputError: depth or colour are no images of the camera's, index or time no number, or the
            depth is probably in millimetres.
    """

    index: int
    timestamp_s: float
    depth_m: NDArray[np.float32]
    camera: Camera
    color: NDArray[np.uint8] | None = None
    name: str = ""

    def __post_init__(self) -> None:
        _make_numbers(self, whole_number, "frame index")
        _make_numbers(self, real_number, "frame timestamp_s")
        if not -(2**63) <= self.index < 2**63:
            raise InputError(
                f"frame index is {shown(self.index)}; it must be a whole number of 64 bits"
            )
        if not isinstance(self.camera, Camera):
            raise InputError(f"frame {self.index}: camera is {_told(self.camera)}; it must be one")
        shape = (self.camera.height, self.camera.width)
        if not _is_image(self.depth_m, shape, np.float32):
            raise InputError(
                f"frame {self.index}: depth is {_told(self.depth_m)}; "
                f"it must be float32 metres, {shape} as the camera says"
            )
        if self.color is not None and not _is_image(self.color, (*shape, 3), np.uint8):
            raise InputError(
                f"frame {self.index}: colour is {_told(self.color)}; "
                f"it must be uint8 {(*shape, 3)}, registered to the depth image"
            )
        object.__setattr__(self, "depth_m", self._readings())
        if self.color is not None:
            object.__setattr__(self, "color", _frozen(self.color))

    def _readings(self) -> NDArray[np.float32]:
        """The depth image with nothing but readings and 0."""
        depth_m = self.depth_m
        is_reading = (depth_m > 0.0) & (depth_m <= FARTHEST_READING_M)
        is_far = (depth_m > FARTHEST_ROOM_M) & (depth_m < np.inf)
        n_far, n_near = np.count_nonzero(is_far), np.count_nonzero(is_reading & ~is_far)
        if n_far > n_near:
            seen = depth_m[is_far | is_reading]
            raise InputError(
                f"frame {self.index}: {n_far} of {n_far + n_near} readings lie beyond "
                f"{FARTHEST_ROOM_M:g} m, from {seen.min():.4g} to {seen.max():.4g} m; they must be "
                "metres, and are probably millimetres"
            )
        if (is_reading | (depth_m == 0.0)).all():
            return _frozen(depth_m)
        return read_only(np.where(is_reading, depth_m, np.float32(0.0)))


class JointState(IntEnum):
    """Why a joint is, or is not, seen. The names, in this order, are the `joint_state_names`."""

    ABSENT = 0
    VISIBLE = 1
    SELF_OCCLUDED = 2
    OCCLUDED_BY_PERSON = 3
    OCCLUDED_BY_OBJECT = 4
    OUT_OF_VIEW = 5


JOINT_STATE_NAMES: tuple[str, ...] = tuple(state.name.lower() for state in JointState)


@dataclass(frozen=True, slots=True, eq=False)
class Person:
    """One person in one frame: J joints and P body parts, in the order of `topview.body`'s
    `OUTPUT_JOINTS` and `PARTS`.

    Attributes:
        id: identity that lasts while the person is in view, counted from 1.
        height_m: stature.
        joints_camera: [J, 3] metres.
        joint_state: [J] uint8, a `JointState` each.
        joint_confidence: [J] float32 in 0..1.
        Ts_camera_part: [P, 4, 4] part poses; a part's frame has its origin at the joint nearer the
            head (the head's own at the crown), +y along its axis to the far end, +x to the
            person's right and +z to the front, when standing with the arms down.
        joint_covariance_m2: [J, 3, 3] float32 of each joint's error in the camera frame, square
            metres, NaN where it is not known: throughout, if it is not given.
    """

    id: int
    height_m: float
    joints_camera: NDArray[np.float64]
    joint_state: NDArray[np.uint8]
    joint_confidence: NDArray[np.float32]
    Ts_camera_part: NDArray[np.float64]
    joint_covariance_m2: NDArray[np.float32] = field(
        default_factory=lambda: np.empty(0, np.float32)
    )

    def __post_init__(self) -> None:
        if not self.joint_covariance_m2.size:
            unknown = np.full((len(self.joints_camera), 3, 3), np.nan, np.float32)
            object.__setattr__(self, "joint_covariance_m2", unknown)
        for array in (
            self.joints_camera,
            self.joint_state,
            self.joint_confidence,
            self.Ts_camera_part,
            self.joint_covariance_m2,
        ):
            read_only(array)


@dataclass(frozen=True, slots=True, eq=False)
class PartMap:
    """Whose each pixel of a depth image is, and which part of the body.

    Attributes:
        person_ids: [H, W] int32, id of the person, 0 for nobody.
        parts: [H, W] uint8, 1 + the index into `topview.PART_NAMES`, 0 for none: hands belong to
            forearms, feet to lower legs; what somebody carries may be of no part.
    """

    person_ids: NDArray[np.int32]
    parts: NDArray[np.uint8]

    def __post_init__(self) -> None:
        read_only(self.person_ids)
        read_only(self.parts)


@runtime_checkable
class Recording(Protocol):
    """A depth recording, or a camera that is live: iterate to get its frames in order. A stored
    one may be iterated again.

    `camera` took it. Frames carry the camera that they follow, which is another one where they have
    been undistorted while they were read. Those that cannot be read are left out of the iteration
    and named in `problems`, one clear line each (file, value, what would be right), so that one bad
    file loses nothing else.

    It may have `is_flipped_back`, True where the source is mirrored and the frames are not, so that
    nobody flips them again; and `is_mirrored`, True where the user said that it is.
    """

    name: str
    camera: Camera
    problems: list[str]

    @property
    def frame_count(self) -> int | None:
        """How many frames there should be, the unreadable ones included; None if nobody knows."""
        ...

    def __iter__(self) -> Iterator[Frame]: ...
