"""States made false in bytes, on CAN FD, in classic frames and on topics; checksums fit, mostly."""

import math
import struct
from collections.abc import Callable, Sequence
from typing import Any

import msgpack
import numpy as np
from e2e.p05 import e2e_p05_protect
from e2e.p11 import e2e_p11_protect

from vegrip.transport.codec import Frame
from vegrip.transport.codec.protection import P04, P04_COUNTER, P04_HEADER
from vegrip.transport.codec.schema import data_id_of

COUNTER_AT, VERSION_AT, TIME_AT, VALUES_AT = 2, 6, 8, 12
"""Where these stand in the frame of a state: the attack knows the wire by itself, not from the DBC."""

HEAD_AT, WORDS_AT, LENGTH = 1, 2, 8
"""Where counter, version and the mark of the last part stand, and the values: known here by itself."""
LAST, VERSIONS, COUNTERS = 0x80, 0x70, 0x0F
DATA_IDS = range(0x100, 0x1C0)
FIRST_PARTS = range(0x100, 0x140)
LATE_NS = 6_000_000  # [ns] more than all parts of a state may take

Sent = Sequence[tuple[int, Frame]]
"""Frames in place of one, each with what it is later [ns]."""
Way = Callable[[bytearray, int], None]
HEAD = frozenset({"version", "finger", "seq", "stamp", "more"})
"""Of the body of a state: what is no value."""
Body = dict[Any, Any]


class Liar:
    """Makes the states of a finger false in bursts: values, counters, times and bytes.

    Args:
        seed: of what is done when.

    """

    BURST = 80  # frames at most
    WELL = 0.4  # share of bursts in which nothing is done
    ODD = (0.0, -0.0, 1e-45, 1e38, -1e38, math.inf, -math.inf, math.nan, 3.4e38, 1.0, -1.0, 60.0, -5.0)

    def __init__(self, seed: tuple[int, int]) -> None:
        self._rng = np.random.default_rng(seed)
        self._ways = (
            self._odd_value, self._random_bits, self._missing, self._all_odd, self._stuck, self._frozen,
            self._counter, self._version, self._scaled, self._slip, self._no_load, self._coarse, self._clock,
            self._jump, self._flipped,
        )  # fmt: skip
        self._left, self._way, self._channel = 0, 0, 0
        self._held: dict[object, bytes] = {}
        self._clock_off = 0  # [us]

    def falsified(self, frame: Frame, later: int) -> bytes:
        """Return the bytes of a state, with a checksum that fits unless that is what is wrong.

        Args:
            frame: the true one.
            later: by how much its clock is to be ahead [ns].

        """
        if self._left <= 0:
            well = self._rng.random() < self.WELL
            self._way = -1 if well else int(self._rng.integers(len(self._ways)))
            self._left, self._channel = int(self._rng.integers(1, self.BURST)), int(self._rng.integers(9))
            if self._way >= 0:
                self._held.clear()
        self._left -= 1
        data = bytearray(frame.data)
        flips = self._way >= 0 and self._ways[self._way] == self._flipped
        if self._way >= 0 and not flips:
            self._ways[self._way](data)
        time = struct.unpack_from("<I", data, TIME_AT)[0] + self._clock_off + later // 1000
        struct.pack_into("<I", data, TIME_AT, time % 2**32)
        e2e_p05_protect(data, frame.arbitration_id, increment_counter=False)
        if flips:
            self._flipped(data)
        return bytes(data)

    @property
    def _at(self) -> int:
        return VALUES_AT + 4 * self._channel

    def _odd_value(self, data: bytearray) -> None:
        struct.pack_into("<f", data, self._at, self._rng.choice(self.ODD))

    def _random_bits(self, data: bytearray) -> None:
        data[self._at : self._at + 4] = self._rng.bytes(4)

    def _missing(self, data: bytearray) -> None:
        struct.pack_into("<f", data, self._at, math.nan)

    def _all_odd(self, data: bytearray) -> None:
        for at in range(VALUES_AT, len(data), 4):
            struct.pack_into("<f", data, at, self._rng.choice(self.ODD))

    def _stuck(self, data: bytearray) -> None:
        data[VALUES_AT : VALUES_AT + 4] = self._held.setdefault(0, bytes(data[VALUES_AT : VALUES_AT + 4]))

    def _frozen(self, data: bytearray) -> None:
        data[VALUES_AT:] = self._held.setdefault(1, bytes(data[VALUES_AT:]))

    def _counter(self, data: bytearray) -> None:
        counter = struct.unpack_from("<I", data, COUNTER_AT)[0] + int(self._rng.integers(-3, 4))
        struct.pack_into("<I", data, COUNTER_AT, counter % 2**32)

    def _version(self, data: bytearray) -> None:
        data[VERSION_AT] = int(self._rng.integers(4))

    def _scaled(self, data: bytearray) -> None:
        value = struct.unpack_from("<f", data, self._at)[0] * self._rng.normal(1.0, 0.3)
        struct.pack_into("<f", data, self._at, np.float32(value))

    def _slip(self, data: bytearray) -> None:
        struct.pack_into("<ff", data, VALUES_AT + 24, 1.0, self._rng.choice([0.0, 1e-3, math.nan]))

    def _no_load(self, data: bytearray) -> None:
        struct.pack_into("<ff", data, VALUES_AT + 4, math.nan, math.nan)

    def _coarse(self, data: bytearray) -> None:
        value = round(struct.unpack_from("<f", data, VALUES_AT)[0] * 20.0) / 20.0
        struct.pack_into("<f", data, VALUES_AT, value)

    def _clock(self, _: bytearray) -> None:
        self._clock_off += int(self._rng.integers(-20_000, 20_000)) if self._left == 1 else 0

    def _jump(self, _: bytearray) -> None:
        self._clock_off = int(self._rng.integers(-(2**31), 2**31)) if self._left == 1 else self._clock_off

    def _flipped(self, data: bytearray) -> None:
        data[int(self._rng.integers(len(data)))] ^= 1 << int(self._rng.integers(8))
        if self._rng.random() < 0.3:
            del data[int(self._rng.integers(len(data))) :]


