"""Packets of a device on a byte stream, in datagrams or on CAN, described in its map.

::

    [packets.reading]
    start = "AA .. 07"                       # its first bytes; .. is any byte
    length = 37                              # of all its bytes; { field = "u8 @3", plus = 4, most = 260 },
                                             # "end" (up to its last bytes, end = "AA BB"), or "datagram"
    checksum = { kind = "x25", signal = "crc", first = 1 }
    counter = "number"
    clock = "time us"                        # the device's own time, and its unit
    valid = { status = 0 }                   # or a list, or "0..249"; else its fields count as not received
    [packets.reading.fields]
    status = "u16 le @1"                     # type, byte order, first byte
    fz = "f32 le @11 * 0.1 N"                # and scale and unit
    "t{1..16}" = "u8 @40 +3"                 # each next one three bytes further
    is_hot = "u1 @3.6"                       # one bit: of byte 3, counted from its lowest
    crc = "u16 le @-2"                       # the checksum alone may be counted from the end
    shear = "u8 @1 if page=0x21"             # there only when another field has this value

A packet is a message of the hand and its fields are the signals of it, named as those of a CAN database.
A packet that holds records is split: each record (``of`` that packet, ``record`` its type) is a message for
itself, and its fields are counted from its own first byte. Where they are says its ``index``::

    index = { at = 5, type = "u16 le @0", offset = "u16 le @2", from = 4 }    # a table of types and offsets
    index = { at = 4, type = "u8 @0", mask = 0xFC, sizes = { 0x10 = 57 } }    # or one behind the other
"""

import re
import struct
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Any, Final

from vegrip.config import build, parameter
from vegrip.errors import ConfigError, suggestion
from vegrip.transport.codec.frame import EXTENDED
from vegrip.transport.maps.checksums import ChecksumMap, Protection, protection
from vegrip.transport.maps.lines import Line, with_line
from vegrip.transport.maps.signals import ForeignMessage, Signal, expanded
from vegrip.transport.maps.units import conversion

MOST_BYTES: Final = 8192  # [bytes] of a packet, unless it says less
FIELD: Final = re.compile(
    r"(?P<kind>[uif])(?P<bits>\d{1,2})(?: +(?P<order>le|be))? *@(?P<byte>-?\d{1,5})(?:\.(?P<bit>[0-7]))?"
    r"(?: *\+(?P<stride>\d{1,5}))?(?: *\* *(?P<scale>-?[\d.]+(?:[eE][-+]?\d+)?)(?: +(?P<unit>\S+))?)?"
    r"(?: +if +(?P<gate>\w+) *= *(?P<value>0[xX][0-9a-fA-F]+|\d+))?"
)
FORMATS: Final = {8: "B", 16: "H", 32: "I", 64: "Q"}


@dataclass(frozen=True)
class PacketMap:
    """One of ``[packets]`` in a map."""

    like: str = parameter("", doc="another packet, of which all keys hold that are not given here")
    device: int = parameter(0, low=0, high=63, doc="which of the addresses of the transport it comes from")
    identifier: int = parameter(-1, low=-1, high=(1 << 29) - 1, doc="on CAN")
    start: str = parameter("", doc="its first bytes, in hexadecimal; .. is any byte")
    end: str = parameter("", doc="its last bytes")
    text: str = parameter("", doc="a line of text instead of bytes, as 'POS {place}'")
    length: Any = parameter("datagram", doc="number of bytes, { field, plus, most }, 'end' or 'datagram'")
    checksum: ChecksumMap = parameter(ChecksumMap())
    counter: str = parameter("", doc="field with a counter")
    clock: str = parameter("", doc="field with the time of the device, and its unit, as 'stamp us'")
    answer: str = parameter("", doc="of a command: the packet that answers it; the next waits for that")
    then: tuple[Any, ...] = parameter((), doc="of a command: what is said after a new one, as in [device]")
    opened: tuple[Any, ...] = parameter((), doc="of a command: what is said instead for a force of zero")
    counted: str = parameter("", doc="each one is counted by this name")
    valid: dict[str, Any] = parameter({}, doc="FIELD = value, list of values or '0..249'")
    index: dict[str, Any] = parameter(
        {}, doc="of records: { at = 5, type = 'u16 le @0', offset = 'u16 le @2', from = 4 }"
    )
    of: str = parameter("", doc="the packet with an index that this is a record of")
    record: int = parameter(-1, doc="its type in that index")
    fields: dict[str, str] = parameter({})


