"""Which version of topview this is."""

from __future__ import annotations

from importlib.metadata import PackageNotFoundError, version


def installed_version() -> str:
    """Of this package; empty where it was never installed."""
    try:
        return version("topview")
    except PackageNotFoundError:
        return ""
