"""The checksums that hands put into their frames: sums, XOR, CRCs by polynomial, profiles of AUTOSAR E2E."""

import binascii
import importlib
import zlib
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, reduce
from operator import xor
from typing import Any, Final

from vegrip.config import parameter
from vegrip.errors import ConfigError
from vegrip.transport.maps.signals import ForeignMessage, Signal

WIDTHS: Final = {"crc8": 8, "crc16": 16, "crc32": 32}
PROFILES: Final = {"p01": 2, "p02": 2, "p04": 12, "p05": 3, "p06": 5, "p07": 20, "p11": 2}
"""Profiles of AUTOSAR E2E -> the least length of a message [bytes]."""

NAMED: Final[Mapping[str, dict[str, Any]]] = {
    "lrc": {"kind": "sum", "start": 0xFF, "final": 0xFF},  # -sum, as ~(sum - 1)
    "x25": {"kind": "crc16", "polynomial": 0x1021, "start": 0xFFFF, "final": 0xFFFF, "reflected": True},
    "modbus": {"kind": "crc16", "polynomial": 0x8005, "start": 0xFFFF, "reflected": True},
    "dynamixel": {"kind": "crc16", "polynomial": 0x8005},
}
"""Checksums with a name of their own -> what they are; the rest of the keys is as given."""

_LEFT: Final = tuple(binascii.crc_hqx(bytes([byte]), 0) for byte in range(256))


def weiss_crc(data: Iterable[int]) -> int:
    """Return the checksum of Weiss Robotics: the table of 0x1021 for bits that go left, used as if right.

    No CRC of a polynomial, but what the maker's sample code computes.

    >>> hex(weiss_crc(bytes.fromhex("AAAAAA 20 0100 00")))
    '0x838f'
    """
    return reduce(lambda value, byte: _LEFT[(value ^ byte) & 0xFF] ^ value >> 8, data, 0xFFFF)


OWN: Final[Mapping[str, Callable[[Iterable[int]], int]]] = {"weiss": weiss_crc}
"""Functions of a maker's own, of 16 bits."""

APPENDED: Final = ("modbus", "dynamixel", "weiss")
"""Those that stand behind a packet, with their low byte first."""
CHECKSUM_KINDS: Final = ("none", "sum", "xor", *OWN, *WIDTHS, *NAMED, *PROFILES)


@dataclass(frozen=True)
class ChecksumMap:
    """``checksum`` of a message in the map."""

    kind: str = parameter("none", choices=CHECKSUM_KINDS)
    signal: str = parameter("", doc="where it stands in the message; the profiles know that themselves")
    first: int = parameter(0, low=0, high=8191, doc="first byte that it covers")
    last: int = parameter(
        -1,
        low=-8191,
        high=8191,
        doc="last byte that it covers; -1: of the message, -5: the fifth from its end",
    )
    own: str = parameter("left out", choices=("left out", "zero"), doc="the bytes of the checksum itself")
    polynomial: int = parameter(0, low=0, high=0xFFFF_FFFF, doc="of a CRC, without its highest bit")
    start: int = parameter(0, low=0, high=0xFFFF_FFFF, doc="start value")
    final: int = parameter(0, low=0, high=0xFFFF_FFFF, doc="XORed at the end")
    reflected: bool = parameter(False, doc="bits of input and output reversed")
    data_id: tuple[int, ...] = parameter((), doc="the ID that both sides know (profile 2: sixteen)")
    id_bytes: str = parameter(
        "none", choices=("none", "before", "after"), doc="CRC: the ID goes into it, two bytes, low one first"
    )


@dataclass(frozen=True, slots=True)
class Protection:
    """Check and protection of a frame; a counter already stands in the data."""

    check: Callable[[bytes], bool]
    protect: Callable[[bytearray], None]


