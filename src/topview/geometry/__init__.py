"""Transforms and quadrics: the readable NumPy definitions."""
