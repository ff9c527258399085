"""Open Sound Control over UDP: a message for each joint, and the VMC protocol's bones.

One bundle for each person and frame:

    /topview/frame         frame index, timestamp in seconds, number of people
    /topview/person/3/left_hand   x y z in metres (camera frame), confidence, state (an integer)

and, for the person with the lowest id, /VMC/Ext/... (`topview.stream.vmc`).
"""

from __future__ import annotations

import socket
from collections.abc import Iterable
from typing import Any, Final

from topview.body import OUTPUT_JOINT_NAMES
from topview.io.writers.extras import needed
from topview.records import InputError
from topview.skeletons import TrackedFrame
from topview.stream.vmc import vmc_messages

Message = tuple[str, tuple[Any, ...]]
IMMEDIATELY: Final = 1  # as OSC says it of a bundle


class OscSender:
    """Sends frames as UDP datagrams, which no listener can hold up.

    Raises:
        InputError: python-osc is missing, or the host has no address.
    """

    def __init__(self, host: str, port: int) -> None:
        needed("pythonosc", "--stream osc", "stream")
        try:
            family, _, _, _, self._address = socket.getaddrinfo(host, port, type=socket.SOCK_DGRAM)[
                0
            ]
        except OSError as error:
            raise InputError(
                f"stream osc:{host}:{port}: the host has no address: {error.strerror}"
            ) from None
        self._socket = socket.socket(family, socket.SOCK_DGRAM)

    def deliver(self, frame: TrackedFrame) -> None:
        """Send one frame."""
        for messages in bundles(frame):
            self._socket.sendto(_as_datagram(messages), self._address)

    def close(self) -> None:
        """End it."""
        self._socket.close()


def bundles(frame: TrackedFrame) -> list[list[Message]]:
    """The messages of each bundle: the frame's own, then everybody's."""
    head = ("/topview/frame", (frame.index, float(frame.timestamp_s), len(frame.people)))
    made: list[list[Message]] = [[head]]
    for person in frame.people:
        place = f"/topview/person/{int(person['id'])}"
        made.append(
            [
                (f"{place}/{name}", (*map(float, xyz_m), float(confidence), int(state)))
                for name, xyz_m, confidence, state in zip(
                    OUTPUT_JOINT_NAMES,
                    person["joints_camera"],
                    person["joint_confidence"],
                    person["joint_state"],
                    strict=True,
                )
            ]
        )
    made.append(vmc_messages(frame))
    return [messages for messages in made if messages]


def _as_datagram(messages: Iterable[Message]) -> bytes:
    from pythonosc.osc_bundle_builder import OscBundleBuilder
    from pythonosc.osc_message_builder import OscMessageBuilder

    bundle = OscBundleBuilder(IMMEDIATELY)
    for address, values in messages:
        message = OscMessageBuilder(address)
        for value in values:
            message.add_arg(value)
        bundle.add_content(message.build())
    return bundle.build().dgram
