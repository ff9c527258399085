"""Transforms, segments and quadrics: the readable NumPy definitions."""