def protection(spec: ChecksumMap, message: ForeignMessage, where: str) -> Protection | None:
    """Return how ``message`` is protected, None when it is not."""
    if spec.kind == "none":
        return None
    spec = replace(spec, **NAMED.get(spec.kind, {}))
    if spec.kind in PROFILES:
        return _profile(spec, message, where)
    signal = message.signals.get(spec.signal)
    if signal is None:
        raise ConfigError(
            f"{where}: 'signal' is {spec.signal!r}; it must be the signal of {message.name} with the checksum"
        )
    if spec.kind in WIDTHS and not spec.polynomial:
        raise ConfigError(
            f"{where}: 'polynomial' is missing, as in 0x2F for a CRC-8 of AUTOSAR; without it a "
            f"{spec.kind} means nothing"
        )
    return _stored(spec, signal, message.length, _function(spec, signal.length))


def _function(spec: ChecksumMap, bits: int) -> Callable[[Iterable[int]], int]:
    if spec.kind == "sum":
        return lambda data: (sum(data) + spec.start) ^ spec.final
    if spec.kind in OWN:
        return OWN[spec.kind]
    if spec.kind == "xor" and bits == 4:  # of the nibbles
        return lambda data: (folded := reduce(xor, data, spec.start)) ^ folded >> 4 ^ spec.final
    if spec.kind == "xor":
        return lambda data: reduce(xor, data, spec.start) ^ spec.final
    crc = make_crc(WIDTHS[spec.kind], spec.polynomial, spec.start, spec.final, reflected=spec.reflected)
    extra = (spec.data_id[0] if spec.data_id else 0).to_bytes(2, "little")
    if spec.id_bytes == "before":
        return lambda data: crc(extra + bytes(data))
    return (lambda data: crc(bytes(data) + extra)) if spec.id_bytes == "after" else crc


def make_crc(
    width: int, polynomial: int, start: int, final: int, *, reflected: bool
) -> Callable[[Iterable[int]], int]:
    """Return a function that computes a CRC: by a library for the usual polynomials, else byte by byte.

    >>> hex(make_crc(8, 0x2F, 0xFF, 0xFF, reflected=False)(b"123456789"))
    '0xdf'
    >>> hex(make_crc(32, 0x04C11DB7, 0xFFFFFFFF, 0xFFFFFFFF, reflected=True)(b"123456789"))
    '0xcbf43926'
    """
    from e2e import crc  # noqa: PLC0415 (only where a hand has checksums)

    ones = (1 << width) - 1
    begin, end = (_turned(start, width) if reflected else start) ^ ones, final ^ ones
    match width, polynomial, reflected:  # those of others are compiled, and an order of magnitude faster
        case 16, 0x1021, False:
            return lambda data: binascii.crc_hqx(bytes(data), start) ^ final
        case 16, 0x1021, True:
            return lambda data: _turned(binascii.crc_hqx(bytes(data).translate(_TURNED), start), 16) ^ final
        case 32, 0x04C11DB7, True:
            return lambda data: zlib.crc32(bytes(data), begin) ^ end
        case 8, 0x1D, False:
            quick, first, last = crc.calculate_crc8, begin, end
        case 8, 0x2F, False:
            quick, first, last = crc.calculate_crc8_h2f, begin, end
        case 16, 0x8005, True:
            quick, first, last = crc.calculate_crc16_arc, begin ^ ones, final
        case 32, 0xF4ACFB13, True:
            quick, first, last = crc.calculate_crc32_p4, begin, end
        case _:
            return table_crc(width, polynomial, start, final, reflected=reflected)
    return lambda data: int(quick(bytes(data), first, False)) ^ last


def table_crc(
    width: int, polynomial: int, start: int, final: int, *, reflected: bool
) -> Callable[[Iterable[int]], int]:
    """Return a function that computes a CRC byte by byte from a table of 256 values.

    What comes with its highest bit first is turned round, so that one loop serves both orders.

    >>> hex(table_crc(8, 0x31, 0xFF, 0, reflected=False)(b"123456789"))
    '0xf7'
    """
    table, begin = _table(_turned(polynomial, width)), _turned(start, width)

    def crc(data: Iterable[int]) -> int:
        value = begin
        for byte in data if reflected else bytes(data).translate(_TURNED):
            value = table[(value ^ byte) & 0xFF] ^ value >> 8
        return (value if reflected else _turned(value, width)) ^ final

    return crc