class PartLiar:
    """Makes the frames of a finger's states false in bursts.

    Args:
        seed: of what is done when.

    """

    BURST = 60  # frames at most
    WELL = 0.5  # share of bursts in which nothing is done
    ODD = (0x0000, 0x7FFF, 0x8000, 0x8001, 0xFFFF, 0x0001)

    def __init__(self, seed: tuple[int, int]) -> None:
        self._rng = np.random.default_rng(seed)
        self._ways: tuple[Way, ...] = (
            self._odd_value, self._random_value, self._missing, self._frozen, self._counter, self._version,
            self._ended, self._unended, self._slip, self._no_counter,
        )  # fmt: skip
        self._fates = (self._lost, self._twice, self._late, self._flipped, self._short, self._delayed_copy)
        self._left, self._way, self._fate = 0, -1, -1
        self._held: dict[int, bytes] = {}
        self._old: dict[int, Frame] = {}

    def falsified(self, frame: Frame) -> Sent:
        """Return what comes in place of a true frame, with a checksum that fits unless it is flipped."""
        if self._left <= 0:
            self._left = int(self._rng.integers(1, self.BURST))
            self._way = self._fate = -1
            self._held.clear()
            if self._rng.random() > self.WELL:
                self._way = int(self._rng.integers(-4, len(self._ways)))
                self._fate = int(self._rng.integers(-4, len(self._fates)))
        self._left -= 1
        data = bytearray(frame.data)
        if self._way >= 0:
            self._ways[self._way](data, frame.arbitration_id)
        e2e_p11_protect(data, frame.arbitration_id, increment_counter=False)
        found = frame._replace(data=bytes(data))
        is_struck = self._fate >= 0 and self._rng.random() < 0.2
        sent = self._fates[self._fate](found) if is_struck else ((0, found),)
        self._old[frame.arbitration_id] = found
        return sent

    def _lost(self, _: Frame) -> Sent:
        return ()

    def _twice(self, frame: Frame) -> Sent:
        return (0, frame), (0, frame)

    def _late(self, frame: Frame) -> Sent:
        return ((LATE_NS, frame),)

    def _flipped(self, frame: Frame) -> Sent:
        data = bytearray(frame.data)
        data[int(self._rng.integers(LENGTH))] ^= 1 << int(self._rng.integers(8))
        return ((0, frame._replace(data=bytes(data))),)

    def _short(self, frame: Frame) -> Sent:
        return ((0, frame._replace(data=frame.data[: int(self._rng.integers(LENGTH))])),)

    def _delayed_copy(self, frame: Frame) -> Sent:
        old = self._old.get(frame.arbitration_id, frame)
        return (0, old._replace(stamp=frame.stamp)), (0, frame)

    def _at(self) -> int:
        return WORDS_AT + 2 * int(self._rng.integers(3))

    def _odd_value(self, data: bytearray, _: int) -> None:
        at = self._at()
        data[at : at + 2] = int(self._rng.choice(self.ODD)).to_bytes(2, "little")

    def _random_value(self, data: bytearray, _: int) -> None:
        at = self._at()
        data[at : at + 2] = self._rng.bytes(2)

    def _missing(self, data: bytearray, identifier: int) -> None:
        if identifier in FIRST_PARTS:
            data[WORDS_AT : WORDS_AT + 2] = b"\x00\x80"

    def _frozen(self, data: bytearray, identifier: int) -> None:
        data[WORDS_AT:] = self._held.setdefault(identifier, bytes(data[WORDS_AT:]))

    def _counter(self, data: bytearray, _: int) -> None:
        moved = ((data[HEAD_AT] & COUNTERS) + int(self._rng.integers(-3, 4))) % 15
        data[HEAD_AT] = data[HEAD_AT] & ~COUNTERS | moved

    def _no_counter(self, data: bytearray, _: int) -> None:
        data[HEAD_AT] |= COUNTERS if self._rng.random() < 0.1 else 0

    def _version(self, data: bytearray, _: int) -> None:
        data[HEAD_AT] = data[HEAD_AT] & ~VERSIONS | int(self._rng.integers(3)) << 4

    def _ended(self, data: bytearray, _: int) -> None:
        data[HEAD_AT] |= LAST

    def _unended(self, data: bytearray, _: int) -> None:
        data[HEAD_AT] &= ~LAST

    def _slip(self, data: bytearray, _: int) -> None:
        data[6] = int(self._rng.choice([0, 1, 2, 255]))


