"""Nothing here fails because a machine is slow; what hangs for good is ended."""

from __future__ import annotations

HANGS_S = 1800.0
"""Seconds after which something that was waited for is taken to have hung. No test is meant to come
anywhere near: it is no bound on anybody's speed."""
