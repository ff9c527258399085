"""Cameras and frames that a user makes by hand: numbers of any type are the same numbers."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numba.core import event
from numpy.testing import assert_array_equal

from topview.records import (
    MAX_IMAGE_PIXELS,
    MIN_FOCAL_SHARE,
    Camera,
    Distortion,
    Frame,
    InputError,
    Person,
)
from topview.track import Tracker, TrackerSettings
from topview.track.methods.utvr import UtvrSettings
from topview_lab.sim import SimulatedRecording, scene_by_name

VALUES = {"fx": 57.0, "fy": 57.0, "cx": 31.5, "cy": 23.5, "width": 64, "height": 48}
NO_NUMBERS = [True, np.bool_(True), "57", None, 57j, [57.0], np.array([57.0]), {}, float, 10**5000]


def camera(**values) -> Camera:
    return Camera(**(VALUES | values))


@pytest.mark.parametrize("kind", [np.float32, np.float64, np.float16, np.longdouble, Fraction, int])
def test_a_focal_length_of_any_type_is_a_float(kind):
    made = camera(fx=kind(57), fy=kind(57))
    assert made == camera()
    assert (type(made.fx), type(made.fy), type(made.cx), type(made.cy)) == (float,) * 4


@pytest.mark.parametrize("kind", [np.int16, np.int64, np.uint16, np.float32, float])
def test_a_size_of_any_type_is_an_int(kind):
    made = camera(width=kind(64), height=kind(48))
    assert made == camera()
    assert (type(made.width), type(made.height)) == (int, int)


@pytest.mark.parametrize("name", VALUES)
@pytest.mark.parametrize("value", NO_NUMBERS, ids=lambda value: type(value).__name__)
def test_what_is_no_number_is_refused_in_one_short_line(name, value):
    with pytest.raises(InputError, match=f"camera {name} is .*; it must be") as error:
        camera(**{name: value})
    assert "\n" not in str(error.value)
    assert len(str(error.value)) < 200


@pytest.mark.parametrize(
    ("values", "complaint"),
    [
        ({"fx": 1e-300}, r"fx is 1e-300; it must be a focal length in pixels, 3\.15 to"),
        ({"fx": 0.999 * MIN_FOCAL_SHARE * 63}, "fx is .*; it must be a focal length"),
        ({"fy": 5e-324}, "fy is 5e-324; it must be a focal length"),
        ({"width": 64.5}, "width is 64.5; it must be a whole number"),
        ({"width": 8192, "height": 8192, "fx": 4e3, "fy": 4e3}, f"at most {MAX_IMAGE_PIXELS}"),
        ({"distortion": (0.1, 0.2, 0.0, 0.0)}, "distortion is .*; it must be a Distortion"),
        ({"sensor": ["tof"]}, "sensor is"),
        ({"T_world_camera": "here"}, "T_world_camera must be 4 x 4 numbers"),
        ({"T_world_camera": [["1", "0", "0", "0"]] * 4}, "T_world_camera must be 4 x 4 numbers"),
        ({"T_world_camera": np.eye(4, dtype=complex)}, "T_world_camera must be 4 x 4 numbers"),
        ({"T_world_camera": np.eye(4, dtype=bool)}, "T_world_camera must be 4 x 4 numbers"),
        ({"T_world_camera": [[10**400] * 4] * 4}, "T_world_camera must be 4 x 4 numbers"),
        ({"T_world_camera": np.eye(4) + 1e300 * np.eye(4, k=3)}, "it must be metres, up to 1e"),
    ],
)
def test_what_no_camera_has_is_refused_in_one_line(values, complaint):
    with pytest.raises(InputError, match=complaint) as error:
        camera(**values)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("kind", [np.float32, list, np.asfortranarray])
def test_a_pose_of_any_type_is_one_of_64_bits(kind):
    T = np.eye(4)
    T[:3, 3] = 1.5, -2.0, 0.25
    given = T.astype(kind) if kind is np.float32 else kind(T)
    made = camera(T_world_camera=given)
    assert made == camera(T_world_camera=T)
    assert made.T_world_camera is not None
    assert made.T_world_camera.dtype == np.float64
    assert not np.shares_memory(made.T_world_camera, T)


@pytest.mark.parametrize("kind", [np.float32, np.int8, int])
def test_coefficients_of_any_type_are_floats(kind):
    lens = Distortion("brown_conrady", tuple(map(kind, (1, 0, 0, 0))))
    assert lens == Distortion("brown_conrady", (1.0, 0.0, 0.0, 0.0))
    assert {type(coefficient) for coefficient in lens.coefficients} == {float}
    assert Distortion("rational", np.zeros(8)) == Distortion("rational", (0.0,) * 8)  # type: ignore


@pytest.mark.parametrize("given", ["0.1", None, 0.1, ("0.1",) * 4, (True,) * 4, (1j,) * 4])
def test_coefficients_that_are_no_numbers_are_refused(given):
    with pytest.raises(InputError, match=r"distortion coefficient.* must be"):
        Distortion("brown_conrady", given)
    with pytest.raises(InputError, match="distortion model is"):
        Distortion(["brown_conrady"])  # type: ignore[arg-type]


anything = st.one_of(
    st.none(), st.booleans(), st.integers(), st.floats(), st.text(), st.binary(),
    st.complex_numbers(), st.lists(st.floats()), st.sampled_from([np.float32(1), np.int8(1)]),
)  # fmt: skip


@given(
    st.dictionaries(st.sampled_from([*VALUES, "distortion", "sensor", "T_world_camera"]), anything)
)
def test_whatever_is_given_is_a_camera_or_one_line(values):
    complaint, made = "", None
    try:
        made = camera(**values)
    except InputError as error:
        complaint = str(error)
    assert "\n" not in complaint
    assert len(complaint) < 300
    assert made is None or np.isfinite([made.fx, made.fy, made.cx, made.cy]).all()


def test_a_frame_s_numbers_are_converted_or_refused():
    depth_m = np.ones((48, 64), np.float32)
    frame = Frame(np.int32(3), np.float32(0.5), depth_m, camera())  # type: ignore[arg-type]
    assert (type(frame.index), type(frame.timestamp_s)) == (int, float)
    for index, time_s, complaint in (
        ("3", 0.1, "frame index is '3'"),
        (True, 0.1, "frame index is True"),
        (2.5, 0.1, "frame index is 2.5"),
        (2**63, 0.1, "frame index is 9223372036854775808"),
        (3, None, "frame timestamp_s is None"),
        (3, "now", "frame timestamp_s is 'now'"),
    ):
        with pytest.raises(InputError, match=complaint):
            Frame(index, time_s, depth_m, camera())  # type: ignore[arg-type]
    with pytest.raises(InputError, match="frame 0: camera is a dict"):
        Frame(0, 0.0, depth_m, VALUES)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("settings", "complaint"),
    [
        ({"hypotheses": 120.5}, "hypotheses is 120.5; it must be a whole number"),
        ({"hypotheses": "120"}, "hypotheses is '120'"),
        ({"tolerance_m": None}, "tolerance_m is None; it must be a number"),
        ({"tolerance_m": float("nan")}, "tolerance_m is nan; it must be 0 to 1"),
        ({"clothing_m": True}, "clothing_m is True"),
    ],
)
def test_settings_of_a_method_that_are_no_numbers_are_refused(settings, complaint):
    with pytest.raises(InputError, match=complaint):
        UtvrSettings(**settings)


@pytest.mark.parametrize("value", [["topview"], None, 3, "x" * 10_000])
def test_a_method_or_detector_that_is_no_name_is_refused(value):
    for name in ("method", "detector"):
        with pytest.raises(InputError, match=f"{name} is .*; it must be one of"):
            TrackerSettings(**{name: value})


def test_settings_of_a_method_are_of_one_type():
    settings = UtvrSettings(hypotheses=np.int16(50), tolerance_m=np.float32(0.5))  # type: ignore
    assert (type(settings.hypotheses), type(settings.tolerance_m)) == (int, float)


class Compiled(event.Listener):
    """What numba compiles while it listens."""

    def __init__(self) -> None:
        self.names: list[str] = []

    def on_start(self, event: event.Event) -> None:
        self.names.append((event.data or {})["dispatcher"].py_func.__name__)

    def on_end(self, event: event.Event) -> None:
        pass


def tracked(frames: list[Frame]) -> list[list[Person]]:
    tracker = Tracker(TrackerSettings(threads=1))
    return [tracker.update(frame) for frame in frames]


def by_hand(frame: Frame) -> Frame:
    """The same frame as somebody makes it who has NumPy's numbers and columnwise arrays."""
    own = frame.camera
    numbers: list[Any] = [*map(np.float32, (own.fx, own.fy, own.cx, own.cy))]
    numbers += map(np.int16, (own.width, own.height))
    index: Any = np.int16(frame.index)
    assert frame.color is not None
    return Frame(
        index,
        np.float64(frame.timestamp_s),
        np.asfortranarray(frame.depth_m),
        Camera(*numbers),
        np.asfortranarray(frame.color),
    )


def test_numbers_of_other_types_compile_nothing_anew_and_give_the_same(compiled):
    plain = [
        replace(frame, camera=replace(frame.camera, sensor="kinect1", T_world_camera=None))
        for frame in SimulatedRecording(scene_by_name("pass_by", seed=3, frames=6))
    ]
    expected = tracked(plain)
    listener = Compiled()
    with event.install_listener("numba:compile", listener):
        found = tracked([by_hand(frame) for frame in plain])
    assert listener.names == []
    for before, after in zip(expected, found, strict=True):
        assert [person.id for person in before] == [person.id for person in after]
        for one, other in zip(before, after, strict=True):
            assert_array_equal(one.Ts_camera_part, other.Ts_camera_part)
            assert_array_equal(one.joints_camera, other.joints_camera)
    assert any(expected)
