"""Skeletons to other programs while tracking runs; no listener slows it.

An outlet gets each tracked frame as soon as it is kept. It never waits: what is not sent when the
next frame comes may be left out, the oldest first.
"""

from topview.stream.outlets import Outlet, open_stream

__all__ = ["Outlet", "open_stream"]
