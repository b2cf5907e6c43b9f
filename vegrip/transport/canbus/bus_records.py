"""The state of a bus: records in the same memory for Python and, as structs, for C; its constants and tables.

Nodes have slots; ``order`` has the slots of those that are there, in the order in which they joined. Frames
that wait are a chain of requests from the ``first`` of a node to its ``last``; the first one is also on the
bus while its node is that of ``current``.
"""

import ctypes
import mmap
import os
import select
import time
from ctypes import Structure, c_bool, c_double, c_int64, c_uint8, sizeof
from typing import Any, Final

from vegrip.clock import NS

Bytes = Any  # an array of c_uint8
Wholes = Any  # an array of c_int64


def nearest(value: float) -> int:
    """Return the nearest whole number; of two, the even one."""
    return round(value)


def copy_bytes(to: Bytes, place: int, source: Bytes, begin: int, size: int) -> None:
    """Copy ``size`` bytes; the two do not overlap."""
    ctypes.memmove(ctypes.byref(to, place), ctypes.byref(source, begin), size)


def store(to: Bytes, place: int, value: int, size: int) -> None:
    """Store a whole number in ``size`` bytes, the least significant first."""
    to[place : place + size] = (value & (1 << 8 * size) - 1).to_bytes(size, "little")


def load(source: Bytes, begin: int, size: int) -> int:
    """Return the whole number of up to seven bytes that :func:`store` has stored."""
    return int.from_bytes(source[begin : begin + size], "little")


def clock() -> int:
    """Return the time [ns]."""
    return time.monotonic_ns()


def sleep_until(end: int) -> bool:
    """Sleep; False: a signal has come."""
    time.sleep(max(end - clock(), 0) / NS)
    return True


def look(watched: Wholes, ready: Wholes, count: int, patience: int) -> bool:
    """Wait up to ``patience`` [ns] for descriptors to become readable; False: a signal has come."""
    wanted = watched[:count]
    found = select.select([fd for fd in wanted if fd >= 0], (), (), patience / NS)[0]
    ready[:count] = [fd in found for fd in wanted]
    return True


def receive(descriptor: int, to: Bytes, room: int) -> int:
    """Receive a packet and return its length; 0: the other side has gone; -1: there is none."""
    try:
        packet = os.read(descriptor, room)
    except (BlockingIOError, InterruptedError):
        return -1
    except OSError:
        return 0
    to[: len(packet)] = packet
    return len(packet)


def send(descriptor: int, source: Bytes, begin: int, size: int) -> bool:
    """Send a packet, though maybe to one that has gone; False: the other side does not read."""
    try:
        os.write(descriptor, bytes(source[begin : begin + size]))
    except (BlockingIOError, InterruptedError):
        return False
    except OSError:
        pass  # it has gone; reading from it will show that
    return True


NO_EVENT: Final = 1 << 62  # [ns]
LONG_AGO: Final = -NO_EVENT  # [ns]
NO_SLOT: Final = -1
NOBODY: Final = -1  # in place of the number of a node

# flags of a frame, as they travel
EXTENDED, REMOTE, FD, SWITCH, ERROR_STATE, ERROR = 1, 2, 4, 8, 16, 32
FRAME_FLAGS: Final = 31
DATA_SIZES: Final = (0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64)  # bytes by length code

ACTIVE, PASSIVE, OFF = 0, 1, 2  # error states
NO_ERROR, BIT_ERROR, STUFF_ERROR, ACK_ERROR = 0, 1, 2, 3  # of an attempt
SENT, FAILED, CHANGED = 1, 2, 3  # events: a frame, an error frame, a node in another error state

# an error frame of SocketCAN (linux/can/error.h): classes of errors as its identifier, and eight bytes: [1]
# state of the controller, [2] kind and [3] place of a protocol error, [6] and [7] the error counters
CONTROLLER, PROTOCOL, ACKNOWLEDGEMENT = 0x004, 0x008, 0x020
BUS_OFF, BUS_ERROR, RESTARTED, HAS_COUNTERS = 0x040, 0x080, 0x100, 0x200
RECEIVE_PASSIVE, TRANSMIT_PASSIVE, ERROR_ACTIVE = 0x10, 0x20, 0x40
OF_BIT, OF_STUFFING, SENDING = 0x01, 0x04, 0x80
ACK_SLOT, IN_DATA = 0x19, 0x0A

