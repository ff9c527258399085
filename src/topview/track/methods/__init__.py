"""The methods of tracking bodies, by name; each is imported when it is first used."""

from __future__ import annotations

from importlib import import_module
from typing import Final

from topview import laboratory
from topview.records import InputError, shown
from topview.track.body_tracker import BodyMethod

DEFAULT: Final = "topview"

# Name of each method: what makes it, called without arguments, and a sentence about it.
METHODS: Final[dict[str, tuple[str, str]]] = {
    "topview": (
        "topview.track.methods.topview:TopviewSettings",
        "the full tracker: all parts together, limbs as pairs scored by f_uTVR",
    ),
    "utvr": (
        "topview.track.methods.utvr:UtvrSettings",
        "the thesis's full-body recipe (Sec. 5.3), part by part from the head down",
    ),
    "btvr": (
        "topview.track.methods.btvr:BtvrSettings",
        "the thesis's tracker of the upper body (Sec. 5.1); it leaves the legs absent",
    ),
    "joints": (
        "topview.track.methods.joints:JointsSettings",
        "the body fitted to the joints that the network proposes, each frame on its own",
    ),
    **laboratory.RIVAL_METHODS,
}
OTHER_NAMES: Final = {"thesis": "utvr"}


def method_name(name: str) -> str:
    """The name of a method, given that or another word for it.

    Raises:
        InputError: there is no such method.
    """
    found = OTHER_NAMES.get(name, name) if isinstance(name, str) else ""
    if found not in METHODS:
        raise InputError(f"method is {shown(name)}; it must be one of {', '.join(METHODS)}")
    return found


def method_by_name(name: str) -> BodyMethod:
    """The method of that name with its default settings.

    Raises:
        InputError: there is no such method.
    """
    module, _, attribute = METHODS[method_name(name)][0].partition(":")
    return getattr(import_module(module), attribute)()