class PayloadLiar:
    """Makes the payloads of a finger's states false in bursts.

    Args:
        seed: of what is done when.
        finger: its name.

    """

    BURST = 60  # payloads at most
    WELL = 0.5  # share of bursts in which nothing is done
    ODD: tuple[Any, ...] = (
        0.0, -0.0, 1e-300, 1e38, -1e300, float("inf"), float("-inf"), float("nan"), 1, -3, 2**63, True, None,
        "1.0", [1.0], {}, 60.0, -5.0,
    )  # fmt: skip
    STAMPS: tuple[Any, ...] = (0, -1, -(2**63), 2**63 - 1, 2**64 - 1, 2**62, 1.5, "now", None, True)

    def __init__(self, seed: tuple[int, int], finger: str) -> None:
        self._rng = np.random.default_rng(seed)
        self._data_id = data_id_of(f"/hand/{finger}/state")
        self._ways: tuple[Callable[[Body], None], ...] = (
            self._odd_value, self._absent, self._all_absent, self._counter, self._version, self._finger,
            self._stamp, self._clock, self._more, self._frozen, self._whole_numbers, self._slip,
        )  # fmt: skip
        self._fates: tuple[Callable[[bytes], Sequence[bytes]], ...] = (
            lambda _: (), lambda data: (data, data), self._flipped, lambda data: (data[:-3],),
            self._other_counter, lambda _: (self._sealed(msgpack.packb([1, 2]), 1),), lambda _: (b"\0",),
        )  # fmt: skip
        self._left, self._way, self._fate = 0, -1, -1
        self._held: Body = {}
        self._clock_off = 0  # [ns]

    def falsified(self, payload: bytes, later: int) -> Sequence[bytes]:
        """Return what comes in place of a payload, whose stamp is to be ``later`` [ns]."""
        if self._left <= 0:
            self._left = int(self._rng.integers(1, self.BURST))
            self._way = self._fate = -1
            self._held = {}
            if self._rng.random() > self.WELL:
                self._way = int(self._rng.integers(-4, len(self._ways)))
                self._fate = int(self._rng.integers(-4, len(self._fates)))
        self._left -= 1
        try:
            body = msgpack.unpackb(payload[P04_HEADER:])
        except (ValueError, msgpack.UnpackException):
            return (payload,)
        body["stamp"] += later + self._clock_off
        if self._way >= 0:
            self._ways[self._way](body)
        seq = body["seq"] if type(body.get("seq")) is int else 0
        data = self._sealed(msgpack.packb(body), seq)
        is_struck = self._fate >= 0 and self._rng.random() < 0.2
        return self._fates[self._fate](data) if is_struck else (data,)

    def _sealed(self, packed: bytes, seq: int) -> bytes:
        data = bytearray(P04_HEADER) + packed
        data[P04_COUNTER] = (seq & 0xFFFF).to_bytes(2, "big")
        P04.protect(data, self._data_id)
        return bytes(data)

    def _flipped(self, data: bytes) -> Sequence[bytes]:
        broken = bytearray(data)
        broken[int(self._rng.integers(len(data)))] ^= 1 << int(self._rng.integers(8))
        return (bytes(broken),)

    def _other_counter(self, data: bytes) -> Sequence[bytes]:
        body = bytearray(data)
        body[P04_COUNTER] = bytes(reversed(body[P04_COUNTER]))
        P04.protect(body, self._data_id)
        return (bytes(body),)

    def _channel(self, body: Body) -> str:
        return str(self._rng.choice([name for name in body if name not in HEAD]))

    def _odd_value(self, body: Body) -> None:
        body[self._channel(body)] = self.ODD[int(self._rng.integers(len(self.ODD)))]

    def _absent(self, body: Body) -> None:
        if len(body) > 5:
            del body[self._channel(body)]

    def _all_absent(self, body: Body) -> None:
        if self._rng.random() < 0.2:
            body.pop(str(self._rng.choice(["seq", "stamp", "finger", "version", "normal_force"])), None)

    def _counter(self, body: Body) -> None:
        body["seq"] = (body["seq"] + int(self._rng.choice([-2, -1, 0, 1, 3, 20_000]))) % 2**32

    def _version(self, body: Body) -> None:
        body["version"] = [1, 2, "1", 1.0, True][int(self._rng.integers(5))]

    def _finger(self, body: Body) -> None:
        body["finger"] = ["thumb", "index", "", 3][int(self._rng.integers(4))]

    def _stamp(self, body: Body) -> None:
        if self._rng.random() < 0.1:
            body["stamp"] = self.STAMPS[int(self._rng.integers(len(self.STAMPS)))]

    def _clock(self, _: Body) -> None:
        if self._left == 1:
            self._clock_off = int(self._rng.choice([0, 10**6, -(10**6), 10**10, -(10**10), 10**15]))

    def _more(self, body: Body) -> None:
        body["more"] = ["of a later version", [1.0]]

    def _frozen(self, body: Body) -> None:
        self._held = self._held or {k: v for k, v in body.items() if k not in {"seq", "stamp"}}
        body.update(self._held)

    def _whole_numbers(self, body: Body) -> None:
        name = self._channel(body)
        if isinstance(body[name], float):
            body[name] = round(body[name])

    def _slip(self, body: Body) -> None:
        body["slip"], body["slip_speed"] = 1.0, float(self._rng.choice([0.0, 1e-3, float("nan")]))
