"""Cameras: projection and its inverse."""

from topview.camera.projection import pixel_rays, project, unproject_depth

__all__ = ["pixel_rays", "project", "unproject_depth"]
