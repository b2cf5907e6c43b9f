"""Bytes as they come from a device -> its packets. Pure: no port, no clock.

Nothing raises. What is cut, merged, corrupted or noise is passed over and counted by name: ``bad_checksum``,
``bad_length`` and ``bad_end`` for what began like a packet and is none, ``short`` and ``long`` for datagrams,
``unknown_packet`` for datagrams that begin like none, ``bad_record`` for an index that points at nothing, and
``resync`` once for each time that bytes were passed over until a packet came again.
"""

from collections import Counter
from collections.abc import Iterator, Sequence
from typing import Final

from vegrip.transport.codec import Frame
from vegrip.transport.mapped.packets import Index, Packet
from vegrip.transport.sender_clock import SenderClock

MOST_ENDS: Final = 2  # that are looked at for one beginning, should one stand in its data
MOST_RECORDS: Final = 64  # in an index
WAIT: Final = "wait"


class PacketStream:
    """The packets of one device.

    Args:
        packets: that it sends.
        counts: where what is passed over is counted, shared with others.

    """

    def __init__(self, packets: Sequence[Packet], counts: Counter[str]) -> None:
        self._packets = packets
        self._counts = counts
        self._buffer = bytearray()
        self._is_lost = False
        self._keep = max((packet.reach for packet in packets), default=1) - 1
        self._clocks = {packet.name: (SenderClock(), [-1, 0]) for packet in packets if packet.clock}

    @property
    def clocks(self) -> list[SenderClock]:
        """The clocks of the device, one for each packet that has its time."""
        return [clock for clock, _ in self._clocks.values()]

    @property
    def pending(self) -> int:
        """Bytes that wait for more."""
        return len(self._buffer)

    def reset(self) -> None:
        """Forget what has come: what comes next begins anew."""
        self._buffer.clear()

    def feed(self, chunk: bytes, stamp: int) -> list[Frame]:
        """Return the packets that are whole with ``chunk``, which came at ``stamp`` [ns]."""
        buffer = self._buffer
        buffer += chunk
        found: list[Frame] = []
        at, length = 0, len(buffer)
        while at < length:
            packet, size = self._next(buffer, at)
            if packet is None:
                if size < 0:  # more is needed
                    break
                self._is_lost = True
                at += size
                continue
            if self._is_lost:
                self._counts["resync"] += 1
                self._is_lost = False
            self._bring(packet, bytes(buffer[at : at + size]), stamp, found)
            at += size
        del buffer[:at]
        return found

    def datagram(self, data: bytes, stamp: int) -> list[Frame]:
        """Return the packet that is ``data`` as a whole; it came at ``stamp`` [ns]."""
        found: list[Frame] = []
        said = "unknown_packet"
        for packet in self._packets:
            if packet.start.match(data) is None:
                continue
            said = _flaw(packet, data)
            if not said:
                self._bring(packet, data, stamp, found)
                return found
        self._counts[said] += 1
        return found

    def _next(self, buffer: bytearray, at: int) -> tuple[Packet | None, int]:
        """Return the packet at ``at`` and its size; without one, how far to go on, or -1 to wait."""
        nearest, waits = len(buffer), False
        for packet in self._packets:
            match = packet.start.search(buffer, at)
            if match is None:
                continue
            if match.start() > at:
                nearest = min(nearest, match.start())
                continue
            size, said = _measure(packet, buffer, at)
            if size:
                return packet, size
            if said == WAIT:
                waits = True
                continue
            self._counts[said] += 1
            nearest = min(nearest, at + 1)
        if waits:
            return None, -1
        if nearest == len(buffer):  # the beginning of one may be cut
            nearest -= min(self._keep, nearest - at)
            if nearest == at:
                return None, -1
        return None, nearest - at

    def _bring(self, packet: Packet, data: bytes, stamp: int, found: list[Frame]) -> None:
        if packet.clock is not None:
            stamp = self._our_time(packet, data, stamp)
        if packet.index is None:
            found.append(Frame(packet.number, data, False, stamp))
            return
        for kind, begin in _records(packet.index, data):
            record = packet.records.get(kind)
            if kind < 0:
                self._counts["bad_record"] += 1
            elif record is None:
                continue
            elif len(data) - begin < record.least or record.start.match(data, begin) is None:
                self._counts["bad_record"] += 1
            else:
                found.append(Frame(record.number, data[begin:], False, stamp))

    def _our_time(self, packet: Packet, data: bytes, stamp: int) -> int:
        """Return the device's own time of a packet on our clock, its count carried on where it wraps."""
        assert packet.clock is not None  # noqa: S101 (looked at by the caller)
        read, modulus, per_count = packet.clock
        clock, told = self._clocks[packet.name]
        raw = read(data, 0)
        told[1] += (raw - told[0]) % modulus if told[0] >= 0 else raw
        told[0] = raw
        return clock.hear(round(told[1] * per_count), stamp)


def _records(index: Index, data: bytes) -> Iterator[tuple[int, int]]:
    """Yield type and first byte of each record; type -1 ends an index that points at nothing."""
    at, first = index.at, len(data)
    for _ in range(MOST_RECORDS):
        if at + index.entry > first:
            if index.sizes and at < first:
                yield -1, at
            return
        kind, begin = index.type(data, at) & index.mask, at
        if index.offset is None:
            at += index.sizes.get(kind, first)
            is_sound = at <= first
        else:
            begin = index.origin + index.offset(data, at)
            at += index.entry
            is_sound = at <= begin < len(data)
            first = min(first, begin)
        yield (kind if is_sound else -1), begin
        if not is_sound:
            return


def _measure(packet: Packet, buffer: bytearray, at: int) -> tuple[int, str]:
    """Return the size of the sound packet at ``at``, or 0 and what it is instead."""
    rest = len(buffer) - at
    if packet.end and packet.size is None and packet.least != packet.most:
        return _up_to_end(packet, buffer, at)
    if rest < packet.least:
        return 0, WAIT
    size = packet.least if packet.size is None else packet.size(buffer, at)
    if not packet.least <= size <= packet.most:
        return 0, "bad_length"
    if rest < size:
        return 0, WAIT
    said = _flaw(packet, bytes(buffer[at : at + size]))
    return (0, said) if said else (size, "")


def _up_to_end(packet: Packet, buffer: bytearray, at: int) -> tuple[int, str]:
    look = at + packet.least - len(packet.end)
    last = at + packet.most
    said = "bad_end"
    for _ in range(MOST_ENDS):
        look = buffer.find(packet.end, look, last)
        if look < 0:
            return (0, WAIT) if len(buffer) < last else (0, said)
        size = look + len(packet.end) - at
        said = _flaw(packet, bytes(buffer[at : at + size]))
        if not said:
            return size, ""
        look += 1
    return 0, said


def _flaw(packet: Packet, data: bytes) -> str:
    """Return what is wrong with the whole packet ``data``, '' when nothing is."""
    length = len(data)
    if length < packet.least:
        return "short"
    wanted = length if packet.size is None else packet.size(data, 0)
    if length != wanted or length > packet.most:
        return "short" if length < wanted else "long"
    if not data.endswith(packet.end):
        return "bad_end"
    guard, index = packet.guard(length), packet.index
    if guard is not None:
        return "" if guard.check(data) else "bad_checksum"
    is_filled = index is None or not index.sizes or all(kind >= 0 for kind, _ in _records(index, data))
    return "" if is_filled else "bad_record"  # its only protection: the records fill it
