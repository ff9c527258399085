"""Cameras: projection and its inverse."""

from topview.camera.projection import pixel_rays, project, unproject_depth
from topview.camera.pyramid import DepthView, Pyramid, thinned

__all__ = ["DepthView", "Pyramid", "pixel_rays", "project", "thinned", "unproject_depth"]
