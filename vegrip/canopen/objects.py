"""Entries of an object dictionary, as an EDS file describes them."""

from dataclasses import dataclass, field
from typing import Final

from cantools.database.can import Message, Signal

from vegrip.transport.codec.database import database

BOOLEAN, INTEGER8, INTEGER16, INTEGER32 = 0x01, 0x02, 0x03, 0x04
UNSIGNED8, UNSIGNED16, UNSIGNED32, REAL32 = 0x05, 0x06, 0x07, 0x08
VISIBLE_STRING, UNSIGNED48 = 0x09, 0x19
BITS: Final = {
    BOOLEAN: 8,
    INTEGER8: 8,
    INTEGER16: 16,
    INTEGER32: 32,
    UNSIGNED8: 8,
    UNSIGNED16: 16,
    UNSIGNED32: 32,
    REAL32: 32,
    UNSIGNED48: 48,
}
"""Length of each data type in a PDO."""


@dataclass(frozen=True, slots=True)
class Entry:
    """One value that can be read or written."""

    name: str
    data_type: int
    access: str = "ro"  # ro, rw, const
    default: str = ""  # as it stands in the file
    is_mappable: bool = False
    note: str = ""  # unit and meaning; goes into a comment


@dataclass(frozen=True, slots=True)
class Variable:
    """An object that is one value."""

    index: int
    entry: Entry


@dataclass(frozen=True, slots=True)
class Record:
    """An object of several values; entries are numbered from sub-index 1."""

    index: int
    name: str
    entries: tuple[Entry, ...]
    is_array: bool = False


Object = Variable | Record


@dataclass(frozen=True, slots=True)
class Pdo:
    """A process data object: one CAN frame of mapped entries."""

    number: int  # from 0
    is_transmitted: bool
    cob_id: str  # as it stands in the file
    transmission_type: int
    mapped: tuple[tuple[int, int, int], ...]  # index, sub-index, bits


@dataclass(frozen=True, slots=True)
class Device:
    """Everything an EDS file says."""

    file: str
    product: str
    product_number: int
    description: str
    objects: tuple[Object, ...]
    pdos: tuple[Pdo, ...]
    comments: tuple[str, ...] = field(default=())


HEADER = Entry("header", UNSIGNED16, "rw", "0", is_mappable=True, note="CRC-8, counter, version, flag")
TYPES = {(8, False): UNSIGNED8, (8, True): INTEGER8, (16, False): UNSIGNED16, (16, True): INTEGER16}


def pdo_record(index: int, name: str, message: str) -> Record:
    found = database().get_message_by_name(message)
    return Record(index, name, (HEADER, *_content(found)))


def pdo_mapping(record: Record) -> tuple[tuple[int, int, int], ...]:
    return tuple((record.index, sub, BITS[e.data_type]) for sub, e in enumerate(record.entries, 1))


def _content(message: Message) -> list[Entry]:
    """Return what follows the header; one block of 48 bits when signals do not lie on bytes."""
    signals = sorted((s for s in message.signals if s.start >= 16), key=lambda s: s.start)
    if any(s.start % 8 or (s.length, s.is_signed) not in TYPES for s in signals):
        return [
            Entry(
                "content", UNSIGNED48, "rw", "0", is_mappable=True, note="; ".join(_bits(s) for s in signals)
            )
        ]
    entries = []
    at = 16
    for signal in signals:
        entries += [_reserved(byte) for byte in range(at, signal.start, 8)]
        entries.append(_entry(signal))
        at = signal.start + signal.length
    return entries + [_reserved(byte) for byte in range(at, 64, 8)]


def _entry(signal: Signal) -> Entry:
    kind = TYPES[signal.length, signal.is_signed]
    unit = f"{float(signal.scale):g} {signal.unit or '1'} per bit"
    return Entry(signal.name, kind, "rw", "0", is_mappable=True, note=unit)


def _reserved(bit: int) -> Entry:
    return Entry(f"reserved_{bit // 8}", UNSIGNED8, "rw", "0", is_mappable=True, note="zero")


def _bits(signal: Signal) -> str:
    return f"{signal.name} bits {signal.start - 16}..{signal.start + signal.length - 17}"
