"""Libraries that only some formats need."""

from __future__ import annotations

from importlib import import_module
from types import ModuleType

from topview.records import InputError


def needed(module: str, format: str, extra: str) -> ModuleType:
    """Import a library.

    Raises:
        InputError: it is not installed; says how to install it.
    """
    try:
        return import_module(module)
    except ImportError:
        raise InputError(
            f"{format} needs {module}; install it with: pip install 'topview[{extra}]'"
        ) from None
