"""The states of a hand on the virtual bus: packed where they are sent from, and handed over at once."""

import time
from collections.abc import Callable

import numpy as np

from vegrip.hand_sample import HandSample, nothing
from vegrip.transport.canbus.hub_wire import REQUEST_AT, plain_requests
from vegrip.transport.codec.state_rows import StateRows

SendPacket = Callable[[bytearray, int], None]
"""Sends a packet that asks for so many frames."""


class StateSender:
    """Sends samples of a hand as the frames of their states.

    Args:
        rows: packs them.
        send: takes the packets.

    """

    def __init__(self, rows: StateRows, send: SendPacket) -> None:
        self._rows, self._send = rows, send
        self._packet = plain_requests(rows.identifiers, rows.length)
        head = REQUEST_AT["data"]
        shape = len(rows.identifiers), head + rows.length
        self._requests = np.frombuffer(self._packet, np.uint8).reshape(shape)
        self._frames = self._requests[:, head:]
        self._times = np.ndarray(shape[:1], "<u8", self._packet, strides=shape[1:])
        rows.prepare(self._frames)
        rows.pack(self._frames, nothing(len(rows.identifiers)))  # compiles before the loop begins

    def send(self, sample: HandSample) -> int:
        """Queue the frames of ``sample``; return how many these are."""
        self._rows.pack(self._frames, sample)
        self._times.fill(time.monotonic_ns())
        if not sample.lost.any():
            self._send(self._packet, len(self._requests))
            return len(self._requests)
        told = self._requests[~sample.lost]
        if len(told):
            self._send(bytearray(told), len(told))
        return len(told)