@dataclass(frozen=True)
class _Length:
    field: str = parameter(doc="where the number stands, as 'u8 @3'")
    plus: int = parameter(0, low=-MOST_BYTES, high=MOST_BYTES, doc="to all its bytes")
    most: int = parameter(MOST_BYTES, low=1, high=MOST_BYTES, doc="more is no length of this packet")


@dataclass(frozen=True)
class _Index:
    at: int = parameter(low=0, high=MOST_BYTES, doc="first byte of the table, or of the first record")
    type: str = parameter(doc="of an entry, or at the head of each record, as 'u16 le @0'")
    offset: str = parameter("", doc="of an entry, as 'u16 le @2'")
    origin: int = parameter(0, low=0, high=MOST_BYTES, doc="('from') the byte that offsets are counted from")
    mask: int = parameter(0, low=0, doc="bits of the type that count; 0: all")
    sizes: dict[str, int] = parameter(
        {}, doc="instead of offsets: { type = bytes of such a record }, one behind another"
    )


Read = Callable[[bytes | bytearray, int], int]
"""The number that stands at a field of the packet that begins at such a byte."""


@dataclass(frozen=True)
class Index:
    """Where the records of a packet are: by a table of offsets, or one behind the other by their sizes."""

    at: int
    type: Read
    mask: int
    offset: Read | None
    entry: int  # [bytes] of the table
    origin: int
    sizes: Mapping[int, int]


@dataclass(frozen=True)
class Record:
    """A record in a packet with an index."""

    number: int
    start: re.Pattern[bytes]
    least: int  # [bytes]


