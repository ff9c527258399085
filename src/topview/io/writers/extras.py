"""Libraries that only some formats need."""

from __future__ import annotations

from importlib import import_module
from types import ModuleType

from topview.records import InputError


def needed(module: str, format: str, extra: str) -> ModuleType:
    """Import a library.

    Raises:
        InputError: it is not installed, and how to install it; or it cannot be loaded, and why.
    """
    try:
        return import_module(module)
    except ImportError as error:
        if error.path:  # it is there, and a library of the system that it needs is not
            raise InputError(f"{format} needs {module}, which cannot be loaded: {error}") from None
        raise InputError(
            f"{format} needs {module}; install it with: pip install 'topview[{extra}]'"
        ) from None
