"""Ellipses: moments there and back, and the distance's laws (Eq. 4.3 - 4.7)."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from topview.detect.ellipses import Ellipse, Moments
from topview.kernels.skin import moments

ellipses = st.builds(
    Ellipse,
    x=st.floats(60, 100),
    y=st.floats(60, 100),
    major=st.floats(20, 40),
    minor=st.floats(6, 16),
    angle=st.floats(-1.5, 1.5),
)


def filled(ellipse: Ellipse) -> np.ndarray:
    """[N, 2] the pixels inside."""
    rows, columns = np.mgrid[:200, :200]
    points = np.stack([columns, rows], axis=-1).astype(np.float64)
    return points[ellipse.distance(points) <= 1.0].astype(np.float32)


def of_pixels(pixels: np.ndarray) -> Ellipse:
    """The ellipse that has the moments of [N, 2] pixels."""
    return Ellipse.of_moments(Moments(*moments(pixels)))


@given(ellipses)
def test_a_filled_ellipse_is_recovered_from_its_moments(ellipse: Ellipse) -> None:
    found = of_pixels(filled(ellipse))
    assert np.allclose(found.center, ellipse.center, atol=0.4)
    assert found.major == pytest.approx(ellipse.major, rel=0.03)
    assert found.minor == pytest.approx(ellipse.minor, rel=0.03, abs=0.4)
    turned = (found.angle - ellipse.angle + np.pi / 2) % np.pi - np.pi / 2
    assert abs(turned) < 0.03


@given(ellipses, st.floats(0, 2 * np.pi))
def test_the_distance_is_1_on_the_ellipse(ellipse: Ellipse, around: float) -> None:
    c, s = np.cos(ellipse.angle), np.sin(ellipse.angle)
    a, b = ellipse.major * np.cos(around), ellipse.minor * np.sin(around)
    on_it = ellipse.center + np.array([c * a - s * b, s * a + c * b])
    assert ellipse.distance(on_it) == pytest.approx(1.0)
    outside = ellipse.center + 2.0 * (on_it - ellipse.center)
    assert ellipse.distance(outside) == pytest.approx(2.0)


@given(ellipses, st.floats(0.5, 3.0), st.floats(-20, 20))
def test_scaling_image_and_ellipse_keeps_distances(
    ellipse: Ellipse, factor: float, shift: float
) -> None:
    points = np.array([[10.0, 20.0], [70.0, 90.0], [150.0, 40.0]])
    moved = ellipse.scaled(factor, shift).distance(points * factor + shift)
    assert np.allclose(moved, ellipse.distance(points))


def test_the_ends_of_the_major_axis_lie_on_the_ellipse() -> None:
    ellipse = Ellipse(50.0, 40.0, 20.0, 5.0, 0.3)
    along = 20.0 * np.array([np.cos(0.3), np.sin(0.3)])
    ends = ellipse.center + np.stack([-along, along])
    assert ellipse.distance(ends) == pytest.approx([1.0, 1.0])


def test_one_pixel_is_a_round_ellipse() -> None:
    ellipse = of_pixels(np.array([[3.0, 4.0]], np.float32))
    assert ellipse.major == pytest.approx(ellipse.minor)
    assert ellipse.minor > 0.5
