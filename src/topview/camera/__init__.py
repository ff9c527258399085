"""Cameras: projection and its inverse, what lenses do to images, and the image pyramid."""

from topview.camera.lens import distort, undistort
from topview.camera.projection import pixel_rays, project, unproject_depth
from topview.camera.pyramid import DepthView, Pyramid, thinned
from topview.camera.undistortion import undistorted, undistorted_camera, undistortion

__all__ = [
    "DepthView",
    "Pyramid",
    "distort",
    "pixel_rays",
    "project",
    "thinned",
    "undistort",
    "undistorted",
    "undistorted_camera",
    "undistortion",
    "unproject_depth",
]