SLOTS: Final = 512  # nodes, among them those that have left and whose frames are still to be sent
REQUESTS: Final = 1 << 16  # frames that may wait, of all nodes
MOST_FILTERS: Final = 512  # of a node; CAN_RAW_FILTER_MAX of linux/can/raw.h
STREAM_BITS: Final = 1024  # an FD frame of 64 bytes has 692 at most up to the end of its data
STATE_WORDS: Final = 624  # of the random generator
REQUEST_BYTES: Final = 14  # of a request as it travels, and then its data
DELIVERY_BYTES: Final = 28  # of a numbered delivery, and then its data
GATHERED_BYTES: Final = 2048  # of deliveries, or requests, in one packet
PACKET_BYTES: Final = 16 + 8 * MOST_FILTERS  # of the longest packet, which brings filters
UNSENT: Final = 4096  # packets
OUTBOX_BYTES: Final = 1 << 21

TRANSMIT_QUEUE: Final = 64  # frames of one member that may wait for the bus; then the member is not read
OLDEST_REQUEST: Final = NS  # [ns] a frame that claims to have waited for longer has not
LONGEST_SLEEP: Final = 10_000_000  # [ns] so that those who come or leave are seen on a slow bus too
GATHERED: Final = 100_000  # [ns] frames that end so soon after another are handed out with it, if more wait
SLICE: Final = (
    NS // 20
)  # [ns] of the bus at a time, when it is behind; else those who come and leave must wait


class Frame(Structure):
    _fields_ = [
        ("identifier", c_int64),
        ("flags", c_int64),
        ("code", c_int64),  # data length code
        ("data", c_uint8 * 64),
    ]


class Request(Structure):
    _fields_ = [
        ("time", c_int64),  # [ns]
        ("key", c_int64),  # of arbitration; the lower one wins
        ("next", c_int64),  # request of the same node, or, of those not in use, the next one
        ("frame", Frame),
    ]


class Stream(Structure):
    """The bits of a frame on the bus, stuff bits included, up to the end of the CRC (FD: of the data)."""

    _fields_ = [
        ("count", c_int64),
        ("run", c_int64),  # how many of the last bits are equal
        ("slow", c_int64),  # how many bits have the nominal bit rate
        ("first", c_int64),  # position of the first bit after the arbitration field
        ("last", c_int64),  # and of the last bit of data (FD: that is followed by six more)
        ("bits", c_uint8 * STREAM_BITS),
    ]


class Faults(Structure):
    """Faults of a node, see :class:`~vegrip.transport.canbus.bus_events.NodeFaults`, and its dice."""

    _fields_ = [
        ("loss", c_double),
        ("corruption", c_double),
        ("misreading", c_double),
        ("flips", c_double),
        ("delay", c_double),  # [s]
        ("jitter", c_double),  # [s]
        ("babble", c_int64),
        ("drawn", c_int64),  # words
        ("words", c_int64 * STATE_WORDS),
    ]


class Node(Structure):
    _fields_ = [
        ("number", c_int64),
        ("listens_only", c_bool),
        ("is_leaving", c_bool),
        ("has_faults", c_bool),
        ("state", c_int64),  # as last reported
        ("transmit", c_int64),  # error counter
        ("receive", c_int64),  # error counter, within 8 bits as the registers of controllers are
        (
            "missing",
            c_int64,
        ),  # sequences of recessive bits still to be seen before a node that is off comes back
        ("since", c_int64),  # [ns] a node that is off counts recessive bits from here on
        ("suspended", c_int64),  # [ns] until when it may not begin a frame
        ("waiting", c_int64),  # requests, the one on the bus included
        ("first", c_int64),
        ("last", c_int64),
        ("descriptor", c_int64),  # of its connection; -1: events alone report it
        ("hears_itself", c_bool),
        ("is_behind", c_bool),  # it does not read; what is for it goes to the outbox
        ("patience", c_int64),  # [ns] for which deliveries may wait for others; negative: none does
        ("delivery", c_int64),  # number of the next one
        ("due", c_int64),  # [ns] when what is gathered is to be handed out
        ("gathered", c_int64),  # bytes
        ("filters", c_int64),  # how many; without any it receives everything
        ("faults", Faults),
        ("gathering", c_uint8 * GATHERED_BYTES),
        ("pairs", c_int64 * (2 * MOST_FILTERS)),  # identifiers and masks
    ]


class Attempt(Structure):
    """A frame on the bus; what becomes of it is settled when it begins."""

    _fields_ = [
        ("slot", c_int64),  # of the node that sends it
        ("number", c_int64),  # of that node
        ("start", c_int64),  # [ns]
        ("end", c_int64),  # [ns] the bus is free again
        ("error", c_int64),
        ("found_by", c_int64),  # number of a node
        ("missed_by", c_int64),  # number of an error-passive node that misread it, alone
        ("is_lost", c_bool),  # no node receives it
        ("frame", Frame),
    ]