class Packet:
    """A packet as a stream looks for it."""

    def __init__(
        self,
        name: str,
        number: int,
        spec: PacketMap,
        signals: Mapping[str, Signal],
        checked: Signal | None,  # the checksum, counted from the end where its start is negative
        least: int,  # [bytes] that its fields take
        where: str,
    ) -> None:
        self.name, self.number, self.device, self.where = name, number, spec.device, where
        self.checksum, self.checked = spec.checksum, checked
        self.start, self.reach = start_pattern(spec.start, where)  # pattern and [bytes] of the start
        self.end = bytes(one or 0 for one in pattern_bytes(spec.end, f"{where}: 'end'"))
        self.least, self.most = max(least, self.reach + len(self.end)), MOST_BYTES  # [bytes] of all
        self.size: Read | None = None  # None: all of a datagram, or up to its end
        self.records: dict[int, Record] = {}
        if checked is not None and checked.start < 0:
            self.least = max(self.least, -(checked.start // 8))
        self._measure(spec.length)
        self.guard = cache(self._guard)
        """The check of a packet of so many bytes."""
        if checked is not None and self.least <= self.most:
            self.guard(max(self.least, checked.start // 8 + 1))  # says now what is wrong with it
        self.line = Line(spec.text) if spec.text else None
        self.clock = _clock(spec, signals, where)  # reads it, modulus, [ns] a count
        self.index = _index(spec, where)

    def _measure(self, length: Any) -> None:
        if isinstance(length, Mapping):
            given = build(_Length, length, f"{self.where}.length")
            place = read_field("length", given.field, 0, f"{self.where}: 'length'")
            read = _reader(place, f"{self.where}: 'length'")
            self.least, self.most = max(self.least, place.start // 8 + place.length // 8), given.most
            self.size = lambda data, at: read(data, at) + given.plus
        elif isinstance(length, int) and not isinstance(length, bool):
            if not self.least <= length <= MOST_BYTES:
                raise ConfigError(
                    f"{self.where}: 'length' is {length}; its fields need {self.least}, and {MOST_BYTES} is "
                    "the most"
                )
            self.least = self.most = length
        elif length not in ("end", "datagram") or (length == "end") != bool(self.end):
            raise ConfigError(
                f"{self.where}: 'length' is {length!r}; it must be a number, "
                "{ field = 'u8 @3', plus = 4 }, 'datagram', or 'end' beside end = 'AA BB'"
            )

    def _guard(self, length: int) -> Protection | None:
        if self.checked is None:
            return None
        signal = self.checked
        if signal.start < 0:
            signal = replace(signal, start=8 * length + signal.start)
        message = ForeignMessage(self.name, 0, length, False, {signal.name: signal})
        return protection(self.checksum, message, self.where)


def read_packets(tables: Mapping[str, Any], where: str) -> dict[str, PacketMap]:
    found: dict[str, PacketMap] = {}
    for name in tables:
        keys, seen = dict(_table(tables, name, where)), {name}
        while like := keys.pop("like", ""):
            if like in seen or like not in tables:
                raise ConfigError(
                    f"{where} [packets.{name}]: 'like' is {like!r}; "
                    f"{suggestion(str(like), set(tables) - seen, 'there are')}"
                )
            seen.add(like)
            keys = {**_table(tables, like, where), **keys}
        place = f"{where} [packets.{name}]"
        keys = with_line(keys, place) if "text" in keys else keys
        found[name] = build(PacketMap, keys, place)
    return found


def _table(tables: Mapping[str, Any], name: str, where: str) -> Mapping[str, Any]:
    if not isinstance(tables[name], Mapping):
        raise ConfigError(f"{where}: packets.{name} is {tables[name]!r}; it must be a table")
    table: Mapping[str, Any] = tables[name]
    return table


def pattern_bytes(text: str, where: str) -> list[int | None]:
    """Return the bytes in hexadecimal ``text``, None where it has two dots."""
    if re.fullmatch(r"\s*((\.\.|[0-9a-fA-F]{2})\s*)*", text) is None:
        raise ConfigError(f"{where}: {text!r} are no bytes; write them like 'AA 55 .. 03'")
    return [None if word == ".." else int(word, 16) for word in re.findall(r"\S\S", text)]


def start_pattern(text: str, where: str) -> tuple[re.Pattern[bytes], int]:
    found = pattern_bytes(text, f"{where}: 'start'")
    return re.compile(
        b"".join(b"." if one is None else re.escape(bytes([one])) for one in found), re.DOTALL
    ), len(found)


def on_bus(identifier: int) -> int:
    """Return ``identifier`` as frames have it, with its mark when it has 29 bits."""
    return identifier | (EXTENDED if identifier > 0x7FF else 0)


def template_of(each: PacketMap, length: int, where: str) -> bytes:
    if each.text:
        return b""  # the fields of a line are all that there is
    start, end = (bytes(one or 0 for one in pattern_bytes(text, where)) for text in (each.start, each.end))
    return start if each.of or not end else start.ljust(length - len(end), b"\0") + end


def as_little(signals: Mapping[str, Signal]) -> list[Signal]:
    """Return ``signals`` as if all were little-endian, for where they end."""
    return [
        replace(signal, start=8 * (signal.start // 8)) if signal.is_big_endian else signal
        for signal in signals.values()
    ]


def signals_of(each: PacketMap, where: str) -> tuple[dict[str, Signal], Signal | None]:
    signals: dict[str, Signal] = {}
    checked = None
    for name, text in each.fields.items():
        names = expanded((name,))
        for number, one in enumerate(names):
            signal = read_field(one, text, number, f"{where}: the field {one!r}")
            if one == each.checksum.signal and each.checksum.kind != "none":
                checked = signal
            if signal.start < 0:
                if signal is not checked:
                    raise ConfigError(
                        f"{where}: the field {one!r} is counted from the end; only a checksum may be"
                    )
            else:
                signals[one] = signal
    if each.checksum.kind != "none" and checked is None:
        raise ConfigError(f"{where}: 'checksum' must name the field that holds it: signal = 'NAME'")
    pages = [signal.selected_by for signal in signals.values()]
    if any(pages) and each.valid:
        raise ConfigError(f"{where}: has 'valid' and fields with 'if'; give one of them")
    for key in (each.counter, *each.valid, *pages):
        if key and key not in signals:
            raise ConfigError(f"{where}: there is no field {key!r}; {suggestion(key, signals, 'there are')}")
    gates = tuple(each.valid)
    for before, gate in zip(("", *gates), gates, strict=False):
        signals[gate] = replace(signals[gate], **_selected(each, before, where))
    if gates:
        chosen = _selected(each, gates[-1], where)
        signals |= {name: replace(one, **chosen) for name, one in signals.items() if name not in gates}
    return signals, checked


def _selected(each: PacketMap, gate: str, where: str) -> dict[str, Any]:
    """Return what makes a signal count only when ``gate`` has one of its valid values."""
    if not gate:
        return {}
    value = each.valid[gate]
    if isinstance(value, str) and (match := re.fullmatch(r"(\d+)\.\.(\d+)", value)):
        return {"selected_by": gate, "selectors": range(int(match[1]), int(match[2]) + 1)}
    values = tuple(value) if isinstance(value, (list, tuple)) else (value,)
    if not all(isinstance(one, int) for one in values):
        raise ConfigError(
            f"{where}: 'valid' has {value!r} for {gate}; give a number, a list of them, or '0..249'"
        )
    return {"selected_by": gate, "selectors": values}


def read_field(name: str, text: str, number: int, where: str) -> Signal:
    """Return the field ``name`` that ``text`` declares, the ``number``-th of its kind."""
    match = FIELD.fullmatch(text.strip())
    bits = int(match["bits"]) if match else 0
    if match is None or not 0 < bits <= 64 or (match["kind"] == "f" and bits not in (16, 32, 64)):
        raise ConfigError(f"{where} is {text!r}; write it like 'f32 le @2', 'i16 be @4 * 0.1 N' or 'u1 @3.6'")
    if bits > 8 and match["order"] is None:
        raise ConfigError(f"{where} is {text!r}; say its byte order: '{match['kind']}{bits} le' or '... be'")
    if match["order"] == "be" and (bits % 8 or match["bit"]):
        raise ConfigError(f"{where} is {text!r}; bits that are no whole bytes are counted 'le'")
    first = int(match["byte"]) + number * int(match["stride"] or bits // 8)
    return Signal(
        name,
        8 * first + (7 if match["order"] == "be" else int(match["bit"] or 0)),
        bits,
        is_big_endian=match["order"] == "be",
        is_signed=match["kind"] == "i",
        is_float=match["kind"] == "f",
        scale=float(match["scale"] or 1.0),
        unit=match["unit"] or "",
        selected_by=match["gate"] or "",
        selectors=(int(match["value"], 0),) if match["gate"] else (),
    )


def _reader(signal: Signal, where: str) -> Read:
    form = FORMATS.get(signal.length)
    if form is None or signal.is_float or signal.start < 0:
        raise ConfigError(f"{where} must be a whole number of 8, 16, 32 or 64 bits")
    take = struct.Struct((">" if signal.is_big_endian else "<") + form).unpack_from
    byte = signal.start // 8
    return lambda data, at: int(take(data, at + byte)[0])


def _clock(each: PacketMap, signals: Mapping[str, Signal], where: str) -> tuple[Read, int, float] | None:
    name, _, unit = each.clock.partition(" ")
    if not name:
        return None
    if name not in signals:
        raise ConfigError(f"{where}: 'clock' is {each.clock!r}; {suggestion(name, signals, 'there are')}")
    scale, _ = conversion(unit, "s", f"{where}: 'clock'")
    signal = signals[name]
    return _reader(signal, f"{where}: 'clock'"), 1 << signal.length, scale * signal.scale * 1e9


def _index(each: PacketMap, where: str) -> Index | None:
    if not each.index:
        return None
    keys = {"origin" if key == "from" else key: value for key, value in each.index.items()}
    given = build(_Index, keys, f"{where}.index")
    if bool(given.offset) == bool(given.sizes):
        raise ConfigError(f"{where}.index: give 'offset' (a table) or 'sizes' (one behind another)")
    parts = [read_field(text, text, 0, f"{where}: index") for text in (given.type, given.offset) if text]
    try:
        sizes = {int(kind, 0): size for kind, size in given.sizes.items()}
    except ValueError:
        raise ConfigError(f"{where}.index: 'sizes' names types by numbers, as {{ 0x10 = 57 }}") from None
    if any(size < 1 for size in sizes.values()):
        raise ConfigError(f"{where}.index: 'sizes' are of whole records, their type among it: 1 and more")
    readers = [_reader(part, f"{where}: index") for part in parts]
    entry = max(part.start // 8 + part.length // 8 for part in parts)
    offset = readers[1] if given.offset else None
    return Index(given.at, readers[0], given.mask or ~0, offset, entry, given.origin, sizes)


def on_streams(packets: Sequence[Packet]) -> None:
    """Refuse packets that only datagrams can carry."""
    for packet in packets:
        if packet.size is None and packet.least != packet.most and not packet.end:
            raise ConfigError(f"{packet.where}: a stream has no datagrams; give 'length'")
        if not packet.reach and packet.checked is None:
            raise ConfigError(
                f"{packet.where}: a stream needs a 'start' or a 'checksum' by which a packet is found"
            )
