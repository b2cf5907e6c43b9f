"""Entries of an object dictionary, as an EDS file describes them."""

from dataclasses import dataclass, field
from typing import Final

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