class Event(Structure):
    _fields_ = [
        ("kind", c_int64),  # SENT and FAILED are about the attempt that is ``done``
        ("time", c_int64),  # [ns]
        ("busy", c_int64),  # [ns] of the bus by then
        ("slot", c_int64),  # of the node that changed
        ("number", c_int64),
        ("state", c_int64),
        ("transmit", c_int64),
        ("receive", c_int64),
        ("dropped", c_int64),  # frames that waited in a node that is off now
    ]


class Unsent(Structure):
    _fields_ = [
        ("slot", c_int64),
        ("at", c_int64),  # in the outbox
        ("size", c_int64),
    ]


class Bus(Structure):
    _fields_ = [
        ("bitrate", c_int64),  # [bit/s]
        ("data_bitrate", c_int64),  # [bit/s] of FD frames with bit-rate switch
        ("busy", c_int64),  # [ns] for how long it has carried frames, good or bad
        ("free", c_int64),  # [ns] when it is (or was) free
        ("queued", c_int64),  # requests of all nodes
        ("attached", c_int64),  # nodes
        ("acknowledging", c_int64),  # nodes that do
        ("troubled", c_int64),  # nodes with an error counter that is not zero
        ("off", c_int64),  # nodes
        ("faulty", c_int64),  # nodes that suffer faults
        ("is_hopeless", c_bool),  # a lone error-passive node repeats its frame, and nothing changes by that
        ("has_suspended", c_bool),
        ("unused", c_int64),  # first of the requests that were used and are not in use
        ("never_used", c_int64),  # first of the requests that never were
        ("current", Attempt),
        ("done", Attempt),
        ("asked", Frame),  # that is to be queued
        ("happened", c_int64),  # events
        # of the loop
        ("door", c_int64),  # descriptor on which newcomers are accepted
        ("due", c_int64),  # [ns] when the first of what is gathered is to be handed out
        ("patience", c_int64),  # [ns] of the next look at the connections
        ("who", c_int64),  # slot of the member whose packet is for Python
        ("length", c_int64),  # bytes of that packet
        ("unsent", c_int64),  # packets for members that do not read
        ("outbox_bytes", c_int64),
        ("watched", c_int64 * (SLOTS + 1)),  # descriptors
        ("ready", c_int64 * (SLOTS + 1)),
        ("order", c_int64 * SLOTS),
        ("delivery", c_uint8 * (DELIVERY_BYTES + 64)),
        ("packet", c_uint8 * PACKET_BYTES),
        ("events", Event * (SLOTS + 2)),
        ("stream", Stream),
        ("nodes", Node * SLOTS),
        ("requests", Request * REQUESTS),
        ("packets", Unsent * UNSENT),
        ("outbox", c_uint8 * OUTBOX_BYTES),
    ]


def new_bus(bitrate: int, data_bitrate: int) -> Bus:
    """Return a bus without nodes; its memory is taken as it is used."""
    memory = mmap.mmap(-1, sizeof(Bus), flags=mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS)
    bus = Bus.from_buffer(memory)
    bus.bitrate, bus.data_bitrate = bitrate, data_bitrate
    bus.current.slot = bus.unused = NO_SLOT
    bus.order[:] = range(SLOTS)
    bus.due = NO_EVENT
    return bus


# --- what a byte does to stuff bits and CRC; counting by bytes is nine times as fast as by bits. A run is the
# --- number ``5 * value + length - 1``, of the last bit and of how many equal ones have gone by

NO_RUN: Final = -1  # before the first bit
RUNS: Final = 5
LONGEST_RUN: Final = 5
CRC15: Final = 0x4599
"""Generator polynomial of classic CAN, without its leading term [ISO2015]_."""


def _stuff_byte(run: int, byte: int) -> tuple[int, int]:
    stuffed, (value, length) = 0, divmod(run, RUNS)
    for position in reversed(range(8)):
        bit = byte >> position & 1
        if length == LONGEST_RUN - 1:
            stuffed, value, length = stuffed + 1, 1 - value, 0
        value, length = (value, length + 1) if bit == value else (bit, 0)
    return stuffed, RUNS * value + length


def _crc15_of(byte: int) -> int:
    crc = byte << 7
    for _ in range(8):
        crc = (crc << 1 & 0x7FFF) ^ (CRC15 if crc & 0x4000 else 0)
    return crc


_AFTER = [_stuff_byte(run, byte) for run in range(2 * RUNS) for byte in range(256)]
STUFFED: Final = tuple(stuffed for stuffed, _ in _AFTER)
"""Bits stuffed in by a byte, at ``256 * run + byte``."""
RUN_AFTER: Final = tuple(run for _, run in _AFTER)
"""The run after it, likewise."""
CRC15_OF_BYTE: Final = tuple(_crc15_of(byte) for byte in range(256))
