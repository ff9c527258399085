"""Recordings in, skeletons out: one file per format."""