@cache
def _table(divisor: int) -> Sequence[int]:
    table = list(range(256))
    for _ in range(8):
        table = [value >> 1 ^ divisor if value & 1 else value >> 1 for value in table]
    return table


def appended(kind: str, data: bytes) -> bytes:
    """Return ``data`` with a checksum of :data:`APPENDED` behind it."""
    function = _function(ChecksumMap(**NAMED.get(kind, {"kind": kind})), 16)
    return data + function(data).to_bytes(2, "little")


def _turned(value: int, width: int) -> int:
    """Return ``value`` with its lowest bit first; ``width`` is of whole bytes."""
    return int.from_bytes(value.to_bytes(width // 8, "little").translate(_TURNED), "big")


_TURNED: Final = bytes(int(f"{byte:08b}"[::-1], 2) for byte in range(256))


def _stored(
    spec: ChecksumMap, signal: Signal, length: int, function: Callable[[Iterable[int]], int]
) -> Protection:
    order: Any = "big" if signal.is_big_endian else "little"
    shift, mask = signal.shift(length), (1 << signal.length) - 1
    bits = mask << shift
    own = [number for number, byte in enumerate(bits.to_bytes(length, order)) if byte]
    last = spec.last if spec.last >= 0 else length + spec.last
    covered = list(range(spec.first, min(last, length - 1) + 1))
    zeroed = spec.own == "zero"
    runs = _runs(covered if zeroed else [number for number in covered if number not in own])

    def value(data: bytes) -> int:
        if zeroed:
            data = (int.from_bytes(data, order) & ~bits).to_bytes(length, order)
        chosen = data[runs[0]] if len(runs) == 1 else b"".join(data[run] for run in runs)
        return function(chosen) & mask

    def check(data: bytes) -> bool:
        return int.from_bytes(data, order) >> shift & mask == value(data)

    place = slice(own[0], own[-1] + 1)

    def check_bytes(data: bytes) -> bool:
        return int.from_bytes(data[place], order) == function(data[runs[0]]) & mask

    def protect(data: bytearray) -> None:
        filled = int.from_bytes(data, order) & ~bits | value(bytes(data)) << shift
        data[:] = filled.to_bytes(length, order)

    is_plain = len(runs) == 1 and 8 * len(own) == signal.length and not zeroed  # the usual case, a short way
    return Protection(check_bytes if is_plain else check, protect)


def _runs(numbers: list[int]) -> list[slice]:
    runs: list[slice] = []
    for number in numbers:
        if runs and runs[-1].stop == number:
            runs[-1] = slice(runs[-1].start, number + 1)
        else:
            runs.append(slice(number, number + 1))
    return runs or [slice(0, 0)]


def _profile(spec: ChecksumMap, message: ForeignMessage, where: str) -> Protection:
    least = PROFILES[spec.kind]
    wanted = 16 if spec.kind == "p02" else 1
    if len(spec.data_id) != wanted:
        given = f"{len(spec.data_id)} numbers"
        raise ConfigError(
            f"{where}: 'data_id' has {given}; profile {spec.kind.upper()} needs {wanted}, from "
            "the data sheet of the hand"
        )
    if message.length < least:
        raise ConfigError(
            f"{where}: {message.name} has {message.length} bytes; profile {spec.kind.upper()} "
            f"takes at least {least}"
        )
    module: Any = importlib.import_module(f"e2e.{spec.kind}")
    identity: Any = bytes(number & 0xFF for number in spec.data_id) if spec.kind == "p02" else spec.data_id[0]
    check = getattr(module, f"e2e_{spec.kind}_check")
    protect = getattr(module, f"e2e_{spec.kind}_protect")
    return Protection(
        lambda data: bool(check(bytearray(data), identity)),
        lambda data: protect(data, identity, increment_counter=False),
    )
