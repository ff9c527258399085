"""Round cones: hits lie on the surface, nothing lies before them, windows hold everything."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from topview.camera.projection import pixel_rays
from topview.records import Camera
from topview_lab.sim.primitives import RayCaster, RoundCones, image_windows, surface_normals

CAMERA = Camera(fx=40.0, fy=40.0, cx=15.5, cy=11.5, width=32, height=24)
RAYS = pixel_rays(CAMERA).astype(np.float64)


def depth_below_surface(solid: RoundCones, points: NDArray[np.float64]) -> NDArray[np.float64]:
    """[...] signed distance in the round local frame: a round cone is the union of the balls
    between its two ends. An independent definition, to within the spacing of the balls."""
    to_local = solid.local_maps()[0]
    s = np.linspace(0.0, 1.0, 501)[:, None]
    centres = (1 - s) * solid.starts[0] + s * solid.ends[0]
    radii = ((1 - s) * solid.start_radii[0] + s * solid.end_radii[0])[:, 0]
    between = (points[..., None, :] - centres) @ to_local.T
    return (np.linalg.norm(between, axis=-1) - radii).min(-1)


def depth_of(solid: RoundCones, camera: Camera = CAMERA) -> NDArray[np.float64]:
    """[H, W] of one solid, looked for in all of the image."""
    caster = RayCaster(solid, camera)
    caster.windows = [(slice(0, camera.height), slice(0, camera.width))]
    depth_m = np.full((camera.height, camera.width), np.inf)
    caster.draw(depth_m, np.zeros(depth_m.shape, np.int32))
    return depth_m


def unit(low: float, high: float) -> st.SearchStrategy[float]:
    return st.floats(low, high, allow_nan=False)


@st.composite
def round_cones(draw: st.DrawFn) -> RoundCones:
    vector = st.tuples(unit(-0.5, 0.5), unit(-0.4, 0.4), unit(1.5, 2.5))
    return RoundCones(
        starts=np.array([draw(vector)]),
        ends=np.array([draw(vector)]),
        start_radii=np.array([draw(unit(0.02, 0.3))]),
        end_radii=np.array([draw(unit(0.02, 0.3))]),
        axes=Rotation.from_rotvec(
            [[draw(unit(-3, 3)), draw(unit(-3, 3)), draw(unit(-3, 3))]]
        ).as_matrix(),
        scales=np.array([[draw(unit(0.5, 1.5)), draw(unit(0.5, 1.5)), draw(unit(0.5, 1.5))]]),
    )


@settings(max_examples=40)
@given(round_cones())
def test_hits_lie_on_the_surface_and_nothing_lies_before_them(solid: RoundCones) -> None:
    depth = depth_of(solid)
    hits = np.isfinite(depth)
    on_surface = depth_below_surface(solid, RAYS[hits] * depth[hits, None])
    np.testing.assert_allclose(on_surface, 0.0, atol=1e-4)

    rays = RAYS.reshape(-1, 3)[::11]
    until = np.minimum(depth, 4.0).ravel()[::11]
    for share in np.linspace(0.1, 0.995, 20):
        before = depth_below_surface(solid, rays * (share * until)[:, None])
        assert (before > -1e-6).all()


@settings(max_examples=40)
@given(round_cones())
def test_windows_hold_every_hit(solid: RoundCones) -> None:
    outside = np.isfinite(depth_of(solid))
    outside[image_windows(solid, CAMERA)[0]] = False
    assert not outside.any()


@settings(max_examples=40)
@given(round_cones())
def test_normals_are_outward_units_across_the_surface(solid: RoundCones) -> None:
    depth = depth_of(solid)
    hits = np.isfinite(depth)
    points = RAYS[hits] * depth[hits, None]
    normals = surface_normals(solid, np.zeros(len(points), np.int32), points)
    np.testing.assert_allclose(np.linalg.norm(normals, axis=-1), 1.0)
    assert ((normals * points).sum(-1) < 1e-6).all()  # against the ray
    step = 0.01
    assert (depth_below_surface(solid, points + step * normals) > 0.3 * step).all()


def test_a_ball_before_the_camera() -> None:
    one = np.ones(1)
    place = np.array([[0.0, 0.0, 2.0]])
    ball = RoundCones(place, place, 0.5 * one, 0.5 * one, np.eye(3)[None], np.ones((1, 3)))
    camera = Camera(fx=40.0, fy=40.0, cx=16.0, cy=12.0, width=33, height=25)
    depth = depth_of(ball, camera)
    assert depth[12, 16] == 1.5
    assert np.isinf(depth[0, 0])
    # the outline: 40 px * 0.5 / sqrt(2^2 - 0.5^2) = 10.3 px around the centre
    assert image_windows(ball, camera)[0] == (slice(2, 23), slice(6, 27))


def test_a_ball_behind_the_camera_is_not_seen() -> None:
    one = np.ones(1)
    place = np.array([[0.0, 0.0, -2.0]])
    ball = RoundCones(place, place, 0.5 * one, 0.5 * one, np.eye(3)[None], np.ones((1, 3)))
    rows, columns = image_windows(ball, CAMERA)[0]
    assert (rows.stop - rows.start) * (columns.stop - columns.start) == 0
